"""Records and enumerations of the driver, with the comments of the C++ headers that each class names.

Positions are (x, y, z) in voxels; voxel (0, 0, 0) has its centre at the origin. Arrays over voxels are indexed
[z, y, x].
Times are simulated, in picoseconds.
"""

# Written by script/records from the public headers: change those.

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Optional, Sequence, Tuple, Union

from gicube import record_calls
from gicube.record_calls import *
from gicube.record_calls import Array as Array, Colour as Colour, Record as Record, Vec3 as Vec3
from gicube.record_calls import LightingReportCalls, SamplingCalls, TransferFunctionCalls

__all__ = [
    "Albedo", "AnsweredCommand", "BackPressure", "BoardInfo", "BoardTime", "BrickDetail", "Bsdf", "ColourPoint",
    "CutPlane", "DepositReport", "DirectionalLight", "ElementKind", "EnergyRules", "Fidelity", "FoundBoard",
    "HostBuses", "Illumination", "Lamp", "LevelError", "LevelReport", "Light", "LightEnergy", "LightPoint",
    "LightingReport", "Loss", "Material", "OpacityPoint", "PairRays", "PairRequest", "Phong", "PixelFilter",
    "Placement", "PlanPoint", "PointLight", "RawLayout", "RayRequest", "RayType", "RectangleLight", "Reopened",
    "SampleType", "Sampling", "ScatterAnswer", "ScatterEvent", "Shading", "SphereLight", "SumWords", "TransferFunction",
    "ValueRange", "View", "VoxelBox", "VoxelFormat", "WorldAxes", "WorldPlacement"
]
__all__ += record_calls.__all__


class Fidelity(Enum):
    """See gicube/board.h."""
    FUNCTIONAL = "functional"
    APPROXIMATE = "approximate"
    CYCLE = "cycle"


class HostBuses(Enum):
    """See gicube/board_group.h."""
    SHARED = "shared"
    """all boards are on one PCI bus, which serves them in turn"""
    OWN = "own"
    """each has a bus of its own"""


class VoxelFormat(Enum):
    """The voxels that the card stores (asic.voxel_format): the paper's 36 bits, or also a colour (Volume.colours). See
    gicube/board.h."""
    DENSITY = "density"
    RGB = "rgb"
    RGBA = "rgba"


class BackPressure(Enum):
    """Behaviour of submit() when OpenOptions.max_rays are under way. See gicube/board.h."""
    WAIT = "wait"
    """the simulated host waits for the oldest batch to complete"""
    THROW = "throw"
    """throws WouldBlock, and nothing is sent"""


class SampleType(Enum):
    """Samples are in the machine's byte order; UINT12 holds 0..4095 in 16 bits. See gicube/volume.h."""
    UINT8 = "uint8"
    UINT12 = "uint12"
    UINT16 = "uint16"
    INT16 = "int16"
    FLOAT32 = "float32"


class Bsdf(Enum):
    """A ray of direction D that interacts with a material of normal N (against the gradient, facing the ray) goes on
    along
      NONE           D: it is not scattered
      SPECULAR       R, the mirror image of -D about N
      DULL_REFLECTION (R + gloss d) / |R + gloss d|, d a random direction
      DULL_SCATTERING (D + gloss d) / |D + gloss d|
      ISOTROPIC      d
      DIFFUSE        (N + d) / |N + d|: radiance alike in all directions of the half space (Lambert)
      TRAP           by a routine: on the board's DSP, or in the application. See gicube/material.h."""
    NONE = "none"
    SPECULAR = "specular"
    DULL_REFLECTION = "dull_reflection"
    DULL_SCATTERING = "dull_scattering"
    ISOTROPIC = "isotropic"
    DIFFUSE = "diffuse"
    TRAP = "trap"


class PixelFilter(Enum):
    """See gicube/view.h."""
    BOX = "box"
    TENT = "tent"


class Albedo(Enum):
    """LOW: every ray deposits a part of its energy at each sample. HIGH: rays are photons that deposit all of it once.
    See gicube/illumination.h."""
    LOW = "low"
    HIGH = "high"


class EnergyRules(Enum):
    """AS_PRINTED: the paper's own rules, which lose scattered energy and count a point light four times. CONSERVING:
    energy is conserved (docs/reference/hardware.md, H901). See gicube/illumination.h."""
    AS_PRINTED = "as_printed"
    CONSERVING = "conserving"


class RayType(Enum):
    """The task of a batch's rays. See gicube/ray.h."""
    INTEGRATE = "integrate"
    """Colour and opacity from its position until it leaves the volume, meets a cut plane, or has
    Sampling.opacity_threshold. Scattered if Sampling.scatter says so. With jitter."""
    FIRST_HIT = "first_hit"
    """Until the opacity that it has gathered reaches RayRequest.opacity: its position is then that of the sample which
    brought it there, and its opacity at least that. A ray with less has hit nothing and ends where it left the volume
    or met a cut plane. No colour. With jitter."""
    SEGMENT = "segment"
    """Colour and opacity between two points, `length` apart, or up to the first sample at which RayRequest.opacity is
    reached. Its own step divides the length evenly, at most RayRequest.step, and it samples the middle of each: so both
    directions see the same samples. Neither jitter nor cut planes."""
    OPACITY = "opacity"
    """Like SEGMENT without colour: the transmittance between two points is 1 - opacity."""
    DEPOSIT = "deposit"
    """Distributes its energy into the irradiance words on its way (docs/reference/hardware.md, Global illumination), by
    RayRequest.albedo and rules. No ray comes back; BatchReport.lighting says where the energy went."""
    INTEGRAL = "integral"
    """The line integral of the volume's values less ValueRange.low between two points, lengths in the unit of
    Volume.spacing. Sampled as SEGMENT; opacities, empty blocks, jitter and cut planes don't matter. It may end outside
    of the volume, but must begin inside like every ray: use clip_to_volume() for sources outside."""
    BACKPROJECT = "backproject"
    """Adds `energy` for each unit of length to the voxels along its way from one point to another. The ray loses
    nothing by that. RayRequest.words says to which words; no ray comes back."""


class SumWords(Enum):
    """The words to which rays of type BACKPROJECT add. See gicube/ray.h."""
    IRRADIANCE = "irradiance"
    """what read_irradiance() reads: not negative, 11 bits or 32 on the wide datapath, by clear_irradiance()"""
    SUMS = "sums"
    """the whole 36-bit words: signed sums of whole units, by clear_sums() and read_sums()"""


class ElementKind(Enum):
    """Flat elements have their front to the side of u x v. See gicube/pair.h."""
    PATCH = "patch"
    """a parallelogram: origin + s u + t v, 0..1 each"""
    BOX = "box"
    """origin + s u + t v + r w: a part of the volume"""
    TRIANGLE = "triangle"
    """with the corners origin, origin + u, origin + v"""
    DISC = "disc"
    """origin + s u + t v, s^2 + t^2 <= 1: about its centre, with the half-axes u and v; a circle or an ellipse. For
    rings and sectors: w.x is the hole's share of the area, and w.y the missing share of the turn, which begins at u and
    goes towards v; each 0 or more and below 1. {} is a whole disc."""


class PairRays(Enum):
    """Maker of the rays. The results have the same bits; the bytes on the bus differ. See gicube/pair.h."""
    BY_BOARD = "by_board"
    """The DSP: 12 bytes per pair and 56 per element down, 16 per pair up; like BY_HOST with boards of version 0.1."""
    BY_HOST = "by_host"
    """the application's processor, as rays of type OPACITY: 32 bytes per ray each way"""


class Loss(Enum):
    """See gicube/error.h."""
    CLOSED = "closed"
    """the board's process ended, or the connection did"""
    CORRUPTED = "corrupted"
    """a frame was damaged, or one is missing"""
    TIMED_OUT = "timed_out"
    """the watchdog expired; the call that it ended has thrown TimedOut"""
    TAKEN_OVER = "taken_over"
    """another client took the board by force"""
    ENDED = "ended"
    """The board ended the session: it shuts down, was reset by management, or received a faulty frame. Or the driver
    ended it, because its capture could not be written."""


class WorldAxes(Enum):
    """See gicube/scene/volume_file.h."""
    NONE = "none"
    """the file gives no directions of its axes"""
    WORLD = "world"
    """x, y, z of some space, with no patient in it"""
    PATIENT = "patient"
    """x to the patient's left, y to the back, z to the head (LPS)"""


@dataclass
class ValueRange(Record):
    """The map from values to the board's 12-bit density: round(4095 (v - low) / (high - low)), clamped. Low < high,
    both finite. See gicube/volume.h."""
    low: float = 0.0
    high: float = 1.0


@dataclass
class VoxelBox(Record):
    """A box of voxels: low[axis] .. low[axis] + size[axis] - 1. See gicube/volume.h."""
    low: Sequence[int] = (0, 0, 0)
    size: Sequence[int] = (0, 0, 0)
    """at least 1 each"""


@dataclass
class Placement(Record):
    """Where a derived volume lies in the original: its voxel p is at low + edge p there. See gicube/level_of_detail.h.
    """
    low: Vec3 = (0.0, 0.0, 0.0)
    edge: float = 1.0
    """of one of its voxels, in the original's"""


@dataclass
class WorldPlacement(Record):
    """Where a volume lies in the world of its file: voxel p is at origin + the sum of p[i] * spacing[i] *
    directions[i]. See gicube/scene/volume_file.h."""
    axes: WorldAxes = WorldAxes.NONE
    directions: Sequence[Vec3] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    """unit vectors of the volume's x, y, z in the world"""
    origin: Vec3 = (0.0, 0.0, 0.0)
    """the first voxel's centre in the world, in the file's unit of length"""
    stored: Sequence[int] = (1, 2, 3)
    """the file's axis, from 1, along the volume's x, y, z; negative: it runs the other way"""


@dataclass
class RawLayout(Record):
    """The layout of a file without a header. See gicube/scene/volume_file.h."""
    dims: Sequence[int] = (0, 0, 0)
    type: SampleType = SampleType.UINT8
    """UINT12: 0..4095 in 16 bits"""
    spacing: Vec3 = (1.0, 1.0, 1.0)
    big_endian: bool = False
    skip_bytes: int = 0
    """before the first sample"""


@dataclass
class ColourPoint(Record):
    """A colour at a value. See gicube/transfer_function.h."""
    value: float = 0.0
    """in the volume's own values"""
    colour: Colour = (0.0, 0.0, 0.0)


@dataclass
class OpacityPoint(Record):
    """An opacity at a value. See gicube/transfer_function.h."""
    value: float = 0.0
    opacity: float = 0.0
    """0..1, of one voxel length (the smallest voxel edge of an anisotropic volume)"""


@dataclass
class TransferFunction(TransferFunctionCalls, Record):
    """Piecewise linear between its points, constant beyond the first and the last. Values must rise strictly, except
    that two points may share one value: a step, which takes the second's side. See gicube/transfer_function.h."""
    colours: Sequence[Union[ColourPoint, Tuple[float, Colour]]] = field(default_factory=list)
    """at least one, unless all opacities are 0"""
    opacities: Sequence[Union[OpacityPoint, Tuple[float, float]]] = field(default_factory=list)
    """at least one"""


@dataclass
class Phong(Record):
    """Shade(normal) = ambient + diffuse max(N.L, 0) + specular s(N.L) max(R.V, 0)^shininess, R the reflected light
    direction, V towards the eye; s fades the highlight in over 0 <= N.L <= 0.1, so that the terminator has no hard
    edge. The part of a shade above ambient + diffuse is a highlight and goes to white. A sample without a gradient is
    not shaded. See gicube/shading.h."""
    ambient: float = 0.25
    """each 0..1.99; ambient + diffuse at most 1.99, diffuse + specular at most 1.99"""
    diffuse: float = 0.7
    specular: float = 0.35
    shininess: float = 24.0
    """1..1000"""


@dataclass
class Shading(Record):
    """Local illumination by one light. See gicube/shading.h."""
    phong: Phong = field(default_factory=Phong)
    light: Vec3 = (0.0, 0.0, 0.0)
    """From the scene towards the light, physical axes (parallel to the voxel axes); any length but 0. The zero vector
    stands for a head light: at the eye."""


@dataclass
class Material(Record):
    """How a material scatters rays. See gicube/material.h."""
    scattering: float = 0.0
    """Ks, the share of an interaction that is scattered and not absorbed; 0..1"""
    bsdf: Bsdf = Bsdf.NONE
    gloss: float = 0.0
    """beta of the dull kinds: 0 is sharp; 0..15.99"""
    seen_through_scattering: bool = False
    """Rendering rays are scattered here too (View.scatter). Mirrors, glossy surfaces and glass; the other materials
    show the irradiance that they hold."""
    routine: int = 0
    """TRAP only"""
    surface: bool = False
    """TRAP only: a ray that was scattered passes until it has left the surface"""
    parameters: Sequence[float] = field(default_factory=list)
    """TRAP only: at most 32, for the routine"""
    scattering_colour: Colour = (1.0, 1.0, 1.0)
    """Factors of `scattering` for red, green and blue of lighting rays, 0..1; other than white only on a board of three
    irradiance words (BoardInfo.irradiance_words). Rendering rays are scattered as the colour that is scattered most."""


@dataclass
class CutPlane(Record):
    """Points p, in voxels, with normal . p >= offset are kept. See gicube/view.h."""
    normal: Vec3 = (0.0, 0.0, 0.0)
    """any length but 0"""
    offset: float = 0.0


@dataclass
class PointLight(Record):
    """Positions in voxels, directions and lengths physical (in smallest voxel edges, axes parallel to the voxel axes).
    See gicube/illumination.h."""
    position: Vec3 = (0.0, 0.0, 0.0)
    """inside the volume or outside"""
    power: float = 1.0
    """> 0, all lights of a pass in one unit"""


@dataclass
class DirectionalLight(Record):
    """A distant light. See gicube/illumination.h."""
    towards: Vec3 = (0.0, 0.0, 0.0)
    """from the scene to the light; any length but 0"""
    irradiance: float = 1.0
    """> 0, power on a unit area across the light"""


@dataclass
class RectangleLight(Record):
    """Shines to the side of edge_u x edge_v, each point by Lambert's law. See gicube/illumination.h."""
    corner: Vec3 = (0.0, 0.0, 0.0)
    edge_u: Vec3 = (0.0, 0.0, 0.0)
    """physical; not parallel, not 0"""
    edge_v: Vec3 = (0.0, 0.0, 0.0)
    """physical; not parallel, not 0"""
    power: float = 1.0


@dataclass
class SphereLight(Record):
    """Shines outward from its surface, Lambert. See gicube/illumination.h."""
    centre: Vec3 = (0.0, 0.0, 0.0)
    radius: float = 1.0
    """physical, > 0"""
    power: float = 1.0


Light = Union[PointLight, DirectionalLight, RectangleLight, SphereLight]


@dataclass
class Lamp(Record):
    """A lamp that scattered rays see where they leave the volume, as in a mirror: a RectangleLight, from the side to
    which it shines, or a SphereLight, from outside. It is as bright as a white surface lit by its full power: power /
    area x exposure, of the view or the automatic one (without View.irradiance and without an exposure: x 1), times
    `colour`. It lights nothing: illuminate() does. See gicube/view.h."""
    light: Light = field(default_factory=SphereLight)
    colour: Colour = (1.0, 1.0, 1.0)
    """not below 0"""


@dataclass
class View(Record):
    """All positions in voxels of the volume; voxel (0, 0, 0) has its centre at the origin. Angles and lengths are seen
    in physical space, so a volume with anisotropic spacing keeps its shape.
     Irradiance is what voxels absorbed after illuminate() and rays of type DEPOSIT: a sample's brightness is then its
    word over (opacity (1 - Ks)). A field that an application wrote, such as a solution of radiosity, is shown as colour
    x irradiance x exposure with `incident`; nothing chooses its exposure. See gicube/view.h."""
    eye: Vec3 = (0.0, 0.0, 0.0)
    look_at: Vec3 = (0.0, 0.0, 0.0)
    """not at the eye"""
    up: Vec3 = (0.0, 1.0, 0.0)
    """not along the line of sight"""
    fov_degrees: float = 30.0
    """vertical, 0..180 exclusive; perspective only"""
    orthographic_height: float = 0.0
    """> 0: orthographic, the image's height in (smallest) voxel edges"""
    width: int = 512
    """pixels, 1..4095"""
    height: int = 512
    samples_per_axis: int = 1
    """1, 2 or 4: rays per pixel are its square"""
    filter: PixelFilter = PixelFilter.BOX
    step: float = 0.5
    """Voxels along the ray, 1/64..16, kept to 16 fraction bits. Without BoardInfo.wide each step is rounded to 2^-14
    voxel on every axis: steps with which positions could drift by more than a voxel over the volume are refused."""
    opacity_threshold: float = 0.98
    """0..1: a ray at or above it is done"""
    shade: bool = True
    jitter: bool = False
    leap: bool = True
    """over blocks whose empty flag is set"""
    irradiance: bool = False
    """lit by the irradiance that illuminate() left, instead of by the reflectance map"""
    incident: bool = False
    """the irradiance is what falls on a sample, not what it absorbed"""
    exposure: float = 0.0
    """irradiance only: brightness of one unit of irradiance; 0 = chosen by illuminate()"""
    scatter: bool = False
    """rays continue where a material scatters them (Material.seen_through_scattering)"""
    high_albedo: bool = False
    """colour is taken once, where the ray is absorbed: needs many rays per pixel"""
    lifetime: int = 8
    """scatterings until a ray is given up, 0..1023"""
    seed: int = 0
    """of the scatterings' random choices"""
    cut_planes: Sequence[CutPlane] = field(default_factory=list)
    """at most 6"""
    lamps: Sequence[Lamp] = field(default_factory=list)
    """With `scatter`: a ray that was scattered and leaves the volume, or by a cut plane, takes the light of the nearest
    in its way, times what it still lets through, and the pixel is opaque there. Rays straight from the eye see none,
    and nothing is seen of a lamp that is inside the volume. At most 32; needs a board of protocol 2.3."""


@dataclass
class Illumination(Record):
    """How light is spread. See gicube/illumination.h."""
    albedo: Albedo = Albedo.LOW
    rules: EnergyRules = EnergyRules.CONSERVING
    rays_per_face_voxel: int = 1
    """k, 1..4096: rays through each cell between four voxels of a face of the volume, (N - 1)^2 of them a face. A light
    inside sends rays through all six faces, one outside through those that it sees."""
    step: float = 0.5
    """voxels along the ray, 1/64..16; refused as View.step"""
    jitter: bool = False
    """of rays with the printed rules; the conserving ones don't depend on where samples lie"""
    leap: bool = True
    lifetime: int = 32
    """scatterings until a ray is given up, 0..1023"""
    seed: int = 0
    """of all random choices: another seed is an independent experiment"""
    light_colours: Sequence[Colour] = field(default_factory=list)
    """On a board of three irradiance words (BoardInfo.irradiance_words): factors of each light's power for red, green
    and blue, not all 0. Empty: all lights are white. One pass then spreads the three colours, with
    Material.scattering_colour."""


@dataclass
class LightEnergy(Record):
    """Energies of one colour of light, as in LightingReport. See gicube/illumination.h."""
    emitted: float = 0.0
    deposited: float = 0.0
    escaped: float = 0.0
    scattered_away: float = 0.0
    given_up: float = 0.0
    clipped: float = 0.0


@dataclass
class LightingReport(LightingReportCalls, Record):
    """The energy balance, in units of the lights' power (`unit` of it is one unit of the energy words). Exactly:
    emitted = deposited + escaped + scattered_away + clipped. With three irradiance words these are sums over red, green
    and blue. See gicube/illumination.h."""
    rays: int = 0
    emitted: float = 0.0
    """The energy of the rays: the light that meets the volume, not the lights' whole power unless they are inside. For
    point and distant lights that is exact, except for the rounding of each ray to whole units. Rays of a rectangle or a
    sphere begin at random points of it, so there it is an estimate, which another seed changes and more rays improve.
    """
    deposited: float = 0.0
    """into irradiance words"""
    escaped: float = 0.0
    """out of the volume"""
    escaped_by_face: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The escaped energy by face: x = 0, x = size - 1, y = 0, y = size - 1, z = 0, z = size - 1; the six sum to
    `escaped`. For a slab that is lit along z, the last two are its reflectance and its transmittance. At an edge or a
    corner, the face whose plane the ray crosses first counts; if it crosses several at once, the one of the first axis.
    Zero from boards of version 0.1."""
    scattered_away: float = 0.0
    """dropped by the printed rules, with rays given up, and by routines"""
    given_up: float = 0.0
    """of that, with rays at the end of their lifetime"""
    clipped: float = 0.0
    """did not fit saturated irradiance words"""
    unit: float = 0.0
    warnings: Sequence[str] = field(default_factory=list)
    """a light in a solid, much energy clipped, low albedo where scattering matters"""
    colours: Sequence[LightEnergy] = field(default_factory=list)
    """With three irradiance words: of red, green and blue, which sum to the above; else empty."""


@dataclass
class BoardTime(Record):
    """Where the simulated time of a board has gone. The parts add up to BoardGroup.now(). See gicube/board_group.h."""
    bus: int = 0
    """its own transfers"""
    work: int = 0
    """what it did meanwhile without the bus: DSP, ASIC, and what the host did for it alone"""
    bus_wait: int = 0
    """on a shared bus: for other boards' transfers"""
    skew: int = 0
    """done, until the last board was"""


@dataclass
class DepositReport(Record):
    """The sums of a batch of type BACKPROJECT: kept + clipped in all. See gicube/ray.h."""
    rays: int = 0
    samples: int = 0
    kept: float = 0.0
    """in the units of HostRay.energy times length"""
    clipped: float = 0.0
    """by words that were full: the words read back are wrong by that much"""
    overflowed: int = 0
    """sums that were full; every command that would change one further counts it again"""
    unit: float = 0.0
    """of one unit of the words"""


@dataclass(frozen=True)
class FoundBoard(Record):
    """A board that a program could open. See gicube/enumerate.h."""
    uri: str = ""
    """for Board.open()"""
    process: int = 0
    """the id of its gicube-board; 0: a PCI function, without version and owner"""
    product: str = ""
    """the board's product name"""
    version: str = ""
    """of its program"""
    in_use: bool = False
    """a session owns it"""
    owner: str = ""
    """which, and since when; empty: none"""


@dataclass
class Sampling(SamplingCalls, Record):
    """How rays are sampled, as the fields of View of the same names; step and leaping are RayRequest's. sampling_of()
    takes it from a view. See gicube/ray.h."""
    jitter: bool = False
    cut_planes: Sequence[CutPlane] = field(default_factory=list)
    """at most 6"""
    seed: int = 0
    """of scatterings' and deposits' random choices"""
    opacity_threshold: float = 0.98
    """INTEGRATE, SEGMENT; the threshold, scattering and its lifetime of INTEGRATE only."""
    shade: bool = True
    irradiance: bool = False
    incident: bool = False
    exposure: float = 0.0
    scatter: bool = False
    high_albedo: bool = False
    lifetime: int = 8
    looking: Vec3 = (0.0, 0.0, 1.0)
    """from the eye into the volume, voxels, any length but 0: highlights are those that it sees"""


@dataclass
class RayRequest(Record):
    """The request for the rays of a batch. See gicube/ray.h."""
    type: RayType = RayType.INTEGRATE
    opacity: float = 1.0
    """FIRST_HIT, SEGMENT, OPACITY: > 0..1"""
    albedo: Albedo = Albedo.LOW
    """DEPOSIT, as in Illumination:"""
    rules: EnergyRules = EnergyRules.CONSERVING
    lifetime: int = 32
    words: SumWords = SumWords.SUMS
    """BACKPROJECT"""
    step: float = 0.5
    """voxels between samples, 1/64..16; refused as View.step"""
    leap: bool = True
    """over blocks whose empty flag is set; INTEGRAL, BACKPROJECT never do"""
    sampling: Sampling = field(default_factory=Sampling)


@dataclass
class PairRequest(Record):
    """Rays for each pair, and how they are sampled. See gicube/pair.h."""
    rays: int = 16
    """For each pair, 1..65536; any number of them fills both elements evenly. The parts of a near pair share them: none
    has more, and some have a few less."""
    first: int = 0
    """the first sample: one that no earlier request has used, if that ended before it"""
    seed: int = 0
    opacity: float = 1.0
    """> 0..1: a ray that has gathered that much ends"""
    step: float = 0.5
    """voxels between samples, 1/64..16; refused as View.step"""
    leap: bool = True
    """over blocks whose empty flag is set"""
    made: PairRays = PairRays.BY_BOARD


@dataclass
class BoardInfo(Record):
    """Properties that the board reported when it was opened. See gicube/board.h."""
    protocol_major: int = 0
    protocol_minor: int = 0
    """the smaller of both sides"""
    fidelity: Fidelity = Fidelity.FUNCTIONAL
    processors: int = 0
    block_voxels: int = 0
    """n, voxels"""
    max_volume_voxels: int = 0
    """N: the card stores the blocks of N^3 voxels"""
    queue_rays: int = 0
    core_khz: int = 0
    config_hash: int = 0
    """of the board's resolved configuration"""
    vendor_id: int = 0
    """PCI configuration space"""
    device_id: int = 0
    wide: bool = False
    """the wide datapath (asic.datapath)"""
    agp: bool = False
    """the card has an AGP capability"""
    host_rays: bool = False
    """submit() is offered"""
    voxel_format: VoxelFormat = VoxelFormat.DENSITY
    irradiance_words: int = 1
    """of a voxel (asic.irradiance_words): 1, or 3 for red, green and blue"""


@dataclass
class Reopened(Record):
    """The result of Board.reopen(). See gicube/board.h."""
    resumed: bool = False
    """the same session continues: nothing was lost"""
    volume: bool = False
    """there is a volume on the board"""


@dataclass
class BrickDetail(Record):
    """Detail of the last picture of a volume in bricks (Board.set_brick_detail()). See gicube/level_of_detail.h."""
    blocks: Sequence[int] = (0, 0, 0, 0)
    """on the card: as they are, and in cells of 2^3, 4^3 and 8^3 voxels"""
    largest_density: float = 0.0
    """by which a sample's density can be wrong, 4095 = the value range: a bound"""
    largest_opacity: float = 0.0
    """and its opacity of one voxel length, 0..1, the worst tag: a bound"""


@dataclass
class LevelError(Record):
    """The difference of a coarser volume from its original. See gicube/level_of_detail.h."""
    largest_density: float = 0.0
    """at any point between voxels, in density units (4095 = the value range): a bound"""
    rms_density: float = 0.0
    """over the points where either can change slope: voxels, and the middles between them"""
    largest_opacity: float = 0.0
    """Largest error of a sample's opacity of one original voxel length, 0..1, for values that differ by
    largest_density, the worst tag: a bound, reached where something is thinner than a coarse voxel."""


@dataclass
class PlanPoint(Record):
    """One setting, and what its pilot showed. See gicube/plan.h."""
    level: int = 0
    step: float = 0.0
    """voxels of that level"""
    opacity_threshold: float = 0.0
    error: float = 0.0
    """as found in the pilot"""
    error_bound: float = 0.0
    """see Plan"""
    samples: float = 0.0
    """predicted, of the whole picture"""
    time: int = 0
    """Predicted for it; that of Plan.chosen was simulated. 0 where the board's fidelity level keeps no time in its
    pipelines."""
    pilot_width: int = 0
    pilot_height: int = 0


@dataclass
class LightPoint(Record):
    """One setting, and what two passes of it showed, or what other passes predict. See gicube/light_plan.h."""
    albedo: Albedo = Albedo.LOW
    step: float = 0.0
    rays_per_face_voxel: int = 0
    error: float = 0.0
    """both of the following together"""
    error_bound: float = 0.0
    """both of the following together"""
    noise: float = 0.0
    bias: float = 0.0
    rays: float = 0.0
    """of a pass"""
    samples: float = 0.0
    """of a pass"""
    time: int = 0
    """0 where the board's fidelity level keeps no time in its pipelines"""


@dataclass
class ScatterEvent(Record):
    """Directions are unit vectors in physical space (axes parallel to the voxel axes). See gicube/scattering.h."""
    position: Vec3 = (0.0, 0.0, 0.0)
    """voxels"""
    direction: Vec3 = (0.0, 0.0, 0.0)
    """in which the ray travels"""
    normal: Vec3 = (0.0, 0.0, 0.0)
    """against the density's gradient, away from dense matter; zero where there is no gradient"""
    opacity: float = 0.0
    """of one voxel length of the material there, 0..1"""
    density: float = 0.0
    """0..4095, the board's (Board.value_range() maps values to it)"""
    tag: int = 0
    lighting: bool = False
    """a lighting ray, which carries energy from a light; else one from the eye"""
    generation: int = 0
    """how often the ray was scattered before, at most 15"""
    random: Sequence[float] = (0.0, 0.0, 0.0, 0.0)
    """even in [0, 1), of this event alone: the only randomness that pictures repeat with"""
    parameters: Sequence[float] = field(default_factory=list)
    """Material.parameters; lives as long as the call"""


@dataclass
class ScatterAnswer(Record):
    """The outcome of a scattering. See gicube/scattering.h."""
    direction: Vec3 = (0.0, 0.0, 0.0)
    """in which the ray continues; physical, of a length from 1e-6 to 1e6"""
    passes: float = 1.0
    """the share of its energy, or of what it can still gather, that continues: 0..1"""


@dataclass
class AnsweredCommand(Record):
    """How many commands of a kind a level answered. See gicube/fidelity.h."""
    command: str = ""
    """"render", "trace", "illuminate", "resume", "pairs", "continue"; empty: the board does not report it."""
    count: int = 0


@dataclass
class LevelReport(Record):
    """The commands of a level, and the parts that it omits. See gicube/fidelity.h."""
    level: Fidelity = Fidelity.FUNCTIONAL
    answered: Sequence[AnsweredCommand] = field(default_factory=list)
    not_modelled: Sequence[str] = field(default_factory=list)
    """at that level: docs/reference/hardware.md"""
