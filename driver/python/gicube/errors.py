"""Exceptions of the package: the classes of gicube/error.h, each also one of Python's own where there is one that fits.

The docstring of each call says which it raises, and what state the board is in then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gicube.records import Loss

__all__ = [
    "BadArgument", "BoardBusy", "Cancelled", "DeadlinePassed", "DeviceLost", "Error", "Fault", "FileError",
    "InputError", "MemoryFault",
    "OpenFailed", "Rejected", "ScatteringFailed", "TimedOut", "Unsupported", "VersionMismatch", "WouldBlock",
]


class Error(RuntimeError):
    """The parent of all that the driver raises."""


class BadArgument(Error, ValueError):
    """A value that the caller gave is wrong. Nothing was sent: the board is untouched."""

    def __init__(self, field: str, expected: str, got: str) -> None:
        super().__init__(f"{field}: expected {expected}, got {got}")
        self.field, self.expected, self.got = field, expected, got

    # for pickling: the arguments of the classes that have more than a text
    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.field, self.expected, self.got)


class OpenFailed(Error, ConnectionError):
    """No board could be opened: the socket or the program of the URI does not exist, or does not answer."""


class BoardBusy(Error):
    """The board has another owner; the message says who, and since when."""


class VersionMismatch(Error):
    """Driver and board speak different major versions."""


class Rejected(Error):
    """The board refused a request, in its own words; its state is as before."""


class ScatteringFailed(Error):
    """The application's scattering routine gave an answer that no ray can follow."""


class MemoryFault(Error):
    """The board's memory reported an error that it could not correct. Nothing has changed; the call may be made
    again."""


class Unsupported(Error):
    """This board or fidelity level can't do what was asked; its state is as before."""


class DeviceLost(Error, ConnectionError):
    """The connection to the board broke, for `cause`. All later calls raise this until Board.reopen() succeeds."""

    def __init__(self, text: str, cause: Loss = Loss.CLOSED) -> None:
        super().__init__(text)
        self.cause = cause

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.cause)


class DeadlinePassed(Error):
    """The simulated host waited until its deadline, a simulated time. The board continues."""


class Cancelled(Error):
    """The call was cancelled by Pending.cancel(). A picture is unknown, irradiance incomplete, a loading volume
    lost."""


class WouldBlock(Error, BlockingIOError):
    """The limit open(max_rays=...) of rays under way is reached. Nothing was sent: receive or poll before the next
    try."""


class TimedOut(Error, TimeoutError):
    """No answer came within the wall-clock watchdog. As after DeviceLost, the board takes no calls until
    Board.reopen()."""


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong in a scene, a transfer function or a volume file."""

    file: str
    line: int
    field: str
    expected: str
    got: str
    text: str


class InputError(Error, ValueError):
    """Something that a user wrote, in a file or as a value, is wrong: `faults` lists all faults. No board was
    touched."""

    def __init__(self, text: str, faults: list[Fault]) -> None:
        super().__init__(text)
        self.faults = faults

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.faults)


class FileError(InputError):
    """A file can't be read or written, is damaged, or has impossible contents."""
