"""gicube-view's connections without a browser: many that come and go, and what is refused."""

from __future__ import annotations

import os
import pathlib
import subprocess
import time
from typing import Any, Callable

import pytest
from view_program import BIN, Page, Program

MOVING = {"do": "picture", "id": 1, "moving": True, "settings": {}}


def descriptors(process: int) -> int:
    return len(os.listdir(f"/proc/{process}/fd"))


def status(process: int, field: str) -> int:
    lines = pathlib.Path(f"/proc/{process}/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith(field + ":")))


def settled(read: Callable[[], int]) -> int:
    """The least that is seen within a while: what has ended is closed soon."""
    least = read()
    for _ in range(100):
        least = min(least, read())
        time.sleep(0.02)
    return least


def test_a_hundred_pages_that_leave_in_mid_frame_leave_nothing_behind(ball: pathlib.Path) -> None:
    with Program(ball, "--fix", "size=256x256", "--fix", "step=0.25") as program:
        process = program.process.pid

        def come_and_go(count: int) -> None:
            for i in range(count):
                with Page(program) as page:
                    page.wait_for("hello")
                    page.send({"do": "machine", "on": True})
                    page.send({**MOVING, "settings": {"fidelity": "cycle"} if i % 10 == 0 else {}})
                    page.send({**MOVING, "id": 2, "moving": False})
                    if i % 2 == 0:
                        page.wait_for("picture")

        # Whole pictures at both levels, so that the program has the boards of both, or of the last one, whatever was
        # stopped before.
        def rest() -> None:
            with Page(program) as page:
                page.wait_for("hello")
                for number, settings in ((3, {"fidelity": "cycle", "size": "64x64"}), (4, {})):
                    page.send({**MOVING, "id": number, "moving": False, "settings": settings})
                    page.wait_for("picture", id=number, final=True)

        come_and_go(20)
        rest()
        before = settled(lambda: descriptors(process)), settled(lambda: status(process, "Threads"))
        board = program.boards()[0]
        memory = status(process, "VmRSS"), status(board, "VmRSS")
        come_and_go(100)
        rest()
        assert (settled(lambda: descriptors(process)), settled(lambda: status(process, "Threads"))) == before
        # KiB; what a hundred pages with a picture of 256 KiB each would hold, were they kept, is 25,000.
        assert status(process, "VmRSS") - memory[0] < 12_000
        assert program.boards()[0] != board or status(board, "VmRSS") - memory[1] < 12_000
        with Page(program) as page:
            page.wait_for("hello")
            page.send({**MOVING, "moving": False})
            page.wait_for("picture", final=True)


def test_a_picture_in_which_nothing_is_visible_says_why(ball: pathlib.Path) -> None:
    with Program(ball) as program, Page(program) as page:
        page.wait_for("hello")
        page.send({**MOVING, "moving": False, "settings": {"cut": "1,0,0,900"}})
        seen, _ = page.wait_for("picture", id=1, final=True)
        assert seen["invisible"] == "nothing is visible in the picture: all that is visible is cut away"
        page.send({**MOVING, "id": 2, "moving": False})
        assert "invisible" not in page.wait_for("picture", id=2, final=True)[0]


def test_a_moving_camera_never_waits_for_an_old_picture(ball: pathlib.Path) -> None:
    slow = {"size": "512x512", "samples": "4", "step": "0.0625"}
    with Program(ball) as program, Page(program) as page:
        page.wait_for("hello")
        page.send({"do": "picture", "id": 1, "moving": False, "settings": slow})
        page.wait_for("picture", id=1, final=False)
        page.send({"do": "picture", "id": 2, "moving": True, "settings": {}})
        kinds = [(header["id"], header["final"]) for header, _ in [page.wait_for("picture")]]
        assert kinds == [(2, False)] or kinds == [(2, True)]


def keeps_all(message: dict[str, Any]) -> int:
    """Every ray that waits is in a block and a processor, every packet in a bank; returns the rays. A board's first
    look has none of it."""
    counters, look = message["counters"], message.get("look")
    if look is None:
        return 0
    waiting = counters["processor.sorter.written"] - counters["processor.sorter.issued"]
    assert sum(look["waiting"]) == sum(look["processors"]) == waiting
    x, y, z = look["cells"]
    assert len(look["waiting"]) == x * y * z and look["blocks_a_side"] == 1
    for i, packets in enumerate(look["memories"]):
        assert len(packets) % look["banks"] == 0
        assert sum(packets) == counters[f"rdram{i}.reads"] + counters[f"rdram{i}.writes"]
    return waiting


def test_counters_come_in_mid_frame_while_a_page_looks_and_not_without(ball: pathlib.Path) -> None:
    with Program(ball, "--fidelity", "cycle", "--fix",
                 "size=384x384") as program, Page(program) as page, Page(program) as other:
        page.wait_for("hello")
        other.wait_for("hello")
        page.send({"do": "machine", "on": True})
        first, _ = page.wait_for("machine", running=False)
        assert first["units"]["bus.down.bytes"] == "byte"
        page.send({"do": "picture", "id": 1, "moving": False, "settings": {}})
        seen, most = [], 0
        for header, _ in page.all():
            if header["type"] == "machine" and header["running"]:
                seen.append(header["counters"].get("asic.cycles", 0))
                most = max(most, keeps_all(header))
            if header["type"] == "picture" and header["final"]:
                break
        last, _ = page.wait_for("machine", running=False)
        cycles = last["counters"]["asic.cycles"]
        # Rays wait within a frame and none behind it, but its packets are counted.
        assert most > 0 and keeps_all(last) == 0 and sum(map(sum, last["look"]["memories"])) > 0
        assert seen == sorted(seen) and len({look for look in seen if 0 < look < cycles}) >= 3
        assert "units" not in last
        other.send({"do": "picture", "id": 1, "moving": True, "settings": {}})
        for header, _ in other.all():
            assert header["type"] != "machine"
            if header["type"] == "picture":
                break


def test_a_comparison_tells_what_differs_and_gives_way_to_its_page(ball: pathlib.Path) -> None:
    small, large = {"size": "32x32", "fidelity": "cycle"}, {"size": "512x512", "fidelity": "cycle"}
    with Program(ball, "--fix", "size=64x64") as program, Page(program) as page:
        page.wait_for("hello")
        page.send({"do": "compare", "id": 7, "settings": small, "other": {**small, "asic.processors": "1"}})
        told, _ = page.wait_for("compared", id=7)
        assert told["same"] and [frame["settings"].get("asic.processors") for frame in told["frames"]] == [None, "1"]
        assert "processor3.samples" in told["frames"][0]["counters"] and "processor1.samples" not in told["frames"][1][
            "counters"]
        page.send({"do": "compare", "id": 8, "settings": large, "other": large})
        page.send(MOVING)
        kinds = []
        while len(kinds) < 2:
            header, _ = page.receive()
            if header["type"] in ("error", "picture", "compared"):
                kinds.append((header["type"], header["id"]))
        assert kinds == [("error", 8), ("picture", 1)]


def test_an_input_that_cannot_be_read_is_told_to_the_page_that_comes(tmp_path: pathlib.Path) -> None:
    with Program(tmp_path / "none.nrrd") as program, Page(program) as page:
        # The page may come before the fault is found, and is told at once then too.
        told = {}
        while not {"hello", "error"} <= told.keys():
            header, _ = page.receive()
            told[header["type"]] = header
        assert told["hello"]["volume"] is None and "none.nrrd" in told["error"]["text"]


def test_a_board_that_is_not_there_is_told_and_found_once_it_is(ball: pathlib.Path, tmp_path: pathlib.Path) -> None:
    endpoint = f"unix:{tmp_path}/board"
    with Program(ball, "--board", endpoint, "--fix", "size=64x64") as program, Page(program) as page:
        page.wait_for("board", state="lost")
        with subprocess.Popen([str(BIN / "gicube-board"), "--listen", endpoint, "--quiet"]) as board:
            while not (tmp_path / "board").exists():
                time.sleep(0.02)
            page.send({"do": "board"})
            page.wait_for("board", state="ready")
            page.send({"do": "machine", "on": True})
            page.send({**MOVING, "moving": False})
            page.wait_for("picture", final=True)
            # This user's board on this machine, by its endpoint.
            page.wait_for("machine", running=False)
            board.terminate()


@pytest.mark.parametrize("message", [b"", b"{", b'{"do":"none"}', b'{"do":"slice","id":1,"axis":"w","at":0}',
                                     b'{"do":"open","names":["../x"]}'])
def test_a_message_that_is_none_ends_the_connection_and_no_other(ball: pathlib.Path, message: bytes) -> None:
    with Program(ball, "--fix", "size=64x64") as program, Page(program) as page, Page(program) as other:
        page.wait_for("hello")
        page.send(message)
        with pytest.raises(ConnectionError, match="1008"):
            for _ in page.all():
                pass
        other.wait_for("hello")
        other.send({**MOVING, "moving": False})
        other.wait_for("picture", final=True)


def test_answers_are_one_line_of_text_and_closed_to_other_pages(ball: pathlib.Path) -> None:
    with Program(ball) as program:
        token = f"token={program.token}"
        own = {"Origin": f"http://127.0.0.1:{program.port}"}
        assert program.get(f"/?{token}")[0] == 200
        assert program.get("/main.js")[0] == 200
        cases: list[tuple[str, str, dict[str, str], int]] = [
            ("/", "GET", {}, 403),
            ("/index.html", "GET", {}, 404),
            ("/none.js", "GET", {}, 404),
            (f"/?{token}", "DELETE", {}, 400),
            (f"/file?{token}&name=a.nrrd", "POST", {}, 403),
            (f"/file?{token}&name=..%2Fa", "POST", own, 400),
            ("/file?name=a.nrrd", "POST", own, 403),
            (f"/download?{token}&what=png&number=1", "GET", {}, 404),
            (f"/socket?{token}", "GET", own, 400),
            ("/%zz", "GET", {}, 400),
            (f"/?{token}", "GET", {"Host": "example.org"}, 403),
        ]
        for path, method, headers, expected in cases:
            status, text = program.get(path, method, b"x" if method == "POST" else None, **headers)
            assert status == expected and text.endswith(b"\n") and text.count(b"\n") == 1, path
        assert program.get(f"/file?{token}&name=a.nrrd", "POST", b"x", **own)[0] == 204
