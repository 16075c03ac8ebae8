"""What records have besides their fields (gicube.records), and those that are not as in C++."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gicube import _core

if TYPE_CHECKING:
    from gicube.records import DepositReport, LightingReport, Sampling, View

__all__ = ["FIRST_USER_ROUTINE", "FRESNEL_ROUTINE", "HENYEY_GREENSTEIN_ROUTINE", "HOST_ROUTINE", "RayBatch", "TABULATED_ROUTINE", "Ticket"]

Array = NDArray[Any]
Vec3 = Sequence[float]
Colour = Sequence[float]

FRESNEL_ROUTINE, HENYEY_GREENSTEIN_ROUTINE, TABULATED_ROUTINE = 0, 1, 2  # Material.routine, on every board
FIRST_USER_ROUTINE, HOST_ROUTINE = 8, 255


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
        """Error bars of a pass with Albedo.HIGH: of one voxel's irradiance (a bound there), of the sum over many, or of an array of them."""
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
class Ticket:
    """Names one submitted batch until its rays have been received; `rays`: how many come back."""

    id: int
    rays: int


@dataclass
class RayBatch:
    """A ray batch that has come back, at the simulated time `completed`. `rays`: array of gicube.TRACED_RAY."""

    ticket: int
    completed: int
    cancelled: bool
    lighting: Optional[LightingReport]
    deposits: Optional[DepositReport]
    rays: Array
