"""Which points of a room see each other: the transmittance between all pairs of points, by OPACITY rays.

Usage: visibility.py
"""

import itertools
from typing import Any

import numpy as np

import gicube


def room() -> Any:
    """uint8 [z, y, x]: a wall across the room with a door in it."""
    samples = np.zeros((32, 32, 32), "u1")
    samples[:, :, 15:17] = 255
    samples[:, 12:20, 15:17] = 0
    return samples


def transmittances(board: gicube.Board, points: Any) -> Any:
    """Array (n, n), symmetric, 1 on the diagonal."""
    pairs = np.array(list(itertools.combinations(range(len(points)), 2)))
    rays = gicube.rays_between(points[pairs[:, 0]], points[pairs[:, 1]])
    opacity = board.receive(board.submit(rays, type=gicube.RayType.OPACITY)).rays["opacity"]
    out = np.eye(len(points))
    out[pairs[:, 0], pairs[:, 1]] = out[pairs[:, 1], pairs[:, 0]] = 1 - opacity
    return out


def main() -> Any:
    points = np.array([[4, 16, 16], [28, 16, 16], [4, 3, 16], [28, 3, 16], [10, 28, 3]])
    with gicube.open() as board:
        board.load_volume(room())
        board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(127, 0), (127, 1)]))
        found = transmittances(board, points)
    print(np.round(found, 2))
    return found


if __name__ == "__main__":
    main()
