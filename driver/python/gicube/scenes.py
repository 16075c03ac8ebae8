"""Files of volumes, looks and scenes, by the SDK's own readers; levels of detail; plans."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from gicube import _core
from gicube.arrays import as_array
from gicube.board import Board, ProgressLike, shown
from gicube.errors import BadArgument, Rejected
from gicube.records import (Illumination, LevelError, Light, Placement, RawLayout, TransferFunction, ValueRange, Vec3,
                            View)
from gicube.records import SampleType, VoxelBox, WorldAxes, WorldPlacement
from gicube.volume import Volume, as_volume

__all__ = [
    "coarser", "cropped", "fit_view", "left_for_picture", "level_error", "level_for", "load_planned", "load_scene",
    "make_plan",
    "parse_scene", "placed_look", "placed_view", "plan_light", "presets", "read_scene", "read_volume", "share_of_light",
    "transfer_function", "value_range", "visible_box", "voxels_a_pixel", "why_look", "write_volume",
]

Path = Union[str, "os.PathLike[str]"]
VolumeLike = Union[Volume, ArrayLike]  # a gicube.Volume, or an array [z, y, x] of its samples


def read_volume(
    path: Path, raw: Optional[RawLayout] = None, *, part: str = "", as_stored: bool = False, nan: Optional[float] = None
) -> Volume:
    """A volume of a file or folder, in the formats of gicube/scene/volume_file.h (docs/guide/formats.md), or raw
    samples by `raw`.

    Its axes run along the nearest of the patient's or the world's, if the file says where these are; Volume.world has
    what is left.

    part: which volume, if there are several: a name or number, as the error or warning says that lists them.
    as_stored: axes stay as the file has them.
    nan: a value in place of samples that are no finite numbers.

    Raises FileError. Warns of what looks wrong, as numbers that are missing among the slices (UserWarning).
    """
    return _core.read_volume(os.fspath(path), raw, part, as_stored, nan)


def write_volume(
    path: Path,
    values: ArrayLike,
    *,
    spacing: Vec3 = (1.0, 1.0, 1.0),
    origin: Vec3 = (0.0, 0.0, 0.0),
    world: Optional[WorldPlacement] = None,
) -> None:
    """Values [z, y, x] as float32, by the extension: .nrrd, .mhd, .mha, .nii, .nii.gz, .vti, .vdb. Raises FileError.

    world: where they lie, in place of `origin` (Volume.world of what was read).
    """
    file = os.fspath(path)
    array = as_array(values, "values", "float32", (None, None, None))
    placement = WorldPlacement(WorldAxes.WORLD, origin=origin) if world is None else world
    _core.write_volume(file, array, list(array.shape[::-1]), spacing, placement)


def value_range(volume: VolumeLike) -> ValueRange:
    """The volume's own range, or the driver's default for its type. Not-a-numbers are left out."""
    volume = as_volume(volume)
    if volume.range is not None:
        return volume.range
    if volume.sample_type in (SampleType.UINT8, SampleType.UINT12):
        return ValueRange(0.0, 255.0 if volume.sample_type is SampleType.UINT8 else 4095.0)
    return ValueRange(float(np.nanmin(volume.samples)), float(np.nanmax(volume.samples)))


def transfer_function(name: Path, volume: Union[VolumeLike, ValueRange]) -> TransferFunction:
    """A preset (see presets()) or a file of a transfer function, in the values of a volume. "auto" is the preset that
    its values suggest, as gicube-render chooses it; why_look() gives the reasons.

    With a ValueRange alone, Hounsfield units count as the volume's values, and other presets go from its low to its
    high end. Raises InputError; BadArgument for "auto" with a range alone.
    """
    if isinstance(volume, ValueRange):
        if name == "auto":
            raise BadArgument("volume", "a volume, whose values suggest a look", "a ValueRange")
        return _core.find_transfer_function(os.fspath(name), volume)
    volume = as_volume(volume)
    if name == "auto":
        return _core.automatic_look(volume)[0]
    return _core.transfer_function_of(os.fspath(name), volume)


def why_look(volume: VolumeLike) -> str:
    """One line: the preset of transfer_function("auto", volume), and why it is that."""
    return _core.automatic_look(as_volume(volume))[1]


def presets() -> list[str]:
    """Names of the transfer functions that are built in."""
    return _core.presets()


def fit_view(
    volume: VolumeLike,
    looks: Union[TransferFunction, Sequence[TransferFunction]] = (),
    *,
    box: Optional[VoxelBox] = None,
    eye: Optional[Vec3] = None,
    look_at: Optional[Vec3] = None,
    up: Optional[Vec3] = None,
    name: str = "",
    **fields: Any,
) -> View:
    """A view that shows a box, or all that `looks` make visible, or the whole volume; further fields are View's.
    `name`: front, back, left, right, top, bottom or iso; of a patient (Volume.world) also anterior, posterior,
    superior, inferior. What is not given is chosen: eye in front, a little to the left and above; up along z. Raises
    InputError, BadArgument."""
    volume = as_volume(volume)
    looks = [looks] if isinstance(looks, TransferFunction) else looks
    if box is None:
        box = visible_box(volume, looks) if looks else VoxelBox((0, 0, 0), volume.dims)
    high = [low + size - 1 for low, size in zip(box.low, box.size)]
    axes = WorldAxes.NONE if volume.world is None else volume.world.axes
    return _core.fit_view(list(box.low), high, volume.spacing, View(**fields), eye, look_at, up, name, axes)


def visible_box(volume: VolumeLike, looks: Sequence[TransferFunction]) -> VoxelBox:
    """The smallest box of whole 4^3 blocks in which any sample can be visible, and one voxel more."""
    return _core.visible_box(as_volume(volume), looks)


def cropped(volume: VolumeLike, box: VoxelBox) -> Volume:
    """The voxels of a box; Volume.placement has their position. Raises BadArgument."""
    return _core.cropped(as_volume(volume), box)


def coarser(volume: VolumeLike, level: int) -> Volume:
    """One voxel, the mean, for 2^level of them on each axis. Raises BadArgument."""
    return _core.coarser(as_volume(volume), level)


def level_error(volume: VolumeLike, coarse: Volume, looks: Sequence[TransferFunction]) -> LevelError:
    """How far what coarser() made is from its original. `looks` by tag, in the volume's values."""
    return _core.level_error(as_volume(volume), coarse, looks)


def voxels_a_pixel(view: View, box: VoxelBox, spacing: Vec3 = (1.0, 1.0, 1.0)) -> float:
    """How many voxel edges one pixel is wide where the box is nearest; below one, a voxel has several. 0: it is beside
    the eye."""
    return _core.voxels_a_pixel(view, box, spacing)


def level_for(voxels_a_pixel: float) -> int:
    """The coarsest level whose voxels are not larger than that."""
    return _core.level_for(voxels_a_pixel)


def placed_view(placement: Placement, view: View) -> View:
    """Camera and image for a derived volume."""
    return _core.placed_view(placement, view)


def placed_look(placement: Placement, look: TransferFunction, span: ValueRange) -> TransferFunction:
    """The transfer function for a derived volume, whose values lie in `span`."""
    return _core.placed_look(placement, look, span)


def read_scene(path: Path, allow_outside: bool = False) -> _core.Scene:
    """A scene file (docs/guide/scenes.md). Raises InputError with all its faults.

    It and its volumes' headers name files in their own folders and below only; `allow_outside`: you trust it.
    """
    return _core.read_scene(os.fspath(path), allow_outside)


def parse_scene(text: str, name: str = "scene", folder: Path = ".", allow_outside: bool = False) -> _core.Scene:
    """Reads a scene from a text, which stands for a file in `folder`."""
    return _core.parse_scene(text, name, os.fspath(folder), allow_outside)


def load_scene(board: Board, setup: _core.SceneSetup, *, light: bool = True, progress: ProgressLike = None) -> View:
    """Brings a board to a scene: voxels, looks, shading, materials and, unless `light` is False, light. Returns the
    scene's view.

    The first scene of a board brings its own codebook of gradients, and later volumes are coded by that.
    On a board of three irradiance words light has its colours if the scene's illumination asks for them.
    Raises as Board.load_volume() and Board.illuminate().
    """
    try:
        own_codebook = not board.dims
    except Rejected:  # there is no volume yet
        own_codebook = True
    with shown(progress, "loading") as told:
        setup.load(board._core, own_codebook, told)
    board.set_shading(setup.shading)
    coloured = setup.light_has_colours and board.info.irradiance_words > 1
    for tag, material in enumerate(setup.materials):
        board.set_material(replace(material, scattering_colour=setup.scattering_colours[tag]) if coloured else material,
                           tag)
    lit = setup.is_lit and light
    if lit:
        settings = replace(setup.illumination, light_colours=setup.light_colours) if coloured else setup.illumination
        board.illuminate(setup.lights, settings, progress=progress)
    return replace(setup.view, irradiance=lit, lamps=setup.view.lamps if lit else [])


def make_plan(
    board: Board,
    volume: Optional[Volume] = None,
    looks: Sequence[TransferFunction] = (),
    view: View = View(),
    *,
    max_error: float = 0.0,
    time_budget: int = 0,
    pilot_pixels: int = 48,
    progress: ProgressLike = None,
) -> _core.Plan:
    """The cheapest settings of a picture for an error or a simulated time, found by pilot pictures (gicube/plan.h).

    The board holds the plan's volume and looks afterwards: board.render(plan.view(view)). Raises BadArgument, Rejected.
    """
    asked = {"view": view, "max_error": max_error, "time_budget": time_budget, "pilot_pixels": pilot_pixels}
    with shown(progress, "planning") as told:
        return _core.make_plan(board._core, volume, looks, asked, told)


def load_planned(board: Board, plan: _core.Plan, volume: Volume, looks: Sequence[TransferFunction]) -> None:
    """Brings another board to where make_plan() left its own."""
    _core.load_planned(board._core, plan, volume, looks)


def plan_light(
    board: Board,
    lights: Sequence[Light],
    settings: Illumination = Illumination(),
    view: View = View(),
    *,
    channel: int = -1,
    max_error: float = 0.0,
    time_budget: int = 0,
    max_rays: int = 256,
    pilot_pixels: int = 64,
    progress: ProgressLike = None,
) -> _core.LightPlan:
    """The cheapest lighting for an error or a simulated time (gicube/light_plan.h): board.illuminate(lights,
    plan.settings(settings)).

    The board needs volume, looks and materials. Raises BadArgument, Rejected.
    """
    asked = {"settings": settings, "view": view, "channel": channel, "max_error": max_error, "time_budget": time_budget}
    asked |= {"max_rays": max_rays, "pilot_pixels": pilot_pixels}
    with shown(progress, "planning light") as told:
        return _core.plan_light(board._core, lights, asked, told)


def share_of_light(max_error: float) -> float:
    """The part of a picture's error that its light gets, for plan_light(max_error=...)."""
    return _core.share_of_light(max_error)


def left_for_picture(max_error: float, light: _core.LightPlan) -> float:
    """The share of an error that a plan of light leaves to the picture, for make_plan(max_error=...)."""
    return _core.left_for_picture(max_error, light)
