"""Draws the charts of docs/studies/charts from their CSV files."""
import functools
import math
import pathlib
import re

import numpy as np

from studies.draw import Panel, Series, chart, panels
from studies.table import rows_of

LEAST = 1e-4  # place of points without error on a logarithmic axis
L2 = "relative L2 error in the field of view"
WORDS = {name: [" ".join(item.split()) for item in re.split(r"^- ", items, flags=re.M)[1:]] for name, items in
         re.findall(r"^## (.+)\n((?:(?:- |  ).+\n?)+)", pathlib.Path(__file__).with_name("charts.md").read_text(),
                    re.M)}


def column(rows, name):
    """Numbers; not-a-number for none, and the width of a size WxH."""
    return [float(row[name].split("x")[0]) if row[name] else math.nan for row in rows]


def where(rows, **fields):
    """Rows with these values in columns; in names, _ replaces characters that Python does not allow."""
    names = {name.replace(".", "_").replace("-", "_").replace(" ", "_"): name for name in rows[0]}
    return [row for row in rows if all(row[names[field]] == value for field, value in fields.items())]


def grouped(rows, name):
    """Rows by their value in a column, in the order of its first appearance."""
    groups = {}
    for row in rows:
        groups.setdefault(row[name], []).append(row)
    return groups


def series(label, rows, x, y, **look):
    return Series(label, column(rows, x), column(rows, y), **look)


def draw(folder, name, lines, **of_panel):
    chart(folder / f"{name}.svg", *WORDS[name], lines, **of_panel)


def draw_panels(folder, name, parts):
    panels(folder / f"{name}.svg", WORDS[name][0], parts)


def front(rows, x, y, mark="front", **look):
    """The Pareto front as a line."""
    on = sorted(where(rows, **{mark: "1"}), key=lambda row: float(row[x]))
    return series("Pareto front", on, x, y, look="line", colour=6, boxed=True, **look)


def rendering(folder):
    rows = rows_of(folder / "rendering.csv")
    of = functools.partial(series, x="frame_ms", y="error picture", look="points")
    full = where(rows, level_of_detail="0")
    lines = [of("64³ voxels, any step", where(rows, level_of_detail="1"), colour=-1),
             *(of(f"steps of {step} voxels", where(full, step=step, jitter=jitter), colour=colour,
                  hollow=jitter == "on")
               for colour, step in enumerate(("2", "1", "0.5", "0.25")) for jitter in ("off", "on"))]
    means = [(np.mean(column(where(full, size=size, step="0.25", jitter="off"), "error picture")), f"{size} pixels")
             for size in ("128x128", "192x192")]
    draw(folder, "rendering_error", [*lines, front(rows, "frame_ms", "error picture")], log_x=True, log_y=True,
         lines_y=means)


def lighting(folder):
    rows, rules = rows_of(folder / "lighting.csv"), ("conserving", "printed")
    of = functools.partial(series, x="pass_ms", y="error")
    fine = where(rows, step="0.5")
    lines = [of("any of these by steps of 2 voxels", where(rows, step="2"), look="points", colour=-1),
             *(of(f"low albedo, {bits} bits", where(fine, albedo="low", rules=rule, datapath=words), colour=colour,
                  dashed=rule == "printed")
               for colour, (words, bits) in enumerate((("wide", 24), ("paper", 8))) for rule in rules),
             *(of("high albedo, any rules and bits", where(fine, albedo="high", rules=rule, datapath=words), colour=2)
               for rule in rules for words in ("paper", "wide"))]
    draw(folder, "lighting_error", [*lines, front(rows, "pass_ms", "error")], log_x=True, log_y=True)


def light(folder):
    kinds = {"low albedo, by k": r"low-k\d+", "low albedo, steps of 2": r"low-k16-step\d",
             "low albedo, surfaces of opacity 1": r"low-k\d+-opaque",
             "high albedo": r"high-k\d+", "paths from the eye": r"eye-\d+", "paths from both ends": r"both-ends-\d+",
             "photon map": r"photons-\d+"}
    parts = [Panel("simulated ms of light and picture", "relative RMS error of the picture",
                   [series(kind, [row for row in rows if re.fullmatch(names, row["method"])], "board_ms", "error",
                           colour=colour, boxed=True)
                    for colour, (kind, names) in enumerate(kinds.items())], title=scene, log_x=True, log_y=True,
                   y_range=(0.008, 0.8))
             for scene, rows in grouped(rows_of(folder / "light.csv"), "scene").items()]
    draw_panels(folder, "light_error", parts)


def levels(folder):
    """Share of the simulated time that each level omits, by the host's seconds."""
    pairs = [row | {"kind": kind_of(row["command"])} for row in rows_of(folder / "levels.csv")]
    lines = [Series(f"functional, {kind}", column(rows, "functional_s"),
                    [max(abs(each), LEAST) for each in column(rows, "functional_time_error")],
                    look="points", colour=colour) for colour, (kind, rows) in enumerate(grouped(pairs, "kind").items())]
    lines.append(Series("cycle leaves nothing out", column(pairs, "cycle_s"), [LEAST] * len(pairs), look="points",
                        colour=5))
    draw(folder, "levels", lines, log_x=True, log_y=True, y_range=(LEAST / 2, 1))


def kind_of(command):
    """The chart of the rays of a pair."""
    if command.startswith("cone-beam"):
        return "backprojection"
    return "light" if ".scene" in command and "--illumination none" not in command else "viewing rays"


def form_factors(folder):
    slopes = rows_of(folder / "form_factors_slopes.csv")
    forms = grouped(rows_of(folder / "form_factors_error.csv"), "form")
    lines = [series(f"{each['form']}, slope {each['slope']}", forms[each["form"]], "rays", "error") for each in slopes]
    rays = [10.0 ** power for power in range(1, 6)]
    lines.append(Series("random points, slope -0.5", rays, [0.2 / math.sqrt(n) for n in rays], look="line", colour=-1,
                        dashed=True))
    draw(folder, "form_factors_error", lines, log_x=True, log_y=True)

    links = rows_of(folder / "form_factors_hierarchy.csv")
    draw(folder, "form_factors_hierarchy", [series("hierarchy", where(links, hierarchy="1"), "links", "standard_error"),
                                            series("full matrix", where(links, hierarchy="0"), "links",
                                                   "standard_error")], log_x=True, log_y=True)

    pairs = grouped(rows_of(folder / "form_factors_front.csv"), "series")
    names = {"host": "rays by the host", "board": "rays by the DSP", "pci33": "PCI", "agp2x": "AGP 2x"}
    for cost in ("board", "bus"):
        lines = [series(f"{names[bus]}, {names[maker]}", rows, f"{cost}_ms", "error",
                        colour=(bus == "agp2x") + 2 * (maker == "board"), boxed=True)
                 for name, rows in pairs.items() for bus, maker in (name.split(),)]
        lines.append(front([row for rows in pairs.values() for row in rows], f"{cost}_ms", "error", f"front_{cost}_ms",
                           dashed=True))
        for line in lines:
            line.x = [1000 * ms for ms in line.x]
        draw(folder, f"form_factors_trade_{cost}", lines, log_x=True, log_y=True)


def volume_texture(folder):
    names = {"pci33": "PCI", "agp1x": "AGP", "agp2x": "AGP 2x", "agp4x": "AGP 4x"}
    lines = [series(names[bus], rows, "rays_a_pixel", "hz") for bus,
             rows in grouped(rows_of(folder / "volume_texture.csv"), "bus").items()]
    draw(folder, "volume_texture", lines, log_x=True, log_y=True, lines_y=[(30, "30 Hz")])


def boards(folder):
    strong, weak = (grouped(rows_of(folder / f"boards_{kind}.csv"), "buses") for kind in ("strong", "weak"))
    names = {"own": "a bus each", "shared": "one PCI bus"}
    lines = [series(names[buses], rows, "boards", "frame_ms") for buses, rows in strong.items()]
    one = column(strong["own"], "frame_ms")[0]
    lines.append(Series("one board's / N", column(strong["own"], "boards"),
                        [one / n for n in column(strong["own"], "boards")], look="line", colour=-1,
                        dashed=True))
    draw_panels(folder, "boards", [
        Panel(WORDS["boards"][1], "simulated ms of the same picture, 512²", lines, log_x=True, log_y=True),
        Panel(WORDS["boards"][1], "simulated ms of a picture of 256² pixels a board",
              [series(names[buses], rows, "boards", "frame_ms") for buses, rows in weak.items()], log_x=True,
              log_y=True)])


def cone_beam_sweeps(folder):
    for name in ("cone_beam_views", "cone_beam_ray_spacing", "cone_beam_cone_angle", "cone_beam_truncation"):
        groups = grouped(rows_of(folder / f"{name}.csv"), "series")
        lines = [series(each, rows, "x", "relative_l2") for each, rows in groups.items()]
        draw_panels(folder, name,
                    [Panel(WORDS[name][1], L2, lines, log_x=name == "cone_beam_views", y_range=(0, None))])


def cone_beam_words(folder):
    groups = grouped(rows_of(folder / "cone_beam_accumulator.csv"), "series")
    whole = [(column(groups.pop("sums of 36 bits"), "relative_l2")[0], "sums of 36 bits")]
    parts = [Panel(axis, L2, [series("", rows, "x", "relative_l2", colour=colour)], log_x=colour != 1, lines_y=whole,
                   y_range=(0.28, 0.7))
             for colour, (axis, rows) in enumerate(zip(WORDS["cone_beam_accumulator"][1:], groups.values()))]
    draw_panels(folder, "cone_beam_accumulator", parts)


def cone_beam_methods(folder):
    groups = grouped(rows_of(folder / "cone_beam_sart.csv"), "series")
    parts = []
    for title in ("without noise", "of 3000 photons a pixel"):
        half = {name.removesuffix(" of 3000 photons").replace("FDK by Ram-Lak / Shepp-Logan / Hann",
            "FDK, three windows"): rows
                for name, rows in groups.items() if name.endswith("photons") == (title != "without noise")}
        fdk = half["FDK, three windows"]
        lines = [series(name, rows, "x", "relative_l2", colour=colour) for colour,
                 (name, rows) in enumerate(half.items()) if rows is not fdk]
        parts.append(Panel("iterations", L2, lines, title=title, log_x=True,
                           lines_y=[(column(fdk, "relative_l2")[0], "FDK, Ram-Lak")],
                           y_range=(0.2, 1.05)))
    draw_panels(folder, "cone_beam_sart", parts)

    groups = grouped(rows_of(folder / "cone_beam_relaxation.csv"), "series")
    lines = [series(name, rows, "x", "relative_l2", boxed=True) for name, rows in groups.items()]
    lines.append(series("reported as divergence",
                        [row for rows in groups.values() for row in where(rows, diverged="1")], "x", "relative_l2",
                        look="points", colour=6))
    draw(folder, "cone_beam_relaxation", lines)


def cone_beam_profiles(folder):
    groups = grouped(rows_of(folder / "cone_beam_axial_profile.csv"), "series")
    first = next(iter(groups.values()))
    of = functools.partial(series, look="line", boxed=True)
    lines = [of("phantom", first, "z", "truth", colour=-1),
             *(of(f"cone of {name}", rows, "z", "within_34") for name, rows in groups.items())]
    draw(folder, "cone_beam_axial_profile", lines, box_outside=True)

    parts = [Panel(*WORDS["cone_beam_profile"][1:],
                   [of("phantom", rows, "x", "truth", colour=-1), of("FDK, plain", rows, "x", "value", colour=4),
                                                     of("FDK, normalised", rows, "x", "normalised", colour=0)],
                   title=name, y_range=(0.9, 1.15) if name.startswith("head") else (-0.1, 1.2))
             for name, rows in grouped(rows_of(folder / "cone_beam_profile.csv"), "series").items()]
    draw_panels(folder, "cone_beam_profile", parts)


def cone_beam_ripple(folder):
    groups = grouped(rows_of(folder / "cone_beam_moire.csv"), "series")
    lines = [series(name, rows, "x", "ripple", boxed=True) for name, rows in groups.items()]
    x = np.linspace(0.4, 3, 400)
    lines.append(Series("sinc² of the rays' wave", x, np.sinc(1 / x) ** 2, look="line", colour=-1, dashed=True,
                        boxed=True))
    draw(folder, "cone_beam_moire", lines, log_y=True, x_range=(0.35, 3.05), y_range=(5e-5, 2))


def cone_beam_host(folder):
    rows = [row for row in rows_of(folder / "cone_beam_trade.csv") if row["cpu_s"]]

    def of(label, *parts, **look):
        return series(label, [row for row in rows if all(part in row["name"] for part in parts)], "cpu_s",
                      "relative_l2", **look)
    lines = [of("board's rays: 90, 180, 360 views", "rays:1/half_steps:2/window:0"),
             of("Shepp-Logan window", "half_steps:2/window:1", look="points"),
             of("steps of 2 voxels", "half_steps:4", look="points"),
             of("steps of ½ voxel", "half_steps:1/", look="points"), of("2 × 2 rays a pixel", "rays:2", look="points"),
             of("double precision", "trade_reference", look="points", hollow=True)]
    # Not published: its user measured it.
    lines.append(Series("plastimatch, as its user measured it", [23], [0.17], look="points", colour=6, hollow=True))
    draw(folder, "cone_beam_trade", [each for each in lines if len(each.x)], log_x=True, y_range=(0, None))


def truths(folder):
    for domain, rows in grouped(rows_of(folder / "truths_fronts.csv"), "domain").items():
        parts, errors = [], column(rows, "error")
        for cost, axis, mark, plan in (("board_ms", "simulated ms", "front_ms", "plan_ms"),
                                       ("host_s", "host seconds", "front_s", "plan_s")):
            lines = []
            for colour, (method, mine) in enumerate(grouped(rows, "method").items()):
                by_words = grouped([row | {"words": "paper" if "datapath=paper" in row["settings"] else "wide"}
                                    for row in mine], "words")
                lines += [series(f"{method}, {words}" if len(by_words) > 1 else method, each, cost, "error",
                                 look="points", colour=colour, hollow=words == "paper")
                          for words, each in by_words.items()]
            parts.append(Panel(axis, "root mean square of the relative errors",
                               [*lines, front(rows, cost, "error", mark),
                                series("a plan's choice for 1%", where(rows, **{plan: "1"}), cost, "error",
                                       look="points", colour=4, mark=6)], log_x=True, log_y=True,
                               lines_y=[(0.01, "1%")] * (min(errors) < 0.01 < max(errors))))
        panels(folder / f"truths_{domain}.svg", WORDS[f"truths_{domain}"][0], parts)


DRAWN = {each.__name__: [each] for each in (rendering, lighting, light, form_factors, volume_texture, boards, levels,
                                            truths)} | {
    "cone_beam": [cone_beam_sweeps, cone_beam_words, cone_beam_methods, cone_beam_profiles, cone_beam_ripple,
                  cone_beam_host]}
