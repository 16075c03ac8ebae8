"""How fast gicube-view turns: plays a drag over the WebSocket as the page does, one picture under way and the newest
view after it.

Usage: view_drag.py [ADDRESS]     without one it starts gicube-view itself, with a buckyball of 256^3 at 512^2 and the
functional level Prints pictures a second, and the time from a move to the picture that has it: median, 95th of 100,
worst. In milliseconds of this machine.
"""

from __future__ import annotations

import contextlib
import math
import os
import pathlib
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("GICUBE_BIN_DIR", str(ROOT / "build/release/bin"))
sys.path.insert(0, str(ROOT / "tests/samples/apps/view"))
from view_program import Page, Program, Running  # noqa: E402

SECONDS = 8
# Degrees a move, 60 moves a second: begins slowly, swings to and fro, stops for a moment.
DRAG = [2.2 * math.sin(2 * math.pi * i / 240) * min(1.0, i / 30) if i % 120 < 110 else 0.0 for i in range(60 * SECONDS)]


def turned(settings: dict[str, str], degrees: float) -> str:
    eye, target = ([float(x) for x in settings[name].split(",")] for name in ("eye", "look-at"))
    x, y = eye[0] - target[0], eye[1] - target[1]
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return f"{target[0] + c * x - s * y:.4f},{target[1] + s * x + c * y:.4f},{eye[2]}"


def play(page: Page) -> tuple[list[float], float]:
    """Latencies, and the seconds that the drag took."""
    hello, _ = page.wait_for("hello")
    while hello["volume"] is None:
        hello, _ = page.wait_for("hello")
    page.send({"do": "picture", "id": 1, "moving": False, "settings": {}})
    page.wait_for("picture", final=True)
    number, angle, latencies = 1, 0.0, []
    asked_at = None  # of the move that the picture under way has
    begin = time.monotonic()
    shown = played = 0
    while played < len(DRAG) or asked_at is not None:
        now = time.monotonic()
        due = min(len(DRAG), int((now - begin) * 60) + 1)
        angle += sum(DRAG[played:due])
        if asked_at is None and due > shown:
            number += 1
            page.send({"do": "picture", "id": number, "moving": True,
                       "settings": {"eye": turned(hello["settings"], angle)}})
            asked_at, shown = begin + (due - 1) / 60, due
        played = due
        if page.readable(max(0.0, begin + played / 60 - time.monotonic()) if played < len(DRAG) else 10.0):
            header, _ = page.receive()
            if header["type"] == "picture" and header["id"] == number and asked_at is not None:
                latencies.append(time.monotonic() - asked_at)
                asked_at = None
    return latencies, time.monotonic() - begin


def main(address: str | None) -> None:
    with contextlib.ExitStack() as stack:
        program = Running(address) if address else stack.enter_context(Program("builtin:buckyball", "--fix",
            "size=512x512"))
        latencies, seconds = play(stack.enter_context(Page(program)))
    ordered = sorted(1000 * latency for latency in latencies)
    print(
        f"{len(ordered) / seconds:.1f} pictures a second; latency {statistics.median(ordered):.0f} ms at the median, "
        f"{ordered[len(ordered) * 95 // 100]:.0f} ms at 95 of 100, {ordered[-1]:.0f} ms at worst; load "
        f"{os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
