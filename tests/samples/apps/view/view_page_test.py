"""gicube-view's picture in a real browser: what a person does, and what is seen then, as pixels and text."""

from __future__ import annotations

import os
import pathlib
import signal
import subprocess
import sys
import urllib.parse
from typing import Any

import numpy as np
import pytest
from browser import Shown, png, run, wait
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from view_program import BIN, write_ball


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


def test_a_picture_is_busy_until_the_newest_request_is_answered(page: Shown) -> None:
    first = page.picture()
    busy = lambda: page.find("#picture").get_attribute("aria-busy")
    assert busy() == "false"
    page.program.process.send_signal(signal.SIGSTOP)
    try:
        page.find("#picture").send_keys(Keys.ARROW_LEFT)
        assert busy() == "true"
    finally:
        page.program.process.send_signal(signal.SIGCONT)
    assert (page.picture() != first).any() and busy() == "false"


def test_the_final_picture_is_bit_for_bit_what_the_printed_command_writes(page: Shown, tmp_path: pathlib.Path) -> None:
    page.picture()
    page.put("step", "0.25")
    image = page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_LEFT))
    run(page.text("#command"), tmp_path)
    assert np.array_equal(png(tmp_path / "picture.png"), image[..., :3])
    # So is the download.
    target = page.find("#get-png").get_attribute("href")
    status, content = page.program.get(target[target.index("/download") :])
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


def test_editing_the_transfer_function_changes_the_picture_and_can_be_undone(page: Shown,
    tmp_path: pathlib.Path) -> None:
    before = page.picture()
    assert page.find(".histogram").get_attribute("d").count("V") == 257
    last = page.browser.find_elements(By.CSS_SELECTOR, "[data-list=opacities]")[-1]
    down = ActionChains(page.browser, duration=20).click_and_hold(last).move_by_offset(0, 60).move_by_offset(-20,
        0).release()
    after = page.after(down.perform)
    assert (before != after).any()
    assert Select(page.find("#preset")).first_selected_option.text == "own points"
    # The saved file is one that the command takes.
    target = page.find("#get-tf").get_attribute("href")
    _, content = page.program.get(target[target.index("/download") :])
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
    again = Shown(page.browser, page.program, page.browser.current_url)
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
