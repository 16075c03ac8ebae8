"""The listings of a page: a fence whose info names a file, as in ```cpp tutorial.cpp, adds its text to that file."""

import pathlib
import re
from typing import Dict

ROOT = pathlib.Path(__file__).parents[2]
CODE = {"c", "cpp", "cmake", "python"}


def listings(page: str) -> Dict[str, str]:
    """Names and texts of the files. Code that names no file would be run by nobody: an error."""
    files: Dict[str, str] = {}
    for language, name, text in re.findall(
        r"^```(\w*)(?: +(\S+))?\n(.*?)^```$", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE
    ):
        assert name or language not in CODE, f"{page}: a listing names no file: {text.splitlines()[0]}"
        if name:
            files[name] = files.get(name, "") + text
    return files
