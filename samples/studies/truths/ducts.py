"""Kobayashi's void ducts: the fluence of a uniform source in a cube, behind voids and a shield.

The planes x = 0, y = 0 and z = 0 reflect, so the model has all eight octants. Boxes are those of one octant, in cm."""
import functools
import pathlib
import warnings

import gicube
import numpy as np

from studies.table import rows_of
from studies.truths.case import ABSORBER, Case, Value, even, folded, lattice, mean_of, sphere, transmittances
from studies.truths.solvers import optical_depths

SOURCE = "Kobayashi, Sugimura and Nagaya, Prog. Nucl. Energy 39 (2001) 119"
SHIELD, VOID = 0.1, 1e-4  # extinction per cm
EDGE = 10.0  # of the source cube, cm; all planes are multiples of it
SOURCE_POWER = 1.0  # per cm^3
ALBEDO = 0.5
LEAST = 1e-3  # chosen
FAINT = 0.1  # chosen: part of a path's first weight; below it, Russian roulette
LEAST_OPACITY = 2.0**-24  # the board's opacities
FEW_PATHS = 0.01  # chosen: part of all paths that bring half of a detector's scattered light
STRATA = 64  # chosen: commands of a batch, each with its own opacity
SIZE = {1: (100, 100, 100), 2: (60, 100, 60), 3: (60, 100, 60)}
DUCTS = {1: [((0, 0, 0), (50, 50, 50))],
         2: [((0, 0, 0), (10, 100, 10))],
         3: [((0, 10, 0), (10, 60, 10)), ((10, 50, 0), (40, 60, 10)), ((30, 50, 10), (40, 60, 40)),
             ((30, 60, 30), (40, 100, 40))]}
ROWS = rows_of(pathlib.Path(__file__).with_name("kobayashi.csv"))


def octants(low, high):
    """A box and its images: one box where it touches the planes."""
    spans = [[(-b, b)] if a == 0 else [(a, b), (-b, -a)] for a, b in zip(low, high)]
    return [tuple(zip(x, y, z)) for x in spans[0] for y in spans[1] for z in spans[2]]


@functools.cache
def boxes(problem):
    """(low, high, extinction); later ones replace earlier ones."""
    size = SIZE[problem]
    out = [((*(-each for each in size),), size, SHIELD)]
    out += [(*box, VOID) for duct in DUCTS[problem] for box in octants(*duct)]
    return out + [(*box, SHIELD) for box in octants((0, 0, 0), (EDGE, EDGE, EDGE))]


def places_of(problem):
    rows = [row for row in ROWS if row["problem"] == str(problem)]
    return rows, np.array([[float(row[axis]) for axis in "xyz"] for row in rows])


def chord(place, direction):
    """Distances from places to where a half line enters and leaves the source cube; both 0 if it misses."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = ((side * EDGE * np.where(direction < 0, -1, 1) - place) / direction for side in (-1, 1))
    enters = np.maximum(np.nan_to_num(near, nan=-np.inf).max(axis=1), 0)
    leaves = np.nan_to_num(far, nan=np.inf).min(axis=1)
    meets = leaves > enters
    return np.where(meets, enters, 0), np.where(meets, leaves, 0)


def unscattered(places, points, through, reach=EDGE):
    """Fluence of unscattered light at places (n, 3), one estimate each from a point (n, 3) of the unit cube. `through`
    returns transmittances between points. Places up to `reach` from the middle use a random direction, which bounds
    the estimates; others use a random point of the source."""
    near = (abs(places) < reach).all(axis=1)
    direction = sphere(points[:, 1:])
    enters, leaves = chord(np.where(near[:, None], places, 0), direction)
    outer = EDGE * (2 * points - 1)
    first = through(places, np.where(near[:, None], places + enters[:, None] * direction, outer))
    second = np.ones(len(places))
    if near.any():
        second[near] = through(places[near], (places + leaves[:, None] * direction)[near])
    squared = np.maximum(((outer - places) ** 2).sum(axis=1), 1e-12)
    return SOURCE_POWER * np.where(near, (first - second) / SHIELD, (2 * EDGE) ** 3 * first / (4 * np.pi * squared))


class Model:
    """The volume of a problem: tags of voxels, and the scale of centimetres. Materials change half way between
    voxels."""

    def __init__(self, problem, voxel=EDGE):
        self.size, self.voxel = np.array(SIZE[problem], float), voxel
        counts = (2 * self.size / voxel).round().astype(int) + 2  # one layer more: rays begin between voxels
        centres = np.stack(np.meshgrid(*((np.arange(n) - (n - 1) / 2) * voxel for n in counts), indexing="ij"), -1)
        self.tags = np.zeros(counts, "u1")
        for low, high, extinction in boxes(problem):
            self.tags[((centres > low) & (centres < high)).all(axis=3)] = extinction == VOID
        self.tags = np.ascontiguousarray(self.tags.T)
        self.middle = (counts - 1) / 2

    def at(self, places):
        return places / self.voxel + self.middle

    def board(self, bench, **of_board):
        # The layer beyond the faces is also a shield, and light that leaves does not return: rays end at the faces.
        return bench.board(np.ones(self.tags.shape), even(SHIELD * self.voxel), self.tags, [even(VOID * self.voxel)],
                           edge=32 if max(self.tags.shape) <= 32 else 128, **of_board)


def absorber(bench, problem, points=8192, runs=4, step=1 / 64, datapath="wide", pieces=1, chosen=slice(None)):
    """Exact, because the error of the lattices is below 0.05%."""
    rows, places = places_of(problem)
    rows, places = rows[chosen], places[chosen]
    random = np.random.default_rng(1)
    model = Model(problem)
    with model.board(bench, datapath=datapath) as board:
        def through(start, end):
            return transmittances(board, model.at(start), model.at(end), step, pieces)
        found = []
        for _ in range(runs):
            shifted = folded(points, 3, random.random(3))
            found.append([unscattered(np.repeat(place[None], points, 0), shifted, through).mean() for place in places])
    mean, error = mean_of(found)
    return [Value(f"{problem} absorber ({row['x']}, {row['y']}, {row['z']})", float(row["absorber"]), a, b,
                  limit=ABSORBER)
            for row, a, b in zip(rows, mean, error)]


def flights(board, voxel, direction, random, step):
    """Traces free paths from `voxel` (n, 3) by first hits. Returns their ends, and whether these are in the volume. A
    path ends where its opacity reaches a random number, uniform in 0..1. The numbers are stratified by commands, and
    assigned to the paths at random."""
    order = random.permutation(len(voxel))
    parts = [each for each in np.array_split(order, min(STRATA, len(order))) if len(each)]
    # Samples are then in the middles of their steps.
    rays = gicube.rays(voxel + step / 2 * direction, direction)
    opacities = (np.arange(len(parts)) + random.random(len(parts))) / len(parts)
    opacities = np.clip(opacities, LEAST_OPACITY, 1 - LEAST_OPACITY)
    tickets = [board.submit(rays[part], type=gicube.RayType.FIRST_HIT, step=step, opacity=float(opacity))
               for part, opacity in zip(parts, opacities)]
    ends, hit = np.empty_like(voxel), np.empty(len(voxel), bool)
    for k, (part, ticket) in enumerate(zip(parts, tickets)):
        traced = board.receive(ticket).rays
        ends[part] = traced["position"]
        hit[part] = traced["opacity"] >= opacities[k]
    return ends + step * (random.random((len(voxel), 1)) - 0.5) * direction, hit


def scattering(bench, problem, paths=512, runs=16, points=2048, step=1 / 8, least=LEAST, chosen=slice(None)):
    """Half of the extinction scatters isotropically. Paths start at the detectors; their collisions collect the
    source's unscattered light. Omits detectors with a fluence below `least`, which too few paths reach."""
    rows, places = places_of(problem)
    seen = [float(row["scattering"]) >= least for row in rows]
    rows, places = [row for row, is_seen in zip(rows, seen) if is_seen][chosen], places[seen][chosen]
    model, found, scattered = Model(problem), [], []
    with model.board(bench) as board:
        def through(start, end):
            return transmittances(board, model.at(start), model.at(end), step)
        for run in range(runs):
            random = np.random.default_rng(run)
            shifted = folded(points, 3, random.random(3))
            clear = np.array([unscattered(np.repeat(place[None], points, 0), shifted, through).mean()
                              for place in places])
            path = np.arange(len(places) * paths)
            place, weight = places[path // paths], np.full(len(path), 1 / paths)
            sums = np.zeros(len(path))
            while len(path):
                direction = sphere(random.random((len(path), 2)))
                voxel, hit = flights(board, model.at(place), direction, random, step)
                place = (voxel - model.middle) * model.voxel
                stays = hit & (abs(place) < model.size).all(axis=1)
                path, place, weight = path[stays], place[stays], ALBEDO * weight[stays]
                sums[path] += weight * unscattered(place, random.random((len(path), 3)), through, 2 * EDGE)
                lives = random.random(len(path)) < np.minimum(1, weight * paths / FAINT)
                path, place, weight = path[lives], place[lives], np.maximum(weight[lives], FAINT / paths)
            scattered.append(sums.reshape(len(places), paths))
            found.append(clear + scattered[-1].sum(axis=1))
    for row, light in zip(rows, np.concatenate(scattered, axis=1)):
        half = 1 + int(np.searchsorted(np.cumsum(np.sort(light)[::-1]), light.sum() / 2))
        if half < FEW_PATHS * light.size:
            warnings.warn(f"half of the scattered light at ({row['x']}, {row['y']}, {row['z']}) is from {half} of "
                          f"{light.size} paths, so its error bar is too small: use more paths", stacklevel=2)
    mean, error = mean_of(found)
    return [Value(f"{problem} half scattering ({row['x']}, {row['y']}, {row['z']})", float(row["scattering"]), a, b,
                  float(row["scattering"]) * float(row["relative_error"])) for row, a, b in zip(rows, mean, error)]


def stored(bench, rays=8192, runs=32, step=0.5, voxel=EDGE / 3):
    """Light that the source's rays deposit in the detectors' voxels, over their absorption of a unit of fluence."""
    rows, places = places_of(1)
    model, found = Model(1, voxel), []
    inside = np.minimum(abs(places), 100).max(axis=1)
    kappa = np.where((inside > EDGE) & (inside < 50), VOID, SHIELD)
    x, y, z = (np.round(model.at(places)).astype(int)).T
    with model.board(bench) as board:
        for run in range(runs):
            random = np.random.default_rng(run)
            start = EDGE * (2 * random.random((rays, 3)) - 1)
            board.clear_irradiance(2.0**-18)
            made = gicube.rays(model.at(start), sphere(random.random((rays, 2))),
                               energy=SOURCE_POWER * (2 * EDGE) ** 3 / rays)
            board.receive(board.submit(made, type=gicube.RayType.DEPOSIT, step=step,
                                       sampling=gicube.Sampling(seed=run)))
            found.append(board.read_irradiance()[z, y, x] / (kappa * voxel**3))
    mean, error = mean_of(found)
    # A deposit is divided among eight voxels, so a voxel has the mean of the fluence under its tent.
    points = lattice(16384, 6)
    even_part = 2 * points[:, 3:] - 1
    tent = voxel * np.sign(even_part) * (1 - np.sqrt(1 - abs(even_part)))

    def clear(start, end):
        return np.exp(-optical_depths(boxes(1), start, end))

    truths = [unscattered(place + tent, points[:, :3], clear).mean() for place in places]
    return [Value(f"1 absorber ({row['x']}, {row['y']}, {row['z']})", truth, a, b, float(row["absorber"]) * ABSORBER)
            for row, truth, a, b in zip(rows, truths, mean, error)]


def cases():
    sweep = tuple({"step": step, "datapath": words, "points": 1024, "runs": 1, "chosen": slice(0, 10, 3)}
                  for words in ("wide", "paper") for step in (1, 1 / 4, 1 / 16, 1 / 64))
    out = [Case(f"ducts/{problem} absorber/transmittance rays", SOURCE, absorber,
                {"problem": problem, "pieces": 2 if problem == 1 else 1},
                {"chosen": slice(0, None, 5), "points": 2048} if problem == 2 else None, sweep if problem == 2 else ())
           for problem in SIZE]
    small = {"chosen": slice(0, None, 4), "paths": 256, "runs": 8, "points": 512}
    out += [Case(f"ducts/{problem} half scattering/paths from the detectors", SOURCE, scattering, {"problem": problem},
                 small if problem == 2 else None) for problem in SIZE]
    out.append(Case("ducts/3 half scattering, deep/paths from the detectors", SOURCE, scattering,
                    {"problem": 3, "least": 0, "chosen": slice(-6, None), "paths": 16384}, None))
    tent = SOURCE + "; under a voxel's tent by quadrature"
    return [*out, Case("ducts/1 absorber/stored light", tent, stored, {}, None)]
