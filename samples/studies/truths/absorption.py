"""Absorbing media: Beer and Lambert's law at every step, and Burns and Christon's cube."""
import math

import gicube
import numpy as np

from studies.truths.case import ABSORBER, EXACT, Case, Value, even, lattice, linear, sphere, transmittances

STEPS = tuple(2.0**-i for i in range(7))
WAYS = {"along an axis": ((0, 9.3, 17.1), (31, 9.3, 17.1)), "slanted": ((1.3, 2.7, 0.4), (29.1, 20.3, 30.2))}


def beer_lambert(bench, depth, datapath="wide", steps=STEPS):
    out = []
    for name, (start, end) in WAYS.items():
        with bench.board(np.ones((32, 32, 32)), even(depth / math.dist(start, end)), datapath=datapath) as board:
            for step in steps:
                found = transmittances(board, np.array([start], float), np.array([end], float), step)[0]
                out.append(Value(f"{name}, step 1/{1 / step:g}", math.exp(-depth), found, limit=ABSORBER))
    return out


def stored(bench, depth, datapath="wide", steps=STEPS, albedo="low"):
    """Energy that a beam along an axis deposits in a layer of 31 voxels."""
    out, paper = [], datapath == "paper"
    rays = 16384 if paper else 1024  # its energies of 8 bits are rounded at random
    with bench.board(np.ones((32, 32, 32)), even(depth / 31), datapath=datapath) as board:
        place = np.column_stack([31 * lattice(rays, 2), np.zeros(rays)])
        made = gicube.rays(place, (0, 0, 1), energy=1.0)
        for step in steps:
            board.clear_irradiance(1 / 255 if paper else 2.0**-20)
            report = board.receive(board.submit(made, type=gicube.RayType.DEPOSIT, step=step, albedo=albedo)).lighting
            absorbed = (report.deposited + report.clipped) / report.emitted
            out.append(Value(f"absorbed, step 1/{1 / step:g}", -math.expm1(-depth), absorbed, limit=ABSORBER))
    return out


TRILINEAR = dict(zip((.5, .55, .6, .65, .7, .75, .8, .85, .9, .95, 1),
                     (3.07561, 2.81667, 2.57196, 2.32896, 2.08181, 1.82691, 1.56180, 1.28473, .99443, .6901, .37165)))


def trilinear_cube(bench, directions=8192, step=1 / 16, datapath="wide", edge=8):
    """div q on the middle line: kappa (4 - G), with G from the transmittances of all directions to the cold walls."""
    axis = 1 - abs(np.linspace(-1, 1, edge + 1))
    values = axis[:, None, None] * axis[:, None] * axis
    with bench.board(values, linear(0.1 / edge, 1.0 / edge), datapath=datapath) as board:
        way = sphere(lattice(directions, 2))
        out = []
        for x, truth in TRILINEAR.items():
            place = edge * np.array([x, 0.5, 0.5])
            with np.errstate(divide="ignore"):
                length = np.where(way > 0, (edge - place) / way, np.where(way < 0, -place / way, np.inf)).min(axis=1)
            end = np.clip(place + way * length[:, None], 0, edge)
            emitted = 4 * (1 - transmittances(board, np.repeat(place[None], directions, 0), end, step)).mean()
            kappa = 0.9 * (1 - abs(2 * x - 1)) + 0.1
            out.append(Value(f"div q at x = {x:g}", truth, kappa * (4 - emitted), limit=EXACT))
    return out


def cases():
    law = "Beer and Lambert"
    beer = [Case(f"absorption/depth {depth:g}, {words}/transmittance rays", law, beer_lambert,
                 {"depth": depth, "datapath": words}, {"steps": (1, 1 / 8)} if depth == 2 else None)
            for depth in (0.1, 2, 6) for words in ("wide", "paper")]
    light = [Case(f"absorption/depth {depth:g}, {words}/stored light", law, stored,
                  {"depth": depth, "datapath": words}, {"steps": (1,)} if depth == 2 else None)
             for depth in (0.01, 0.1, 2) for words in ("wide", "paper")]
    sweep = tuple({"step": step, "directions": count, "datapath": words} for words in ("wide", "paper")
                  for step in (1, 1 / 4, 1 / 16) for count in (128, 1024))
    return [*beer, *light, Case("absorption/trilinear cube/transmittance rays",
                                "Burns and Christon, Numer. Heat Transfer B 31 (1997) 401", trilinear_cube, {},
                                {"directions": 1024}, sweep)]
