"""The compiled part. Its Board and its functions are called by the package's own modules, which document them and say their types."""

from typing import Any, Final, List, Optional, Tuple

from gicube.records import Fidelity, Illumination, LevelError, LevelReport, Light, LightPoint, Material, Placement, PlanPoint, Shading
from gicube.records import TransferFunction, View, VoxelBox
from gicube.volume import Volume

__version__: str

class Plan:
    """What make_plan() found (gicube/plan.h)."""

    chosen: Final[PlanPoint]
    best: Final[PlanPoint]
    finest: Final[PlanPoint]
    kept: Final[bool]
    points: Final[List[PlanPoint]]
    placement: Final[Placement]
    dims: Final[Tuple[int, int, int]]
    original_dims: Final[Tuple[int, int, int]]
    box: Final[VoxelBox]
    gradients: Final[bool]
    voxels_a_pixel: Final[float]
    level_for_pixels: Final[int]
    level_errors: Final[List[LevelError]]
    fidelity: Final[Fidelity]
    pilots: Final[int]
    pilot_samples: Final[float]
    pilot_host_seconds: Final[float]
    def view(self, original: View) -> View:
        """The caller's view, with the plan's settings, for the volume on the board."""
    def explain(self) -> List[str]:
        """What was chosen, why, and what it saves; lines for people."""

class LightPlan:
    """What plan_light() found (gicube/light_plan.h)."""

    chosen: Final[LightPoint]
    asked: Final[LightPoint]
    kept: Final[bool]
    at_limit: Final[bool]
    points: Final[List[LightPoint]]
    passes: Final[int]
    pass_samples: Final[float]
    host_seconds: Final[float]
    channel: Final[int]
    def settings(self, original: Illumination) -> Illumination: ...
    def explain(self) -> List[str]: ...

class SceneSetup:
    """A scene as voxels, ready for a board. Its volume's arrays are read-only views of its memory."""

    volume: Final[Volume]
    looks: Final[List[TransferFunction]]
    materials: Final[List[Material]]
    shading: Final[Shading]
    lights: Final[List[Light]]
    is_lit: Final[bool]
    illumination: Final[Illumination]
    view: Final[View]
    background: Final[Optional[Tuple[float, float, float]]]
    scattering_colours: Final[List[Tuple[float, float, float]]]  # by tag
    emissions: Final[List[Tuple[float, float, float]]]  # by tag: power of a unit of area, or of a fog's volume
    light_colours: Final[List[Tuple[float, float, float]]]
    light_has_colours: Final[bool]
    def load(self, board: Any, own_codebook: bool, progress: Any) -> None: ...

class Scene:
    """A scene as a user asked for one."""

    cameras: Final[List[str]]
    view: View
    def at_time(self, seconds: float) -> "Scene":
        """The scene with all its engines' values of that time."""
    def choose_camera(self, name: str) -> None: ...
    def allow_outside(self) -> None:
        """Headers of its volumes may name data files in other folders."""
    def get(self, target: str) -> float:
        """The number of this name, as "camera.eye.x" or "node[ring].transform[0].rotate.degrees" (gicube/scene/engine.h)."""
    def set(self, target: str, value: float) -> None: ...
    def set_up(self, threads: int = ...) -> SceneSetup:
        """Reads or makes the volume and completes what the scene leaves open. Raises InputError, FileError."""

def clip_to_volume(rays: Any, dims: Any) -> Any: ...
def colour_at(look: Any, value: float) -> Any: ...
def opacity_at(look: Any, value: float) -> Any: ...
def fidelity_report(counters: List[Tuple[str, str, int]]) -> List[LevelReport]: ...
def __getattr__(name: str) -> Any: ...
