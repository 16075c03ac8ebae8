"""Volumes in the host's memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike

from gicube.arrays import as_array, as_choice
from gicube.errors import BadArgument
from gicube.records import Array, Placement, Record, SampleType, ValueRange, Vec3, WorldPlacement


def as_volume(given: "Union[Volume, ArrayLike]") -> "Volume":
    """A gicube.Volume, one of an array's samples, or of another package's image. Raises BadArgument."""
    if isinstance(given, Volume):
        return given
    from gicube import images  # which imports this module

    return images.volume_from(given) if images.reader_of(given) else Volume(_stacked(given))


def _stacked(given: Any) -> Any:
    """A list of planes, with their masks."""
    hidden = isinstance(given, (list, tuple)) and any(isinstance(each, np.ma.MaskedArray) for each in given)
    return np.ma.stack(given) if hidden else np.asanyarray(given)


def _of_board(array: Any) -> Any:
    """Converts to a type that boards take, with the same values. Integers become the smallest that holds them, or else
    float32."""
    kind = array.dtype
    if kind.name in ("uint8", "uint16", "int16", "float32"):
        return array
    if kind.kind == "b":
        return array.astype("u1")
    if kind.kind == "f":
        finite = array[np.isfinite(array)]
        if finite.size and np.abs(finite).max() > np.finfo("f4").max:
            raise BadArgument("samples", "values that float32 holds", f"{np.abs(finite).max()}")
        return array.astype("f4")
    if kind.kind in "iu":
        low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
        fits = [name for name in ("uint8", "uint16", "int16") if np.iinfo(name).min <= low
                and high <= np.iinfo(name).max]
        return array.astype(fits[0] if fits and kind.itemsize > 1 else "int16" if fits else "float32")
    raise BadArgument("samples", "an array of numbers", str(kind))


@dataclass
class Volume(Record):
    """A volume in the host's memory (gicube/volume.h).

    samples: array [z, y, x] of numbers. One of uint8, uint16, int16 or float32 is used where it lies if it is
    contiguous and in the
        machine's byte order, and copied once if not. Others become one of these: float16 and float64 float32, bool
        uint8 with the range 0..1, other integers the smallest type that holds their values, or else float32, which
        rounds beyond 2^24. A masked array's masked voxels get its least value, at which most looks are clear, and the
        range is that of the others. UINT12 is uint16 with `sample_type`.
    spacing: physical voxel edges x, y, z; the ratios count, and for line integrals and backprojection the lengths too.
    range: the values that become density 0 and 4095. None: 0..255 of uint8, 0..4095 of uint12, else the least and
    greatest sample. gradients: None: found by the driver. Else float32 [z, y, x, 3], the direction x, y, z in which the
    value grows. tags: None: all 0. Else uint8 [z, y, x], the material's tag 0..3.
    colours: None: none. Else uint8 [z, y, x, 3], red, green, blue, 255 = 1, for a card whose voxels have colours
        (BoardInfo.voxel_format): factors of the transfer function's. With VoxelFormat.RGBA the samples are the colours'
        alpha, and colours are premultiplied by it before they are interpolated.
    find_gradients: False, without `gradients`: nothing is shaded, and loading takes a third less time.

    Raises BadArgument with the field.
    """

    samples: Array
    spacing: Vec3 = (1.0, 1.0, 1.0)
    range: Optional[ValueRange] = None
    sample_type: Optional[SampleType] = None
    gradients: Optional[Array] = None
    tags: Optional[Array] = None
    find_gradients: bool = True
    source: str = ""  # the file it was read from, for messages
    placement: Optional[Placement] = None  # of one that coarser() or cropped() made
    colours: Optional[Array] = None
    world: Optional[WorldPlacement] = None  # its position by the file

    def __post_init__(self) -> None:
        array: Any = np.asanyarray(self.samples)
        if self.range is None and array.dtype.kind == "b":
            self.range = ValueRange(0.0, 1.0)
        if isinstance(array, np.ma.MaskedArray):
            hidden: Any = array  # its methods have no types
            array = np.asarray(hidden)
            if np.any(hidden.mask):
                shown = hidden.compressed()
                if shown.size == 0:
                    raise BadArgument("samples", "some voxels without a mask", "none")
                low, high = np.nanmin(shown), np.nanmax(shown)
                self.range = self.range or (ValueRange(float(low), float(high)) if low < high else None)
                array = np.asarray(hidden.filled(low))
        array = _of_board(array)
        native = array.dtype.newbyteorder("=")
        found = SampleType(native.name)
        given = found if self.sample_type is None else as_choice(SampleType, self.sample_type, "sample_type")
        if given is not found and (given, found) != (SampleType.UINT12, SampleType.UINT16):
            raise BadArgument("sample_type", f"{found.value}, as the array's", given.value)
        if array.ndim != 3:
            raise BadArgument("samples", "three axes, [z, y, x]", f"the shape {array.shape}")
        self.samples, self.sample_type = np.ascontiguousarray(array, dtype=native), given
        if self.gradients is not None:
            self.gradients = as_array(self.gradients, "gradients", "float32", (*array.shape, 3))
        if self.tags is not None:
            self.tags = as_array(self.tags, "tags", "uint8", array.shape)
        if self.colours is not None:
            self.colours = as_array(self.colours, "colours", "uint8", (*array.shape, 3))

    @property
    def dims(self) -> Tuple[int, int, int]:
        """Voxels along x, y, z."""
        z, y, x = self.samples.shape
        return x, y, z

    def __repr__(self) -> str:
        x, y, z = self.dims
        assert self.sample_type is not None
        source = f" from {self.source}" if self.source else ""
        return f"<gicube.Volume {x} x {y} x {z} {self.sample_type.value}{source}>"


@dataclass
class VolumeStream(Record):
    """A volume that is read while it is loaded, for one that does not fit into memory (gicube/volume.h).

    read: called with the first plane and their number, returns these planes [z, y, x] of `sample_type`. It is asked for
    all of them in their
        order; for those of uint16, int16 and float32 without a range twice. An exception of it leaves load_volume(),
        and the board keeps its volume.
    dims: voxels along x, y, z.
    spacing, range, find_gradients: as Volume's.
    read_colours: None: no colours. Else it is asked after `read` for the same planes, and returns uint8 [z, y, x, 3].
    """

    read: Callable[[int, int], ArrayLike]
    dims: Tuple[int, int, int]
    sample_type: SampleType = SampleType.UINT8
    spacing: Vec3 = (1.0, 1.0, 1.0)
    range: Optional[ValueRange] = None
    find_gradients: bool = True
    read_colours: Optional[Callable[[int, int], ArrayLike]] = None

    def _colours(self, first: int, count: int) -> Array:
        x, y, _ = self.dims
        assert self.read_colours is not None
        return as_array(self.read_colours(first, count), "read_colours", "uint8", (count, y, x, 3))

    def _planes(self, first: int, count: int) -> Array:
        x, y, _ = self.dims
        kind = "uint16" if self.sample_type is SampleType.UINT12 else self.sample_type.value
        return as_array(self.read(first, count), "read", kind, (count, y, x))
