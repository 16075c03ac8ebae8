"""Charts as small, simple SVG files. The same data give the same bytes.

    from studies import draw
    draw.chart("growth.svg", "Time grows with the square of the edge", "edge, pixels", "host seconds",
               [draw.Series("cycle", [64, 128, 256], [0.2, 0.8, 3.1])], log_x=True, log_y=True)

The title is one sentence about the chart's result; the labels of the axes have the units. A chart has at most seven
series with different marks, in colours for any colour vision (Okabe and Ito, 2008). Labels are at the ends of lines; a
box names other series (look "points", "steps" of many points). Adjacent charts are panels:

    draw.panels("both.svg", "Title", [draw.Panel("x", "y", series), draw.Panel("x", "z", others)])
"""
import io
import itertools
import re
import textwrap
from dataclasses import dataclass
from typing import Optional

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot  # noqa: E402
import matplotlib.ticker as ticker  # noqa: E402
import numpy as np  # noqa: E402

from studies.table import write_whole  # noqa: E402

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
GRAY = "#8C8C8C"
MARKS = "osD^vPX"
MAX_SERIES = 7
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "gicube", "font.family": "DejaVu Sans", "font.size": 10,
         "axes.grid": True,
         "grid.color": "#E4E4E4", "grid.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False,
         "axes.axisbelow": True,
         "axes.edgecolor": "#606060", "path.simplify": True, "path.simplify_threshold": 0.3, "legend.frameon": True,
         "legend.framealpha": 0.85, "legend.edgecolor": "none", "legend.fontsize": 9}


@dataclass
class Series:
    label: str  # equal labels are written once; empty: the series of its colour has the label
    x: object  # numbers; bars: texts
    y: object  # numbers; not-a-number for gaps
    look: str = "both"  # of a line and points; or line, points
    colour: Optional[int] = None  # of COLOURS; -1 is gray, for references; None: the next
    dashed: bool = False
    hollow: bool = False
    mark: Optional[int] = None  # of MARKS; None: as the colour
    boxed: bool = False  # a line with its name in the box


@dataclass
class Panel:
    x_label: str
    y_label: str
    series: list
    title: str = ""
    log_x: bool = False
    log_y: bool = False
    x_range: tuple = (None, None)
    y_range: tuple = (None, None)
    bars: bool = False  # a group of bars for each x
    box_outside: bool = False  # the box of names is beside the panel
    lines_y: tuple = ()  # (value, label): horizontal reference lines


def chart(path, title, x_label, y_label, series, *, size=(8.4, 5.0), **of_panel):
    """One panel; `of_panel`: fields of Panel. Raises as panels()."""
    panels(path, title, [Panel(x_label, y_label, series, **of_panel)], size=size)


def panels(path, title, parts, *, size=None, columns=2):
    """Writes an SVG of panels side by side, `columns` at most, `size` in inches of 72 points. Raises ValueError (more
    than seven series in a panel, a series of unequal lengths), FileError."""
    columns = min(columns, len(parts))
    rows = -(-len(parts) // columns)
    size = size or (5.8 * columns, 4.6 * rows)
    with matplotlib.rc_context(STYLE):
        figure, grid = pyplot.subplots(rows, columns, figsize=size, squeeze=False, constrained_layout=True)
        lines = textwrap.wrap(title, int(size[0] * 9.6))
        figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=12, fontweight="bold")
        for part, axes in itertools.zip_longest(parts, grid.flat):
            if part is None:
                axes.remove()
            else:
                _fill(axes, part)
        figure.canvas.draw()  # computes the labels' places
        for part, axes in zip(parts, grid.flat):
            _label(axes, part)
        drawn = io.StringIO()
        figure.savefig(drawn, format="svg", metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        pyplot.close(figure)
    write_whole(path, _shortened(drawn.getvalue()))


def _fill(axes, part):
    names = {each.label or each.colour or id(each) for each in part.series}
    if len(names - set(range(MAX_SERIES))) > MAX_SERIES:
        raise ValueError(f"series of {part.y_label}: expected at most {MAX_SERIES}, got {len(names)}")
    if part.log_x:
        axes.set_xscale("log")
    if part.log_y:
        axes.set_yscale("log")
    following = itertools.count()
    for number, each in enumerate(part.series):
        if len(each.x) != len(each.y):
            raise ValueError(f"{each.label}: expected as many x as y, got {len(each.x)} and {len(each.y)}")
        if each.colour is None:
            each.colour = next(following) % len(COLOURS)
        (_bars if part.bars else _plot)(axes, part, number, each)
    axes.set(xlabel=part.x_label, ylabel=part.y_label, xlim=part.x_range, ylim=part.y_range)
    if part.title:
        axes.set_title(part.title, fontsize=10, loc="left")
    for value, _ in part.lines_y:
        axes.axhline(value, color=GRAY, lw=1, ls=(0, (4, 3)))
    if part.bars:
        axes.set_xticks(range(len(part.series[0].x)), [x if isinstance(x, str) else f"{x:g}" for x in part.series[0].x])
        axes.grid(axis="x", visible=False)
    if part.log_x:
        _plain_numbers(axes.xaxis, sorted({float(x) for each in part.series for x in each.x}))
    if part.log_y:
        _plain_numbers(axes.yaxis)


def _plain_numbers(axis, measured=()):
    """Ticks of a logarithmic axis: a few measured values with enough distance, or else 0.01, 0.1, 1, and for few
    decades 2 and 5."""
    low, high = sorted(axis.get_view_interval())
    decades = np.log10(high / low) if low > 0 else 9
    axis.set_major_formatter(ticker.FuncFormatter(lambda value,
                                                  _: f"{value:.10g}" if 0.9e-4 < value < 2e5
                                                  else f"1e{round(np.log10(value))}"))
    axis.set_minor_formatter(ticker.NullFormatter())
    if 2 < len(measured) <= 12 and all(map(_is_round, measured)) and min(b / a for a,
        b in zip(measured, measured[1:])) > 10 ** (decades / 16):
        axis.set_major_locator(ticker.FixedLocator(measured))
        axis.set_minor_locator(ticker.NullLocator())
        return
    axis.set_major_locator(ticker.LogLocator(base=10, subs=(1, 2, 5) if decades < 2.2 else (1,), numticks=20))
    axis.set_minor_locator(ticker.LogLocator(base=10, subs=range(1, 10), numticks=99))


def _is_round(value):
    return value < 1e5 and (len(f"{value:.9g}".strip("0")) <= 3 or np.log2(value) % 1 == 0)


def _plot(axes, part, number, each):
    colour = GRAY if each.colour < 0 else COLOURS[each.colour]
    y = np.asarray(each.y, dtype=float)
    there = np.isfinite(y)
    many = there.sum() > 60
    mark = "" if each.look == "line" else MARKS[each.colour % len(MARKS) if each.mark is None else each.mark]
    line = "none" if each.look == "points" else (0, (4, 2)) if each.dashed else "-"
    axes.plot(np.asarray(each.x, dtype=float)[there], y[there], color=colour, marker=mark, linestyle=line,
              lw=1.8 if each.colour >= 0 else 1.4,
              ms=3.5 if many else 5, mfc="white" if each.hollow else colour, mew=1, clip_on=not mark
              or part.x_range != part.y_range, zorder=3 if each.colour >= 0 else 2,
              label=each.label if _in_box(each) else "")


def _bars(axes, part, number, each):
    width = 0.8 / len(part.series)
    at = np.arange(len(each.x)) + (number - (len(part.series) - 1) / 2) * width
    axes.bar(at, np.nan_to_num(np.asarray(each.y, dtype=float)), width, color=COLOURS[each.colour], label=each.label)


def _in_box(each):
    return bool(each.label) and (each.boxed or each.look == "points")


def _label(axes, part):
    """Labels at the lines' ends, moved vertically until they do not overlap; the others in a box."""
    named = dict(reversed(list(zip(*reversed(axes.get_legend_handles_labels())))))
    if named:
        place = {"loc": "center left", "bbox_to_anchor": (1, 0.5)} if part.box_outside else {"loc": "best"}
        axes.legend(reversed(named.values()), reversed(named), **place)
    if part.bars:
        return
    seen, ends = set(), []
    for each in part.series:
        there = np.flatnonzero(np.isfinite(np.asarray(each.y, dtype=float)))
        if _in_box(each) or not each.label or each.label in seen or not len(there):
            continue
        seen.add(each.label)
        point = (float(each.x[there[-1]]), float(each.y[there[-1]]))
        x, y = axes.transAxes.inverted().transform(axes.transData.transform(point))
        if x > 0.88:
            ends.append((each, point, x, y))
        else:
            _write(axes, each, point, (6, 8 if _free_above(axes, part, point) else -10), "offset points", False)
    right = axes.get_xlim()[1]
    for value, text in part.lines_y:
        ends.append((Series(text, (), (), colour=-1), (right, value),
                     *axes.transAxes.inverted().transform(axes.transData.transform((right, value)))))
    points = axes.bbox.height * 72 / axes.figure.dpi
    ends.sort(key=lambda end: -end[3])
    names = [_wrapped(each) for each, *_ in ends]
    heights = [min(max(y, 0), 1) for *_, y in ends]
    for _ in range(300):  # pushes neighbours apart
        for i in range(1, len(ends)):
            apart = (3 + 5.5 * (names[i - 1].count("\n") + names[i].count("\n") + 2)) / points
            if (gap := heights[i - 1] - heights[i]) < apart:
                heights[i - 1] += (apart - gap) / 2
                heights[i] -= (apart - gap) / 2
    for (each, point, x, y), height in zip(ends, heights):
        moved = abs(height - y) * points > 7 or x < 0.97
        _write(axes, each, point, (1.03, height), "axes fraction", moved)


def _free_above(axes, part, point):
    """Fewer lines run above than below to the right of a point."""
    lines = [axes.transData.transform(np.column_stack([np.interp(np.linspace(0, len(each.x) - 1, 400),
        range(len(each.x)), values)
                                                       for values in (np.asarray(each.x, float),
                                                           np.asarray(each.y, float))]))
             for each in part.series]
    off = (np.concatenate(lines) - axes.transData.transform(point)) * 72 / axes.figure.dpi
    beside = (off[:, 0] > 5) & (off[:, 0] < 60)
    return np.sum(beside & (off[:, 1] > 2) & (off[:, 1] < 16)) <= np.sum(beside & (off[:, 1] < -2) & (off[:, 1] > -16))


def _wrapped(each):
    return "\n".join(textwrap.wrap(each.label, 24))


def _write(axes, each, point, place, coordinates, moved):
    colour = matplotlib.colors.to_rgb(GRAY if each.colour < 0 else COLOURS[each.colour])
    dark = tuple(0.72 * part for part in colour)
    axes.annotate(_wrapped(each), point, place, textcoords=coordinates, va="center", fontsize=9, color=dark,
                  linespacing=0.95,
                  annotation_clip=False, arrowprops={"arrowstyle": "-", "color": dark, "lw": 0.5, "shrinkA": 0,
                                                     "shrinkB": 3} if moved else None)


def _shortened(text):
    """Removes comments, the document type, and digits beyond a hundredth of a point. Clip paths get numbers, because
    matplotlib names them by a hash of their corners, whose last bits differ between machines."""
    text = re.sub(r"<!DOCTYPE[^>]*>|<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"(\d\.\d\d)\d{3,}", r"\1", text).replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
    for number, name in enumerate(dict.fromkeys(re.findall(r'<clipPath id="(p[0-9a-f]{10})">', text))):
        text = text.replace(name, f"clip{number}")
    return "".join(line.strip() + "\n" for line in text.splitlines() if line.strip())
