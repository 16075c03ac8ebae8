"""Pictures by gicube-light of half spaces and of furnaces: paths from the eye, from both ends, and photon maps."""
import json
import math
import pathlib
import tempfile

import numpy as np

from studies.points import run
from studies.truths.case import Case, Value
from studies.truths.solvers import h_at

VOXELS = 65
METHODS = {"paths from the eye": "path --light-scatterings 0 --passes {n}", "paths from both ends": "path --passes {n}",
           "photon map": "photon-map --photons 20000 --neighbours 60 --passes {n}"}
CAMERA = """camera {{
  eye {{ x: {0[0]} y: {0[1]} z: {0[2]} }} look_at {{ x: {1[0]} y: {1[1]} z: {1[2]} }} up {{ y: 1 }} fov_degrees: {2}
}}
image {{ width: 16 height: 16 }}
"""
# 64 free paths deep and wide; a unit is 32 voxels.
FOG = """world {{ size: 65 node {{ material: "fog" box {{ low {{ x: -2 y: -2 z: -2 }} high {{ x: 2 y: 2 z: 2 }} }} }} }}
material {{ name: "fog" fog {{ extinction: 32 }} scattering: {albedo} bsdf: "isotropic" }}
light {{ towards {{ x: {x} z: {z} }} power: 1 }}
"""
BALL = """world {{ size: 33 node {{ material: "white" sphere {{ radius: 0.7 }} }} }}
material {{ name: "white" solid {{ }} scattering: {albedo} bsdf: "diffuse" }}
"""


def shown(bench, scene, method, runs, passes, scatterings=32):
    """Mean radiance of the picture over independent runs, and its error bar. The unit is power per square of a voxel's
    edge."""
    means = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "x.scene").write_text(scene)
        board = "" if bench.uri == "emu:" else f"--board {bench.uri}"
        for seed in range(runs):
            run(folder, "gicube-light",
                f"{METHODS[method].format(n=passes)} @x.scene --allow-outside --seed {seed} "
                f"--fidelity {bench.fidelity} --quiet --set asic.datapath=wide --stats @x.json --pixels @x.csv "
                f"--max-scatterings {scatterings} {board}")
            means.append(np.genfromtxt(folder / "x.csv", delimiter=",", skip_header=1)[:, 2].mean())
            bench.ms += json.loads((folder / "x.json").read_text())["board_ms"]
    return np.mean(means), np.std(means, ddof=1) / math.sqrt(runs)


def half_space(bench, method, albedo, view, sun, scatterings, passes, runs=8):
    """Radiance of a half space in the sun, with the cosines of both directions to the surface's normal."""
    eye = (0, 30 * math.sqrt(1 - view * view), 1 + 30 * view)
    scene = FOG.format(albedo=albedo, x=math.sqrt(1 - sun * sun), z=sun) + CAMERA.format(eye, (0, 0, 1), 0.2)
    mean, error = shown(bench, scene, method, runs, passes, scatterings)
    unit = (2 / (VOXELS - 1)) ** 2
    truth = albedo / (4 * math.pi) * sun / (view + sun) * h_at(albedo, view) * h_at(albedo, sun)
    return [Value(f"albedo {albedo:g}, cosines {sun:g} and {view:g}: radiance", truth, mean / unit, error / unit,
                  1e-6 * truth)]


def furnace(bench, method, albedo, runs=8, passes=2):
    """A convex body in radiance 1 from all directions shows its albedo. Six large lamps make that radiance."""
    far = 60
    lamps = ""
    for axis in range(3):
        for side in (-far, far):
            corner, u, v = [-far] * 3, [0] * 3, [0] * 3
            corner[axis] = side
            first, second = ((axis + 1) % 3, (axis + 2) % 3)[::1 if side < 0 else -1]
            u[first] = v[second] = 2 * far
            parts = "".join(f"{name} {{ x: {p[0]} y: {p[1]} z: {p[2]} }} " for name,
                            p in (("corner", corner), ("edge_u", u), ("edge_v", v)))
            lamps += f"light {{ rectangle {{ {parts}}} power: {math.pi * (2 * far) ** 2} }}\n"
    scene = BALL.format(albedo=albedo) + lamps + CAMERA.format((0, -6, 0.5), (0, 0, 0), 3).replace("up { y: 1 }",
                                                                                                   "up { z: 1 }")
    mean, error = shown(bench, scene, method, runs, passes)
    unit = (2 / 32) ** 2
    return [Value(f"a ball of albedo {albedo:g}", albedo, mean / unit, error / unit)]


def cases():
    out = []
    for method in METHODS:
        maps = method == "photon map"
        for albedo, view, sun in ((.5, 1, 1), (.9, .8, .6), (.95, .5, .9)):
            thick = albedo > .9  # light with more than 32 scatterings matters here
            settings = {"scatterings": 256 if thick and not maps else 32, "passes": 1 if thick and maps else 4}
            out.append(Case(f"light/half space {albedo:g} {view:g} {sun:g}/{method}",
                            "Chandrasekhar's H (Radiative Transfer, 1960)", half_space,
                            {"method": method, "albedo": albedo, "view": view, "sun": sun, **settings},
                            {"runs": 6, "passes": 2} if albedo == .5 and not maps else None,
                            tuple({"passes": n, "runs": 4} for n in (1, 4)[:2 - maps]) if albedo == .9 else ()))
        for albedo in (.3, .7, 1):
            out.append(Case(f"light/furnace {albedo:g}/{method}", "a convex body in radiance 1", furnace,
                            {"method": method, "albedo": albedo},
                            {"runs": 6} if albedo == .7 and method == "paths from the eye" else None))
    return out
