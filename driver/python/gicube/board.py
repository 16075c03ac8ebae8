"""The host's handle to one GI-Cube board."""

from __future__ import annotations

import atexit
import os
import sys
import warnings
import weakref
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Optional, Protocol, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from gicube import _core
from gicube.arrays import ELEMENT, ELEMENT_PAIR, RAY, TRACED_RAY, as_array, as_choice, as_request, unmasked
from gicube.counters import Counters
from gicube.errors import BadArgument, DeviceLost
from gicube.image import Image
from gicube.pending import Pending, readable
from gicube.records import (Array, BackPressure, BoardInfo, BrickDetail, FoundBoard, Illumination, Light,
                            LightingReport, Material, PairRequest, RayBatch)
from gicube.records import RayRequest, RayType, Reopened, ScatterAnswer, ScatterEvent, Shading, Ticket, TransferFunction
from gicube.records import ValueRange, View, VoxelBox
from gicube.volume import Volume, VolumeStream, as_volume

#: progress=...: a callable(done, all), or True: a bar on standard error, by tqdm if it is there.
ProgressLike = Union[None, bool, Callable[[int, int], object]]

NO_DEADLINE = 2**64 - 1


@contextmanager
def shown(progress: ProgressLike, what: str) -> Iterator[Optional[Callable[[int, int], object]]]:
    """The callable that the core takes."""
    if progress is not True:
        yield progress or None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield lambda done, all: print(f"\r{what}: {done} of {all}", end="\n" if done == all else "", file=sys.stderr)
        return
    with tqdm(desc=what) as bar:

        def show(done: int, all: int) -> None:
            bar.total = all
            bar.update(done - bar.n)

        yield show


_open_boards: "weakref.WeakSet[Any]" = weakref.WeakSet()


@atexit.register
def _close_boards() -> None:
    for board in list(_open_boards):
        board._end()


class RayExchange(Protocol):
    """How the ranks of a job tell each other of rays (Board.share_blocks()). With mpi4py: COMM_WORLD's rank, size,
    alltoall() and allreduce()."""

    @property
    def rank(self) -> int:
        """0..ranks - 1."""

    @property
    def ranks(self) -> int:
        """At least 1."""

    def exchange(self, parts: List[bytes]) -> List[bytes]:
        """Sends parts[r] to rank r, this one too; returns what each rank sent to this one, by rank."""

    def sum(self, value: int) -> int:
        """The sum over all ranks' values."""


class Board:
    """One session with one board, which ends with close(), the `with` statement or this object.

    Several threads may use it: each call is one transaction, they take turns, and other threads of Python run
    meanwhile. Ctrl-C ends a call that waits by KeyboardInterrupt. The board then finishes its work and accepts the next
    call: a picture is unknown, irradiance incomplete, a loading volume lost; ray batches stay under way. A process that
    is forked from this one opens its own board.

    Every call but close() raises DeviceLost and TimedOut (see reopen()), Error in a forked process.
    """

    def __init__(
        self,
        uri: str = "emu:",
        *,
        watchdog: float = 600.0,
        max_rays: int = 1 << 22,
        back_pressure: BackPressure = BackPressure.WAIT,
        keep_volume: bool = False,
        reopen_attempts: int = 0,
        force: bool = False,
        wait_for_board: float = 0.0,
        capture: Union[str, "os.PathLike[str]"] = "",
        token_file: Union[str, "os.PathLike[str]"] = "",
        ca_file: Union[str, "os.PathLike[str]"] = "",
        go_on: bool = False,
        max_waiting_rays: int = 1 << 22,
    ) -> None:
        """Opens a board and resets it.

        uri: "emu:" starts a private emulated one, "unix:PATH", "tcp:HOST:PORT" and "tls:HOST:PORT" name a gicube-board
        that
            listens, "pci:0000:00:04.0" a PCI function of this machine (docs/guide/pci.md). emu: takes options, as
            in "emu:?fidelity=cycle&bus=agp2x&set=asic.processors=8" (gicube/board.h).
        watchdog: seconds of wall-clock time for one answer of the board, 0: no limit.
        max_rays, back_pressure: how many rays may be under way, 4096 or more, and what submit() does then.
        keep_volume: the volume stays in the host's memory for reopen(), 4.5 bytes per voxel.
        reopen_attempts: how often in a row a call resumes a lost session by itself. Not for emu:.
        force: takes the board from its owner. wait_for_board: seconds to wait in line for it.
        capture: file for every frame of the session (docs/guide/capture.md).
        token_file, ca_file: access over TCP, TLS and PCI (docs/reference/security.md).
        go_on: the board is not reset, but continues from the checkpoint of save() that its process began with
        (gicube-board
            --restore); "emu:?restore=FILE" does the same.
        max_waiting_rays: for blocks of a volume that the card does not store whole, 1024 or more: so many on the card,
        as many
            in the host's memory, others in a file in TMPDIR.

        Raises BadArgument, OpenFailed, BoardBusy, VersionMismatch, TimedOut.
        """
        self.uri = uri
        options = {"watchdog": watchdog, "max_rays": max_rays, "back_pressure": back_pressure,
                   "keep_volume": keep_volume}
        options |= {"reopen_attempts": reopen_attempts, "force": force, "wait_for_board": wait_for_board}
        options |= {"go_on": go_on, "max_waiting_rays": max_waiting_rays}
        options |= {"capture": os.fspath(capture), "token_file": os.fspath(token_file), "ca_file": os.fspath(ca_file)}
        self._core = _core.Board(uri, options)
        _open_boards.add(self)

    @classmethod
    def _of(cls, uri: str, core: Any) -> "Board":
        """A board of a group."""
        board = cls.__new__(cls)
        board.uri, board._core = uri, core
        return board

    def close(self) -> None:
        """Ends the session; calls of other threads end first. May be called again."""
        self._core.close()

    def _end(self) -> None:
        """At the end of the interpreter. The calls of daemon threads continue, and keep their boards."""
        self._core.close_if_idle()

    def __enter__(self) -> "Board":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        try:
            info = self.info
        except RuntimeError:
            return f"<gicube.Board {self.uri}, closed>"
        return (f"<gicube.Board {self.uri}: {info.fidelity.value}, {info.processors} processors, at "
                f"{self.now * 1e-9:.6g} ms>")

    @property
    def info(self) -> BoardInfo:
        """Properties that the board reported when it was opened."""
        return self._core.info

    @property
    def now(self) -> int:
        """The simulated host's clock since open(), picoseconds."""
        return self._core.now

    def reopen(self) -> Reopened:
        """After DeviceLost or TimedOut: connects again by the same URI.

        If the board still has the session, it continues, and the failed call may be repeated. Otherwise it is a new
        board: tables and materials are written again, with keep_volume the volume too; irradiance, sums and framebuffer
        are lost. Raises OpenFailed, BoardBusy, VersionMismatch: the board is still lost.
        """
        return self._core.reopen()

    def save(self, file: Union[None, str, "os.PathLike[str]"] = None) -> Optional[bytes]:
        """A checkpoint: the whole state of the board and of this object, including ray batches under way. To a file,
        which is complete or does not exist, or as bytes.

        A board that continues from it gets the same bits, times and counters as this one. The scattering routine is not
        in it. It costs no simulated time. Raises Rejected if it is larger than the board holds for a client, Error if
        the file can't be written.
        """
        if file is None:
            return self._core.save().tobytes()
        self._core.save_to(os.fspath(file))
        return None

    def restore(self, checkpoint: Union[bytes, str, "os.PathLike[str]"]) -> None:
        """This board continues from a checkpoint of save(): bytes, or a file's name. `now` is the clock that was saved,
        and its tickets are valid. Set the scattering routine again.

        Raises BadArgument (a damaged checkpoint, by its field), Rejected (of another configuration, or too large):
        nothing has changed.
        """
        if isinstance(checkpoint, bytes):
            self._core.restore(np.frombuffer(checkpoint, "u1"))
        else:
            self._core.restore_from(os.fspath(checkpoint))

    # Volume.

    def load_volume(self, volume: Union[Volume, VolumeStream, ArrayLike], *, progress: ProgressLike = None) -> None:
        """Replaces the volume: an array [z, y, x] of numbers (gicube.Volume says which are converted); a gicube.Volume,
        which has more properties; or a gicube.VolumeStream, which is read in planes.

        Quantises gradients, cuts all into blocks and sends those that are not zero. The simulated host waits. Transfer
        functions are kept. A volume with more blocks than the card stores is kept by the driver, a stream in a file,
        and its blocks are sent as pictures, rays and light need them, with the same bits; what needs the whole volume
        raises Unsupported. Raises BadArgument, and Error if a stream's file can't be written: the board keeps its
        volume. Raises Rejected if it needs more memory than the board may take: there is no volume then.
        """
        with shown(progress, "loading") as told:
            if isinstance(volume, VolumeStream):
                self._core.load_stream(volume, told)
            else:
                self._core.load_volume(as_volume(volume), told)

    def start_load(self, volume: Union[Volume, VolumeStream, ArrayLike]) -> Pending[None]:
        """load_volume(), started: the array must not change until it has ended."""
        if isinstance(volume, VolumeStream):
            return Pending(self._core.start_load_stream(volume))
        return Pending(self._core.start_load(as_volume(volume)))

    def _read(self, call: Callable[[VoxelBox], Array], box: Optional[VoxelBox], words: int = 1) -> Array:
        """The values of a box, or of all; `words` a voxel."""
        where = VoxelBox((0, 0, 0), self.dims) if box is None else box
        return call(where).reshape(tuple(where.size)[::-1] + (words,) * (words > 1))

    def _write(self, call: Callable[[VoxelBox, Array], object], values: ArrayLike, box: Optional[VoxelBox],
               words: int = 1) -> None:
        array = as_array(values, "values", "float32", (None, None, None) + (words,) * (words > 1))
        size = array.shape[2::-1]
        where = VoxelBox((0, 0, 0), size) if box is None else box
        if tuple(where.size) != size:
            raise BadArgument("values", f"the shape {tuple(where.size)[::-1]}, as the box's", str(array.shape))
        call(where, array)

    @property
    def dims(self) -> tuple[int, int, int]:
        """The loaded volume's size x, y, z, voxels. Raises Rejected before load_volume()."""
        return self._core.dims()

    def read_volume(self, box: Optional[VoxelBox] = None) -> Array:
        """The values of a box, or of all, as the board holds them, 12 bits each: float32 [z, y, x]. Raises Rejected,
        BadArgument."""
        return self._read(self._core.read_volume, box)

    def write_volume(self, values: ArrayLike, box: Optional[VoxelBox] = None) -> None:
        """Overwrites a box of the volume, by default the one at (0, 0, 0), with values [z, y, x], clamped to its range.

        Raises Rejected (no volume), BadArgument (box, a value's index): the volume is unchanged.
        """
        self._write(self._core.write_volume, values, box)

    def verify_volume(self) -> list[int]:
        """The blocks that differ from what was written there, numbered as in empty_flags.ravel(). Raises Rejected,
        MemoryFault."""
        return self._core.verify_volume()

    @property
    def value_range(self) -> ValueRange:
        """The map from the loaded volume's values to densities. Raises Rejected before load_volume()."""
        return self._core.value_range()

    @property
    def blocks(self) -> tuple[int, int, int]:
        """How many blocks the volume has along x, y, z. Raises Rejected before load_volume()."""
        return self._core.blocks()

    @property
    def empty_flags(self) -> Array:
        """The flags in force, uint8 [z, y, x], one per block, nonzero = nothing visible. May be assigned, until the
        next load_volume() or set_transfer_function(): a flag that is set on a visible block hides that block."""
        return self._core.empty_flags().reshape(self.blocks[::-1])

    @empty_flags.setter
    def empty_flags(self, flags: ArrayLike) -> None:
        array = np.asarray(unmasked(flags, "flags"))
        self._core.set_empty_flags(as_array(array.astype("u1") if array.dtype == bool else array, "flags", "uint8"))

    def set_gradient_codebook(self, directions: ArrayLike) -> None:
        """Replaces the codebook: at most 2048 unit directions (n, 3), the first of them zero. Raises BadArgument,
        Rejected."""
        self._core.set_gradient_codebook(as_array(directions, "directions", "float64", (None, 3)))

    # Looks.

    def set_transfer_function(self, function: TransferFunction, tag: int = 0) -> None:
        """Sets how tag 0..3 looks; a tag never set is invisible. Raises BadArgument: the board is untouched."""
        self._core.set_transfer_function(function, tag)

    def set_shading(self, shading: Optional[Shading] = None, **fields: Any) -> None:
        """Phong coefficients and light of the next renderings: a Shading or its fields. Raises BadArgument: the board
        is untouched."""
        self._core.set_shading(as_request(Shading, shading, fields, "shading"))

    def set_material(self, material: Optional[Material] = None, tag: int = 0, **fields: Any) -> None:
        """How tag 0..3 scatters rays, by a Material or its fields; until then it does not. Raises BadArgument: the
        board is untouched."""
        self._core.set_material(as_request(Material, material, fields, "material"), tag)

    def set_scattering_routine(
        self, routine: Optional[Callable[[ScatterEvent], ScatterAnswer]], time_per_ray: int = 0
    ) -> None:
        """Scatters the rays that meet a material with Bsdf.TRAP and HOST_ROUTINE; the simulated host takes
        `time_per_ray` for each.

        It may ask this board for `now` and `info` only. An exception of it leaves the call that needed it; an answer
        that no ray can follow raises ScatteringFailed. The rays that had not ended are lost then, and the board is
        ready for the next call.
        """
        self._core.set_scattering_routine(routine, time_per_ray)

    # Light.

    def illuminate(
        self,
        lights: Sequence[Light],
        settings: Optional[Illumination] = None,
        *,
        progress: ProgressLike = None,
        **fields: Any,
    ) -> LightingReport:
        """Clears the irradiance and distributes the lights' energy by lighting rays. The settings are an Illumination
        or its fields. The simulated host waits.

        Raises BadArgument (a light's index and field, settings), Rejected (no volume, no routine), DeadlinePassed: the
        irradiance is incomplete.
        """
        asked = as_request(Illumination, settings, fields, "settings")
        with shown(progress, "lighting") as told:
            return self._core.illuminate(list(lights), asked, told)

    def start_illuminate(
        self, lights: Sequence[Light], settings: Optional[Illumination] = None, **fields: Any
    ) -> Pending[LightingReport]:
        """illuminate(), started."""
        asked = as_request(Illumination, settings, fields, "settings")
        return Pending(self._core.start_illuminate(list(lights), asked))

    def read_irradiance(self, box: Optional[VoxelBox] = None) -> Array:
        """float32 [z, y, x], in units of the lights' power, of a box or of all; with three irradiance words [z, y, x,
        3]. Raises Rejected, BadArgument."""
        return self._read(self._core.read_irradiance, box, self.info.irradiance_words)

    def write_irradiance(self, values: ArrayLike, box: Optional[VoxelBox] = None) -> None:
        """Overwrites it in a box, by default the one at (0, 0, 0): words are rounded to the unit in force, and
        saturate."""
        self._write(self._core.write_irradiance, values, box, self.info.irradiance_words)

    def clear_irradiance(self, unit: float) -> None:
        """Zero everywhere; one unit of the words is `unit` of the lights' power: for DEPOSIT rays and
        write_irradiance()."""
        self._core.clear_irradiance(unit)

    def clear_sums(self, unit: float) -> None:
        """Sets the sums of BACKPROJECT rays to zero, and one unit of them to `unit`, an energy times a length."""
        self._core.clear_sums(unit)

    def read_sums(self, box: Optional[VoxelBox] = None) -> Array:
        """float32 [z, y, x]: one sum a voxel. Raises Rejected before clear_sums(), BadArgument."""
        return self._read(self._core.read_sums, box)

    # Pictures.

    def render(self, view: Optional[View] = None, *, progress: ProgressLike = None, **fields: Any) -> Image:
        """Renders and reads the picture of a View or of its fields. The simulated host waits. A picture in which
        nothing is visible is warned of, with the likely reason (UserWarning).

        Raises BadArgument (the view's field), Rejected (no volume, light or routine): the framebuffer is unchanged;
        DeadlinePassed.
        """
        self.render_to_framebuffer(view, progress=progress, **fields)
        return self._warned(self._core.read_framebuffer())

    def start_render(self, view: Optional[View] = None, **fields: Any) -> Pending[Image]:
        """render(), started, without its warning."""
        return Pending(self._core.start_render(as_request(View, view, fields, "view")))

    def render_to_framebuffer(
        self, view: Optional[View] = None, *, progress: ProgressLike = None, **fields: Any
    ) -> None:
        """Renders without reading the picture."""
        asked = as_request(View, view, fields, "view")
        with shown(progress, "rendering") as told:
            self._core.render_to_framebuffer(asked, told)

    def read_framebuffer(self) -> Image:
        """The last picture, at 36 bits per pixel over the bus. Raises Rejected before the first."""
        return self._warned(self._core.read_framebuffer())

    def why_invisible(self, image: Image) -> str:
        """The likely reason, as a sentence, why nothing is visible in a picture of this board; empty if something
        is."""
        return self._core.why_invisible(image.pixels)

    def _warned(self, image: Image) -> Image:
        if reason := self.why_invisible(image):
            warnings.warn(reason, stacklevel=3)
        return image

    # Rays.

    def submit(self, rays: Union[Array, Sequence[Array]], request: Optional[RayRequest] = None,
               **fields: Any) -> Ticket:
        """Sends rays as one batch: an array of gicube.RAY (gicube.rays() makes one), or a list of such arrays that lie
        in several places. Returns at once unless too many are under way.

        What is asked of them is a RayRequest, or its fields: submit(rays, type=RayType.FIRST_HIT, opacity=0.5).
        Raises BadArgument (a ray's index and field, the request's fields), Rejected, WouldBlock: nothing was sent.
        """
        asked = as_request(RayRequest, request, fields)
        places = [as_array(each, "rays", RAY, (None,))
                  for each in (rays if isinstance(rays, (list, tuple)) else [rays])]
        none_return = as_choice(RayType, asked.type, "type") in (RayType.DEPOSIT, RayType.BACKPROJECT)
        return Ticket(self._core.submit(places, asked), 0 if none_return else sum(map(len, places)))

    def start_rays(self, rays: Array, request: Optional[RayRequest] = None, **fields: Any) -> Pending[RayBatch]:
        """submit() with a handle in place of a ticket: its result() is receive()."""
        return Pending(self._core.start_rays(as_array(rays, "rays", RAY, (None,)),
                                             as_request(RayRequest, request, fields)))

    def receive(self, ticket: Ticket, *, out: Optional[Array] = None, deadline: int = NO_DEADLINE) -> RayBatch:
        """Waits until that batch has returned, and moves the simulated clock to its arrival.

        out: an array of gicube.TRACED_RAY for the rays, as many as were submitted; None: a new one.
        Raises BadArgument (unknown ticket, wrong size), Rejected, Unsupported (the batch is gone), DeadlinePassed if it
        has not arrived by the simulated time `deadline`, picoseconds: the batch is still under way.
        """
        space = np.empty(ticket.rays, TRACED_RAY) if out is None else out
        if space.dtype != TRACED_RAY or not space.flags.c_contiguous:
            raise BadArgument("out", "a contiguous array of gicube.TRACED_RAY", str(space.dtype))
        return self._core.receive(ticket.id, space, deadline)

    async def receive_async(self, ticket: Ticket) -> RayBatch:
        """receive() for asyncio: other tasks run until the board has worked the batch out."""
        await readable(self.descriptor(ticket))
        return self.receive(ticket)

    def descriptor(self, ticket: Ticket) -> int:
        """A file descriptor that becomes readable when receive() would no longer wait for the board's work. The caller
        closes it."""
        return self._core.descriptor(ticket.id)

    def poll(self) -> list[RayBatch]:
        """The batches that have arrived by now and were not received yet, in the order of their simulated arrival."""
        return self._core.poll()

    def cancel(self, ticket: Ticket) -> bool:
        """Takes back the part of a batch that has not begun. False: it is too late, and the whole batch comes back."""
        return self._core.cancel(ticket.id)

    def pair_factors(
        self,
        elements: Array,
        pairs: Array,
        request: Optional[PairRequest] = None,
        *,
        progress: ProgressLike = None,
        **fields: Any,
    ) -> Array:
        """How much light goes between pairs of elements: an array of gicube.PAIR_FACTOR, one factor a pair
        (gicube/pair.h).

        elements, pairs: by gicube.elements() and gicube.pairs(). The request is a PairRequest or its fields.
        Raises BadArgument (an element's, a pair's index, the request's fields), Rejected (no volume): nothing was sent.
        """
        asked = as_request(PairRequest, request, fields)
        with shown(progress, "pairs") as told:
            all_elements, all_pairs = as_array(elements, "elements", ELEMENT, (None,)), as_array(pairs, "pairs",
                ELEMENT_PAIR, (None,))
            return self._core.pair_factors(all_elements, all_pairs, asked, told)

    def start_pair_factors(
        self, elements: Array, pairs: Array, request: Optional[PairRequest] = None, **fields: Any
    ) -> Pending[Array]:
        """pair_factors(), started."""
        all_elements, all_pairs = as_array(elements, "elements", ELEMENT, (None,)), as_array(pairs, "pairs",
            ELEMENT_PAIR, (None,))
        return Pending(self._core.start_pair_factors(all_elements, all_pairs, as_request(PairRequest, request, fields)))

    # Time.

    def host_compute(self, duration: int) -> None:
        """The simulated host computes for that long, picoseconds; the board continues meanwhile."""
        self._core.host_compute(duration)

    def share_blocks(self, exchange: RayExchange) -> None:
        """Traces volumes together with the boards of other ranks of a job, which `exchange` reaches. Each rank's card
        is sent its own blocks, and rays that come to others' blocks go there. From now on load_volume(), render(),
        render_to_framebuffer(), read_framebuffer(), illuminate() and submit() are calls that all ranks make alike
        (gicube/board.h). What the exchange raises comes from the call; then the job must end, since the others wait.

        Raises BadArgument (exchange), Rejected (a volume is loaded), Unsupported.
        """
        self._core.share_blocks(exchange)

    def set_brick_detail(self, detail: float) -> None:
        """Blocks of a volume that the card does not store whole are sent in cells of 2, 4 or 8 voxels an edge, as their
        means, where these are at most that many pixels wide. 0: as they are (gicube/board.h).

        Raises BadArgument (detail: 0..64), Unsupported.
        """
        self._core.set_brick_detail(detail)

    def brick_detail(self) -> Optional[BrickDetail]:
        """The level of detail of the last picture; None if the card stores the volume whole. Raises Rejected if there
        is no picture."""
        return self._core.brick_detail()

    def set_time_limit(self, limit: int) -> None:
        """From now on a picture or a lighting pass that takes longer, in simulated picoseconds, raises DeadlinePassed.
        0: none."""
        self._core.set_time_limit(limit)

    @property
    def counters(self) -> Counters:
        """The board's counters since its start."""
        return Counters(self._core.counters())


def enumerate() -> List[FoundBoard]:
    """The boards on this machine that listen and are of this user, then its PCI functions that are boards (pci:).
    Private
    ones (emu:) of other programs are none. Raises Error if the folder in which boards make themselves known can't be
    trusted."""
    return _core.enumerate()


#: gicube.open("emu:") reads better; it is the class.
open = Board
