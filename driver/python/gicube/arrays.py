"""The arrays that go to the board and come from it: their dtypes, how they are made, how they are checked."""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import Any, Dict, Optional, Sequence, Type, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike

from gicube import _core
from gicube.errors import BadArgument
from gicube.records import Array, ElementKind

__all__ = [
    "ELEMENT", "ELEMENT_PAIR", "PAIR_FACTOR", "PIXEL", "RAY", "TRACED_RAY", "clip_to_volume", "elements", "pairs",
    "rays",
    "rays_between",
]

#: A ray of the host: id, position and direction (x, y, z in voxels), length (voxels), energy. gicube/ray.h, HostRay.
RAY: np.dtype[Any] = _core.RAY
#: A ray as it returned: id, position, direction, colour (premultiplied, 0..1), opacity, integral.
TRACED_RAY: np.dtype[Any] = _core.TRACED_RAY
#: rgb: 0..255, premultiplied by alpha, display-referred; alpha: 0..4095.
PIXEL: np.dtype[Any] = _core.PIXEL
#: kind (index of ElementKind), origin, u, v, w. gicube/pair.h, Element.
ELEMENT: np.dtype[Any] = _core.ELEMENT
#: a, b: indices of elements; id picks the points.
ELEMENT_PAIR: np.dtype[Any] = _core.ELEMENT_PAIR
#: transported, geometric, standard_error, clear. gicube/pair.h, PairFactor.
PAIR_FACTOR: np.dtype[Any] = _core.PAIR_FACTOR


Request = TypeVar("Request")


def as_request(
    kind: Type[Request], request: Optional[Request], fields: Dict[str, Any], name: str = "request"
) -> Request:
    """`request` with these fields changed; one of them alone if it is None. Raises BadArgument, for the argument
    `name`, if it is of another kind."""
    if request is None:
        return kind(**fields)
    if not isinstance(request, kind):
        raise BadArgument(name, f"a {kind.__name__}, or its fields by their names", repr(request))
    return replace(request, **fields)


Choice = TypeVar("Choice", bound=Enum)


def as_choice(kind: Type[Choice], value: Any, field: str) -> Choice:
    """The member of an enumeration that has this value. Raises BadArgument."""
    try:
        return kind(value)
    except ValueError as error:
        raise BadArgument(field, f"a {kind.__name__}: {', '.join(each.value for each in kind)}", repr(value)) from error


def unmasked(value: ArrayLike, field: str) -> ArrayLike:
    """Raises BadArgument for an array with masked elements, or a sequence of such arrays: the board has none."""
    parts = value if isinstance(value, (list, tuple)) else [value]
    masks = [np.ascontiguousarray(each.mask) for each in parts if isinstance(each, np.ma.MaskedArray)]
    hidden = sum(np.count_nonzero(mask.view(bool)) for mask in masks)
    if hidden:
        expected = "an array without masked elements (filled() gives them a value)"
        raise BadArgument(field, expected, f"one with {hidden} masked")
    return value


def as_array(value: ArrayLike, field: str, dtype: Any, shape: Optional[Sequence[Optional[int]]] = None) -> Array:
    """`value` contiguous, in the machine's byte order, without a copy if it is that already.

    `shape`: None is any length. Raises BadArgument: another dtype (integers that fit become floats), another shape,
    masked elements.
    """
    wanted = np.dtype(dtype)
    unmasked(value, field)
    array = np.asarray(value) if isinstance(value, np.ndarray) else np.asarray(value, dtype=wanted)
    native = array.dtype.newbyteorder("=")
    if native != wanted and not (wanted.names is None and np.can_cast(native, wanted, "same_kind")
                                 and wanted.kind == "f"):
        raise BadArgument(field, f"an array of {wanted.name if wanted.names is None else wanted.names}",
                          str(array.dtype))
    if shape is not None:
        fits = len(shape) == array.ndim and all(want in (None, got) for want, got in zip(shape, array.shape))
        if not fits:
            edges = ", ".join("any" if edge is None else str(edge) for edge in shape)
            raise BadArgument(field, f"the shape ({edges})", str(array.shape))
    return np.ascontiguousarray(array, dtype=wanted)


def rays(
    position: ArrayLike,
    direction: ArrayLike,
    *,
    length: ArrayLike = 0.0,
    energy: ArrayLike = 0.0,
    id: Optional[ArrayLike] = None,
) -> Array:
    """Rays from arrays (n, 3) of positions and directions, in voxels; one of them may be a single vector for all.

    length (voxels), energy, id: one value or n. Ids are 0..n-1 if none are given. Returns an array of RAY.
    """
    positions = as_array(position, "position", "float64")
    directions = as_array(direction, "direction", "float64")
    for field, array in (("position", positions), ("direction", directions)):
        if array.shape[-1:] != (3,) or array.ndim > 2:
            raise BadArgument(field, "the shape (n, 3) or (3,)", str(array.shape))
    count = max(array.shape[0] if array.ndim == 2 else 1 for array in (positions, directions))
    out = np.zeros(count, RAY)
    values = {
        "position": positions,
        "direction": directions,
        "length": length,
        "energy": energy,
        "id": np.arange(count, dtype="u4") if id is None else id,
    }
    for field, value in values.items():
        unmasked(value, field)
        try:
            out[field] = value
        except (ValueError, OverflowError) as error:
            raise BadArgument(field, f"one value, or {count} of them", str(np.shape(value))) from error
    return out


def rays_between(start: ArrayLike, end: ArrayLike, *, id: Optional[ArrayLike] = None, energy: ArrayLike = 0.0) -> Array:
    """Rays from one point to another, arrays (n, 3) or single points in voxels, for ray types with a length."""
    starts, ends = as_array(start, "start", "float64"), as_array(end, "end", "float64")
    try:
        way = ends - starts
    except ValueError as error:
        raise BadArgument("end", f"the shape {starts.shape}, as the start's", str(ends.shape)) from error
    length = np.sqrt((way * way).sum(axis=-1))
    direction = np.where(length[..., None] > 0, way, (0.0, 0.0, 1.0))
    return rays(np.broadcast_to(starts, way.shape), direction, length=length, id=id, energy=energy)


def clip_to_volume(rays: Array, dims: Sequence[int]) -> Array:
    """The parts of rays with a length that are inside a volume of `dims` voxels; rays that miss it are left out."""
    return _core.clip_to_volume(as_array(rays, "rays", RAY, (None,)), list(dims))


def elements(
    kind: Union[ElementKind, str, Sequence[Union[ElementKind, str]]],
    origin: ArrayLike,
    u: ArrayLike,
    v: ArrayLike,
    w: ArrayLike = (0.0, 0.0, 0.0),
) -> Array:
    """Elements for Board.pair_factors(): arrays (n, 3) in voxels, or single vectors for all. A kind is an ElementKind
    or its value, as "patch": origin + s u + t v, 0 to 1, inside the volume, with its front towards u x v. Returns an
    array of ELEMENT."""
    vectors = {name: as_array(value, name, "float64") for name,
               value in (("origin", origin), ("u", u), ("v", v), ("w", w))}
    kinds = [kind] if isinstance(kind, (ElementKind, str)) else list(kind)
    count = max([len(kinds), *(len(value) for value in vectors.values() if value.ndim == 2)])
    out = np.zeros(count, ELEMENT)
    order = list(ElementKind)
    out["kind"] = [order.index(as_choice(ElementKind, each, "kind")) for each in kinds]
    for name, value in vectors.items():
        if value.shape not in ((3,), (count, 3)):
            raise BadArgument(name, f"the shape (3,) or ({count}, 3)", str(value.shape))
        out[name] = value
    return out


def pairs(a: ArrayLike, b: ArrayLike, id: Optional[ArrayLike] = None) -> Array:
    """Pairs of elements by their indices, for Board.pair_factors(). Ids are 0..n-1 if none are given."""
    firsts, seconds = np.broadcast_arrays(np.atleast_1d(unmasked(a, "a")), np.atleast_1d(unmasked(b, "b")))
    out = np.empty(firsts.size, ELEMENT_PAIR)
    out["a"], out["b"] = firsts.ravel(), seconds.ravel()
    out["id"] = np.arange(firsts.size) if id is None else unmasked(id, "id")
    return out
