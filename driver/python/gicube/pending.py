"""Handles to calls that run while the application does something else (gicube/pending.h)."""

from __future__ import annotations

import asyncio
import os
from typing import Any, Generator, Generic, Optional, TypeVar

from gicube import _core

__all__ = ["Pending"]

Result = TypeVar("Result")


async def readable(descriptor: int) -> None:
    """Waits until it is, and closes it."""
    arrived = asyncio.Event()
    loop = asyncio.get_running_loop()
    try:
        loop.add_reader(descriptor, arrived.set)
        await arrived.wait()
    finally:
        loop.remove_reader(descriptor)
        os.close(descriptor)


class Pending(Generic[Result]):
    """A call that was started: Board.start_render() and others. It does what the blocking call does, with the same bits
    and simulated times, in its place in the order of calls: later calls to the board, `now` included, wait until it has
    ended. Only ray batches continue beside other calls. It may be awaited, and may outlive its board: it ends with
    DeviceLost then."""

    def __init__(self, core: "_core.Started[Result]") -> None:
        self._core = core

    @property
    def ready(self) -> bool:
        """True if result() would not have to wait for the board's work."""
        return self.wait(0.0)

    def wait(self, timeout: Optional[float] = None) -> bool:
        """Waits for that, for at most so many seconds of wall-clock time; returns `ready`. No simulated time passes by
        it."""
        return self._core.wait(timeout)

    def result(self, deadline: int = 2**64 - 1) -> Result:
        """Returns the call's result, once, or raises its error. Raises DeadlinePassed if it came after the simulated
        time `deadline`, picoseconds, or has not come by then: it can be asked for again. Raises Cancelled after
        cancel(), BadArgument if it was taken before."""
        return self._core.result(deadline)

    def cancel(self) -> bool:
        """Asks the call to end: True if it does, or will; False if it had ended, or its rays are in work. A batch of
        rays comes back with `cancelled` then."""
        return self._core.cancel()

    @property
    def progress(self) -> tuple[int, int]:
        """Parts done and parts in all; (0, 0) before the call has said so."""
        return self._core.progress()

    def descriptor(self) -> int:
        """A file descriptor that becomes readable when `ready` is true. The caller closes it."""
        return self._core.descriptor()

    def __await__(self) -> Generator[Any, None, Result]:
        yield from readable(self.descriptor()).__await__()
        return self.result()
