"""gicube-view's page in a real browser: what a person does there, and what is seen then, as pixels and text."""

from __future__ import annotations

import os
import pathlib
import shlex
import signal
import subprocess
import sys
import time
import urllib.parse
from typing import Any, Callable, Iterator

import numpy as np
import OpenImageIO as oiio
import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.ui import Select
from view_program import BIN, Page, Program, write_ball

# With a folder in GICUBE_VIEW_PICTURES, tests leave screenshots there, this one that of the guide: docs/pictures/view.png.
FOLDER = os.environ.get("GICUBE_VIEW_PICTURES")

# Opaque, so that a canvas keeps each bit.
LOOK = ("--fix", "size=128x128", "--fix", "background=0.1,0.2,0.3")

DROP = """
const [name, text, done] = arguments;
const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const data = new DataTransfer();
data.items.add(new File([bytes], name));
for (const kind of ["dragenter", "dragover", "drop"]) document.body.dispatchEvent(new DragEvent(kind, {dataTransfer: data, bubbles: true, cancelable: true}));
done();
"""


def wait(what: str, holds: Callable[[], Any], seconds: float = 60) -> Any:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := holds():
            return found
        time.sleep(0.02)
    raise AssertionError(f"waited {seconds} s for {what}")


class Shown:
    """The page in one tab of the browser."""

    def __init__(self, browser: webdriver.Chrome, address: str, size: tuple[int, int] = (1280, 720)) -> None:
        self.browser = browser
        browser.set_window_size(*size)
        browser.get("about:blank")
        browser.get(address)
        self.tab = browser.current_window_handle

    def find(self, selector: str) -> WebElement:
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector: str) -> str:
        return str(self.browser.execute_script("return document.querySelector(arguments[0])?.textContent ?? ''", selector))

    def picture(self) -> np.ndarray[Any, Any]:
        """The canvas's pixels, once it shows the whole picture of the view as it is."""
        wait("a whole picture", lambda: self.find("#picture").get_attribute("data-final") == "true")
        return self.pixels("#picture")

    def pixels(self, selector: str) -> np.ndarray[Any, Any]:
        width, height, data = self.browser.execute_script(
            "const c = document.querySelector(arguments[0]);"
            "return [c.width, c.height, Array.from(c.getContext('2d').getImageData(0, 0, c.width, c.height).data)]",
            selector,
        )
        return np.array(data, dtype="u1").reshape(height, width, 4)

    def after(self, act: Callable[[], Any]) -> np.ndarray[Any, Any]:
        """The whole picture that follows an act."""
        before = self.find("#picture").get_attribute("data-id")
        act()
        wait("another picture", lambda: self.find("#picture").get_attribute("data-id") != before)
        return self.picture()

    def put(self, field: str, value: str) -> None:
        """Into a field, as by typing."""
        element = self.find(f"#set-{field}".replace(".", "\\."))
        self.browser.execute_script("arguments[0].closest('details')?.setAttribute('open', '')", element)
        if element.tag_name == "select":
            Select(element).select_by_value(value)
        else:
            element.send_keys(Keys.CONTROL + "a" + Keys.NULL + value + Keys.TAB)

    def drop(self, name: str, content: bytes) -> None:
        import base64

        self.browser.execute_async_script(DROP, name, base64.b64encode(content).decode())

    def shot(self, size: tuple[int, int], dark: bool, act: Callable[[], object], name: str) -> None:
        """Acts on a screen of that size; a screenshot of it is kept if somebody asks for those."""
        metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
        try:
            act()
            if FOLDER:
                self.browser.save_screenshot(str(pathlib.Path(FOLDER) / name))
        finally:
            self.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})

    def faults(self) -> list[str]:
        """What the browser complains about, as of scripts and of the content security policy."""
        return [line["message"] for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]


@pytest.fixture
def page(chromium: webdriver.Chrome, ball: pathlib.Path, request: pytest.FixtureRequest) -> Iterator[Shown]:
    with Program(*(getattr(request, "param", None) or (ball, *LOOK))) as program:
        shown = Shown(chromium, program.address)
        shown.program = program  # type: ignore[attr-defined]
        yield shown
        assert shown.faults() == []


def run(command: str, folder: pathlib.Path) -> None:
    words = shlex.split(command)
    subprocess.run([str(BIN / words[0]), *words[1:], "--quiet"], cwd=folder, check=True, timeout=120)


def png(path: pathlib.Path) -> np.ndarray[Any, Any]:
    return np.asarray(oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8))


def test_a_scan_is_loaded_and_shown_with_its_name_and_slices(page: Shown) -> None:
    image = page.picture()
    assert image.shape == (128, 128, 4)
    # The background in the corners, the ball in the middle.
    assert tuple(image[0, 0]) == (26, 51, 77, 255)
    assert np.ptp(image[40:90, 40:90, :3].astype(int)) > 60
    assert Select(page.find("#input")).first_selected_option.text == "ball.nrrd"
    assert "whole picture 128 × 128 · functional" in page.text("#status")
    for axis in "zyx":
        canvas = f"canvas[aria-label='slice along {axis}']"
        wait("a slice", lambda: page.find(canvas).get_attribute("width") == "48")
        assert page.pixels(canvas)[24, 24, 0] > 200 and page.pixels(canvas)[0, 0, 0] == 0


def test_a_slider_shows_another_slice(page: Shown) -> None:
    page.picture()
    canvas = "canvas[aria-label='slice along z']"
    wait("a slice", lambda: page.find(canvas).get_attribute("width") == "48")
    slider = page.find("#slice-z")
    slider.send_keys(Keys.HOME)
    wait("the first slice", lambda: page.pixels(canvas)[..., 0].max() < 100)
    assert "z 0" in page.text("#slices")


def test_dragging_turns_it_and_coarse_pictures_come_meanwhile(page: Shown) -> None:
    before = page.picture()
    address = page.browser.current_url
    canvas = page.find("#picture")

    def drag() -> None:
        actions = ActionChains(page.browser, duration=20).move_to_element(canvas).click_and_hold()
        for _ in range(10):
            actions.move_by_offset(6, 1)
        actions.release().perform()

    after = page.after(drag)
    assert (before != after).any()
    wait("the address", lambda: page.browser.current_url != address)
    # It is the picture that gicube-render makes with the eye of the address.
    state = dict(urllib.parse.parse_qsl(urllib.parse.urlsplit(page.browser.current_url).fragment))
    assert f"--eye={state['eye']}" in page.text("#command")


def test_keys_turn_move_zoom_and_reset_it(page: Shown) -> None:
    first = page.picture()
    seen = [first]
    canvas = page.find("#picture")
    for key in (Keys.ARROW_LEFT, Keys.ARROW_UP, "+", Keys.SHIFT + Keys.ARROW_RIGHT + Keys.NULL):
        seen.append(page.after(lambda: canvas.send_keys(key)))
    assert all((a != b).any() for i, a in enumerate(seen) for b in seen[:i])
    assert np.array_equal(page.after(lambda: canvas.send_keys(Keys.HOME)), first)


def test_zooming_by_the_wheel_makes_it_larger(page: Shown) -> None:
    def share(image: np.ndarray[Any, Any]) -> float:
        return float((image[..., :3] != image[0, 0, :3]).any(axis=2).mean())

    before = share(page.picture())
    canvas = page.find("#picture")
    wheel = "arguments[0].dispatchEvent(new WheelEvent('wheel', {deltaY: 100, bubbles: true, cancelable: true}))"
    assert share(page.after(lambda: page.browser.execute_script(wheel, canvas))) < before


def test_the_final_picture_is_bit_for_bit_what_the_printed_command_writes(page: Shown, tmp_path: pathlib.Path) -> None:
    page.picture()
    page.put("step", "0.25")
    image = page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_LEFT))
    run(page.text("#command"), tmp_path)
    assert np.array_equal(png(tmp_path / "picture.png"), image[..., :3])
    # So is the download.
    target = page.find("#get-png").get_attribute("href")
    status, content = page.program.get(target[target.index("/download") :])  # type: ignore[attr-defined]
    (tmp_path / "download.png").write_bytes(content)
    assert status == 200 and np.array_equal(png(tmp_path / "download.png"), image[..., :3])


def test_the_python_lines_make_the_same_picture(page: Shown, tmp_path: pathlib.Path, ball: pathlib.Path) -> None:
    page.picture()
    page.put("step", "0.75")
    image = page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_UP))
    (tmp_path / "lines.py").write_text(page.text("#python"))
    if "GICUBE_PYTHON" not in os.environ:
        pytest.skip("this build has no Python package")
    paths = os.pathsep.join([os.environ["GICUBE_PYTHON"], os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PYTHONPATH": paths, "GICUBE_BOARD": str(BIN / "gicube-board")}
    (tmp_path / "ball.nrrd").write_bytes(ball.read_bytes())
    subprocess.run([sys.executable, "lines.py"], cwd=tmp_path, check=True, env=environment, timeout=120)
    assert np.array_equal(png(tmp_path / "picture.png")[..., :3], image[..., :3])


def test_editing_the_transfer_function_changes_the_picture_and_can_be_undone(page: Shown, tmp_path: pathlib.Path) -> None:
    before = page.picture()
    assert page.find(".histogram").get_attribute("d").count("V") == 257
    last = page.browser.find_elements(By.CSS_SELECTOR, "[data-list=opacities]")[-1]
    down = ActionChains(page.browser, duration=20).click_and_hold(last).move_by_offset(0, 60).move_by_offset(-20, 0).release()
    after = page.after(down.perform)
    assert (before != after).any()
    assert Select(page.find("#preset")).first_selected_option.text == "own points"
    # What is saved is what the command takes.
    target = page.find("#get-tf").get_attribute("href")
    _, content = page.program.get(target[target.index("/download") :])  # type: ignore[attr-defined]
    (tmp_path / "view.tf").write_bytes(content)
    run(page.text("#command"), tmp_path)
    assert np.array_equal(png(tmp_path / "picture.png"), after[..., :3])
    assert np.array_equal(page.after(lambda: page.find("#undo").click()), before)
    assert np.array_equal(page.after(lambda: page.find("#redo").click()), after)


def test_the_editor_takes_keys(page: Shown) -> None:
    before = page.picture()
    point = page.browser.find_elements(By.CSS_SELECTOR, "[data-list=opacities]")[-1]
    after = page.after(lambda: point.send_keys(Keys.SHIFT + Keys.ARROW_DOWN + Keys.NULL))
    assert (before != after).any()
    label = page.browser.switch_to.active_element.get_attribute("aria-label")
    assert label is not None and label.startswith("opacity 0.")


def test_a_preset_is_shown_as_its_points(page: Shown) -> None:
    before = page.picture()
    after = page.after(lambda: Select(page.find("#preset")).select_by_value("ct-bone"))
    assert (before != after).any() and "--transfer-function=ct-bone" in page.text("#command")
    assert len(page.browser.find_elements(By.CSS_SELECTOR, "[data-list=colours]")) > 1


def test_a_cut_plane_takes_a_half_away(page: Shown) -> None:
    before = page.picture()
    after = page.after(lambda: Select(page.find("#cut-axis")).select_by_visible_text("x"))
    assert (before != after).any() and "--cut=1,0,0," in page.text("#command")
    other = page.after(lambda: page.find("#cut-side").click())
    assert (other != after).any() and "--cut=-1,0,0," in page.text("#command")


def test_a_wrong_setting_is_told_at_its_field_and_the_next_right_one_helps(page: Shown) -> None:
    before = page.picture()
    page.put("step", "99")
    wait("a fault", lambda: page.text(".fault"))
    assert "16" in page.text(".fault")
    assert page.find("#set-step").get_attribute("aria-invalid") == "true"
    after = page.after(lambda: page.put("step", "1"))
    assert page.text(".fault") == "" and (before != after).any()


def test_the_state_of_a_view_is_in_its_address(page: Shown) -> None:
    page.picture()
    page.put("samples", "2")
    image = page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_RIGHT))
    wait("the address", lambda: "eye=" in page.browser.current_url and "samples=2" in page.browser.current_url)
    again = Shown(page.browser, page.browser.current_url)
    assert np.array_equal(again.picture(), image)


def test_a_broken_file_is_refused_with_its_reason_and_the_scan_stays(page: Shown) -> None:
    before = page.picture()
    page.drop("broken.nrrd", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\nfew")
    wait("a notice", lambda: "broken.nrrd" in page.text("#notices"))
    assert np.array_equal(page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_RIGHT)).shape, before.shape)
    page.find("#notices button").click()
    assert page.text("#notices") == ""
    assert Select(page.find("#input")).first_selected_option.text == "ball.nrrd"


def test_a_dropped_scan_is_opened_and_a_dropped_look_is_taken(page: Shown, tmp_path: pathlib.Path) -> None:
    before = page.picture()
    write_ball(tmp_path / "small.nrrd", 32, hole=False)
    after = page.after(lambda: page.drop("small.nrrd", (tmp_path / "small.nrrd").read_bytes()))
    assert (before != after).any()
    assert Select(page.find("#input")).first_selected_option.text == "small.nrrd"
    look = b"values absolute\ncolour 0 1 0 0\ncolour 255 1 0 0\nopacity 0 0\nopacity 60 0\nopacity 80 1\n"
    red = page.after(lambda: page.drop("red.tf", look))
    assert red[64, 64, 0] > 2 * max(red[64, 64, 1], red[64, 64, 2])
    assert Select(page.find("#preset")).first_selected_option.text == "red.tf"


def test_a_board_that_is_killed_in_mid_frame_is_told_and_a_new_one_goes_on(page: Shown) -> None:
    before = page.picture()
    page.put("size", "512x512")
    page.put("fidelity", "cycle")
    wait("the cycle level's board", lambda: len(page.program.boards()) == 2)  # type: ignore[attr-defined]
    wait("its frame", lambda: "picture 1 of 1" in page.text("#status"))
    for board in page.program.boards():  # type: ignore[attr-defined]
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
        other = Shown(page.browser, page.program.address)  # type: ignore[attr-defined]
        assert np.array_equal(other.picture(), first)
        turned = other.after(lambda: other.find("#picture").send_keys(Keys.ARROW_LEFT))
        assert (turned != first).any()
    finally:
        page.browser.close()
        page.browser.switch_to.window(tab)
    assert np.array_equal(page.picture(), first)


BUCKYBALL = ("builtin:buckyball", "--fix", "volume-size=64", "--fix", "size=384x384", "--fix", "background=0,0,0")


@pytest.mark.parametrize("page", [BUCKYBALL if FOLDER else None], indirect=True)
def test_the_machine_is_seen_at_work(page: Shown) -> None:
    page.picture()
    page.find("#machine-panel summary").click()
    page.put("fidelity", "cycle")
    wait("a running frame", lambda: "a frame runs" in page.text("#machine-state"))
    wait("its cycles", lambda: page.browser.find_elements(By.CSS_SELECTOR, "#machine [aria-label='cycles by cause'] rect"))
    wait("more than a look at its time line", lambda: len(page.browser.find_elements(By.CSS_SELECTOR, "#timeline rect")) > 10)
    if FOLDER:
        page.shot((1280, 720), False, lambda: time.sleep(5), "view.png")
    page.picture()
    wait("the end", lambda: "figures of the last frame" in page.text("#machine-state"))
    assert "pictures a second on the card" in page.text("#status")
    for words in ("samples", "processor 3", "cache hit ratio", "rdram: bandwidth used", "bus up, bytes"):
        assert words in page.text("#machine")


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
        page = Shown(chromium, program.address)
        wait("the invitation", lambda: page.find("#empty").is_displayed())
        page.drop("ball.nrrd", ball.read_bytes())
        assert page.picture().shape == (128, 128, 4)
        assert not page.find("#empty").is_displayed()


def test_a_program_that_has_ended_is_told(chromium: webdriver.Chrome, ball: pathlib.Path) -> None:
    with Program(ball, *LOOK) as program:
        page = Shown(chromium, program.address)
        page.picture()
    wait("a notice", lambda: "connection to gicube-view has ended" in page.text("#notices"))


def test_a_wrong_token_gets_one_line_and_no_page(page: Shown) -> None:
    page.picture()
    wrong = Shown(page.browser, page.program.address[:-4] + "0000")  # type: ignore[attr-defined]
    assert wrong.text("body").startswith("token: expected that of the address")
    with Page(page.program, token="0" * 32) as refused:  # type: ignore[attr-defined]
        assert refused.status == 403
    page.browser.get_log("browser")  # of the refusal


def test_a_foreign_page_is_refused(page: Shown) -> None:
    page.picture()
    program: Program = page.program  # type: ignore[attr-defined]
    with Page(program, origin="http://example.org") as foreign:
        assert foreign.status == 403
    assert program.get(f"/?token={program.token}", Host="example.org")[0] == 403
    # As a script of another address would try it in a browser.
    page.browser.get(f"data:text/html,<title>foreign</title>")
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
