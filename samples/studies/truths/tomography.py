"""Line integrals of Shepp and Logan's head, with closed forms for its ellipsoids."""
import math

import gicube
import numpy as np

from studies.truths.case import EXACT, Case, Value, even

SOURCE = "Shepp and Logan's ellipsoids (Kak and Slaney 1988, table 3.1, in three dimensions), closed form"
HEAD = np.array([  # value, half axes, centre, degrees about z
    (2.00, .6900, .920, .900, 0, 0, 0, 0), (-.98, .6624, .874, .880, 0, 0, 0, 0), (-.02, .4100, .160, .210, -.22, 0,
                                                                                   -.25, 108),
    (-.02, .3100, .110, .220, .22, 0, -.25, 72), (.02, .2100, .250, .500, 0, .35, -.25, 0), (.02, .0460, .046, .046, 0,
                                                                                             .1, -.25, 0),
    (.01, .0460, .023, .020, -.08, -.65, -.25, 0), (.01, .0460, .023, .020, .06, -.65, -.25, 90), (.02, .0560, .040,
        .100, .06, -.105, .625, 90),
    (-.02, .0560, .056, .100, 0, .1, .625, 0)])


def to_sphere(row, points, is_way=False):
    """x, y and z in coordinates in which the ellipsoid is the unit sphere; arrays of one shape."""
    c, s = math.cos(math.radians(row[7])), math.sin(math.radians(row[7]))
    x, y, z = points if is_way else (part - middle for part, middle in zip(points, row[4:7]))
    return (c * x + s * y) / row[1], (c * y - s * x) / row[2], z / row[3]


def dot(p, q):
    return sum(a * b for a, b in zip(p, q))


def integrals(start, way):
    """Line integrals along infinite lines; `way`: unit vectors."""
    total = 0
    for row in HEAD:
        p, d = to_sphere(row, start.T), to_sphere(row, way.T, True)
        a, b, c = dot(d, d), dot(p, d), dot(p, p) - 1
        total = total + row[0] * 2 * np.sqrt(np.maximum(0, b * b - a * c)) / a
    return total


def voxels(size, parts):
    """Means over voxels of edge 2 / (size - 1) that cover -1..1, with so many points along each edge."""
    inner = ((np.arange(parts) + 0.5) / parts - 0.5) * 2 / (size - 1)
    axis = (np.linspace(-1, 1, size)[:, None] + inner).ravel()
    out = np.zeros((size, size, size))
    for number, z in enumerate(axis):
        plane = np.zeros((len(axis), len(axis)))
        for row in HEAD:
            p = to_sphere(row, (axis, axis[:, None], z))
            if abs(p[2]) < 1:
                plane += row[0] * (dot(p, p) <= 1)
        out[number // parts] += plane.reshape(size, parts, size, parts).sum(axis=(1, 3))
    return out / parts**3


def projections(bench, size=97, angles=12, step=0.5, datapath="wide", parts=3):
    """Parallel rays through the head's middle, a voxel apart, in views about the z axis."""
    edge = (size - 1) / 2  # voxels of a unit
    turns = np.arange(angles) * np.pi / angles
    across, height = np.meshgrid(np.linspace(-.95, .95, size - 4), np.linspace(-.85, .85, 9))
    start, way = [], []
    for turn in turns:
        side, along = np.array([math.cos(turn), math.sin(turn), 0]), np.array([-math.sin(turn), math.cos(turn), 0])
        start.append(across.ravel()[:, None] * side + height.ravel()[:, None] * np.array([0, 0, 1]) - 2 * along)
        way.append(np.repeat(along[None], across.size, 0))
    start, way = np.concatenate(start), np.concatenate(way)
    truth = integrals(start, way)
    made = gicube.rays_between(edge * (1 + start), edge * (1 + start + 4 * way))
    clipped = gicube.clip_to_volume(made, 3 * (size,))
    found = np.zeros(len(truth))
    head = voxels(size, parts)
    with bench.board(head / 2, even(0), datapath=datapath, edge=128) as board:
        rays = board.receive(board.submit(clipped, type=gicube.RayType.INTEGRAL, step=step)).rays
        found[rays["id"]] = 2 * rays["integral"] / edge
    chosen = truth > 0.5 * truth.max()
    off = (found - truth)[chosen] / np.sqrt((truth[chosen] ** 2).mean())
    out = [Value(f"mean of {chosen.sum()} integrals, {size}\N{SUPERSCRIPT THREE} voxels", truth[chosen].mean(),
                 found[chosen].mean(), limit=EXACT)]
    return [*out, Value(f"root mean square difference, {size}\N{SUPERSCRIPT THREE} voxels", 0,
                        math.sqrt((off**2).mean()), limit=EXACT)]


def cases():
    sweep = tuple({"size": size, "step": step, "datapath": words, "angles": 2} for words in ("wide", "paper")
                  for size in (25, 49, 97) for step in (2, 1, 1 / 2))
    return [Case(f"tomography/Shepp-Logan {size}/integral rays", SOURCE, projections, {"size": size},
                 {"angles": 3} if size == 49 else None, sweep if size == 97 else ()) for size in (49, 97)]
