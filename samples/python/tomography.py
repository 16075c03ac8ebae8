"""Tomography of a numpy phantom on the board: parallel projections by INTEGRAL rays, and their reconstruction by SIRT,
whose corrections go back into the volume by BACKPROJECT rays (Gilbert 1972).

Usage: tomography.py PICTURE.png [ITERATIONS]
"""

import sys
from typing import Any

import numpy as np

import gicube

SIZE, ANGLES = 48, 24  # voxels an edge; directions over half a turn
BOARD = "emu:?set=asic.datapath=wide&set=asic.block_voxels=16"


def phantom() -> Any:
    """Three balls in a cylinder, float32 [z, y, x], 0..1."""
    z, y, x = np.mgrid[0:SIZE, 0:SIZE, 0:SIZE] - (SIZE - 1) / 2
    out = 0.25 * (np.hypot(x, y) < 0.4 * SIZE) * (np.abs(z) < 0.3 * SIZE)
    for (cx, cy, radius), value in {(8, 0, 6): 0.5, (-7, 6, 5): 0.75, (-4, -9, 4): -0.25}.items():
        out[(x - cx) ** 2 + (y - cy) ** 2 + z**2 < radius**2] += value
    return out.astype("f4")


def projection_rays() -> Any:
    """Parallel rays around the z axis, one through each pixel of each view, clipped to the volume."""
    middle, reach = (SIZE - 1) / 2, SIZE
    across = np.arange(SIZE) - middle
    u, v = (each.ravel() for each in np.meshgrid(across, across))
    starts, ends = [], []
    for angle in np.arange(ANGLES) * np.pi / ANGLES:
        side, along = np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])
        centre = middle + u[:, None] * side + v[:, None] * np.array([0, 0, 1.0])
        starts.append(centre - reach * along)
        ends.append(centre + reach * along)
    rays = gicube.rays_between(np.concatenate(starts), np.concatenate(ends))
    return gicube.clip_to_volume(rays, (SIZE, SIZE, SIZE))


def integrals(board: gicube.Board, rays: Any) -> Any:
    return board.receive(board.submit(rays, type=gicube.RayType.INTEGRAL)).rays["integral"]


def backprojection(board: gicube.Board, rays: Any, values: Any) -> Any:
    board.clear_sums(2.0**-14)
    loaded = rays.copy()
    loaded["energy"] = values
    board.receive(board.submit(loaded, type=gicube.RayType.BACKPROJECT))
    return board.read_sums()


def reconstruct(board: gicube.Board, rays: Any, measured: Any, iterations: int) -> Any:
    """SIRT: f += backprojection of (measured - projected) / (a ray's length), over what a voxel gets of rays of value
    one."""
    estimate = np.zeros((SIZE, SIZE, SIZE), "f4")
    board.load_volume(gicube.Volume(estimate, range=gicube.ValueRange(0, 1), find_gradients=False))
    weights = np.maximum(backprojection(board, rays, 1.0), 1e-3)
    lengths = np.maximum(rays["length"], 1)
    for iteration in range(iterations):
        missing = (measured - integrals(board, rays)) / lengths
        estimate += backprojection(board, rays, missing) / weights
        np.clip(estimate, 0, 1, out=estimate)
        board.load_volume(gicube.Volume(estimate, range=gicube.ValueRange(0, 1), find_gradients=False))
        print(f"iteration {iteration + 1}: {np.sqrt((missing**2).mean()):.4f} RMS of the mean value along a ray")
    return estimate


def main(picture: str, iterations: int = 8) -> float:
    """Returns the root of the mean square error."""
    truth, rays = phantom(), projection_rays()
    with gicube.open(BOARD) as board:
        board.load_volume(gicube.Volume(truth, range=gicube.ValueRange(0, 1), find_gradients=False))
        measured = integrals(board, rays)
        found = reconstruct(board, rays, measured, iterations)
        error = float(np.sqrt(((found - truth) ** 2).mean()))
        print(f"{len(rays)} rays a pass, error {error:.4f} of 1, {board.now * 1e-12:.2f} s of simulated time, "
              f"{picture}")
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, all_axes = plt.subplots(1, 2, figsize=(6, 3), layout="constrained")
    for axes, values, title in zip(all_axes, (truth, found),
                                   ("phantom", f"{ANGLES} directions, {iterations} iterations")):
        axes.imshow(values[SIZE // 2], cmap="gray", vmin=0, vmax=1)
        axes.set_title(title)
        axes.set_axis_off()
    figure.savefig(picture, dpi=100)
    return error


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *(int(each) for each in sys.argv[2:]))
