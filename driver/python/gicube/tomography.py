"""Tomography on a board: line integrals for flat detectors that stand anywhere, and their transpose."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike

from gicube import _core
from gicube.arrays import as_array
from gicube.board import Board
from gicube.errors import BadArgument
from gicube.records import Array

__all__ = ["Projector", "circular_views", "tigre_views"]


class Projector:
    """The operator pair of all iterative methods (gicube/projector.h; docs/guide/cone_beam_geometry.md).

        views = gicube.circular_views(500, 1000, np.linspace(0, 2 * np.pi, 90, endpoint=False), pitch=2)
        projector = gicube.Projector(board, dims=(64, 64, 64), columns=96, rows=80, views=views)
        projections = projector.project(volume)               # [view, row, column]
        gradient = projector.backproject(projections - measured)    # [z, y, x]

    It uses the board's volume and sums, which its calls replace: nothing else may load a volume between them.
    """

    def __init__(
        self,
        board: Board,
        *,
        dims: Sequence[int],
        columns: int,
        rows: int,
        views: ArrayLike,
        spacing: Sequence[float] = (1.0, 1.0, 1.0),
        step: float = 1.0,
    ) -> None:
        """dims: voxels (x, y, z). spacing: their edges, in one unit with all lengths. columns, rows: pixels of the
        detectors.

        views: (n, 12) numbers, of each view the source, the detector's middle, and the steps from a pixel to the next
        in its row and in its column, as ASTRA's cone_vec. The origin is the volume's middle. step: between samples, at
        most, 1/64..16 voxels.

        Raises BadArgument that names the field.
        """
        vectors = as_array(views, "views", "float64", (None, 12))
        fields = {"dims": list(dims), "spacing": tuple(spacing), "columns": columns, "rows": rows, "step": step}
        self._core = _core.Projector(board._core, fields, vectors)
        self._volume, self._view, self._views = tuple(dims)[::-1], (rows, columns), len(vectors)

    def _indices(self, views: Optional[Sequence[int]]) -> List[int]:
        chosen = list(range(self._views)) if views is None else [int(view) for view in views]
        if not chosen or min(chosen) < 0 or max(chosen) >= self._views:
            raise BadArgument("views", f"indices of 0..{self._views - 1}", str(chosen))
        return chosen

    def project(self, volume: ArrayLike, views: Optional[Sequence[int]] = None) -> Array:
        """Line integrals [view, row, column], float32, of a volume [z, y, x] from the source to each pixel; `views`:
        indices, None for all.

        Values lie between voxel centres by trilinear interpolation; outside of their box there is nothing. The board
        holds the volume in 12 bits between its least value, at most 0, and its greatest. Raises BadArgument (shape,
        values that are not finite).
        """
        values, chosen = as_array(volume, "volume", "float32", self._volume), self._indices(views)
        return self._core.project(values, chosen).reshape(len(chosen), *self._view)

    def backproject(self, values: ArrayLike, views: Optional[Sequence[int]] = None) -> Array:
        """The transpose of project(): each ray of values [view, row, column] leaves its value, times its length in a
        voxel by the same interpolation, in that voxel. Returns [z, y, x], float32. Raises BadArgument (shape, values
        that are not finite)."""
        chosen = self._indices(views)
        return self._core.backproject(as_array(values, "values", "float32", (len(chosen), *self._view)),
                                      chosen).reshape(self._volume)

    @property
    def counts(self) -> Tuple[int, int, int]:
        """Rays of both directions so far, deposits of backprojections, and sums that were full (values are wrong
        there)."""
        return self._core.counts()


def circular_views(
    source_to_axis: float,
    source_to_detector: float,
    angles: ArrayLike,
    *,
    pitch: ArrayLike,
    offset: Sequence[float] = (0.0, 0.0),
    heights: ArrayLike = 0.0,
) -> Array:
    """Views (n, 12) about the z axis, for Projector: at an angle b (radians) the source is at source_to_axis (cos b,
    sin b, 0), and the detector faces it squarely; columns run along (-sin b, cos b, 0), rows along z.

    pitch: of columns and rows, or one for both. offset: of the detector's middle from the ray through the axis,
    as offset_u and offset_v of a scan file.
    heights: along z of source and detector, of each view or of all; angles that ascend with heights are a helix.
    """
    angles, heights = np.broadcast_arrays(as_array(np.atleast_1d(angles), "angles", "float64", (None,)),
                                          np.asarray(heights, "f8"))
    pitches = np.broadcast_to(np.asarray(pitch, "f8"), (2,))
    offsets = as_array(offset, "offset", "float64", (2,))
    zero, one = np.zeros_like(angles), np.ones_like(angles)
    c, s = np.cos(angles), np.sin(angles)
    out, u, v = (np.stack(each, 1) for each in ((c, s, zero), (-s, c, zero), (zero, zero, one)))
    height = heights[:, None] * v
    centre = (source_to_axis - source_to_detector) * out + offsets[0] * u + offsets[1] * v
    return np.hstack([source_to_axis * out + height, centre + height, pitches[0] * u, pitches[1] * v])


def _turned(rotation: Array, vectors: Array) -> Array:
    out: Array = (rotation @ vectors[:, :, None])[:, :, 0]
    return out


def _about(axis: int, angles: Array) -> Array:
    """Rotations (n, 3, 3)."""
    first, second = [(1, 2), (2, 0), (0, 1)][axis]
    out = np.tile(np.eye(3), (len(angles), 1, 1))
    out[:, first, first] = out[:, second, second] = np.cos(angles)
    out[:, second, first], out[:, first, second] = np.sin(angles), -np.sin(angles)
    return out


def tigre_views(geo: Any, angles: ArrayLike) -> Array:
    """Views (n, 12) for Projector from a geometry of TIGRE (mode "cone") and its angles, (n,) or (n, 3), in radians.

    Read are DSD, DSO, dDetector, offOrigin, offDetector, rotDetector and COR, each one value or one per view, in
    TIGRE's order (z, y, x) and (v, u). Volumes are [z, y, x] and projections [view, v, u] in both:
    dims=geo.nVoxel[::-1], spacing=geo.dVoxel[::-1], columns=geo.nDetector[1], rows=geo.nDetector[0].
    """
    turns = as_array(np.asarray(angles, "f8"), "angles", "float64")
    turns = np.column_stack([turns, np.zeros((len(turns), 2))]) if turns.ndim == 1 else turns
    if turns.ndim != 2 or turns.shape[1] != 3:
        raise BadArgument("angles", "the shape (n,) or (n, 3)", str(np.shape(angles)))
    if getattr(geo, "mode", "cone") != "cone":
        raise BadArgument("geo.mode", '"cone"', repr(geo.mode))
    count = len(turns)

    def given(name: str, numbers: int, otherwise: float = 0.0) -> Array:
        value = getattr(geo, name, None)
        array = np.asarray(otherwise if value is None else value, "f8")
        try:
            return np.broadcast_to(array[:, None] if array.ndim == 1 and numbers == 1 else array,
                                   (count, numbers)).copy()
        except ValueError as error:
            raise BadArgument(f"geo.{name}", f"{numbers} numbers, or as many a view", str(array.shape)) from error

    to_detector, to_axis, pitch = given("DSD", 1)[:, 0], given("DSO", 1)[:, 0], given("dDetector", 2)
    roll, pitch_angle, yaw = given("rotDetector", 3).T
    tilt = _about(2, roll) @ _about(1, pitch_angle) @ _about(0, yaw)
    zero = np.zeros(count)
    u = _turned(tilt, np.stack([zero, pitch[:, 1], zero], 1))
    v = _turned(tilt, np.stack([zero, zero, pitch[:, 0]], 1))
    shift = given("offDetector", 2)
    centre = np.stack([to_axis - to_detector, shift[:, 1], shift[:, 0]], 1)
    rotation = _about(2, turns[:, 0]) @ _about(1, turns[:, 1]) @ _about(2, turns[:, 2])
    beside = given("COR", 1) * np.stack([-np.sin(turns[:, 0]), np.cos(turns[:, 0]), zero], 1) - given("offOrigin", 3)[:,
        ::-1]
    source = _turned(rotation, np.stack([to_axis, zero, zero], 1)) + beside
    return np.hstack([source, _turned(rotation, centre) + beside, _turned(rotation, u), _turned(rotation, v)])
