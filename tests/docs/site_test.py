"""The site's parts: its checker finds what is broken, and the pages that Sphinx is given are whole. script/check makes
the
site itself."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from listings import ROOT

sys.path.insert(0, str(ROOT / "docs/site"))
import check  # noqa: E402
import stage  # noqa: E402


def test_the_checker_finds_what_is_broken(tmp_path):
    links = '<a href="whole.html#here">1</a><a href="none.html">2</a><a href="whole.html#gone">3</a>'
    (tmp_path / "index.html").write_text(links + '<img src="https://a.b/c.png">')
    (tmp_path / "whole.html").write_text('<p id="here"><a href="https://a.b">5</a></p><img src="none.png">')
    (tmp_path / "alone.html").write_text("<p>nobody links here</p>")
    pages, count, faults = check.faults_of(tmp_path)
    assert (pages, count) == (3, 4)
    assert sorted(faults) == [
        "alone.html: no page links to it",
        "index.html: loads https://a.b/c.png",
        "index.html: no anchor whole.html#gone",
        "index.html: no page none.html",
        "whole.html: loads none.png",
    ]


def test_listings_in_two_languages_become_tabs():
    text = "One.\n\n```cpp a.cpp\nint x;\n```\n\n```python a.py\nx = 1\n```\n\nTwo.\n"
    made = stage.with_tabs(text)
    assert (
        made.count("{tab}") == 2 and ":caption: a.cpp" in made and made.startswith("One.") and made.endswith("Two.\n")
    )
    alone = "```cpp\nint x;\n```\n"
    assert stage.with_tabs(alone) == alone


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """What Sphinx is given."""
    if shutil.which("doxygen") is None:
        pytest.skip("not installed: doxygen (script/bootstrap docs)")
    folder = tmp_path_factory.mktemp("site")
    environment = {**os.environ, "GICUBE_DOCS_OUT": str(folder), "GICUBE_VERSION": "0"}
    subprocess.run(["doxygen", "docs/site/Doxyfile"], cwd=ROOT, env=environment, check=True)
    stage.main(folder / "xml", folder / "pages")
    return folder / "pages"


def test_the_navigation_has_every_document(pages):
    navigation = (pages / "index.md").read_text()
    entries = set(
        re.findall(r"^(?:[^<\n]*<)?([\w/]+)>?$", navigation[navigation.index("```{toctree}") :], re.MULTILINE)
    )
    documents = {str(path.with_suffix("")) for path in stage.documents()} - {"README"}
    assert documents - entries == set()


def test_the_api_has_what_the_headers_declare(pages):
    for page, names in {
        "cpp/board.rst": ["cpp:class:: gicube::Board", "Board open(", "bool keep_volume = false"],
        "cpp/ray.rst": ["cpp:enum-class:: gicube::RayType", "enumerator:: kFirstHit", "gicube::ray_between("],
        "c/c_api.rst": ["c:function:: gicube_status gicube_render("],
        "c/c_types.rst": ["c:struct:: gicube_view", "c:macro:: GICUBE_OK"],
        "scene/volume_file.rst": ["gicube::scene::read_volume("],
        "python/board.rst": ["py:class:: Board", "py:method:: set_time_limit(limit)"],
        "python/records.rst": ["py:class:: View", "py:attribute:: fov_degrees"],
    }.items():
        text = (pages / "api" / page).read_text()
        assert [name for name in names if name not in text] == [], page
