"""Pictures and counters by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

from gicube.counters import Counters
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
    "dsp": "rays",
}


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
    """The share of the pipelines' cycles that each cause has, of a board with fidelity cycle or approximate; they add up to 1."""
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
