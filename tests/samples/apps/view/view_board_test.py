"""gicube-view's page and its boards, other pages and screens: what is told when one is lost, refused, or at work."""

from __future__ import annotations

import os
import pathlib
import re
import signal
import time

import numpy as np
import pytest
from browser import FOLDER, LOOK, Shown, wait
from selenium import webdriver
from selenium.common.exceptions import JavascriptException
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from view_program import Page, Program

# Of the guide's picture, docs/pictures/view.png, which the test of the machine leaves in FOLDER.
BUCKYBALL = ("builtin:buckyball", "--set", "asic.block_voxels=8", "--fix", "volume-size=64", "--fix", "size=384x384")


def test_a_board_that_is_killed_in_mid_frame_is_told_and_a_new_one_goes_on(page: Shown) -> None:
    before = page.picture()
    page.put("size", "512x512")
    page.put("fidelity", "cycle")
    wait("the cycle level's board", lambda: len(page.program.boards()) == 2)
    wait("its frame", lambda: "picture 1 of 1" in page.text("#status"))
    for board in page.program.boards():
        os.kill(board, signal.SIGKILL)
    wait("a notice", lambda: "board was lost" in page.text("#notices"))
    page.put("size", "128x128")
    page.put("fidelity", "functional")
    page.find("[data-notice=board] button").click()
    wait("no notice", lambda: page.text("#notices") == "")
    assert np.array_equal(page.picture(), before)


def test_two_pages_at_once_have_each_their_own_view(page: Shown) -> None:
    first = page.picture()
    tab = page.browser.current_window_handle
    page.browser.switch_to.new_window("tab")
    try:
        other = Shown(page.browser, page.program)
        assert np.array_equal(other.picture(), first)
        turned = other.after(lambda: other.find("#picture").send_keys(Keys.ARROW_LEFT))
        assert (turned != first).any()
    finally:
        page.browser.close()
        page.browser.switch_to.window(tab)
    assert np.array_equal(page.picture(), first)


def coloured(page: Shown, canvas: str) -> bool:
    try:
        pixels = page.pixels(canvas)
    except JavascriptException:  # it is not there yet
        return False
    shown = pixels[pixels[..., 3] == 255]
    return len(np.unique(shown, axis=0)) > 1


@pytest.mark.parametrize("page", [BUCKYBALL if FOLDER else None], indirect=True)
def test_the_machine_is_seen_at_work(page: Shown) -> None:
    page.picture()
    page.find("#machine-panel summary").click()
    page.put("size", "768x768")  # a frame of seconds, so that it is looked at many times
    page.put("fidelity", "cycle")
    wait("a running frame", lambda: "a frame runs" in page.text("#machine-state"))
    wait("its cycles", lambda: page.browser.find_elements(By.CSS_SELECTOR,
                                                          "#machine [aria-label='cycles by cause'] rect"))
    wait("more than a look at its time line",
         lambda: len(page.browser.find_elements(By.CSS_SELECTOR, "#timeline rect")) > 10)
    # Rays wait in some blocks, and banks serve: squares of colour among grey ones.
    for title in ("rays waiting by block", "packets by bank"):
        wait(title, lambda: coloured(page, f"#machine canvas[aria-label='{title}']"))
    assert "under way" in page.text("#machine") and "Rays wait in" in page.text("#machine")
    if FOLDER:
        top = "document.querySelector('#looks').scrollTop = 0"
        page.shot((1280, 1000), False, lambda: page.browser.execute_script(top), "view.png")
    page.picture()
    wait("the end", lambda: "figures of the last frame" in page.text("#machine-state"))
    assert len(page.browser.find_elements(By.CSS_SELECTOR, "#machine [aria-label='energy by part'] rect")) == 7
    assert "pictures a second on the card" in page.text("#status")
    for words in ("samples", "processor 3", "cache hit ratio", "rdram: bandwidth used", "bus up, bytes",
                  "rdram0 to rdram3, banks 0 to 31 across"):
        assert words in page.text("#machine")

TWO_BOARDS = """
const [done] = arguments, tell = {}, counted = (ms, rays, running) =>
  tell.machine({ type: "machine", simulated_ms: ms, running,
    counters: { "pipeline.rays": rays, "pipeline.samples": 10 * rays } });
import("./machine.js").then(({ Machine }) => {
  new Machine({ on: (kind, act) => (tell[kind] = act), send() {} });
  counted(9, 700, true); counted(1, 0, true); counted(2, 30, false);
  done(document.querySelector("#machine").innerText);
}).catch((error) => done(String(error)));
"""


def test_counts_of_the_board_before_are_not_taken_off_a_new_boards(page: Shown) -> None:
    page.picture()
    page.browser.execute_script(
        "document.querySelector('#machine-panel').open = true; document.querySelector('#machine').replaceChildren()")
    text = page.browser.execute_async_script(TWO_BOARDS)
    assert re.search(r"rays ended\s+30\b", text) and re.search(r"samples\s+300\b", text), text


def test_two_configurations_stand_side_by_side(page: Shown) -> None:
    page.picture()
    page.find("#compare-panel summary").click()
    Select(page.find("#compare-size")).select_by_value("64x64")
    page.find("#compare-0").send_keys(Keys.CONTROL + "a" + Keys.NULL + "1")
    page.find("#compare-run").click()
    wait("the result", lambda: "bit for bit" in page.text("#compared"))
    rows = {row.text.split(" ")[0]: row.text for row in page.browser.find_elements(By.CSS_SELECTOR, "#compared tr")}
    assert rows["asic.processors"].startswith("asic.processors 1 8")
    # Eight processors are faster than one.
    assert float(rows["frame,"].split("×")[1]) < 0.9


def test_without_an_input_the_page_asks_for_one(chromium: webdriver.Chrome, ball: pathlib.Path) -> None:
    with Program(*LOOK) as program:
        page = Shown(chromium, program)
        wait("the invitation", lambda: page.find("#empty").is_displayed())
        page.drop("ball.nrrd", ball.read_bytes())
        assert page.picture().shape == (128, 128, 4)
        assert not page.find("#empty").is_displayed()


def test_a_program_that_has_ended_is_told(chromium: webdriver.Chrome, ball: pathlib.Path) -> None:
    with Program(ball, *LOOK) as program:
        page = Shown(chromium, program)
        page.picture()
    wait("a notice", lambda: "connection to gicube-view has ended" in page.text("#notices"))


def test_a_wrong_token_gets_one_line_and_no_page(page: Shown) -> None:
    page.picture()
    wrong = Shown(page.browser, page.program, page.program.address[:-4] + "0000")
    assert wrong.text("body").startswith("token: expected the one in the printed address")
    with Page(page.program, token="0" * 32) as refused:
        assert refused.status == 403
    page.browser.get_log("browser")  # of the refusal


def test_a_foreign_page_is_refused(page: Shown) -> None:
    page.picture()
    program = page.program
    with Page(program, origin="http://example.org") as foreign:
        assert foreign.status == 403
    assert program.get(f"/?token={program.token}", Host="example.org")[0] == 403
    # The request that a script of another address would make in a browser.
    page.browser.get("data:text/html,<title>foreign</title>")
    script = """
    const done = arguments[2];
    const socket = new WebSocket(`ws://127.0.0.1:${arguments[0]}/socket?token=${arguments[1]}`);
    socket.onopen = () => done("open");
    socket.onerror = () => done("refused");
    """
    assert page.browser.execute_async_script(script, program.port, program.token) == "refused"
    page.browser.get_log("browser")


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("size", [(1280, 720), (390, 844)])
def test_everything_fits_a_screen_and_a_phone_in_light_and_dark(page: Shown, size: tuple[int, int], dark: bool) -> None:
    def looks() -> None:
        page.picture()
        width, inner = page.browser.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        assert inner == size[0] and width <= inner
        box = page.find("#picture").rect
        assert box["x"] >= 0 and box["x"] + box["width"] <= inner and abs(box["width"] - box["height"]) <= 1
        assert box["y"] + box["height"] <= size[1]
        colour = page.browser.execute_script("return getComputedStyle(document.body).backgroundColor")
        assert (sum(int(c) for c in colour[4:-1].split(",")) < 150) == dark

    page.shot(size, dark, looks, f"view_{'phone' if size[0] < 900 else 'page'}_{'dark' if dark else 'light'}.png")
