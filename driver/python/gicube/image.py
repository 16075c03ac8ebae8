"""Pictures read from the framebuffer."""

from __future__ import annotations

import os
import tempfile
from typing import Any, Optional

import numpy as np

from gicube import _core
from gicube.arrays import PIXEL, as_array
from gicube.records import Array, Colour


class Image:
    """A picture. `pixels`: array [row, column] of gicube.PIXEL, rows from the top. Jupyter shows it over black."""

    def __init__(self, pixels: Array) -> None:
        self.pixels: Array = as_array(pixels, "pixels", PIXEL, (None, None))

    @property
    def width(self) -> int:
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        return int(self.pixels.shape[0])

    @property
    def rgb(self) -> Array:
        """uint8 [row, column, 3], premultiplied by alpha, display-referred: the picture over black. A view."""
        return self.pixels["rgb"]

    @property
    def alpha(self) -> Array:
        """uint16 [row, column], 0..4095. A view."""
        return self.pixels["alpha"]

    def over(self, background: Colour = (0.0, 0.0, 0.0)) -> Array:
        """uint8 [row, column, 3]: over a colour, 0..1 each, mixed in display-referred values as on a screen."""
        left = (1 - self.alpha / 4095.0)[..., None] * np.asarray(background, dtype=float)
        mixed: Array = np.rint(np.clip(self.rgb + 255 * left, 0, 255)).astype("u1")
        return mixed

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Array:
        """`rgb`: numpy.asarray() and pyplot.imshow() take a picture."""
        rgb = self.rgb if dtype is None else self.rgb.astype(dtype)
        return rgb.copy() if copy else rgb

    def save(self, path: "os.PathLike[str] | str", background: Optional[Colour] = None) -> None:
        """Writes .png (display-referred) or .exr (linear light), with alpha, or over a colour. Raises FileError."""
        _core.write_image(os.fspath(path), self.pixels, background)

    def _repr_png_(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "image.png")
            self.save(path, (0, 0, 0))
            with open(path, "rb") as file:
                return file.read()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Image) and np.array_equal(self.rgb, other.rgb) and np.array_equal(self.alpha,
            other.alpha)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<gicube.Image {self.width} x {self.height}>"
