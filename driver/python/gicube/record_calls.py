"""Methods of the records (gicube.records), and the records that differ from C++."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gicube import _core

if TYPE_CHECKING:
    from gicube.records import DepositReport, LightingReport, Sampling, View

__all__ = ["FIRST_USER_ROUTINE", "FRESNEL_ROUTINE", "HENYEY_GREENSTEIN_ROUTINE", "HOST_ROUTINE", "RayBatch",
           "TABULATED_ROUTINE", "Ticket"]

Array = NDArray[Any]
Vec3 = Sequence[float]
Colour = Sequence[float]

FRESNEL_ROUTINE, HENYEY_GREENSTEIN_ROUTINE, TABULATED_ROUTINE = 0, 1, 2  # Material.routine, on every board
FIRST_USER_ROUTINE, HOST_ROUTINE = 8, 255


class Record:
    """Base of all records: an unknown name is refused, with the nearest known one."""

    def __new__(cls, *_: Any, **given: Any) -> Any:
        for name in given:
            if name not in cls._names():
                raise TypeError(cls._without(name))
        return super().__new__(cls)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._names():
            raise AttributeError(self._without(name))
        super().__setattr__(name, value)

    @classmethod
    def _names(cls) -> Any:
        return getattr(cls, "__dataclass_fields__")

    @classmethod
    def _without(cls, name: str) -> str:
        # A part of a name counts as near, as fov of fov_degrees.
        near = [known for known in cls._names() if name in known] or difflib.get_close_matches(name, cls._names(), 1)
        return f"{cls.__name__} has no field {name!r}" + (f", the nearest is {near[0]!r}" if near
                                                          else f": it has {', '.join(cls._names())}")


class TransferFunctionCalls:
    """Points may be given as (value, (r, g, b)) and (value, opacity)."""

    def __post_init__(self) -> None:
        from gicube.records import ColourPoint, OpacityPoint

        of: Any = self
        of.colours = [p if isinstance(p, ColourPoint) else ColourPoint(*p) for p in of.colours]
        of.opacities = [p if isinstance(p, OpacityPoint) else OpacityPoint(*p) for p in of.opacities]

    def colour_at(self, value: float) -> Tuple[float, float, float]:
        """Raises BadArgument: no points."""
        of: Any = self
        return _core.colour_at(of, value)

    def opacity_at(self, value: float) -> float:
        """Raises BadArgument: no points."""
        of: Any = self
        return _core.opacity_at(of, value)


class LightingReportCalls:
    def standard_error(self, irradiance: ArrayLike) -> Any:
        """Error bars of a pass with Albedo.HIGH: of one voxel's irradiance (a bound there), of the sum over many, or of
        an array of them."""
        of: Any = self
        return np.sqrt(np.asarray(irradiance) * (of.emitted / of.rays if of.rays else 0.0))


class SamplingCalls:
    @classmethod
    def of(cls, view: View) -> Sampling:
        """That of the view's own rays."""
        made: Any = cls
        same = {each.name: getattr(view, each.name) for each in fields(made) if each.name != "looking"}
        x, y, z = (float(b) - float(a) for a, b in zip(view.eye, view.look_at))
        sampling: Sampling = made(**same, looking=(x, y, z)) if (x, y, z) != (0, 0, 0) else made(**same)
        return sampling


@dataclass(frozen=True)
class Ticket(Record):
    """Names one submitted batch until its rays have been received; `rays`: how many come back."""

    id: int
    rays: int


@dataclass(repr=False)
class RayBatch(Record):
    """A ray batch that has come back, at the simulated time `completed`. `rays`: array of gicube.TRACED_RAY."""

    ticket: int
    completed: int
    cancelled: bool
    lighting: Optional[LightingReport]
    deposits: Optional[DepositReport]
    rays: Array

    def __repr__(self) -> str:
        how = "cancelled" if self.cancelled else f"completed at {self.completed} ps"
        left = "".join(f", {name}" for name in ("lighting", "deposits") if getattr(self, name) is not None)
        return f"<gicube.RayBatch {self.ticket}: {len(self.rays)} rays, {how}{left}>"
