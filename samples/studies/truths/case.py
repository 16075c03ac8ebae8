"""A truth, the board's value, and its cost."""
import contextlib
import math
import time
import warnings
from dataclasses import dataclass, field
from typing import Callable, NamedTuple

import gicube
import numpy as np

EXACT, ABSORBER = 0.01, 0.002  # chosen: largest error of a value without noise, as a share of the truth
GENERATOR = (1, 182667, 469891, 498753, 110745, 446247)
LOST_PER_STEP = 2.0**-28  # measured in Kobayashi's shields: what rounding adds to a transmittance in each step
MOST_ERRORS = 3  # largest error of a stochastic value, in standard errors


@dataclass
class Value:
    """One number. Standard errors judge a value with an error bar; the limit, a share of the truth, judges others."""
    quantity: str
    truth: float
    found: float
    error: float = 0  # standard error of `found`
    truth_error: float = 0  # standard error of `truth`; half of its last digit if that matters
    limit: float = 0  # 0: stochastic

    @property
    def off(self):
        """The error in standard errors, or as a share of the truth."""
        difference = self.found - self.truth
        if self.limit:
            return difference / self.truth if self.truth else difference
        spread = math.hypot(self.error, self.truth_error)
        return difference / spread if spread else math.copysign(math.inf, difference) if difference else 0.0

    @property
    def holds(self):
        return abs(self.off) <= (self.limit or MOST_ERRORS)


class Case(NamedTuple):
    """A truth. `measure` takes a Bench and the settings, and returns Values."""
    name: str  # DOMAIN/CASE/METHOD
    source: str
    measure: Callable
    settings: dict = {}  # for the table
    small: dict = {}  # changes for the small version; None: it omits the case
    sweep: tuple = ()  # changes for the points of the domain's chart

    @property
    def domain(self):
        return self.name.split("/")[0]


@dataclass
class Bench:
    """Opens boards for a case, and sums their costs."""
    uri: str = "emu:"
    fidelity: str = "cycle"
    ms: float = 0  # simulated, without loading the volume
    seconds: float = field(default_factory=time.monotonic)  # start

    @contextlib.contextmanager
    def board(self, volume, look, tags=None, looks=(), datapath="wide", edge=32, spacing=(1, 1, 1), gradients=False,
              **options):
        """A board with a volume [z, y, x] of 0..1 and looks by tag. `edge`: the card's, in voxels; a served board has
        its own."""
        uri = self.uri
        if uri.startswith("emu:"):
            settings = {"fidelity": self.fidelity, "set=asic.datapath": datapath, "set=asic.block_voxels": "8",
                        "set=asic.max_volume_voxels": edge, **options}
            uri += "?" + "&".join(f"{name}={value}" for name, value in settings.items())
        with gicube.open(uri) as board:
            board.load_volume(gicube.Volume(np.asarray(volume, "f4"), range=gicube.ValueRange(0, 1), tags=tags,
                                            spacing=spacing, find_gradients=gradients))
            for tag, each in enumerate([look, *looks]):
                board.set_transfer_function(each, tag)
            began = board.now
            yield board
            self.ms += (board.now - began) * 1e-9

    def cost(self):
        return self.ms, time.monotonic() - self.seconds


def even(extinction):
    """The look of a medium of this extinction per voxel, for all values."""
    return gicube.TransferFunction([(0, (1, 1, 1))], [(0, -math.expm1(-extinction))])


def linear(low, high, points=257):
    """The look with an extinction that rises linearly from `low` at 0 to `high` at 1. Its points interpolate this
    within 1e-6 of `high`."""
    at = np.linspace(0, 1, points)
    return gicube.TransferFunction([(0, (1, 1, 1))], [(x, -math.expm1(-low - (high - low) * x)) for x in at.tolist()])


def scatterer(board, albedo, g=0.0, tag=0):
    """Makes a tag a medium with Henyey and Greenstein's phase function."""
    bsdf = {"bsdf": gicube.Bsdf.ISOTROPIC} if g == 0 else {"bsdf": gicube.Bsdf.TRAP,
                                                           "routine": gicube.HENYEY_GREENSTEIN_ROUTINE,
                                                             "parameters": [g]}
    board.set_material(gicube.Material(scattering=albedo, **bsdf), tag)


def transmittances(board, start, end, step, pieces=1):
    """Transmittances between points, in voxels. An opacity has 24 bits, each step of a ray rounds it, and faint
    transmittances have few of them left; the product of pieces has more."""
    cuts = [start + (end - start) * k / pieces for k in range(pieces)] + [end]
    rays = gicube.rays_between(np.concatenate(cuts[:-1]), np.concatenate(cuts[1:]))
    passed = 1 - board.receive(board.submit(rays, type=gicube.RayType.OPACITY, step=step)).rays["opacity"]
    lost = LOST_PER_STEP * np.sqrt(((end - start) ** 2).sum(axis=1).max(initial=0)) / (pieces * step)
    if passed[passed < lost / ABSORBER].sum() > passed.sum() / 2:
        warnings.warn(f"most transmittances are below {lost / ABSORBER:.1g}: they may be off by more than "
                      f"{ABSORBER:.1%}, because opacities have 24 bits; use more pieces", stacklevel=2)
    return passed.reshape(pieces, -1).prod(axis=0)


def lattice(count, dimensions, shift=0.0):
    """Points (count, dimensions) in 0..1 of a rank-1 lattice (Cools, Kuo and Nuyens, SIAM J. Sci. Comput. 28 (2006),
    2162): `count` a power of two."""
    return (np.arange(count)[:, None] * np.array(GENERATOR[:dimensions]) / count + 0.5 / count + np.asarray(shift)) % 1


def folded(count, dimensions, shift):
    """Folded points, so that the integrand is periodic (Hickernell 2002)."""
    return 1 - abs(2 * lattice(count, dimensions, shift) - 1)


def sphere(uv):
    """Unit vectors, uniform over the sphere, from points of the unit square."""
    z, turn = 1 - 2 * uv[:, 0], 2 * np.pi * uv[:, 1]
    ring = np.sqrt(np.maximum(0, 1 - z * z))
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], 1)


def lambert(uv):
    """Unit vectors about z by Lambert's law."""
    ring, turn = np.sqrt(uv[:, 0]), 2 * np.pi * uv[:, 1]
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), np.sqrt(1 - uv[:, 0])], 1)


def mean_of(samples):
    """Means and their standard errors over the first axis: independent runs."""
    samples = np.asarray(samples, float)
    spread = samples.std(axis=0, ddof=1) if len(samples) > 1 else np.zeros(samples.shape[1:])
    return samples.mean(axis=0), spread / math.sqrt(len(samples))
