"""The dataclasses are the driver's records."""

import dataclasses
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import gicube
from gicube import _core

HEADERS = Path(__file__).parents[3] / "driver/include/gicube"


def test_hold_what_the_drivers_records_hold_if_nothing_is_said():
    assert len(_core.defaults()) == 37
    for held in _core.defaults():
        assert type(held)() == held


def declared(header):
    return re.sub(r"//[^\n]*", "", (HEADERS / header).read_text())


def test_the_board_has_every_call_of_the_cpp_one():
    body = re.search(r"class GICUBE_API Board \{(.*?) private:", declared("board.h"), re.DOTALL).group(1)
    calls = set(re.findall(r"^  \w[^;{=]*?\b(\w+)\((?=[^;]*[;{])", body, re.MULTILINE)) - {"Board"}
    assert {"open", "render", "counters", "set_empty_flags"} <= calls
    otherwise = {"open": "__init__", "set_empty_flags": "empty_flags"}
    # the parts, whose calls it has
    otherwise |= dict.fromkeys(["volume", "tables", "renderer", "rays", "light", "pairs"], "info")
    assert {call for call in calls if not hasattr(gicube.Board, otherwise.get(call, call))} == set()


def test_the_package_has_every_function_of_the_public_headers():
    otherwise = {"sampling_of": gicube.Sampling.of, "standard_error": gicube.LightingReport.standard_error,
                 "ray_between": gicube.rays_between}
    of_numpy = {"cross", "dot", "length", "normalise", "bytes_per_sample", "to_ms", "name_of"}
    of_own_plans = {"count_text", "plan_cost_line", "plan_error_line", "plan_headline", "plan_time_line"}  # their texts
    found = set()
    for header in HEADERS.glob("*.h"):
        if header.name not in ("c_types.h", "c_api.h", "testing.h"):
            found |= set(re.findall(r"^(?:GICUBE_API |inline |constexpr )+[\w:<>, *&]+?[ &*](\w+)\(",
                                    declared(header.name), re.MULTILINE))
    assert {"make_plan", "level_error", "standard_error", "dot"} <= found
    assert {name for name in found - set(otherwise) - of_numpy - of_own_plans if not hasattr(gicube, name)} == set()


def test_the_compiled_part_has_nothing_that_the_package_does_not_use():
    sources = "".join(path.read_text() for path in Path(gicube.__file__).parent.glob("*.py"))
    own = [name for name in dir(_core) if not name.startswith("__")] + [name
        for name in dir(_core.Board) if not name.startswith("__")]
    # of tests
    assert {name for name in own if f"_core.{name}" not in sources
            and f"_core import {name}" not in sources} == {"defaults"}


@pytest.mark.parametrize(
    "made, words",
    [
        (lambda board: board.render(gicube.View(eye=(1, 2))), "eye: expected three numbers"),
        (lambda board: board.render(gicube.View(eye=(1, 2, "z"))), "eye.z: expected a number, got 'z'"),
        (lambda board: board.render(gicube.View(width=1.5)), "width: expected an integer, got 1.5"),
        (lambda board: board.render(gicube.View(width=2**40)), "width: expected -2147483648..2147483647"),
        (lambda board: board.render(gicube.View(shade="no")), "shade: expected True or False, got 'no'"),
        (lambda board: board.render(gicube.View(lamps=[gicube.Lamp(light="sun")])),
         "lamps[0].light: expected one of PointLight, DirectionalLight"),
        (lambda board: board.render(gicube.View(filter="sinc")),
         "filter: expected a PixelFilter: box, tent, got 'sinc'"),
        (lambda board: board.render("a view"), "view: expected a View, or its fields by their names, got 'a view'"),
        (lambda board: board.illuminate(["lamp"]), "lights[0]: expected one of PointLight, DirectionalLight"),
        (lambda board: board.set_shading(gicube.Shading(gicube.Phong(ambient=None))),
         "shading.phong.ambient: expected a number"),
        (lambda board: board.set_material(gicube.Material(scattering=2)), "scattering: expected"),
        (lambda board: gicube.elements("b", (0, 0, 0), (1, 0, 0), (0, 1, 0)), "kind: expected a ElementKind: patch"),
        (lambda board: board.submit(gicube.rays((0, 0, 0), (0, 0, 1)), type="last_hit"), "type: expected a RayType"),
        (lambda board: gicube.Volume(np.zeros((4, 4, 4), "u1"), sample_type="u4"), "sample_type: expected"),
    ],
)
def test_a_wrong_value_names_its_field_what_was_expected_and_what_came(loaded, made, words):
    with pytest.raises(gicube.BadArgument) as fault:
        made(loaded)
    assert words in str(fault.value)
    assert loaded.render(gicube.fit_view(gicube.Volume(loaded.read_volume().astype("f4")), width=8,
                                         height=8)).width == 8


def test_errors_are_pythons_own_too_and_can_be_pickled():
    fault = gicube.BadArgument("a", "b", "c")
    assert isinstance(fault, ValueError) and isinstance(fault, gicube.Error)
    again = pickle.loads(pickle.dumps(fault))
    assert (again.field, again.expected, again.got) == ("a", "b", "c") and str(again) == str(fault)
    faulty = pickle.loads(pickle.dumps(gicube.FileError("text", [gicube.Fault("a", 1, "b", "c", "d", "e")])))
    assert type(faulty) is gicube.FileError and faulty.faults[0].line == 1 and str(faulty) == "text"
    assert pickle.loads(pickle.dumps(gicube.DeviceLost("text", gicube.Loss.ENDED))).cause is gicube.Loss.ENDED
    assert issubclass(gicube.TimedOut, TimeoutError) and issubclass(gicube.DeviceLost, ConnectionError)


def test_text_stands_for_the_value_of_an_enumeration():
    assert gicube.RayType("first_hit") is gicube.RayType.FIRST_HIT


def test_what_is_offered_is_documented():
    names = [name for name in dir(gicube) if not name.startswith("_")]
    assert {"Board", "open", "render"} - set(names) == {"render"}
    for name in names:
        offered = getattr(gicube, name)
        if callable(offered) and not isinstance(offered, type(gicube.Light)):
            assert dataclasses.is_dataclass(offered) or offered.__doc__ or offered.__module__ == "gicube._core", name
