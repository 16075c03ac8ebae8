"""gicube-view's page under fingers, and what is dropped on it: slices voxel by voxel, scenes, touch."""

from __future__ import annotations

import pathlib
import re
from typing import Any

import numpy as np
import pytest
from browser import Shown, png, run, wait
from selenium.webdriver.support.ui import Select

SCENE = """
volume { builtin: "buckyball" size: 32 }
camera { eye { x: 60 y: 50 z: -30 } look_at { x: 15.5 y: 15.5 z: 15.5 } }
"""


def voxels(ball: pathlib.Path) -> np.ndarray[Any, Any]:
    content = ball.read_bytes()
    return np.frombuffer(content[content.index(b"\n\n") + 2 :], dtype="u1").reshape(48, 48, 48)


@pytest.mark.parametrize("axis", "zyx")
def test_a_slice_shows_its_voxels_and_no_others(page: Shown, ball: pathlib.Path, axis: str) -> None:
    page.picture()
    at = 17
    page.browser.execute_script(
        "const slider = document.getElementById(arguments[0]); slider.value = arguments[1]; slider.dispatchEvent(new Event('input'))",
        f"slice-{axis}",
        at,
    )
    # Along z it lies as in the file, y down; along the others z is up.
    expected = {"z": voxels(ball)[at], "y": voxels(ball)[::-1, at], "x": voxels(ball)[::-1, :, at]}[axis]
    canvas = f"canvas[aria-label='slice along {axis}']"
    wait("the slice", lambda: np.array_equal(page.pixels(canvas)[..., 0], expected))
    assert (page.pixels(canvas)[..., 3] == 255).all() and f"{axis} {at}" in page.text("#slices")


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
