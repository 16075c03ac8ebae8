"""Cost of a pass of lighting rays, and error of its irradiance against the closed form of a point source in an
absorber."""
import functools
import itertools

import gicube
import numpy as np

from studies.points import Table
from studies.table import on_front

SIZE = 25
EXTINCTION = 0.15  # per voxel
LAMP = np.array((12.25, 11.5, 12))
GAUSS = np.polynomial.legendre.leggauss(6)
CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))  # x, y, z
DEEPEST = 16


@functools.cache
def closed_form():
    """[z, y, x]: share of a light's energy per voxel, if it is distributed trilinearly where it is absorbed, with
    density kappa e^(-kappa r) / (4 pi r^2). Error below 1e-6: boxes are divided in eight until they are smaller than
    their distance from the lamp."""
    out = np.zeros((SIZE, SIZE, SIZE))
    cells = low = np.stack(np.meshgrid(*3 * (np.arange(SIZE - 1.0),), indexing="ij"), axis=-1).reshape(-1, 3)
    at, weights = (np.stack(np.meshgrid(*3 * (each,), indexing="ij"), axis=-1).reshape(-1, 3) for each in GAUSS)
    size = 1.0
    for depth in range(DEEPEST + 1):
        distance = np.linalg.norm(np.maximum(0, np.maximum(low - LAMP, LAMP - low - size)), axis=1)
        done = (distance >= np.sqrt(3) * size) | ((depth == DEEPEST) & (distance > 0))
        places = low[done, None] + size / 2 * (1 + at)
        r = np.linalg.norm(places - LAMP, axis=-1)
        density = EXTINCTION * np.exp(-EXTINCTION * r) / (4 * np.pi * r * r) * weights.prod(axis=-1) * (size / 2) ** 3
        for corner in CORNERS:
            voxels = cells[done] + corner
            tents = (1 - np.abs(places - voxels[:, None])).prod(axis=-1)
            np.add.at(out, tuple(voxels.astype(int).T[::-1]), (density * tents).sum(axis=1))
        size /= 2
        cells, low = np.repeat(cells[~done], 8, axis=0), (low[~done, None] + size * CORNERS).reshape(-1, 3)
    return out


def measured(albedo, rules, datapath, step, rays, fidelity="cycle"):
    """Milliseconds of the pass; root mean square error of the voxels' shares of the light, relative to the root mean
    square share, for voxels more than two from the lamp; share of the light that full words lost."""
    settings = gicube.Illumination(albedo=albedo, rules={"printed": "as_printed"}.get(rules, rules),
                                   rays_per_face_voxel=rays, step=step)
    uri = f"emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&set=asic.datapath={datapath}&fidelity={fidelity}"
    with gicube.open(uri) as board:
        board.load_volume(np.full(3 * (SIZE,), 100, "u1"))
        board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(0, -np.expm1(-EXTINCTION))]))
        begin = board.now
        report = board.illuminate([gicube.PointLight(LAMP, 1)], settings)
        ms = (board.now - begin) * 1e-9
        irradiance = board.read_irradiance().astype(float)
    exact = closed_form()
    far = np.linalg.norm(np.indices(exact.shape)[::-1].T - LAMP, axis=-1).T > 2
    # With the printed rules a light emits four times its power; this compares shares of that.
    off = irradiance / (4 if rules == "printed" else 1) - exact
    return [ms, np.sqrt((off[far] ** 2).sum() / (exact[far] ** 2).sum()), report.clipped / report.emitted]


def rows(found):
    fronts = on_front([(ms, error) for _, (ms, error, _) in found])
    for (name, (ms, error, clipped)), front in zip(found, fronts):
        _, albedo, rules, datapath, step, rays = name.split("/")
        yield name, [f"{ms:.6g}", f"{error:.6g}", int(front), albedo, rules, datapath, rays, step, f"{clipped:.4g}"]


def tables():
    settings = itertools.product(("low", "high"), ("conserving", "printed"), ("paper", "wide"), (0.5, 2),
                                 (1, 2, 4, 8, 16))
    points = {f"lighting/{a}/{r}/{d}/{step}/{k}": lambda _, each=(a, r, d, step, k): measured(*each) for a, r, d, step,
              k in settings}
    return [Table("lighting", ["pass_ms", "error", "front", "albedo", "rules", "datapath", "k", "step", "clipped"],
                  points, rows)]
