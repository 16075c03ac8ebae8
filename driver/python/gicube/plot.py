"""Pictures, counters and traces by matplotlib."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

import numpy as np

from gicube.counters import Counters
from gicube.errors import BadArgument
from gicube.image import Image
from gicube.records import Colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Causes of the pipelines' cycles and their colours, which people with any colour vision can tell (Okabe and Ito, 2008).
_CAUSES = {
    "busy": ("samples", "#009E73"),
    "leap": ("leaps", "#56B4E9"),
    "latency": ("pipeline's latency", "#F0E442"),
    "cache": ("cache", "#E69F00"),
    "memory": ("memory", "#D55E00"),
    "rays": ("waiting for rays", "#0072B2"),
    "other": ("other", "#999999"),
}
_GROUPS = {
    "cache_fill": "cache",
    "cache_miss": "cache",
    "splat": "cache",
    "memory_bank": "memory",
    "refresh": "memory",
    "sorter": "rays",
    "queue_empty": "rays",
    "link": "rays",
    "ray_bus": "rays",
    "dsp_compute": "rays",
    "sdram": "rays",
}

# Groups of the parts of energy.*, and their colours.
_ENERGY = {
    "memory": ("memory", "memory_interface"),
    "SDRAM": ("sdram",),
    "DSP": ("dsp",),
    "clock": ("clock",),
    "on-chip memories": ("queues", "cache", "tables", "leakage"),
    "logic": ("sorters", "pipelines"),
    "buses, links": ("links", "ray_bus", "host_bus"),
}
_ENERGY_COLOURS = ("#0072B2", "#56B4E9", "#E69F00", "#999999", "#CC79A7", "#009E73", "#5B5B5B")


def _axes(axes: Optional[Axes]) -> Any:  # of matplotlib, which has no types
    if axes is not None:
        return axes
    import matplotlib.pyplot as pyplot

    return pyplot.subplots()[1]


def picture(image: Image, background: Colour = (0.0, 0.0, 0.0), axes: Optional[Axes] = None) -> Axes:
    """Shows a picture over a colour, without scales."""
    to = _axes(axes)
    to.imshow(image.over(background), interpolation="nearest")
    to.set_axis_off()
    return to


def cycles_by_cause(counters: Counters) -> dict[str, float]:
    """The share of the pipelines' cycles that each cause has, of a board with fidelity cycle; they add up to 1."""
    prefix = "processor.cycles."
    found = {name[len(prefix) :]: value for name, value in counters.items() if name.startswith(prefix)}
    total = sum(found.values())
    shares = dict.fromkeys(_CAUSES, 0.0)
    for cause, value in found.items():
        group = cause if cause in _CAUSES else _GROUPS.get(cause, "other")
        shares[group] += value / total
    return {cause: share for cause, share in shares.items() if share > 0}


def cycles(counters: Counters, axes: Optional[Axes] = None) -> Axes:
    """One bar of where the pipelines' cycles went, with the causes written on it or above."""
    to = _axes(axes)
    left = 0.0
    for cause, share in cycles_by_cause(counters).items():
        text, colour = _CAUSES[cause]
        to.barh(0, share, left=left, color=colour, edgecolor="white")
        if share > 0.04:
            to.annotate(f"{text}\n{100 * share:.0f}%", (left + share / 2, 0), ha="center", va="center", fontsize=8)
        left += share
    to.set_xlim(0, 1)
    to.set_yticks([])
    to.set_xlabel("share of the pipelines' cycles")
    return to


def energy_by_part(counters: Counters) -> dict[str, tuple[float, float, float]]:
    """Joules of each part of a board with fidelity cycle, the largest first: (value, low, high). docs/guide/energy.md.

    Raises BadArgument: the counters have no energy, as those of other fidelities.
    """
    parts = [name for name in counters if name.startswith("energy.") and name.count(".") == 1
             and name != "energy.total"]
    if not parts:
        raise BadArgument("counters", "those of a board with fidelity=cycle", "none named energy.*")
    parts.sort(key=lambda name: -counters[name])
    return {name.removeprefix("energy."): (counters[name] * 1e-12, counters[f"{name}.low"] * 1e-12,
                                           counters[f"{name}.high"] * 1e-12) for name in parts}


def energy(counters: Counters, axes: Optional[Axes] = None) -> Axes:
    """One bar of a card's millijoules by groups of its parts, with the interval that the uncertainties of the prices
    give for their sum."""
    to = _axes(axes)
    parts = energy_by_part(counters)
    left = 0.0
    for (text, names), colour in zip(_ENERGY.items(), _ENERGY_COLOURS):
        mj = 1e3 * sum(parts[name][0] for name in names)
        to.barh(0, mj, left=left, color=colour, edgecolor="white", label=f"{text} {mj:.3g} mJ")
        left += mj
    to.plot([1e3 * sum(each[bound] for each in parts.values()) for bound in (1, 2)], [0, 0], color="black", marker="|")
    to.set_yticks([])
    to.set_xlabel("mJ")
    to.legend(fontsize=8)
    return to


def loads_over_time(trace: Union[str, "os.PathLike[str]"]) -> dict[str, tuple[Any, Any]]:
    """Draws waiting rays and packets of a board with fidelity cycle that was opened by "emu:?fidelity=cycle&trace=FILE"
    and closed: arrays of simulated picoseconds and of the values from then on, by "processor 0 rays waiting", "memory
    RDRAM 0 packets/us", "links rays on links". """
    processes: dict[int, str] = {}
    points: dict[str, list[tuple[float, int]]] = {}
    with open(trace) as file:
        for line in file:  # one event each, and most are slices of the pipelines
            if '"process_name"' in line:
                event = json.loads(line.rstrip(",\n"))
                process = processes[event["pid"]] = event["args"]["name"]
                if process.startswith("processor "):
                    points[f"{process} rays waiting"] = []  # none, unless it tells of some
            elif '"ph":"C"' in line:
                event = json.loads(line.rstrip(",\n"))
                name = f"{processes[event['pid']]} {event['name']}"
                points.setdefault(name, []).append((event["ts"], event["args"]["value"]))
    columns = {name: np.array(each, float).reshape(-1, 2).T for name, each in points.items()}
    return {name: (np.rint(times * 1e6).astype("i8"), values) for name, (times, values) in columns.items()}


def _means(times: Any, values: Any, edges: Any) -> Any:
    """The mean of a value that changes at `times`, between `edges`."""
    if not len(times):
        return np.zeros(len(edges) - 1)
    areas = np.concatenate([[0], np.cumsum(values[:-1] * np.diff(times))])
    return np.diff(np.interp(edges, times, areas)) / np.diff(edges)


def loads(trace: Union[str, "os.PathLike[str]"], axes: Optional[Sequence[Axes]] = None) -> Sequence[Axes]:
    """How full the queues of each processor are and how much each memory reads, over simulated time: two maps with a
    row for each.

    trace: as in loads_over_time(). Raises BadArgument: nothing waited or moved, as on boards of another fidelity.
    """
    found = loads_over_time(trace)
    changes = [times for times, _ in found.values() if len(times)]
    if not changes:
        raise BadArgument("trace", "one of a board with fidelity=cycle that has traced rays", os.fspath(trace))
    if axes is None:
        import matplotlib.pyplot as pyplot

        axes = list(pyplot.subplots(2, sharex=True, layout="constrained")[1])
    begin, end = min(times[0] for times in changes), max(times[-1] for times in changes)
    edges = np.linspace(begin, end, 201)  # chosen: bins that a figure's width can show
    for to, kind in zip(axes, ("rays waiting", "packets/us")):
        rows = {name[: -len(kind)].removeprefix("memory "): _means(*each, edges) for name,
                each in found.items() if name.endswith(kind)}
        extent = (begin * 1e-9, end * 1e-9, len(rows), 0)
        image = to.imshow(list(rows.values()), aspect="auto", extent=extent, cmap="viridis", interpolation="nearest",
                          vmin=0)
        to.set_yticks(np.arange(len(rows)) + 0.5, list(rows))
        to.figure.colorbar(image, ax=to, label=kind)
    axes[-1].set_xlabel("simulated ms")
    return axes
