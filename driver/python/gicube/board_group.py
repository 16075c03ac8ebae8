"""Several boards in one host."""

from __future__ import annotations

import inspect
import os
from typing import Any, Callable, Optional, Sequence, Tuple, Union

from gicube import _core
from gicube.arrays import RAY, as_array, as_request
from gicube.board import Board, ProgressLike, _open_boards, shown
from gicube.counters import Counters
from gicube.image import Image
from gicube.records import Array, BoardTime, HostBuses, RayBatch, RayRequest, View


class BoardGroup:
    """Several boards that make pictures and trace rays together, with the bits of one (docs/guide/boards.md).

        with gicube.BoardGroup("emu:?boards=4") as group:
            group.on_all(lambda board: board.load_volume(volume))
            image = group.render(view)

    The simulated host begins a call at the same time on all boards, and continues when the last one has finished. One
    caller at a time. What one board raises, the caller gets once the others have done their part, with the board's
    number and address in its message; what the others have is kept, and boards[i].reopen() brings a lost one back.
    """

    def __init__(
        self, addresses: Union[str, Sequence[str]] = "emu:?boards=2", *, buses: HostBuses = HostBuses.SHARED,
        **options: Any
    ) -> None:
        """Opens the boards and resets them.

        addresses: one for each board, 1 to 64; or one of emulated boards with the options boards=N and buses=shared or
        own. buses: whether they share one PCI bus, of a list of addresses. options: of each board, as of Board().

        Raises what Board() raises; BadArgument too for boards of an AGP port that share a bus.
        """
        unknown = options.keys() - inspect.signature(Board.__init__).parameters.keys()
        if unknown:
            raise TypeError(f"Board() has no option {min(unknown)}")
        paths = {name: os.fspath(options[name]) for name in ("capture", "token_file", "ca_file") if name in options}
        places: Union[str, list[str]] = addresses if isinstance(addresses, str) else list(addresses)
        self._core = _core.BoardGroup(places, {"buses": buses, "board": options | paths})
        uris = [places] * self._core.size() if isinstance(places, str) else places
        self.boards: Tuple[Board, ...] = tuple(Board._of(uri, self._core.board(i)) for i, uri in enumerate(uris))
        _open_boards.add(self)

    def close(self) -> None:
        """Ends all sessions. May be called again."""
        for board in self.boards:
            board.close()
        self._core.close()

    _end = close

    def __enter__(self) -> "BoardGroup":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __len__(self) -> int:
        return len(self.boards)

    @property
    def buses(self) -> HostBuses:
        """Whether the boards share one."""
        return self._core.buses

    def on_all(self, work: Callable[[Board], object]) -> None:
        """Has each board do the same: load a volume, take tables and materials, be lit. In simulated time at once, in
        this process one after the other."""
        self._core.on_all(lambda index: work(self.boards[index]))

    def render(self, view: Optional[View] = None, *, progress: ProgressLike = None, **fields: Any) -> Image:
        """The picture that each board would make of the view, a View or its fields, if all have the same volume, tables
        and light: each makes rows of it. Warns as Board.render().

        Raises as Board.render(), and Unsupported if a board is older than protocol 2.3.
        """
        asked = as_request(View, view, fields, "view")
        with shown(progress, "rendering") as told:
            return self.boards[0]._warned(self._core.render(asked, told))

    def trace(self, rays: Array, request: Optional[RayRequest] = None, **fields: Any) -> RayBatch:
        """Rays that come back are dealt to the boards and returned in their order; those that leave energy are traced
        by each board, so that all have the same irradiance and sums. The request is a RayRequest or its fields. Raises
        as Board.submit() and receive().
        """
        asked = as_request(RayRequest, request, fields)
        return self._core.trace(as_array(rays, "rays", RAY, (None,)), asked)

    @property
    def now(self) -> int:
        """The simulated host's clock since the boards were opened, picoseconds."""
        return self._core.now

    @property
    def times(self) -> list[BoardTime]:
        """Where the simulated time of each board has gone."""
        return self._core.times()

    @property
    def counters(self) -> Counters:
        """Sums over all boards."""
        return Counters(self._core.counters())
