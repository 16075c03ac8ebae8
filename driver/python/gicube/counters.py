"""The counters of a board."""

from __future__ import annotations

import difflib
import html
from typing import Iterable, Iterator, List, Mapping, Tuple

from gicube import _core
from gicube.records import LevelReport


class Counters(Mapping[str, int]):
    """Counters by name, as "bus.down.busy_ps"; docs/reference/counters.md lists them all.

    Every counter only grows within a session: `end - begin` is what happened in between. A counter that is not there
    (another fidelity level, or nothing of its kind has happened) raises KeyError; get(name, 0) is 0.
    """

    def __init__(self, counters: Iterable[Tuple[str, str, int]]) -> None:
        self._held = {name: (unit, value) for name, unit, value in counters}

    def _entry(self, name: str) -> Tuple[str, int]:
        if name in self._held:
            return self._held[name]
        near = difflib.get_close_matches(name, self._held, 1)
        nearest = f"; the nearest is {near[0]!r}" if near else ""
        raise KeyError(f"expected a counter of this board at its fidelity level, got {name!r}{nearest}")

    def __getitem__(self, name: str) -> int:
        return self._entry(name)[1]

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    def unit(self, name: str) -> str:
        """The unit, for instance "ps" or "ray". Raises KeyError."""
        return self._entry(name)[0]

    def __sub__(self, begin: "Counters") -> "Counters":
        return Counters((name, unit, value - begin.get(name, 0)) for name, (unit, value) in self._held.items())

    def matching(self, part: str) -> "Counters":
        """Those with `part` in their names."""
        return Counters((name, *each) for name, each in self._held.items() if part in name)

    def __repr__(self) -> str:
        return f"<gicube.Counters: {len(self)} counters>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td style='text-align:left'>{html.escape(name)}</td><td>{value:,}</td>"
            f"<td style='text-align:left'>{html.escape(unit)}</td></tr>"
            for name, (unit, value) in self._held.items()
        )
        return f"<table><tr><th>counter</th><th>value</th><th>unit</th></tr>{rows}</table>"


def fidelity_report(window: Counters) -> List[LevelReport]:
    """Which fidelity level answered which commands, and what it does not model.

    `window`: of a run, as `board.counters - before`. One entry for each level that answered, from functional to cycle.
    Empty if the window has no command with rays. Nothing happens on the board.
    """
    return _core.fidelity_report([(name, window.unit(name), value) for name, value in window.items()])
