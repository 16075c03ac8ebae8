"""Tests of an application against a board with a given bus, configuration and fault plan: on simulated time and on
bytes, so that they hold on every machine. gicube/testing.h is the same for C++.

With pytest:

    pytest_plugins = ["gicube.testing"]

    @pytest.mark.board(bus=["pci33", "agp2x"], faults="plan.textproto")
    def test_upload(board):                          # once for each bus
        with Window(board) as upload:
            load_the_scan(board)                     # the application
        assert_time(upload, 0.57e12, 0.01)
"""

from __future__ import annotations

import itertools
import os
import tempfile
import weakref
from dataclasses import dataclass, field, replace
from typing import Any, Iterator, List, Mapping, Optional, Sequence
from urllib.parse import quote

from gicube.board import Board
from gicube.counters import Counters
from gicube.errors import BadArgument


@dataclass
class BoardSetup:
    """Which board a test runs on. What is empty is the board's default."""

    board: str = ""  # URI of a board that there is, in place of all below
    bus: str = ""  # pci33, agp1x, agp2x or agp4x
    fidelity: str = ""  # functional or cycle
    config: str = ""  # file of a board configuration
    set: Sequence[str] = field(default_factory=list)  # "field=value", fields of it
    faults: str = ""  # file of a fault plan, or the plan itself: text with a brace
    seed: int = 1  # of the test's own random choices

    @classmethod
    def from_environment(cls, environment: Optional[Mapping[str, str]] = None) -> "BoardSetup":
        """The setup of gicube_add_test(), by GICUBE_TEST_BUS and so on. Raises BadArgument: a seed that is no
        number."""
        given = os.environ if environment is None else environment
        texts = {name: given.get("GICUBE_TEST_" + name.upper(), "")
                 for name in ("board", "bus", "fidelity", "config", "faults")}
        seed = given.get("GICUBE_TEST_SEED", "") or "1"
        if not seed.isdecimal():
            raise BadArgument("GICUBE_TEST_SEED", "a number from 0 to 2^64 - 1", repr(seed))
        return cls(**texts, set=given.get("GICUBE_TEST_SET", "").split(), seed=int(seed))

    def uri(self) -> str:
        """The URI for Board()."""
        if self.board:
            return self.board
        options = [("config", self.config), ("fidelity", self.fidelity), ("bus", self.bus)]
        options += [("set", each) for each in self.set] + [("faults", self.faults)]
        text = "&".join(f"{name}={quote(value, safe='/._-=')}" for name, value in options if value)
        return f"emu:?{text}" if text else "emu:"

    def open(self, **options: Any) -> Board:
        """Raises as Board()."""
        if "{" not in self.faults:
            return Board(self.uri(), **options)
        plan = tempfile.NamedTemporaryFile("w", suffix=".textproto")
        plan.write(self.faults)
        plan.flush()
        board = Board(replace(self, faults=plan.name).uri(), **options)
        weakref.finalize(board, plan.close)  # reopen() reads it again
        return board


class Window:
    """The changes between two points of simulated time: from its begin to the end of the `with` statement, or until
    now."""

    def __init__(self, board: Board) -> None:
        self._board, self._begin, self._counters = board, board.now, board.counters
        self._end: Optional[tuple[int, Counters]] = None

    def __enter__(self) -> "Window":
        return self

    def __exit__(self, kind: Optional[type[BaseException]], *error: object) -> None:
        if kind is None:
            self._end = self._board.now, self._board.counters

    @property
    def time(self) -> int:
        """Simulated, picoseconds."""
        return (self._end[0] if self._end else self._board.now) - self._begin

    @property
    def counters(self) -> Counters:
        """Their growth."""
        return (self._end[1] if self._end else self._board.counters) - self._counters

    def share(self, counter: str) -> float:
        """The share of the time that a counter in picoseconds has, 0..1."""
        return self.counters.get(counter, 0) / self.time if self.time else 0.0

    def per_second(self, counter: str) -> float:
        """A counter per simulated second."""
        return self.counters.get(counter, 0) / (self.time * 1e-12) if self.time else 0.0


def _assert(what: str, got: float, expected: float, tolerance: float) -> None:
    within = "exactly" if tolerance == 0 else f"within {100 * tolerance:.3g}%"
    off = f" ({100 * (got - expected) / abs(expected):+.3f}%)" if expected else ""
    assert abs(got - expected) <= tolerance * abs(
        expected), f"{what}: expected {expected:.12g} {within}, got {got:.12g}{off}"


def assert_time(window: Window, picoseconds: float, tolerance: float) -> None:
    """The simulated time; a tolerance of 0.01 is one per cent."""
    _assert("simulated time in ps", window.time, picoseconds, tolerance)


def assert_counter(window: Window, name: str, value: float, tolerance: float = 0.0) -> None:
    """A counter's growth. Fails too if the board does not keep it."""
    assert name in window.counters, f"{name}: this board has no such counter"
    _assert(name, window.counters[name], value, tolerance)


def assert_share(window: Window, name: str, share: float, tolerance: float) -> None:
    """The share of the time that a counter in picoseconds grew by."""
    assert name in window.counters, f"{name}: this board has no such counter"
    _assert(f"{name} / time", window.share(name), share, tolerance)


def _setups(marker: Any) -> List[BoardSetup]:
    """One for each combination of the marker's lists; `set` is one list of fields."""
    choices = [each if isinstance(each, list) and name != "set" else [each] for name, each in marker.kwargs.items()]
    return [BoardSetup(**dict(zip(marker.kwargs, each))) for each in itertools.product(*choices)]


try:
    import pytest
except ImportError:
    pass
else:

    def pytest_configure(config: pytest.Config) -> None:
        config.addinivalue_line("markers",
                                "board(bus=, fidelity=, config=, set=, faults=): the boards that a test runs on")

    def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
        if "board_setup" not in metafunc.fixturenames:
            return
        marker = metafunc.definition.get_closest_marker("board")
        setups = [BoardSetup.from_environment()] if marker is None else _setups(marker)
        ids = ["-".join(filter(None, (each.bus, each.fidelity))) or "board" for each in setups]
        metafunc.parametrize("board_setup", setups, ids=ids)

    @pytest.fixture
    def board(board_setup: BoardSetup) -> Iterator[Board]:
        """A board as the marker `board` says, or as the environment does. It is closed after the test."""
        with board_setup.open() as opened:
            yield opened
