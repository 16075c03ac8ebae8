"""GI-Cube: a volumetric ray tracing board, emulated, from Python.

    import gicube

    volume = gicube.read_volume("head.nrrd")
    look = gicube.transfer_function("ct-bone", volume)
    with gicube.open("emu:?fidelity=cycle") as board:
        board.load_volume(volume)
        board.set_transfer_function(look)
        board.render(gicube.fit_view(volume, [look])).save("head.png")
        print(board.now, "ps of simulated time")

Positions are (x, y, z) in voxels, arrays over voxels are indexed [z, y, x], times are simulated picoseconds.
"""

from gicube._core import LightPlan as LightPlan
from gicube._core import Plan as Plan
from gicube._core import Scene as Scene
from gicube._core import SceneSetup as SceneSetup
from gicube._core import __version__ as __version__
from gicube.arrays import (
    ELEMENT as ELEMENT,
    ELEMENT_PAIR as ELEMENT_PAIR,
    PAIR_FACTOR as PAIR_FACTOR,
    PIXEL as PIXEL,
    RAY as RAY,
    TRACED_RAY as TRACED_RAY,
    clip_to_volume as clip_to_volume,
    elements as elements,
    pairs as pairs,
    rays as rays,
    rays_between as rays_between,
)
from gicube.board import (
    NO_DEADLINE as NO_DEADLINE,
    Board as Board,
    Future as Future,
    open as open,
)
from gicube.counters import Counters as Counters
from gicube.errors import (
    BadArgument as BadArgument,
    BoardBusy as BoardBusy,
    DeadlinePassed as DeadlinePassed,
    DeviceLost as DeviceLost,
    Error as Error,
    Fault as Fault,
    FileError as FileError,
    InputError as InputError,
    MemoryFault as MemoryFault,
    OpenFailed as OpenFailed,
    Rejected as Rejected,
    ScatteringFailed as ScatteringFailed,
    TimedOut as TimedOut,
    Unsupported as Unsupported,
    VersionMismatch as VersionMismatch,
    WouldBlock as WouldBlock,
)
from gicube.image import Image as Image
from gicube.records import (
    FIRST_USER_ROUTINE as FIRST_USER_ROUTINE,
    FRESNEL_ROUTINE as FRESNEL_ROUTINE,
    HENYEY_GREENSTEIN_ROUTINE as HENYEY_GREENSTEIN_ROUTINE,
    HOST_ROUTINE as HOST_ROUTINE,
    TABULATED_ROUTINE as TABULATED_ROUTINE,
    Albedo as Albedo,
    BackPressure as BackPressure,
    BoardInfo as BoardInfo,
    Bsdf as Bsdf,
    ColourPoint as ColourPoint,
    CutPlane as CutPlane,
    DepositReport as DepositReport,
    DirectionalLight as DirectionalLight,
    ElementKind as ElementKind,
    EnergyRules as EnergyRules,
    Fidelity as Fidelity,
    Illumination as Illumination,
    LevelError as LevelError,
    Light as Light,
    LightingReport as LightingReport,
    LightPoint as LightPoint,
    Loss as Loss,
    Material as Material,
    OpacityPoint as OpacityPoint,
    PairRays as PairRays,
    PairRequest as PairRequest,
    Phong as Phong,
    PixelFilter as PixelFilter,
    Placement as Placement,
    PlanPoint as PlanPoint,
    PointLight as PointLight,
    RawLayout as RawLayout,
    RayBatch as RayBatch,
    RayRequest as RayRequest,
    RayType as RayType,
    RectangleLight as RectangleLight,
    Reopened as Reopened,
    SampleType as SampleType,
    ScatterAnswer as ScatterAnswer,
    ScatterEvent as ScatterEvent,
    Shading as Shading,
    SphereLight as SphereLight,
    SumWords as SumWords,
    Ticket as Ticket,
    TransferFunction as TransferFunction,
    ValueRange as ValueRange,
    View as View,
    Volume as Volume,
    VoxelBox as VoxelBox,
)
from gicube.scenes import (
    coarser as coarser,
    cropped as cropped,
    fit_view as fit_view,
    left_for_picture as left_for_picture,
    level_error as level_error,
    level_for as level_for,
    load_planned as load_planned,
    load_scene as load_scene,
    make_plan as make_plan,
    parse_scene as parse_scene,
    placed_look as placed_look,
    placed_view as placed_view,
    plan_light as plan_light,
    presets as presets,
    read_scene as read_scene,
    read_volume as read_volume,
    share_of_light as share_of_light,
    transfer_function as transfer_function,
    value_range as value_range,
    visible_box as visible_box,
    voxels_a_pixel as voxels_a_pixel,
    write_volume as write_volume,
)
