"""A ray algorithm of one's own: an ambient-occlusion map of a scene. FIRST_HIT rays find what each pixel sees, the
gradient there says where outside is, and OPACITY rays into the half space say how much of the sky reaches the point.

Usage: ambient_occlusion.py PICTURE.png [RAYS_A_POINT]
"""

import sys
from typing import Any

import numpy as np

import gicube

SIZE, PIXELS, REACH = 64, 128, 24.0  # voxels; pixels; how far an occluder may be, voxels
SCENE = f'volume {{ builtin: "buckyball" size: {SIZE} }}'


def pixel_rays() -> Any:
    """Parallel rays along y, a grid of them over the volume's front."""
    across = np.linspace(0.5, SIZE - 1.5, PIXELS)
    x, z = (each.ravel() for each in np.meshgrid(across, across[::-1]))
    return gicube.rays(np.stack([x, np.zeros_like(x), z], axis=1), (0, 1, 0))


def normals_at(samples: Any, points: Any) -> Any:
    """Unit vectors against the gradient at the nearest voxels."""
    z, y, x = np.gradient(samples.astype("f4"))
    index = tuple(np.rint(points[:, axis]).astype(int).clip(0, SIZE - 1) for axis in (2, 1, 0))
    gradient = np.stack([x[index], y[index], z[index]], axis=1)
    return -gradient / np.maximum(np.linalg.norm(gradient, axis=1, keepdims=True), 1e-6)


def main(picture: str, rays_a_point: int = 32) -> Any:
    """Returns the map: float [row, column], 1 where all of the sky is seen, NaN where nothing was hit."""
    setup = gicube.parse_scene(SCENE).set_up()
    random = np.random.default_rng(1)
    with gicube.open() as board:
        gicube.load_scene(board, setup)
        hits = board.receive(board.submit(pixel_rays(), type=gicube.RayType.FIRST_HIT, opacity=0.5)).rays
        is_hit = hits["opacity"] >= 0.5
        points = hits["position"][is_hit]
        normals = normals_at(setup.volume.samples, points)
        directions = random.normal(size=(len(points), rays_a_point, 3))
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        directions += normals[:, None]  # about the normal, as much light comes from each (Lambert)
        directions /= np.maximum(np.linalg.norm(directions, axis=-1, keepdims=True), 1e-6)
        starts = np.repeat(points + 2.5 * normals, rays_a_point, axis=0).clip(0, SIZE - 1)
        rays = gicube.clip_to_volume(
            gicube.rays(starts, directions.reshape(-1, 3), length=REACH, id=np.arange(len(starts)) // rays_a_point),
            (SIZE,) * 3
        )
        arrived = board.receive(board.submit(rays, type=gicube.RayType.OPACITY)).rays
        print(f"{len(rays)} rays of {len(points)} points, {board.now * 1e-9:.1f} ms of simulated time")
    hidden = np.bincount(arrived["id"], weights=arrived["opacity"], minlength=len(points))
    shades = np.full(PIXELS * PIXELS, np.nan)
    shades[is_hit] = 1 - hidden / rays_a_point
    shades = shades.reshape(PIXELS, PIXELS)
    pixels = np.zeros(shades.shape, gicube.PIXEL)
    pixels["rgb"] = (255 * np.nan_to_num(shades))[..., None]
    pixels["alpha"] = np.where(np.isnan(shades), 0, 4095)
    gicube.Image(pixels).save(picture)
    return shades


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *(int(each) for each in sys.argv[2:]))
