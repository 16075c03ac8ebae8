"""What files, connections, pages and signals can't make gicube-view do."""

from __future__ import annotations

import gzip
import os
import pathlib
import pty
import re
import resource
import signal
import socket
import subprocess
import time
from typing import Any, Iterator

import numpy as np
import pytest
from browser import png, run, wait
from view_program import BIN, Page, Program, Running, write_ball

SMALL = ("--fix", "size=64x64", "--fix", "background=0.1,0.2,0.3")
PICTURE = {"do": "picture", "id": 1, "moving": False, "settings": {}}
SECRET = "root:x:0:0:root"


def picture(page: Page, number: int, **settings: str) -> tuple[dict[str, Any], bytes]:
    page.send({**PICTURE, "id": number, "settings": settings})
    return page.wait_for("picture", id=number, final=True)


def opened(page: Page, *names: str) -> dict[str, Any]:
    """What opening these files is answered with: an error, or hello."""
    page.send({"do": "open", "names": list(names)})
    for header, _ in page.all():
        if header["type"] == "error" or (header["type"] == "hello" and header["volume"]["name"] == names[0]):
            return header
    raise AssertionError


# ---- names in files


@pytest.mark.parametrize(
    "field, scene",
    [
        ("volume.file", 'volume { file: "NAME" raw { dims: [2, 2, 2] type: "uint8" } }'),
        ("transfer_function.file", 'volume { builtin: "buckyball" size: 16 } transfer_function { file: "NAME" }'),
        ("mesh.file", 'world { size: 16 node { name: "n" material: "m" mesh { file: "NAME" } } } '
         'material { name: "m" }'),
        ("volume.file", 'world { node { name: "n" material: "m" volume { file: "NAME" } } } material { name: "m" }'),
    ],
    ids=["volume", "transfer_function", "mesh", "scan"],
)
def test_a_dropped_scene_names_no_file_beside_its_own(
    ball: pathlib.Path, tmp_path: pathlib.Path, field: str, scene: str
) -> None:
    (tmp_path / "secret").write_text(SECRET + "\nsecond line\n")
    with Program(ball, *SMALL, env={**os.environ, "TMPDIR": str(tmp_path)}) as program, Page(program) as page:
        page.wait_for("hello")
        faults = []
        names = [tmp_path / "secret", "../secret", "a/../../secret", "../none", "/proc/self/environ"]
        for number, name in enumerate(names):
            assert program.post(f"{number}.scene", scene.replace("NAME", str(name)).encode())[0] == 204
            answer = opened(page, f"{number}.scene")
            assert answer["type"] == "error" and f"{field}: expected a file in " in answer["text"], answer
            assert SECRET not in answer["text"] and "second" not in answer["text"]
            faults.append(re.sub(r"\d\.scene|\"[^\"]*\"", "", answer["text"]))
        assert len(set(faults)) == 1  # whether it is there is not told
        # One of its own is read.
        assert program.post("look.tf", b"values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 200 1\n")[0] == 204
        own = 'volume { builtin: "buckyball" size: 16 } transfer_function { file: "look.tf" }'
        assert program.post("own.scene", own.encode())[0] == 204
        assert opened(page, "own.scene", "look.tf")["type"] == "hello"


def test_a_scene_of_the_command_line_names_none_either(tmp_path: pathlib.Path) -> None:
    (tmp_path / "own").mkdir()
    (tmp_path / "look.tf").write_text(SECRET + "\n")
    scene = 'volume { builtin: "buckyball" size: 16 } transfer_function { file: "../look.tf" }'
    (tmp_path / "own" / "a.scene").write_text(scene)
    with Program(tmp_path / "own" / "a.scene") as program, Page(program) as page:
        for header, _ in page.all():
            if header["type"] == "error":
                break
        assert "transfer_function.file: expected a file in " in header["text"] and SECRET not in header["text"]


def test_a_name_that_begins_as_an_option_is_a_file_in_the_printed_command(tmp_path: pathlib.Path) -> None:
    write_ball(tmp_path / "--help", 16)
    (tmp_path / "--help").rename(tmp_path / "-h.nrrd")
    with Program(*SMALL) as program, Page(program) as page:
        page.wait_for("hello")
        assert program.post("-h.nrrd", (tmp_path / "-h.nrrd").read_bytes())[0] == 204
        assert opened(page, "-h.nrrd")["type"] == "hello"
        header, pixels = picture(page, 2)
        run(header["command"], tmp_path)
        shown = np.frombuffer(pixels, "u1").reshape(64, 64, 4)[..., :3]
        assert np.array_equal(png(tmp_path / "picture.png"), shown)


def test_a_posted_pair_is_opened_by_its_header(tmp_path: pathlib.Path) -> None:
    nibabel = pytest.importorskip("nibabel")
    nibabel.save(nibabel.AnalyzeImage(np.eye(8, dtype="i2")[:, :, None] * np.arange(8, dtype="i2"), np.eye(4)),
                 tmp_path / "a.img")
    with Program(*SMALL) as program, Page(program) as page:
        page.wait_for("hello")
        for name in ("a.hdr", "a.img"):
            assert program.post(name, (tmp_path / name).read_bytes())[0] == 204
        assert opened(page, "a.hdr", "a.img")["volume"]["dims"] == [8, 8, 8]


# ---- connections


def test_silent_connections_keep_nobody_out(ball: pathlib.Path) -> None:
    with Program(ball, *SMALL) as program:
        silent = [socket.create_connection(("127.0.0.1", program.port)) for _ in range(80)]
        silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: ")
        with Page(program) as page:
            assert page.status == 101
            picture(page, 1)
            assert program.get(f"/?token={program.token}")[0] == 200
            assert program.get("/main.js")[0] == 200
            # Nor do those with the token that are at work: newer silent ones go before them.
            silent += [socket.create_connection(("127.0.0.1", program.port)) for _ in range(80)]
            picture(page, 2)
        for each in silent:
            each.close()


def test_connections_with_the_token_leave_places_for_others(ball: pathlib.Path) -> None:
    with Program(ball, *SMALL) as program:
        pages = []
        while len(pages) < 40:
            pages.append(Page(program))
            if pages[-1].status != 101:
                break
        assert pages[-1].status == 503 and len(pages) == 29  # an eighth of 32 is for newcomers
        assert program.get("/main.js")[0] == 200
        for each in pages:
            each.socket.close()


@pytest.mark.parametrize("target", ["?x", "x", "*", "http://127.0.0.1/"])
def test_a_target_without_a_path_is_answered(ball: pathlib.Path, target: str) -> None:
    with Program(ball) as program, socket.create_connection(("127.0.0.1", program.port), timeout=60) as plain:
        plain.sendall(f"GET {target} HTTP/1.1\r\nHost: 127.0.0.1:{program.port}\r\n\r\n".encode())
        assert plain.recv(1000).startswith(b"HTTP/1.1 400 ")


def memory(process: int) -> int:
    """In MiB, the most so far."""
    status = pathlib.Path(f"/proc/{process}/status").read_text()
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    assert found
    return int(found[1]) >> 10


def test_a_page_that_reads_nothing_is_left(ball: pathlib.Path) -> None:
    look = "values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 200 1\n"
    long = f"transfer-function={look}#{'x' * 100_000}"  # each hello has it
    with Program(ball, *SMALL, "--fix", long) as program, Page(program) as page, Page(program) as other:
        picture(other, 1)
        assert program.post("look.tf", look.encode())[0] == 204
        for _ in range(600):  # of 100 KB each, to both
            other.send({"do": "open", "names": ["look.tf"]})
            other.wait_for("hello")
        page.socket.settimeout(10)
        with pytest.raises(ConnectionError):
            for _ in page.all():
                pass
        picture(other, 2)


def test_slices_that_are_not_read_take_the_memory_of_the_last_ones(tmp_path: pathlib.Path) -> None:
    head = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 2\nencoding: raw\n\n"
    (tmp_path / "flat.nrrd").write_bytes(head + bytes(2 << 20))
    with Program(tmp_path / "flat.nrrd", *SMALL) as program, Page(program) as page, Page(program) as other:
        other.wait_for("hello")
        before = memory(program.process.pid)
        for number in range(100):  # of a mebibyte each
            page.send({"do": "slice", "id": number, "axis": "z", "at": number % 2})
            time.sleep(0.002)  # so that it comes first
            other.send({"do": "slice", "id": number, "axis": "x", "at": 0})
            other.wait_for("slice", id=number)
        assert memory(program.process.pid) - before < 48
        for header, _ in page.all():  # the newest comes
            if header["type"] == "slice" and header["id"] == 99:
                break


# ---- posted files


def begin_post(program: Program, name: str, size: int) -> socket.socket:
    """Says that so many bytes come, and sends none."""
    plain = socket.create_connection(("127.0.0.1", program.port), timeout=60)
    head = f"POST /file?token={program.token}&name={name} HTTP/1.1\r\nHost: 127.0.0.1:{program.port}\r\n"
    head += f"Origin: http://127.0.0.1:{program.port}\r\nExpect: 100-continue\r\nContent-Length: {size}\r\n\r\n"
    plain.sendall(head.encode())
    return plain


def answer(plain: socket.socket) -> bytes:
    return plain.recv(4096).split(b"\r\n")[0]


def test_a_file_beyond_the_quota_is_told_so(ball: pathlib.Path) -> None:
    with Program(ball) as program:
        for size in (2**31 + 1, 2**40, 2**63):
            with begin_post(program, "large.raw", size) as plain:
                assert answer(plain) == b"HTTP/1.1 413 Payload Too Large"
        # Also one who sends all the same, before the answer is read.
        with begin_post(program, "large.raw", 2**31 + 1) as plain:
            plain.sendall(bytes(8 << 20))
            assert answer(plain) == b"HTTP/1.1 413 Payload Too Large"


def test_files_that_come_at_once_share_the_quota(ball: pathlib.Path) -> None:
    third = 2**31 // 3
    with Program(ball) as program:
        parts = [begin_post(program, f"{i}.raw", third) for i in range(3)]
        assert [answer(each) for each in parts] == [b"HTTP/1.1 100 Continue"] * 3
        with begin_post(program, "more.raw", third) as more:
            assert answer(more) == b"HTTP/1.1 413 Payload Too Large"
        # Two bytes are left; those of a file do not count that takes another's name.
        assert [program.post("small.raw", content)[0] for content in (b"x", b"xy", b"xyz")] == [204, 204, 413]
        parts[0].close()

        def has_room() -> bool:
            with begin_post(program, "more.raw", third) as more:
                return answer(more) == b"HTTP/1.1 100 Continue"

        wait("the room of the one that has gone", has_room)


def test_a_cut_file_does_not_take_the_good_ones_place(ball: pathlib.Path) -> None:
    good = ball.read_bytes()
    with Program(*SMALL) as program, Page(program) as page:
        page.wait_for("hello")
        assert program.post("a.nrrd", good)[0] == 204
        assert opened(page, "a.nrrd")["type"] == "hello"
        before = picture(page, 1)[1]
        for _ in range(2):
            assert program.post("a.nrrd", good[: len(good) // 2])[0] == 204
            page.send({"do": "open", "names": ["a.nrrd"]})  # the good one is opened again, then the error comes
            assert any(header["type"] == "error" for header, _ in page.all())
            assert picture(page, 2)[1] == before
            page.send({"do": "board"})  # reads it again
            page.wait_for("hello")
            assert picture(page, 3)[1] == before
        # A good one does, and slices that can't be opened leave nothing.
        assert program.post("a.nrrd", good.replace(b"\n\n", b"\n\n" + bytes(48 * 48 * 24), 1))[0] == 204
        assert opened(page, "a.nrrd")["type"] == "hello"
        assert (other := picture(page, 4)[1]) != before
        assert program.post("0.png", b"none")[0] == program.post("1.png", b"none")[0] == 204
        assert opened(page, "0.png", "1.png")["type"] == "error"
        assert picture(page, 5)[1] == other


def test_a_transfer_function_that_a_full_disk_cut_is_written_again(ball: pathlib.Path) -> None:
    look = "values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 60 0\nopacity 80 1\n" + "# why\n" * 2000
    ignore = lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN) and None
    with Program(ball, *SMALL, preexec_fn=ignore) as program, Page(program) as page:
        page.wait_for("hello")
        plain = picture(page, 1)[1]
        resource.prlimit(program.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        page.send({**PICTURE, "id": 2, "settings": {"transfer-function": look}})
        for header, _ in page.all():
            if header["type"] == "error":
                break
            assert header["type"] != "picture"
        assert header["id"] == 2
        resource.prlimit(program.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        header, red = picture(page, 3, **{"transfer-function": look})
        assert red != plain
        status, text = program.get(f"/download?token={program.token}&number={header['number']}&what=tf")
        assert status == 200 and text.decode() == look


@pytest.fixture(scope="module")
def bomb() -> bytes:
    """A mebibyte of gzip with 1,000 times as much in it."""
    head = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 1023\nencoding: gzip\n\n"
    layer = gzip.compress(bytes(1024 * 1024 * 93), 9)
    return head + layer * 11  # members follow each other


def test_a_file_that_is_being_read_holds_up_neither_others_nor_the_end(ball: pathlib.Path, bomb: bytes) -> None:
    with Program(ball, *SMALL) as program, Page(program) as other:
        before = picture(other, 1)[1]
        with Page(program) as page:
            page.wait_for("hello")
            assert program.post("bomb.nrrd", bomb)[0] == 204
            page.send({"do": "open", "names": ["bomb.nrrd"]})
            time.sleep(0.2)
            other.send({**PICTURE, "id": 2})
        # Its page has gone, and so has its file.
        for header, pixels in other.all():
            assert header["type"] != "hello" or header["volume"]["name"] == "ball.nrrd", header
            if header["type"] == "picture" and header["final"]:
                break
        assert pixels == before
        assert program.post("bomb.nrrd", bomb)[0] == 204
        other.send({"do": "open", "names": ["bomb.nrrd"]})
        time.sleep(0.2)
        program.process.terminate()
        program.process.wait(timeout=10)


# ---- signals and the browser


def folders(place: pathlib.Path) -> list[pathlib.Path]:
    return list(place.glob("gicube-view-*"))


@pytest.mark.parametrize("kind", [signal.SIGHUP, signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_with_its_folder(ball: pathlib.Path, tmp_path: pathlib.Path, kind: int) -> None:
    with Program(ball, env={**os.environ, "TMPDIR": str(tmp_path)}) as program:
        assert program.post("a.nrrd", ball.read_bytes())[0] == 204
        assert len(folders(tmp_path)) == 1
        program.process.send_signal(kind)
        assert program.process.wait(timeout=60) == 0
        assert folders(tmp_path) == []


def test_a_hang_up_that_is_ignored_and_a_log_that_nobody_reads_do_not(ball: pathlib.Path) -> None:
    ignore = lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN) and None  # as nohup does
    with Program(ball, *SMALL, preexec_fn=ignore, stderr=subprocess.PIPE) as program:
        assert program.process.stderr is not None
        program.process.send_signal(signal.SIGHUP)
        program.process.send_signal(signal.SIGPIPE)  # as a line to a pipe without a reader does
        with Page(program) as page:
            picture(page, 1)


OPENER = """#!/bin/sh
echo "$@" > OUT.part && mv OUT.part OUT.words
[ -e "$1" ] && { stat -c %a "$(dirname "$1")"; cat "$1"; } > OUT.part && mv OUT.part OUT
"""


@pytest.fixture
def opener(tmp_path: pathlib.Path) -> Iterator[tuple[pathlib.Path, dict[str, str]]]:
    """What stands for the browser leaves OUT and OUT.words; the environment that has it."""
    out = tmp_path / "out"
    (tmp_path / "xdg-open").write_text(OPENER.replace("OUT", str(out)))
    (tmp_path / "xdg-open").chmod(0o755)
    yield out, {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "DISPLAY": ":99"}


class InATerminal:
    """The program with a terminal as its standard output, and the address that it prints there."""

    def __init__(self, environment: dict[str, str], *words: object) -> None:
        self.screen, inner = pty.openpty()
        command = [str(word) for word in (BIN / "gicube-view", *words)]
        self.process = subprocess.Popen(command, stdout=inner, env=environment)
        os.close(inner)
        self.address = ""
        while not self.address.endswith("\n"):
            self.address += os.read(self.screen, 1000).decode()
        self.address = self.address.strip()

    def __enter__(self) -> "InATerminal":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(timeout=60)
        os.close(self.screen)


@pytest.mark.parametrize("words", [["--open"], []])
def test_the_browser_is_opened_and_no_command_line_shows_the_token(
    ball: pathlib.Path, opener: tuple[pathlib.Path, dict[str, str]], words: list[str]
) -> None:
    out, environment = opener
    with InATerminal(environment, *words, ball) as shown:
        wait("the browser", out.with_suffix(".words").exists, 20)
        assert shown.address.split("token=")[1] not in out.with_suffix(".words").read_text()
        wait("its page", out.exists, 20)
        mode, page = out.read_text().split("\n", 1)
        assert mode == "700" and f'content="0; url={shown.address}"' in page


def test_no_browser_is_opened_where_none_is_wanted(
    ball: pathlib.Path, opener: tuple[pathlib.Path, dict[str, str]]
) -> None:
    out, environment = opener
    without = {name: value for name, value in environment.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    for its, words in ((environment, ["--no-open"]), (without, [])):
        with InATerminal(its, *words, ball) as shown:
            Page(Running(shown.address)).wait_for("hello")  # it would have been opened by now
        assert not out.with_suffix(".words").exists()
