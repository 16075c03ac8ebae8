"""Volumes to try the programs with: a head as a CT and as an MRI have it, a part with an insert, labels in labels,
cells, and a cloud.

Usage: phantoms.py FOLDER [VOXELS]     voxels of an edge, 128 if not given

Each is a NRRD file, the cloud one of OpenVDB. `gicube-render FOLDER/ct_head.nrrd` and so on need no option
(docs/guide/first_pictures.md).
"""

import pathlib
import sys
from typing import Any, Dict

import numpy as np

import gicube


def phantoms(size: int) -> Dict[str, Any]:
    """Arrays [z, y, x] by name. The face looks along -y."""
    z, y, x = np.mgrid[:size, :size, :size].astype("f4") * (2 / (size - 1)) - 1
    random = np.random.default_rng(5)

    def ball(place: Any, axes: Any, edge: float = 0.06) -> Any:
        """1 inside of an ellipsoid, 0 outside, with a soft edge."""
        distance = sum(((at - middle) / half) ** 2 for at, middle, half in zip((x, y, z), place, axes))
        return np.clip(0.5 - (distance - 1) / edge, 0, 1)

    def noise(deviation: float) -> Any:
        return random.normal(0, deviation, x.shape)

    skin = np.maximum(ball((0, 0, 0.05), (0.7, 0.84, 0.88)), ball((0, -0.86, -0.08), (0.11, 0.15, 0.18)))
    skin = np.maximum(skin, np.clip(4 - 9 * np.hypot(x, y - 0.15), 0, 1) * (z < -0.4))
    brain = ball((0, 0.04, 0.12), (0.56, 0.68, 0.7))
    skull = ball((0, 0.02, 0.08), (0.65, 0.78, 0.82)) - ball((0, 0.02, 0.1), (0.58, 0.71, 0.75))
    eyes = [ball((side * 0.27, -0.68, 0.02), (0.16, 0.2, 0.15)) for side in (-1, 1)]
    arch = np.hypot(x, 0.8 * (y + 0.1))  # of the teeth
    teeth = np.clip(1 - ((arch - 0.42) / 0.06) ** 2 - ((z + 0.58) / 0.12) ** 2, 0,
                    1) * (y < 0) * (np.sin(20 * np.arctan2(x, -y)) > -0.5)
    fluid = np.maximum(ball((-0.14, 0.1, 0.2), (0.08, 0.32, 0.14)), ball((0.14, 0.1, 0.2), (0.08, 0.32, 0.14)))
    bone = np.maximum(skull, 1.5 * teeth) * (1 - np.maximum(*eyes))
    hounsfield = np.where(bone > 0.05, 40 + 1100 * bone, -1000 + 1040 * skin) + noise(15)

    folds = 0.07 * np.sin(11 * x + 3 * np.sin(7 * y)) * np.cos(9 * z + 2 * np.sin(8 * x))
    cortex = np.clip(0.5 - (((x / 0.56) ** 2 + ((y - 0.04) / 0.68) ** 2 + ((z - 0.12) / 0.7) ** 2 - 1) / 0.06 +
                            9 * np.abs(folds)), 0, 1)
    field = 1 + 0.3 * np.sin(2 * x + 1) * np.cos(1.6 * y) + 0.15 * np.sin(17 * x + 5 * y) * np.sin(13 * z)
    tissue = field * cortex * (110 + 70 * ball((0, 0.04, 0.12), (0.45, 0.57, 0.6)))
    mri = np.hypot(tissue * (1 - fluid) + 560 * fluid * cortex + noise(5), noise(5))

    box = np.clip(0.5 - (np.maximum(np.maximum(np.abs(x) / 0.75, np.abs(y) / 0.5), np.abs(z) / 0.55) - 1) * 20, 0, 1)
    bores = [np.clip(0.5 + (np.hypot(x - at, y) - 0.2) * 20, 0, 1) for at in (-0.4, 0.2)]
    pin = np.clip(0.5 - (np.hypot(y + 0.1, z) - 0.08) * 30, 0, 1) * (x > -0.1) * box
    part = 9000 + 21000 * box * bores[0] * bores[1] + 20000 * pin + noise(700)

    labels = np.where(skin > 0.5, 1, 0)
    for label, tissue in ((2, skull), (3, brain), (4, fluid)):
        labels[tissue > 0.5] = label
    cells = np.zeros(x.shape)
    for cell, (*place, radius) in enumerate(random.uniform((-0.8, -0.8, -0.8, 0.1), (0.8, 0.8, 0.8, 0.25), (40, 4)), 1):
        cells[ball(place, (radius, radius, radius)) > 0.5] = cell

    waves = [frequency * random.normal(0, 1, (6, 4)).astype("f4") for frequency in (7, 14, 28)]
    billows = sum(np.abs(sum(np.sin(a * x + b * y + c * z + d) for a, b, c, d in octave)) / 5 / 2**i
                  for i, octave in enumerate(waves))
    puffs = np.max([1 - sum(((at - middle) / radius) ** 2 for at, middle in zip((x, y, z), place))
                    for *place, radius in ((-0.45, 0.1, -0.3, 0.38), (0.05, 0, -0.15, 0.5), (0.5, -0.1, -0.35, 0.33),
                                           (-0.1, 0.1, 0.25, 0.36))], 0)
    cloud = np.clip(1.5 * (puffs + 0.25 - 0.7 * billows), 0, 1)
    return {"ct_head": hounsfield, "mri_head": mri, "part": part, "labels": labels, "cells": cells, "cloud": cloud}


def main(folder: str, size: int = 128) -> None:
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    for name, values in phantoms(size).items():
        file = pathlib.Path(folder) / (f"{name}.vdb" if name == "cloud" else f"{name}.nrrd")
        gicube.write_volume(file, values)
        print(f"{file}: {gicube.why_look(values)}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
