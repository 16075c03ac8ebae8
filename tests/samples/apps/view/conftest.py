"""A headless Chromium for the tests of the page, and scans for it."""

from __future__ import annotations

import pathlib
from typing import Iterator

import pytest
from browser import LOOK, Shown
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from view_program import Program, write_ball


@pytest.fixture(scope="session")
def chromium() -> Iterator[webdriver.Chrome]:
    options = webdriver.ChromeOptions()
    # Root has no sandbox; a small /dev/shm would end it.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--hide-scrollbars",
                     "--lang=en"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    browser.set_script_timeout(60)
    yield browser
    browser.quit()


@pytest.fixture(scope="session")
def ball(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    path = tmp_path_factory.mktemp("scans") / "ball.nrrd"
    write_ball(path)
    return path


@pytest.fixture
def page(chromium: webdriver.Chrome, ball: pathlib.Path, request: pytest.FixtureRequest) -> Iterator[Shown]:
    with Program(*(getattr(request, "param", None) or (ball, *LOOK))) as program:
        shown = Shown(chromium, program)
        yield shown
        assert shown.faults() == []
