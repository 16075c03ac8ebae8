"""Records and enumerations of the driver. Fields, defaults and meanings are those of the C++ headers that each class names.

Positions are (x, y, z) in voxels, voxel (0, 0, 0) has its centre at the origin; arrays over voxels are indexed [z, y, x].
Times are simulated, in picoseconds.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gicube import _core

__all__ = [  # of the package
    "FIRST_USER_ROUTINE", "FRESNEL_ROUTINE", "FoundBoard", "HENYEY_GREENSTEIN_ROUTINE", "HOST_ROUTINE", "TABULATED_ROUTINE", "Albedo", "AnsweredCommand",
    "BackPressure", "BoardInfo", "BrickDetail", "Bsdf", "ColourPoint", "CutPlane", "DepositReport", "DirectionalLight", "ElementKind",
    "BoardTime", "HostBuses",
    "EnergyRules", "Fidelity", "Illumination", "Lamp", "LevelError", "LevelReport", "Light", "LightEnergy", "LightingReport", "LightPoint", "Loss", "Material",
    "OpacityPoint", "PairRays", "PairRequest", "Phong", "PixelFilter", "Placement", "PlanPoint", "PointLight", "RawLayout",
    "RayBatch", "RayRequest", "RayType", "RectangleLight", "Reopened", "SampleType", "Sampling", "ScatterAnswer", "ScatterEvent", "Shading",
    "SphereLight", "SumWords", "Ticket", "TransferFunction", "ValueRange", "View", "VoxelBox"
]

Array = NDArray[Any]
Vec3 = Sequence[float]
Colour = Sequence[float]


class Fidelity(Enum):
    """How a board emulates: values alone, or each cycle."""

    FUNCTIONAL = "functional"
    APPROXIMATE = "approximate"  # boards of 0.2 only
    CYCLE = "cycle"


class HostBuses(Enum):
    """Whether the boards of a group are on one PCI bus, which serves them in turn, or each has its own."""

    SHARED = "shared"
    OWN = "own"


class VoxelFormat(Enum):
    """What a card stores of a voxel: the paper's 36 bits, or a colour besides (Volume.colours)."""

    DENSITY = "density"
    RGB = "rgb"
    RGBA = "rgba"


class BackPressure(Enum):
    """What submit() does when open(max_rays=...) are under way: wait for the oldest batch, or raise WouldBlock."""

    WAIT = "wait"
    THROW = "throw"


class SampleType(Enum):
    """Of a volume's samples. UINT12 holds 0..4095 in 16 bits."""

    UINT8 = "uint8"
    UINT12 = "uint12"
    UINT16 = "uint16"
    INT16 = "int16"
    FLOAT32 = "float32"


class Bsdf(Enum):
    """How a material scatters rays (gicube/material.h has the formulas)."""

    NONE = "none"
    SPECULAR = "specular"
    DULL_REFLECTION = "dull_reflection"
    DULL_SCATTERING = "dull_scattering"
    ISOTROPIC = "isotropic"
    DIFFUSE = "diffuse"
    TRAP = "trap"


class PixelFilter(Enum):
    """How the rays of a pixel become its colour."""

    BOX = "box"
    TENT = "tent"


class Albedo(Enum):
    """LOW: rays deposit a part of their energy at each sample. HIGH: photons that deposit all of it once."""

    LOW = "low"
    HIGH = "high"


class EnergyRules(Enum):
    """AS_PRINTED: the paper's, which lose scattered energy. CONSERVING: what goes in comes out."""

    AS_PRINTED = "as_printed"
    CONSERVING = "conserving"


class RayType(Enum):
    """What is asked of the rays of a batch (gicube/ray.h)."""

    INTEGRATE = "integrate"
    FIRST_HIT = "first_hit"
    SEGMENT = "segment"
    OPACITY = "opacity"
    DEPOSIT = "deposit"
    INTEGRAL = "integral"
    BACKPROJECT = "backproject"


class SumWords(Enum):
    """Where rays of type BACKPROJECT leave what they carry."""

    IRRADIANCE = "irradiance"
    SUMS = "sums"


class ElementKind(Enum):
    """Of Board.pair_factors() (gicube/pair.h)."""

    PATCH = "patch"
    BOX = "box"
    TRIANGLE = "triangle"
    DISC = "disc"


class PairRays(Enum):
    """Who makes the rays between pairs. The results are the same to the bit; what crosses the bus is not."""

    BY_BOARD = "by_board"
    BY_HOST = "by_host"


class Loss(Enum):
    """Why a board was lost."""

    CLOSED = "closed"
    CORRUPTED = "corrupted"
    TIMED_OUT = "timed_out"
    TAKEN_OVER = "taken_over"
    ENDED = "ended"


FRESNEL_ROUTINE, HENYEY_GREENSTEIN_ROUTINE, TABULATED_ROUTINE = 0, 1, 2  # Material.routine, on every board
FIRST_USER_ROUTINE, HOST_ROUTINE = 8, 255


@dataclass
class ValueRange:
    """The map from values to the board's 12-bit density: round(4095 (v - low) / (high - low)), clamped."""

    low: float = 0.0
    high: float = 1.0


@dataclass
class VoxelBox:
    """The voxels low[axis] .. low[axis] + size[axis] - 1, axes x, y, z."""

    low: Sequence[int] = (0, 0, 0)
    size: Sequence[int] = (0, 0, 0)


@dataclass
class Placement:
    """Where a derived volume lies in the original: its voxel p is at low + edge p there."""

    low: Vec3 = (0.0, 0.0, 0.0)
    edge: float = 1.0


@dataclass
class RawLayout:
    """How the samples of a file without a header lie."""

    dims: Sequence[int] = (0, 0, 0)
    type: SampleType = SampleType.UINT8
    spacing: Vec3 = (1.0, 1.0, 1.0)
    big_endian: bool = False
    skip_bytes: int = 0


@dataclass
class ColourPoint:
    """At a volume's value: red, green, blue, 0..1, display-referred."""

    value: float = 0.0
    colour: Colour = (0.0, 0.0, 0.0)


@dataclass
class OpacityPoint:
    """At a volume's value: 0..1, of one voxel length."""

    value: float = 0.0
    opacity: float = 0.0


@dataclass
class TransferFunction:
    """Piecewise linear between its points, constant beyond. Points may be given as (value, (r, g, b)) and (value, opacity)."""

    colours: Sequence[Union[ColourPoint, Tuple[float, Colour]]] = field(default_factory=list)
    opacities: Sequence[Union[OpacityPoint, Tuple[float, float]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.colours = [p if isinstance(p, ColourPoint) else ColourPoint(*p) for p in self.colours]
        self.opacities = [p if isinstance(p, OpacityPoint) else OpacityPoint(*p) for p in self.opacities]

    def colour_at(self, value: float) -> Tuple[float, float, float]:
        """Raises BadArgument: no points."""
        return _core.colour_at(self, value)

    def opacity_at(self, value: float) -> float:
        return _core.opacity_at(self, value)


@dataclass
class Phong:
    """Coefficients of the reflectance map (gicube/shading.h)."""

    ambient: float = 0.25
    diffuse: float = 0.7
    specular: float = 0.35
    shininess: float = 24.0


@dataclass
class Shading:
    """`light`: towards the light; (0, 0, 0) is a head light."""

    phong: Phong = field(default_factory=Phong)
    light: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class Material:
    """How a material scatters rays (gicube/material.h). `scattering` is Ks, `gloss` beta of the dull kinds."""

    scattering: float = 0.0
    bsdf: Bsdf = Bsdf.NONE
    gloss: float = 0.0
    seen_through_scattering: bool = False
    routine: int = 0
    surface: bool = False
    parameters: Sequence[float] = field(default_factory=list)
    scattering_colour: Colour = (1.0, 1.0, 1.0)  # factors of Ks, on a board of three irradiance words


@dataclass
class CutPlane:
    """Points p with normal . p >= offset are kept; voxels."""

    normal: Vec3 = (0.0, 0.0, 0.0)
    offset: float = 0.0


@dataclass
class PointLight:
    """Positions in voxels; all lights of a pass in one unit of power."""

    position: Vec3 = (0.0, 0.0, 0.0)
    power: float = 1.0


@dataclass
class DirectionalLight:
    """`irradiance`: power on a unit area across the light."""

    towards: Vec3 = (0.0, 0.0, 0.0)
    irradiance: float = 1.0


@dataclass
class RectangleLight:
    """Shines to the side of edge_u x edge_v, by Lambert's law."""

    corner: Vec3 = (0.0, 0.0, 0.0)
    edge_u: Vec3 = (0.0, 0.0, 0.0)
    edge_v: Vec3 = (0.0, 0.0, 0.0)
    power: float = 1.0


@dataclass
class SphereLight:
    """Shines outward from its surface, by Lambert's law."""

    centre: Vec3 = (0.0, 0.0, 0.0)
    radius: float = 1.0
    power: float = 1.0


Light = Union[PointLight, DirectionalLight, RectangleLight, SphereLight]


@dataclass
class Lamp:
    """What scattered rays see where they leave the volume: a RectangleLight or a SphereLight, as bright as a white surface
    that all its power reaches, times `colour` (gicube/view.h)."""

    light: Light = field(default_factory=SphereLight)
    colour: Colour = (1.0, 1.0, 1.0)


@dataclass
class View:
    """What a picture is taken from: camera, image, sampling (gicube/view.h). Lengths in voxels, angles in degrees."""

    eye: Vec3 = (0.0, 0.0, 0.0)
    look_at: Vec3 = (0.0, 0.0, 0.0)
    up: Vec3 = (0.0, 1.0, 0.0)
    fov_degrees: float = 30.0
    orthographic_height: float = 0.0
    width: int = 512
    height: int = 512
    samples_per_axis: int = 1
    filter: PixelFilter = PixelFilter.BOX
    step: float = 0.5
    opacity_threshold: float = 0.98
    shade: bool = True
    jitter: bool = False
    leap: bool = True
    irradiance: bool = False
    incident: bool = False
    exposure: float = 0.0
    scatter: bool = False
    high_albedo: bool = False
    lifetime: int = 8
    seed: int = 0
    cut_planes: Sequence[CutPlane] = field(default_factory=list)
    lamps: Sequence[Lamp] = field(default_factory=list)


@dataclass
class Illumination:
    """How light is spread (gicube/illumination.h)."""

    albedo: Albedo = Albedo.LOW
    rules: EnergyRules = EnergyRules.CONSERVING
    rays_per_face_voxel: int = 1
    step: float = 0.5
    jitter: bool = False
    leap: bool = True
    lifetime: int = 32
    seed: int = 0
    light_colours: Sequence[Colour] = field(default_factory=list)  # of each light, on a board of three irradiance words


@dataclass
class LightEnergy:
    """Where the energy of one colour of light went."""

    emitted: float
    deposited: float
    escaped: float
    scattered_away: float
    given_up: float
    clipped: float


@dataclass
class LightingReport:
    """Where the energy went, in units of the lights' power: emitted = deposited + escaped + scattered_away + clipped.
    With three irradiance words sums over red, green and blue, which `colours` has one by one."""

    rays: int
    emitted: float
    deposited: float
    escaped: float
    escaped_by_face: Tuple[float, ...]  # x = 0, x = size - 1, y, y, z, z
    scattered_away: float
    given_up: float
    clipped: float
    unit: float
    warnings: Sequence[str]
    colours: Sequence[LightEnergy] = ()

    def standard_error(self, irradiance: ArrayLike) -> Any:
        """Error bars of a pass with Albedo.HIGH: of one voxel's irradiance (a bound there), of the sum over many, or of an array of them."""
        return np.sqrt(np.asarray(irradiance) * (self.emitted / self.rays if self.rays else 0.0))


@dataclass
class BoardTime:
    """Where the simulated time of one board of a group has gone, picoseconds; the parts sum to BoardGroup.now (gicube/board_group.h)."""

    bus: int  # its own transfers
    work: int  # what it did meanwhile without the bus
    bus_wait: int  # on a shared bus: for other boards' transfers
    skew: int  # done, until the last board was


@dataclass
class DepositReport:
    """What a batch of type BACKPROJECT left: kept + clipped in all."""

    rays: int
    samples: int
    kept: float
    clipped: float
    overflowed: int
    unit: float


@dataclass(frozen=True)
class FoundBoard:
    """A board that gicube.open(uri) could open (gicube/enumerate.h)."""

    uri: str
    process: int
    product: str
    version: str
    in_use: bool
    owner: str


@dataclass
class Sampling:
    """How rays are sampled, as the fields of View of the same names (gicube/ray.h)."""

    jitter: bool = False
    cut_planes: Sequence[CutPlane] = field(default_factory=list)
    seed: int = 0
    opacity_threshold: float = 0.98
    shade: bool = True
    irradiance: bool = False
    incident: bool = False
    exposure: float = 0.0
    scatter: bool = False
    high_albedo: bool = False
    lifetime: int = 8
    looking: Vec3 = (0.0, 0.0, 1.0)

    @classmethod
    def of(cls, view: View) -> "Sampling":
        """That of the view's own rays."""
        same = {each.name: getattr(view, each.name) for each in fields(cls) if each.name != "looking"}
        x, y, z = (float(b) - float(a) for a, b in zip(view.eye, view.look_at))
        return cls(**same, looking=(x, y, z)) if (x, y, z) != (0, 0, 0) else cls(**same)


@dataclass
class RayRequest:
    """What is asked of the rays of a batch (gicube/ray.h)."""

    type: RayType = RayType.INTEGRATE
    opacity: float = 1.0
    albedo: Albedo = Albedo.LOW
    rules: EnergyRules = EnergyRules.CONSERVING
    lifetime: int = 32
    words: SumWords = SumWords.SUMS
    step: float = 0.5
    leap: bool = True
    sampling: Sampling = field(default_factory=Sampling)


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


@dataclass
class PairRequest:
    """Rays for each pair, and how they are sampled (gicube/pair.h)."""

    rays: int = 16
    first: int = 0
    seed: int = 0
    opacity: float = 1.0
    step: float = 0.5
    leap: bool = True
    made: PairRays = PairRays.BY_BOARD


@dataclass
class BoardInfo:
    """What the board said of itself when it was opened (gicube/board.h)."""

    protocol_major: int
    protocol_minor: int
    fidelity: Fidelity
    processors: int
    block_voxels: int
    max_volume_voxels: int
    queue_rays: int
    core_khz: int
    config_hash: int
    vendor_id: int
    device_id: int
    wide: bool
    agp: bool
    host_rays: bool
    voxel_format: VoxelFormat
    irradiance_words: int  # of a voxel: 1, or 3 for red, green and blue


@dataclass
class Reopened:
    """What Board.reopen() found: whether the same session goes on, and whether there is a volume on the board."""

    resumed: bool
    volume: bool


@dataclass
class BrickDetail:
    """Of the last picture of a volume that the card does not store whole (Board.set_brick_detail())."""

    blocks: Tuple[int, int, int, int]
    """On the card: as they are, and in cells of 2^3, 4^3 and 8^3 voxels."""
    largest_density: float
    """By which a sample's density can be wrong, 4095 = the value range: a bound."""
    largest_opacity: float
    """And its opacity of one voxel length, 0..1, the worst tag: a bound."""


@dataclass
class LevelError:
    """How far a coarser volume is from its original (gicube/level_of_detail.h)."""

    largest_density: float
    rms_density: float
    largest_opacity: float


@dataclass
class PlanPoint:
    """One setting of a picture's plan, and what its pilot showed (gicube/plan.h)."""

    level: int
    step: float
    opacity_threshold: float
    error: float
    error_bound: float
    samples: float
    time: int
    pilot_width: int
    pilot_height: int


@dataclass
class LightPoint:
    """One setting of a plan of light, and what passes of it showed (gicube/light_plan.h)."""

    albedo: Albedo
    step: float
    rays_per_face_voxel: int
    error: float
    error_bound: float
    noise: float
    bias: float
    rays: float
    samples: float
    time: int


@dataclass
class ScatterEvent:
    """What a routine of the application learns of a ray that met its material (gicube/scattering.h)."""

    position: Tuple[float, float, float]
    direction: Tuple[float, float, float]
    normal: Tuple[float, float, float]
    opacity: float
    density: float
    tag: int
    lighting: bool
    generation: int
    random: Tuple[float, float, float, float]
    parameters: Sequence[float] = ()  # Material.parameters, float32


@dataclass
class ScatterAnswer:
    """In which direction the ray goes on, and with which share of its energy."""

    direction: Vec3 = (0.0, 0.0, 0.0)
    passes: float = 1.0


@dataclass
class AnsweredCommand:
    """Commands of one kind that a level answered (gicube/fidelity.h)."""

    command: str
    count: int


@dataclass
class LevelReport:
    """What a fidelity level answered, and what its figures leave out (gicube/fidelity.h)."""

    level: Fidelity
    answered: Sequence[AnsweredCommand]
    not_modelled: Sequence[str]
