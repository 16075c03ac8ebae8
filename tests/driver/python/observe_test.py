"""Events of a private board by a callable, and the debugger of a board with a management plane."""

import collections
import os
import pathlib
import subprocess
import threading
import time

import pytest
from conftest import LOOK, ball

import gicube
import gicube.observe

PROGRAMS = pathlib.Path(os.environ["GICUBE_BOARD"]).parent


def draw(uri: str) -> gicube.Image:
    with gicube.open(uri) as board:
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        return board.render(gicube.fit_view(gicube.Volume(ball()), [LOOK], width=32, height=32))


def test_a_callable_gets_a_rays_life_in_order() -> None:
    steps = []
    with gicube.observe.events(steps.append, of="pixel=16:16") as options:
        draw("emu:?fidelity=cycle&" + options)
    assert [step["event"] for step in steps[:2]] == ["made", "sent"]
    assert steps[2]["event"] in ("queued", "overflowed")
    assert steps[-1]["event"] == "taken"
    assert sorted(step["cycle"] for step in steps) == [step["cycle"] for step in steps]
    assert sum(step["event"] == "sampled" for step in steps) > 3


def test_events_of_lit_rays_are_the_boards_counters() -> None:
    steps = []
    with gicube.observe.events(steps.append, of="rays=0:1000000") as options:
        with gicube.open("emu:?fidelity=cycle&set=asic.block_voxels=8&" + options) as board:
            board.load_volume(ball(16, 5))
            board.set_transfer_function(LOOK)
            board.illuminate([gicube.PointLight((7.5, 7.5, 1))], gicube.Illumination(rays_per_face_voxel=1))
            counters = board.counters
    count = collections.Counter((step["event"], "carrier" in step) for step in steps)
    carriers = counters["processor.splat.carriers"]
    assert carriers > 0
    assert sum(step["count"] for step in steps if step["event"] == "deposited") == carriers == count["gone", True]
    assert count["deposited", False] + carriers == counters["processor.splat.deposits"]
    assert count["sampled", False] == counters["processor.samples"]
    assert count["taken", False] == counters["dsp.rays_taken"]
    assert count["linked", False] + count["linked", True] == counters["link.rays_sent"]


def test_what_a_callable_raises_comes_at_the_end() -> None:
    def refuse(event: object) -> None:
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        with gicube.observe.events(refuse, of="rays=0:1000") as options:
            draw("emu:?fidelity=cycle&" + options)


def test_a_board_that_is_never_opened_leaves_no_thread() -> None:
    before = threading.active_count()
    with gicube.observe.events(print, of="rays=0:1"):
        pass
    assert threading.active_count() == before


def test_a_faulty_selection_is_refused_by_the_board() -> None:
    with pytest.raises(gicube.BadArgument, match="pixel: expected X:Y"):
        with gicube.observe.events(print, of="pixel=1") as options:
            draw("emu:?fidelity=cycle&" + options)


def test_a_debugger_stops_a_board_and_lets_it_go(tmp_path: pathlib.Path) -> None:
    bus, plane = f"unix:{tmp_path}/b", f"unix:{tmp_path}/m"
    program = subprocess.Popen(
        [PROGRAMS / "gicube-board", "--listen", bus, "--management", plane, "--set", "fidelity=cycle", "--quiet"]
    )
    try:
        while not (tmp_path / "m").exists():
            time.sleep(0.01)
        expected = draw(bus)
        images = []
        with gicube.observe.Debugger(plane, program=str(PROGRAMS / "gicube-smi")) as debugger:
            assert not debugger.is_paused
            debugger.say("break pixel 16 16")
            drawing = threading.Thread(target=lambda: images.append(draw(bus)))
            drawing.start()
            assert "was made" in debugger.say("continue 30")
            assert debugger.is_paused and debugger.stands
            assert "DSP: " in debugger.say("why")
            smi = [PROGRAMS / "gicube-smi", "info", "--management", plane]  # others are answered meanwhile
            subprocess.run(smi, check=True, stdout=subprocess.DEVNULL)
            with pytest.raises(gicube.Error, match="expected a command that help lists"):
                debugger.say("jump")
            with pytest.raises(gicube.Error, match="another caller debugs"):
                gicube.observe.Debugger(plane, program=str(PROGRAMS / "gicube-smi"))
        drawing.join()
        assert images[0] == expected
    finally:
        program.terminate()
        program.wait()
