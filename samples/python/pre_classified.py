"""A volume that was classified before it came to the card, as photographs of slices are: each voxel has a colour and an
alpha of its own, and the card interpolates colours premultiplied by alpha. Here it is a melon, with a wedge cut out.

Usage: pre_classified.py PICTURE.png [VOXELS]     voxels of an edge, 128 if not given
"""

import sys
from typing import Any, Tuple

import numpy as np

import gicube


def melon(size: int) -> Tuple[Any, Any]:
    """Alpha [z, y, x] and colours [z, y, x, 3]: bytes."""
    z, y, x = np.mgrid[:size, :size, :size].astype("f4") * (2 / (size - 1)) - 1
    radius = np.sqrt(x * x + y * y + 1.2 * z * z)
    around = np.arctan2(y, x)
    random = np.random.default_rng(7)
    colours = np.zeros((size, size, size, 3), "f4")
    stripes = 0.5 + 0.5 * np.tanh(4 * np.sin(10 * around + 1.5 * np.sin(7 * z)))
    colours[:] = np.where(stripes[..., None] > 0.5, (30, 80, 25), (120, 165, 70))  # the skin
    for edge, colour in ((0.90, (205, 225, 170)), (0.84, (235, 120, 110)), (0.78, (215, 45, 50)),
                         (0.35, (230, 80, 85))):
        colours[radius < edge] = colour
    flesh = radius < 0.8
    colours[flesh] += random.normal(0, 6, (int(flesh.sum()), 1))
    for angle in np.arange(0, 2 * np.pi, np.pi / 6):  # seeds
        for height in (-0.35, 0.0, 0.35):
            place = np.array([0.55 * np.cos(angle), 0.55 * np.sin(angle), height])
            near = np.sqrt((x - place[0]) ** 2 + (y - place[1]) ** 2 + ((z - place[2]) / 1.6) ** 2)
            colours[near < 0.05] = (40, 25, 20)
    # inside: above 0
    wedge = np.minimum(np.minimum(y * np.cos(0.5) + x * np.sin(0.5), x * np.sin(0.9) - y * np.cos(0.9)), z + 0.1)
    within = np.minimum(0.95 - radius, -wedge) * (size - 1) / 2  # voxels from the surface
    return (255 * (0.5 + within / 2).clip(0, 1)).astype("u1"), colours.clip(0, 255).astype("u1")


def main(picture: str, size: int = 128) -> gicube.Image:
    alpha, colours = melon(size)
    # the samples are the opacities
    opacity = gicube.TransferFunction(colours=[(0, (1, 1, 1))], opacities=[(0, 0), (255, 1)])
    with gicube.open("emu:?set=asic.voxel_format=rgba") as board:
        board.load_volume(gicube.Volume(alpha, colours=colours))
        board.set_transfer_function(opacity)
        middle = (size - 1) / 2
        view = gicube.View(
            eye=(middle + 1.7 * size, middle + 0.9 * size, middle + 1.3 * size),
            look_at=(middle, middle, middle),
            up=(0, 0, 1),
            fov_degrees=28,
            width=384,
            height=384,
            samples_per_axis=2,
            shade=True,
        )
        image = board.render(view)
        print(f"{size}^3 voxels of 60 bits, {board.now * 1e-9:.1f} ms of simulated time, {picture}")
    image.save(picture, background=(1, 1, 1))
    return image


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
