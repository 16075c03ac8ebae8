"""gicube-view's page under fingers, and what is dropped on it: slices voxel by voxel, scenes, touch."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import numpy as np
import pytest
from browser import Shown, png, run, wait
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from view_program import Program

SCENE = """
volume { builtin: "buckyball" size: 32 }
camera { eye { x: 60 y: 50 z: -30 } look_at { x: 15.5 y: 15.5 z: 15.5 } }
"""


def voxels(ball: pathlib.Path) -> np.ndarray[Any, Any]:
    content = ball.read_bytes()
    return np.frombuffer(content[content.index(b"\n\n") + 2 :], dtype="u1").reshape(48, 48, 48)


def show_values(page: Shown, level: float, window: float) -> None:
    """Types into the fields of the window of values."""
    page.browser.execute_script(
        "for (const [id, value] of Object.entries(arguments[0])) document.getElementById(id).value = value;"
        "document.getElementById('window').dispatchEvent(new Event('change'))",
        {"level": level, "window": window},
    )


@pytest.mark.parametrize("axis", "zyx")
def test_a_slice_shows_its_voxels_and_no_others(page: Shown, ball: pathlib.Path, axis: str) -> None:
    page.picture()
    at = 17
    page.browser.execute_script(
        "const slider = document.getElementById(arguments[0]); slider.value = arguments[1]; slider.dispatchEvent(new "
        "Event('input'))",
        f"slice-{axis}",
        at,
    )
    show_values(page, 127.5, 255)
    # Along z it lies as in the file, y down; along the others z is up.
    expected = {"z": voxels(ball)[at], "y": voxels(ball)[::-1, at], "x": voxels(ball)[::-1, :, at]}[axis]
    canvas = f"canvas[aria-label='slice along {axis}']"
    wait("the slice", lambda: np.array_equal(page.pixels(canvas)[..., 0], expected))
    assert (page.pixels(canvas)[..., 3] == 255).all() and f"{axis} {at}" in page.text("#slices")


def test_slices_are_linked_by_a_point_whose_value_is_told(page: Shown, ball: pathlib.Path) -> None:
    page.picture()
    canvas = page.find("canvas[aria-label='slice along z']")
    wait("a slice", lambda: canvas.get_attribute("width") == "48")
    box = canvas.rect
    at = (10, 30)  # of 48 voxels along x and y
    offset = [round((voxel + 0.5) / 48 * box[edge] - box[edge] / 2) for voxel, edge in zip(at, ("width", "height"))]
    ActionChains(page.browser).move_to_element_with_offset(canvas, *offset).click().perform()
    assert page.find("#slice-x").get_attribute("value") == "10" and page.find("#slice-y").get_attribute("value") == "30"
    value = voxels(ball)[24, 30, 10]
    wait("the value", lambda: page.text("#value").strip() == f"x 10, y 30, z 24: {value}")
    canvas.send_keys(Keys.ARROW_RIGHT, Keys.PAGE_UP)
    value = voxels(ball)[25, 30, 11]
    wait("the next one", lambda: page.text("#value").strip() == f"x 11, y 30, z 25: {value}")


def test_window_and_level_follow_a_drag(page: Shown, ball: pathlib.Path) -> None:
    page.picture()
    canvas = page.find("canvas[aria-label='slice along z']")
    wait("a slice", lambda: canvas.get_attribute("width") == "48")
    level, window = (float(str(page.find(name).get_attribute("value"))) for name in ("#level", "#window"))
    keys = ActionChains(page.browser).key_down(Keys.SHIFT).move_to_element(canvas).click_and_hold()
    keys.move_by_offset(20, -10).release().key_up(Keys.SHIFT).perform()
    share = 20 / canvas.rect["width"]
    wait("the window", lambda: abs(float(str(page.find("#window").get_attribute("value"))) - window * (1 +
        share)) < 0.02 * window)
    assert abs(float(str(page.find("#level").get_attribute("value"))) - (level + window * share / 2)) < 0.02 * window


# A ray for each column of voxels along y, whole voxels from the eye.
ALONG_Y = ("--fix", "eye=23.5,-100,23.5", "--fix", "look-at=23.5,23.5,23.5", "--fix", "up=0,0,1", "--fix",
           "orthographic=48", "--fix", "size=48x48")


def test_projections_are_the_maximum_and_the_average_along_the_pictures_rays(chromium: webdriver.Chrome,
                                                                             ball: pathlib.Path) -> None:
    along_y, canvas = voxels(ball).astype(float), "#projected"
    with Program(ball, *ALONG_Y) as program:
        page = Shown(chromium, program)
        page.picture()
        show_values(page, 127.5, 255)
        for show, values in (("max", along_y.max(axis=1)), ("mean", along_y.mean(axis=1))):
            Select(page.find("#projection")).select_by_value(show)
            wait("its size", lambda: page.pixels(canvas).shape == (48, 48, 4))
            wait(show, lambda: np.abs(page.pixels(canvas)[..., 0] - values[::-1]).max() <= 1)
        before = page.pixels(canvas)
        page.after(lambda: page.find("#picture").send_keys(Keys.ARROW_LEFT))
        wait("the next view's", lambda: (page.pixels(canvas) != before).any())
        Select(page.find("#projection")).select_by_value("")
        assert not page.find(canvas).is_displayed()
        assert page.faults() == []


def test_a_dropped_scene_is_shown_as_gicube_render_makes_it(page: Shown, tmp_path: pathlib.Path) -> None:
    page.picture()
    (tmp_path / "small.scene").write_text(SCENE)
    page.after(lambda: page.drop("small.scene", SCENE.encode()))
    wait("its name", lambda: Select(page.find("#input")).first_selected_option.text == "small.scene")
    image = page.picture()
    assert "small.scene" in page.text("#command")
    run(page.text("#command"), tmp_path)
    assert np.array_equal(image[..., :3], png(tmp_path / "picture.png"))


def of_command(page: Shown, option: str) -> np.ndarray[Any, Any]:
    """A position of the whole picture that is shown."""
    page.picture()
    found = re.search(rf"--{option}=(\S+)", page.text("#command"))
    assert found, page.text("#command")
    return np.array([float(x) for x in found[1].split(",")])


class Fingers:
    """On the picture, by places from its middle."""

    def __init__(self, page: Shown) -> None:
        self.page = page
        box = page.find("#picture").rect
        self.middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def touch(self, kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": self.middle[0] + x, "y": self.middle[1] + y, "id": i} for i, (x, y) in enumerate(places)]
        self.page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def drag(self, begin: list[tuple[float, float]], end: list[tuple[float, float]], steps: int = 5) -> None:
        self.touch("touchStart", *begin)
        for step in range(1, steps + 1):
            share = step / steps
            self.touch("touchMove", *[(x + share * (u - x), y + share * (v - y)) for (x, y), (u, v) in zip(begin, end)])
        self.touch("touchEnd")


def test_a_finger_turns_it_round_what_is_looked_at(page: Shown) -> None:
    eye, target = of_command(page, "eye"), of_command(page, "look-at")
    page.after(lambda: Fingers(page).drag([(0, 0)], [(40, 10)]))
    turned = of_command(page, "eye")
    assert np.allclose(of_command(page, "look-at"), target, atol=1e-3)
    assert np.linalg.norm(turned - target) == pytest.approx(np.linalg.norm(eye - target), rel=1e-4)
    # 40 of 128 pixels, three radians a height, are more than half a radian across.
    cosine = np.dot(turned - target, eye - target) / np.linalg.norm(eye - target) ** 2
    assert 0.5 < np.arccos(cosine) < 1.2


def test_two_fingers_that_part_go_nearer_and_two_that_go_together_move_it(page: Shown) -> None:
    def offset() -> np.ndarray[Any, Any]:
        return of_command(page, "eye") - of_command(page, "look-at")

    far = offset()
    page.after(lambda: Fingers(page).drag([(-15, 0), (15, 0)], [(-30, 0), (30, 0)]))
    assert np.allclose(offset(), far / 2, rtol=1e-3, atol=1e-3)
    target = of_command(page, "look-at")
    page.after(lambda: Fingers(page).drag([(-20, 0), (20, 0)], [(-20, 30), (20, 30)]))
    assert np.allclose(offset(), far / 2, rtol=1e-3, atol=1e-3)
    assert np.linalg.norm(of_command(page, "look-at") - target) > 1
