"""Errors and costs of form factors: closed forms, pairs of random voxels, links of a hierarchy."""
import math
import pathlib
import tempfile
from typing import Callable, NamedTuple

import gicube
import numpy as np

from studies.points import Table, run, statistics
from studies.table import to_markdown

EDGE = 40  # voxels of the volume of the closed forms
SIDE = 20  # voxels, of their squares
ESTIMATES = 16  # chosen: independent estimates with averaged errors
LEAST_RAYS, MOST_RAYS = 8, 65536  # of an estimate
RANDOM_PAIRS = 500
RAYS_IN_ALL = 32768  # chosen: of a point of the trade
REFERENCE_RAYS = 4096  # per pair, for the reference of the trade's errors
ROOM = "samples/scenes/radiosity/glowing_room.scene --volume-size 12"
THRESHOLDS = (1e-2, 1e-3, 1e-4, 1e-5)


def integral(f):
    """Integral of f over 0..1, by Simpson's rule; f takes arrays and may have more axes after the first."""
    n = 128
    weights = np.where(np.arange(n + 1) % 2, 4.0, 2.0)
    weights[[0, -1]] = 1
    return np.tensordot(weights, f(np.arange(n + 1) / n), 1) / (3 * n)


def over_square(f):
    """Integral of f(x, y, ...) weighted by (1 - x) (1 - y), the distribution of the difference of two points of unit
    squares."""
    return 4 * integral(lambda x: ((1 - x) * integral(lambda y: (1 - y[:, None]) * f(x, y[:, None])).T).T)


def parallel_rectangles(a, b, c):
    """F of two equal rectangles a by b, face to face and c apart (Howell, A Catalog of Radiation Heat Transfer
    Configuration Factors, C-11)."""
    x, y = a / c, b / c
    p, q = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    across = x * q * math.atan(x / q) + y * p * math.atan(y / p) - x * math.atan(x) - y * math.atan(y)
    return 2 / (math.pi * x * y) * (math.log(p * q / math.sqrt(p * p + q * q - 1)) + across)


def parallel_squares(kappa):
    """F of two unit squares face to face, one side apart, in a medium of `kappa` per side. A clear medium has the
    closed form, others quadrature to 1e-9."""
    if kappa == 0:
        return parallel_rectangles(1, 1, 1)
    return over_square(lambda x, y: np.exp(-kappa * np.sqrt(x * x + y * y + 1)) / (math.pi * (x * x + y * y + 1) ** 2))


def perpendicular_rectangles(h, w):
    """F from a floor of width w to a wall of height h, both of length 1 along their common edge (C-14)."""
    s, t = h * h, w * w
    root = math.sqrt(s + t)
    logs = math.log((1 + t) * (1 + s) / (1 + t + s) * (t * (1 + t + s) / ((1 + t) * (t + s))) ** t
                    * (s * (1 + s + t) / ((1 + s) * (s + t))) ** s)
    return (w * math.atan(1 / w) + h * math.atan(1 / h) - root * math.atan(1 / root) + logs / 4) / (math.pi * w)


def mean_inverse_square(distance):
    """The mean of 1 / r^2 over two unit cubes whose centres are `distance` >= 2 sides apart along an edge, by
    quadrature to 1e-9."""
    def along(z):
        return over_square(lambda x, y: 1 / (x * x + y * y + z * z))
    return integral(lambda zs: np.array([(1 - z) * (along(distance + z) + along(distance - z)) for z in zs]))


class Form(NamedTuple):
    """A pair of elements with a known factor."""
    kind: str
    elements: tuple  # two, each origin, u, v, w
    unit: float  # F of a mean of G of 1
    exact: Callable
    kappa: float = 0  # of the medium, per side


FLOOR = ((5, 5, 5), (SIDE, 0, 0), (0, SIDE, 0), (0, 0, 0))
CEILING = ((5, 5, 25), (0, SIDE, 0), (SIDE, 0, 0), (0, 0, 0))
WALL = ((5, 5, 5), (0, SIDE, 0), (0, 0, SIDE), (0, 0, 0))
BOXES = tuple(((5, 5, z), (4, 0, 0), (0, 4, 0), (0, 0, 4)) for z in (5, 13))
FORMS = {
    "parallel": Form("patch", (FLOOR, CEILING), SIDE * SIDE, lambda: parallel_squares(0)),
    "parallel kappa 1": Form("patch", (FLOOR, CEILING), SIDE * SIDE, lambda: parallel_squares(1), 1),
    "parallel kappa 3": Form("patch", (FLOOR, CEILING), SIDE * SIDE, lambda: parallel_squares(3), 3),
    "boxes two apart": Form("box", BOXES, 16 * math.pi, lambda: mean_inverse_square(2)),
    "common edge": Form("patch", (FLOOR, WALL), SIDE * SIDE, lambda: perpendicular_rectangles(1, 1))}


def error_of(name, rays):
    """Root mean square of F / exact - 1 over independent estimates with so many rays each."""
    form = FORMS[name]
    with gicube.open("emu:") as board:
        board.load_volume(np.full(3 * (EDGE,), 100, "u1"))
        board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(0, 1 - math.exp(-form.kappa / SIDE))]))
        elements = gicube.elements(2 * [gicube.ElementKind(form.kind)], *map(np.array, zip(*form.elements)))
        found = board.pair_factors(elements, gicube.pairs(ESTIMATES * [0], 1), rays=rays)["transported"] * form.unit
    return math.sqrt(((found / form.exact() - 1) ** 2).sum() / ESTIMATES)


def slope_of(rays, errors):
    """Slope of log(error) over log(rays), by a straight line."""
    return np.polyfit(np.log(rays), np.log(errors), 1)[0]


def slope_rows(found):
    curves = {}
    for name, error in found:
        _, form, rays = name.split("/")
        curves.setdefault(form.replace("_", " "), []).append((int(rays), error))
    for form, curve in curves.items():
        rays, errors = zip(*curve)
        yield form, [form, f"{FORMS[form].exact():.7g}", f"{slope_of(rays, errors):.2f}", f"{errors[-1]:.3g}"]


def error_rows(found):
    for name, error in found:
        _, form, rays = name.split("/")
        yield name, [form.replace("_", " "), rays, f"{error:.4g}"]


def error_tables(most_rays=MOST_RAYS):
    counts = [1 << i for i in range(LEAST_RAYS.bit_length() - 1, most_rays.bit_length())]
    points = {f"error/{form}/{rays}".replace(" ", "_"): lambda _, form=form, rays=rays: error_of(form, rays)
              for form in FORMS for rays in counts}
    return [Table("form_factors_error", ["form", "rays", "error"], points, error_rows),
            Table("form_factors_slopes", ["form", "exact", "slope", "error at most rays"], points, slope_rows,
                  again=False)]


def look(words):
    """Results of gicube-form-factors visibility for the buckyball: statistics, and each pair's two boxes and
    transmittance."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(folder, "gicube-form-factors",
            f"visibility builtin:buckyball --volume-size 128 --quiet --stats @stats.json --pairs-file @pairs.csv "
            f"{words}")
        return statistics(folder / "stats.json"), np.loadtxt(folder / "pairs.csv", delimiter=",", skiprows=1)


def reference():
    """Transmittances of the first pairs, with far more rays and another seed."""
    _, pairs = look(f"--fidelity functional --pairs {RANDOM_PAIRS} --rays 1")
    low, high = pairs[:, :12].reshape(-1, 2, 3).swapaxes(0, 1)
    setup = gicube.parse_scene('volume { builtin: "buckyball" size: 128 }').set_up()
    with gicube.open("emu:") as board:
        setup.load(board._core, False, None)
        u, v, w = ((high - low) * axis for axis in np.eye(3))
        boxes = gicube.elements(len(low) * [gicube.ElementKind.BOX], low, u, v, w)
        found = board.pair_factors(boxes, gicube.pairs(np.arange(0, len(low), 2), np.arange(1, len(low), 2)),
                                   rays=REFERENCE_RAYS, seed=1)
    return np.divide(found["transported"], found["geometric"], where=found["geometric"] > 0,
                     out=np.zeros(len(found))).tolist()


def trade_of(kept, bus, made, rays):
    # Enough of them that the parts of the board overlap; the first ones tell the error.
    stats, pairs = look(f"--board emu:?bus={bus} --fidelity cycle --made {made} --rays {rays} --pairs "
                        f"{max(RANDOM_PAIRS, RAYS_IN_ALL // rays)}")
    exact = np.array(kept.of("reference of trade", reference))
    error = math.sqrt(((pairs[:len(exact), 12] - exact) ** 2).sum() / len(exact))
    return {"error": error} | {key: stats[key] for key in ("pairs", "board_ms", "bus_ms", "rays_per_simulated_second",
                                                           "utilisation")}


def trade_rows(found):
    for name, each in found:
        use = each["utilisation"]
        yield name, [*name.split("/")[1:], each["pairs"], f"{each['error']:.4g}", f"{each['board_ms']:.4f}",
                     f"{each['bus_ms']:.4f}",
                     f"{each['rays_per_simulated_second']:.0f}",
                     *(f"{use[part]:.3f}" for part in ("bus_down", "bus_up", "dsp", "pipelines", "sorter", "memory")),
                     use["bound"]]


def trade_table():
    points = {f"trade/{bus}/{made}/{4 ** i}": lambda kept, each=(bus, made, 4 ** i): trade_of(kept, *each)
              for bus in ("pci33", "agp2x") for made in ("host", "board") for i in range(5)}
    columns = ["bus", "made", "rays a pair", "pairs", "error", "board_ms", "bus_ms", "rays_per_second", "bus_down",
               "bus_up", "dsp",
               "pipelines", "sorter", "memory", "bound"]
    return Table("form_factors_trade", columns, points, trade_rows)


def solved(words):
    """Results of gicube-form-factors solve for a scene: statistics, and each element's weight, incident light and
    standard error, but for the volume's ends."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(folder, "gicube-form-factors", f"solve {words} --quiet --stats @stats.json --elements @elements.csv")
        elements = np.loadtxt(folder / "elements.csv", delimiter=",", skiprows=1)
        return statistics(folder / "stats.json"), elements[elements[:, 4] < 255, 5:]


def link_of(kept, words, scene):
    """A solution held against a full matrix of twice the rays, and another seed."""
    def exact():
        return solved(f"{scene} --full-matrix --rays 32 --seed 1")[1].tolist()
    stats, ours = solved(f"{scene} {words}")
    exact = np.array(kept.of("reference of hierarchy", exact))
    weight, light, true = ours[:, 0], ours[:, 1:4], exact[:, 1:4]
    difference = (weight[:, None] * abs(light - true)).sum() / (weight[:, None] * true).sum()
    # the mean of |x| of a normal distribution
    noise = math.sqrt(2 / math.pi) * (weight * ours[:, 4]).sum() / (weight[:, None] * light).sum()
    keys = ("links", "all_pairs", "rays", "board_ms", "bus_down_bytes", "bus_up_bytes", "closure_rms", "host_seconds")
    return {"difference": difference, "noise": noise} | {key: stats[key] for key in keys}


def link_rows(found):
    for name, each in found:
        threshold = name.split("/")[1]
        full = threshold == "full"
        yield name, [int(not full), "1e-05" if full else threshold, f"{each['difference']:.6f}", f"{each['noise']:.6f}",
                     each["links"],
                     each["all_pairs"], each["rays"], f"{each['board_ms']:.3f}",
                     each["bus_down_bytes"] + each["bus_up_bytes"],
                     f"{each['closure_rms']:.6f}", f"{each['host_seconds']:.3f}"]


def hierarchy_table(scene=ROOM, thresholds=THRESHOLDS):
    points = {f"hierarchy/{error:g}": lambda kept, error=error: link_of(kept, f"--error {error!r}", scene)
              for error in thresholds}
    points["hierarchy/full"] = lambda kept: link_of(kept, "--full-matrix", scene)
    columns = ["hierarchy", "error", "difference", "standard_error", "links", "all_pairs", "rays", "board_ms",
               "bus_bytes", "closure_rms",
               "seconds"]
    return Table("form_factors_hierarchy", columns, points, link_rows)


def tables():
    return [*error_tables(), trade_table(), hierarchy_table()]


def error_summary(rows):
    """The table of docs/studies/form_factors.md of the errors at most rays, of the rows of form_factors_slopes.csv."""
    return to_markdown(["pair", "exact", "error"],
                       ([row["form"], f"{float(row['exact']):.6f}", f"{100 * float(row['error at most rays']):.2g}%"]
                        for row in rows))


def hierarchy_summary(rows):
    """The table of a hierarchy against a full matrix, of the rows of form_factors_hierarchy.csv."""
    def line(row):
        is_hierarchy = row["hierarchy"] == "1"
        return ["hierarchy" if is_hierarchy else "full matrix", row["error"] if is_hierarchy else "",
                f"{int(row['links']):,}",
                f"{int(row['all_pairs']) / int(row['links']):.0f}", f"{int(row['rays']):,}",
                f"{float(row['board_ms']):.0f}",
                f"{100 * float(row['difference']):.1f}%"]
    return to_markdown(["", "error setting", "links", "fewer than all pairs by", "rays", "board ms",
                        "error of the light"], map(line, rows))
