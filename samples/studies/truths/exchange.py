"""Form factors of Howell's catalogue, clear, with a blocker and in a medium, by Board.pair_factors()."""
import math

import gicube
import numpy as np

from studies.form_factors import parallel_rectangles, parallel_squares, perpendicular_rectangles
from studies.truths.case import Case, Value, even

HOWELL = "Howell, A Catalog of Radiation Heat Transfer Configuration Factors, "
EDGE, SIDE, LOW = 40, 20.0, 9.5  # voxels of the volume, of a unit, and before it
BLOCKER_THICKNESS = 1 / 32  # voxels


def at(x, y, z):
    return np.array((LOW + SIDE * x, LOW + SIDE * y, LOW + SIDE * z))


def patch(low, u, v):
    return "patch", at(*low), SIDE * np.array(u, float), SIDE * np.array(v, float), np.zeros(3)


def disc(centre, radius, up, hole=0.0):
    """Facing up or down; `hole`: a ring's share of the disc's area without it."""
    u, v = (radius, 0, 0), (0, radius if up else -radius, 0)
    return "disc", at(*centre), SIDE * np.array(u, float), SIDE * np.array(v, float), np.array((hole, 0, 0))


FLOOR, CEILING = patch((0, 0, 0), (1, 0, 0), (0, 1, 0)), patch((0, 0, 1), (0, 1, 0), (1, 0, 0))


def discs(r1, r2, apart):
    """C-41: coaxial discs, from the first to the second."""
    x = 1 + (apart * apart + r2 * r2) / (r1 * r1)
    return (x - math.sqrt(x * x - 4 * (r2 / r1) ** 2)) / 2


def blocked(side, kappa, cells=500):
    """Unit squares one apart with an opaque square half way, by quadrature over pairs of points with a free line. The
    line's middle is the mean of its ends, so on each axis the weights of distances divide into those of middles inside
    and outside."""
    d = (np.arange(-cells, cells) + 0.5) / cells  # of the ends, on an axis
    free = np.clip(1 - abs(d), 0, None)  # number of middles: their span is centred
    inner = np.minimum(free, side)  # of them within the blocker
    both = np.outer(free, free) - np.outer(inner, inner)
    squared = 1 + d[:, None] ** 2 + d**2
    return (both * np.exp(-kappa * np.sqrt(squared)) / (math.pi * squared**2)).sum() / cells**2


# Elements a and b, and F from a to b.
PAIRS = {
    "C-11 squares one apart": (FLOOR, CEILING, parallel_squares(0)),
    "C-11 squares a fifth apart": (FLOOR, patch((0, 0, .2), (0, 1, 0), (1, 0, 0)), parallel_rectangles(1, 1, .2)),
    "C-11 rectangles": (patch((0, 0, 0), (1, 0, 0), (0, .4, 0)), patch((0, 0, .5), (0, .4, 0), (1, 0, 0)),
                        parallel_rectangles(1, .4, .5)),
    "C-14 common edge": (FLOOR, patch((0, 0, 0), (0, 1, 0), (0, 0, 1)), perpendicular_rectangles(1, 1)),
    "C-14 low wall": (FLOOR, patch((0, 0, 0), (0, 1, 0), (0, 0, .3)), perpendicular_rectangles(.3, 1)),
    "C-41 equal discs": (disc((.5, .5, 0), .5, True), disc((.5, .5, .8), .5, False), discs(.5, .5, .8)),
    "C-41 a small disc": (disc((.5, .5, 0), .2, True), disc((.5, .5, .3), .5, False), discs(.2, .5, .3)),
    "C-42 disc to ring": (disc((.5, .5, 0), .3, True), disc((.5, .5, .4), .5, False, hole=.36),
                          discs(.3, .5, .4) - discs(.3, .3, .4)),
}


def area(element):
    kind, _, u, v, w = element
    square = np.linalg.norm(np.cross(u, v))
    return square * {"patch": 1, "triangle": 0.5, "disc": math.pi * (1 - w[0])}[kind]


def factors(board, pairs, rays, seeds, **request):
    """F of each pair with its error bar, and the unobstructed F, by seeds: [estimate, pair]."""
    elements = gicube.elements(*map(list, zip(*(element for pair in pairs for element in pair[:2]))))
    areas = np.array([area(b) for _, b, *_ in pairs])
    out = []
    for seed in range(seeds):
        of_elements = gicube.pairs(np.arange(0, len(elements), 2), np.arange(1, len(elements), 2))
        found = board.pair_factors(elements, of_elements, rays=rays, seed=seed, **request)
        out.append([found[name] * areas for name in ("transported", "standard_error", "geometric")])
    return np.array(out).swapaxes(0, 1)


def clear(bench, counts=(16, 256, 4096), made="by_board"):
    """Unobstructed pairs, with so many rays per pair."""
    out = []
    with bench.board(np.ones(3 * (EDGE,)), even(0), edge=64) as board:
        for rays in counts:
            found, error, _ = factors(board, list(PAIRS.values()), rays, 1, made=made, leap=False)
            out += [Value(f"{name}, {rays} rays", truth, a, b, 1e-7)
                    for (name, (*_, truth)), a, b in zip(PAIRS.items(), found[0], error[0])]
    return out


def with_blocker(bench, side, kappa, rays=4096, seeds=8, step=1 / 32):
    """An opaque sheet of 1/32 voxel half way: tagged columns whose densities rise through the opaque one of their
    look."""
    voxels = np.arange(EDGE)
    z = np.tile((voxels / (EDGE - 1))[:, None, None], (1, EDGE, EDGE))
    middle, half = at(.5, .5, .5), side * SIDE / 2
    beside = abs(voxels - middle[0]) < half
    tags = np.zeros(z.shape, "u1")
    tags[:, beside[:, None] & beside] = 1
    at_sheet, thin = middle[2] / (EDGE - 1), BLOCKER_THICKNESS / 2 / (EDGE - 1)
    medium = -math.expm1(-kappa / SIDE)
    sheet = gicube.TransferFunction([(0, (1, 1, 1))], [
        (0, medium), (at_sheet - thin, medium), (at_sheet - thin, 1), (at_sheet + thin, 1), (at_sheet + thin, medium)])
    with bench.board(z, even(kappa / SIDE), tags, [sheet], edge=64) as board:
        return between_squares(board, f"blocker of {side:g}, kappa {kappa:g}, {rays} rays", blocked(side, kappa), rays,
                               seeds, step=step)


def in_medium(bench, kappa, rays=1024, seeds=8):
    with bench.board(np.ones(3 * (EDGE,)), even(kappa / SIDE), edge=64) as board:
        return between_squares(board, f"squares one apart, kappa {kappa:g}, {rays} rays", parallel_squares(kappa), rays,
                               seeds)


def between_squares(board, name, truth, rays, seeds, **request):
    """One estimate per seed; none may exceed the unobstructed one."""
    found, error, geometric = factors(board, [(FLOOR, CEILING)], rays, seeds, **request)
    out = [Value(f"{name}, seed {seed}", truth, a, b) for seed, (a, b) in enumerate(zip(found[:, 0], error[:, 0]))]
    return [*out, Value(f"{name}: most over the unobstructed one", 0, max(0, (found / geometric).max() - 1),
                        limit=1e-6)]


def cases():
    howell, quadrature = HOWELL + "C-11, C-14, C-41, C-42", "quadrature, 1e-6"
    sweep = tuple({"rays": 4**i, "seeds": 16} for i in range(2, 7))
    return [*(Case(f"exchange/clear/pairs, rays {made.replace('_', ' ')}", howell, clear, {"made": made},
                   {"counts": (64,)}) for made in ("by_board", "by_host")),
            *(Case(f"exchange/blocker {side:g}, kappa {kappa:g}/pairs", quadrature, with_blocker,
                   {"side": side, "kappa": kappa}, {"rays": 1024, "seeds": 3} if side < 1 else None)
              for side in (.5, 1) for kappa in (0, 1)),
            *(Case(f"exchange/kappa {kappa:g}/pairs", quadrature, in_medium, {"kappa": kappa}, {"seeds": 4},
                   sweep if kappa == 1 else ()) for kappa in (1, 3))]
