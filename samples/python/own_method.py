"""A reconstruction method of one's own on gicube.Projector: gradient descent with momentum (Nesterov 1983) from views
on a helix, values below 0 cut off.

Usage: own_method.py
"""

from typing import Any

import numpy as np

import gicube

SIZE, HEIGHT, VIEWS = 24, 32, 72


def reconstruct(projector: gicube.Projector, measured: Any, iterations: int) -> Any:
    x = np.ones((HEIGHT, SIZE, SIZE), "f4")
    for _ in range(6):  # the greatest eigenvalue of backproject(project()), by the power method
        x = projector.backproject(projector.project(x))
        greatest = float(np.linalg.norm(x))
        x /= greatest
    estimate = ahead = np.zeros_like(x)
    momentum = 1.0
    for i in range(1, iterations + 1):
        missing = measured - projector.project(ahead)
        before, estimate = estimate, np.maximum(ahead + 0.95 / greatest * projector.backproject(missing),
                                                0).astype("f4")
        momentum, last = (1 + np.sqrt(1 + 4 * momentum**2)) / 2, momentum
        ahead = (estimate + (last - 1) / momentum * (estimate - before)).astype("f4")
        if i % 10 == 0:
            print(f"iteration {i}: residual {np.linalg.norm(missing) / np.linalg.norm(measured):.4f}")
    return estimate


def main(iterations: int = 40) -> float:
    """Returns the error of the volume over the object."""
    z, y, x = np.mgrid[0:HEIGHT, 0:SIZE, 0:SIZE]

    def ball(i: int, j: int, k: int, radius: int) -> Any:
        return (x - i) ** 2 + (y - j) ** 2 + (z - k) ** 2 < radius**2

    truth = (ball(8, 14, 9, 5) + 0.5 * ball(15, 9, 22, 6)).astype("f4")
    turns = np.arange(VIEWS) * 3 * 2 * np.pi / VIEWS
    heights = (np.arange(VIEWS) + 0.5) * HEIGHT / VIEWS - HEIGHT / 2
    views = gicube.circular_views(80, 120, turns, pitch=1.5, heights=heights)
    with gicube.open("emu:?set=asic.block_voxels=16") as board:
        projector = gicube.Projector(board, dims=(SIZE, SIZE, HEIGHT), columns=40, rows=24, views=views)
        found = reconstruct(projector, projector.project(truth), iterations)
        error = float(np.linalg.norm(found - truth) / np.linalg.norm(truth))
        print(f"error {error:.3f} of the object, {board.now * 1e-9:.0f} simulated ms")
    return error


if __name__ == "__main__":
    main()
