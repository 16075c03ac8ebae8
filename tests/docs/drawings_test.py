"""The drawings are those that script/drawings makes, they name folders that exist, and a document shows each."""

import re
import subprocess
import sys

import pytest
from listings import ROOT

PICTURES = ROOT / "docs/pictures"


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawings")
    subprocess.run([sys.executable, "-B", ROOT / "script/drawings", folder], check=True, capture_output=True)
    return sorted(folder.iterdir())


def test_the_documents_have_what_the_script_draws(drawn):
    assert len(drawn) == 7
    for drawing in drawn:
        assert (
            drawing.read_text() == (PICTURES / drawing.name).read_text()
        ), f"script/drawings was not run: {drawing.name}"


def test_each_drawing_is_shown(drawn):
    text = (ROOT / "docs/reference/drawings.md").read_text()
    assert [each.name for each in drawn if f"(../pictures/{each.name})" not in text] == []


def test_the_block_diagram_names_folders_that_exist():
    named = re.findall(r'font-family="monospace">([^<]+)<', (PICTURES / "blocks.svg").read_text())
    folders = [folder for each in named for folder in each.split(", ")]
    assert len(folders) > 15
    missing = [
        folder for folder in folders if not (ROOT / folder).is_dir() and not (ROOT / "board_emu" / folder).is_dir()
    ]
    assert missing == []
