"""Volumes of other packages' images, with their geometry. None of these packages is imported: an image brings its
own."""

from __future__ import annotations

from typing import Any, Callable, Optional, Sequence, Tuple

import numpy as np

from gicube import _core
from gicube.errors import BadArgument
from gicube.records import Array, WorldAxes, WorldPlacement
from gicube.volume import Volume

__all__ = ["volume_from"]

#: [z, y, x] samples; spacing x, y, z; directions of x, y, z, one per row; origin; the world's axes.
Parts = Tuple[Array, Sequence[float], Array, Sequence[float], WorldAxes]


def _of_simpleitk(image: Any) -> Parts:
    import SimpleITK  # type: ignore[import]  # which made the image

    if image.GetDimension() != 3:
        raise BadArgument("image", "three axes", str(image.GetDimension()))
    directions = np.reshape(image.GetDirection(), (3, 3)).T
    return SimpleITK.GetArrayFromImage(image), image.GetSpacing(), directions, image.GetOrigin(), WorldAxes.PATIENT


def _of_nibabel(image: Any) -> Parts:
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ image.affine  # from right, anterior, superior
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    return np.asanyarray(image.dataobj).T, spacing, (affine[:3, :3] / spacing).T, affine[:3, 3], WorldAxes.PATIENT


def _of_vtk(image: Any) -> Parts:
    from vtkmodules.util.numpy_support import vtk_to_numpy  # type: ignore[import]

    scalars = image.GetPointData().GetScalars()
    if scalars is None or scalars.GetNumberOfComponents() != 1:
        raise BadArgument("image", "point data with scalars of one component",
                          "none" if scalars is None else "several components")
    matrix = image.GetDirectionMatrix()
    directions = np.array([[matrix.GetElement(row, column) for row in range(3)] for column in range(3)])
    low = np.array(image.GetExtent()[::2])
    origin = np.array(image.GetOrigin()) + (low * image.GetSpacing()) @ directions
    return vtk_to_numpy(scalars).reshape(
        image.GetDimensions()[::-1]), image.GetSpacing(), directions, origin, WorldAxes.WORLD


def reader_of(image: Any) -> Optional[Callable[[Any], Parts]]:
    """Takes such an image apart; none if it is no image of these packages."""
    if hasattr(image, "GetDirection") and hasattr(image, "GetPixelIDTypeAsString"):
        return _of_simpleitk
    if hasattr(image, "affine") and hasattr(image, "dataobj"):
        return _of_nibabel
    if hasattr(image, "GetDirectionMatrix") and hasattr(image, "GetPointData"):
        return _of_vtk
    return None


def volume_from(image: Any) -> Volume:
    """The volume of an image of SimpleITK, nibabel, VTK or PyVista, its axes brought to the nearest of its world, as
    read_volume() does.

    Images of more than three axes are refused, as are types that Volume does not take. Raises BadArgument.
    """
    parts = reader_of(image)
    if parts is None:
        raise BadArgument("image", "an image of SimpleITK, nibabel, VTK or PyVista", type(image).__name__)
    shape = getattr(image, "shape", None)
    if shape is not None and len(shape) != 3:
        raise BadArgument("image", "three axes", f"the shape {tuple(shape)}")
    samples, spacing, directions, origin, axes = parts(image)
    if samples.ndim != 3:
        raise BadArgument("image", "three axes", f"the shape {samples.shape}")
    stored = _core.nearest_axes([[float(part) for part in row] for row in directions])
    if not any(stored):
        raise BadArgument("image", "directions that span space", str(np.asarray(directions).tolist()))
    order = [abs(axis) - 1 for axis in stored]
    signs = [1 if axis > 0 else -1 for axis in stored]
    first: Any = np.asarray(origin, "f8")
    for axis, sign in zip(order, signs):
        if sign < 0:
            first = first + (samples.shape[2 - axis] - 1) * spacing[axis] * np.asarray(directions[axis])
    turned = samples.transpose([2 - axis for axis in order[::-1]])[tuple(slice(None, None, sign)
        for sign in signs[::-1])]
    world = WorldPlacement(
        axes,
        [tuple(float(sign * part) for part in directions[axis]) for axis, sign in zip(order, signs)],
        tuple(float(part) for part in first),
        list(stored),
    )
    edges = tuple(float(spacing[axis]) for axis in order)
    return Volume(turned, spacing=edges, world=world)
