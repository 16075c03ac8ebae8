"""Events inside a private board for Python callables, and the debugger of a board with a management plane.

    with gicube.observe.events(lambda event: print(event["event"]), of="pixel=32:32") as options:
        with gicube.open("emu:?fidelity=cycle&" + options) as board:
            ...
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import tempfile
import threading
from typing import IO, Any, Callable, Dict, Iterator, List, Optional
from urllib.parse import quote

from gicube.errors import BadArgument, Error

__all__ = ["Debugger", "events"]

Event = Dict[str, Any]


@contextlib.contextmanager
def events(take: Callable[[Event], object], of: str) -> Iterator[str]:
    """Options of a URI "emu:?fidelity=cycle&..." with which the board of that URI tells `take` of its events.

    take: called with each event, a dict as in docs/guide/observation.md, in their order, on a separate thread; events
        of a command arrive at its end at the latest. If it raises, it is not called again, and this raises the same at
        the end.
    of: which events, as of gicube-board --events-of: "pixel=32:32", "rays=0:10,parts=sorter", "counters=1000". The
        board's opening refuses a faulty text.

    Open one board with it, and close that before the end. Time on the board does not depend on `take`.
    """
    raised: List[BaseException] = []

    def read(stream: IO[str]) -> None:
        for line in stream:
            if raised:
                continue  # the board may not be held up
            try:
                take(json.loads(line))
            except BaseException as error:  # is raised by the caller's thread
                raised.append(error)

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "events")
        os.mkfifo(path, 0o600)
        # Both ends, so that opening the other one does not wait, and no thread is left if the board never opens it.
        own = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        with open(os.open(path, os.O_RDONLY | os.O_CLOEXEC), encoding="utf-8") as stream:
            thread = threading.Thread(target=read, args=(stream,), daemon=True)
            thread.start()
            try:
                yield f"events={quote(path)}&events_of={quote(of)}"
            finally:
                os.close(own)
                thread.join()
    if raised:
        raise raised[0]


class Debugger:
    """Stops a board and looks into it, by `gicube-smi debug`: docs/guide/debugging.md has its lines.

    The board continues when this is closed. A board accepts one debugger at a time.
    """

    def __init__(self, management: str, board: int = 0, program: str = "gicube-smi") -> None:
        """Attaches to board number `board` of the process whose management plane is at `management` ("unix:PATH",
        "tcp:HOST:PORT").

        program: of the SDK, if it is not on the PATH.
        """
        #: Whether the board is paused, with a command in progress, after the latest line.
        self.is_paused = False
        self._smi: Optional[subprocess.Popen[str]] = subprocess.Popen(
            [program, "debug", "--json", "--management", management, "--board", str(board)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            self.say("where")
        except BaseException:
            self.close()
            raise

    def say(self, line: str) -> str:
        """The board's answer to a line, as "break pixel 32 32", "continue 20" or "why".

        Raises Error with what was expected if the line can't be executed: then nothing has changed; or if there
        is no board, or no right to debug it.
        """
        if self._smi is None or self._smi.stdin is None or self._smi.stdout is None:
            raise Error("the debugger is closed")
        if "\n" in line:
            raise BadArgument("line", "one line", repr(line))
        with contextlib.suppress(BrokenPipeError):
            self._smi.stdin.write(line + "\n")
            self._smi.stdin.flush()
        text = self._smi.stdout.readline()
        if not text:
            said = self._smi.stderr.read().strip() if self._smi.stderr is not None else ""
            raise Error(said or "gicube-smi debug has ended")
        answer = json.loads(text)
        self.is_paused = bool(answer["stands"])
        if answer["is_fault"]:
            raise Error(answer["text"].strip())
        return str(answer["text"])

    @property
    def stands(self) -> bool:
        """The name of is_paused in 0.3.0."""
        return self.is_paused

    def close(self) -> None:
        """Detaches: the board continues."""
        if self._smi is None:
            return
        smi, self._smi = self._smi, None
        smi.communicate()

    def __enter__(self) -> "Debugger":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
