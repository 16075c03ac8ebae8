"""Paths of light that the host makes and the board flies: Monte Carlo with free paths by first hits."""
import gicube
import numpy as np

LEAST = 2.0**-24  # the board's opacities
STRATA = 64  # chosen: commands of a batch, each with an opacity of its own


def flights(board, voxel, direction, random, step):
    """Where flights from places (n, 3) in voxels end, and whether they do before the volume does. A flight ends where
    the opacity that it has gathered reaches a number that is even in 0..1: one of as many strata as there are commands,
    dealt at random."""
    order = random.permutation(len(voxel))
    parts = [each for each in np.array_split(order, min(STRATA, len(order))) if len(each)]
    # Samples then lie in the middles of their steps.
    rays = gicube.rays(voxel + step / 2 * direction, direction)
    opacities = np.clip((np.arange(len(parts)) + random.random(len(parts))) / len(parts), LEAST, 1 - LEAST)
    tickets = [board.submit(rays[part], type=gicube.RayType.FIRST_HIT, step=step, opacity=float(opacity)) for part,
               opacity in zip(parts, opacities)]
    ends, hit = np.empty_like(voxel), np.empty(len(voxel), bool)
    for k, (part, ticket) in enumerate(zip(parts, tickets)):
        traced = board.receive(ticket).rays
        ends[part] = traced["position"]
        hit[part] = traced["opacity"] >= opacities[k]
    return ends + step * (random.random((len(voxel), 1)) - 0.5) * direction, hit
