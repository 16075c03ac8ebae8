"""The measured scenes: procedural ones, which look the same at all sizes, and scans if they are available."""
import functools
import math
import pathlib
import re
from dataclasses import replace

import gicube
import numpy as np

FAINT = 0.003  # chosen: 443 voxels of opacity 0.003 transmit a quarter
DESIGN_EDGE = 256  # edge in voxels of the volume for the opacities below
FILES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
DATA = FILES.parents[2] / "shared/data"  # scans beside the source's folder, which are separate from it
BRAIN = DATA / "stroke_brain_mri/T1.nii.gz"
# Scans and the opacities of their values, 0..255.
SCANS = {"engine": (DATA / "engine_ct/engine.nii.gz", [(60, 0), (150, 0.03), (200, 0.3)]),
         "mouse": (DATA / "mouse_head_microct/C57BL6_J_.nii.gz", [(25, 0), (60, 0.1), (140, 0.3)]),
         "brain": (BRAIN, [(30, 0), (90, 0.3)]),
         "human": (DATA / "visible_human_female_head_ct", [(20, 0), (50, 0.02), (80, 0.02), (110, 0.3)])}
TOWARDS_THE_EYE = {"along x": (-1, 0, 0), "along y": (0, -1, 0), "along z": (0, 0, -1), "diagonal": (-1, -1, 1)}


def lattice_values(x, y, z):
    """Values 0..1 at integer points, hashed by SplitMix64's finalizer; without a period."""
    x, y, z = (np.asarray(each).astype("u4").astype("u8") for each in (x, y, z))
    hashed = x * np.uint64(0x9E3779B97F4A7C15) ^ y * np.uint64(0xC2B2AE3D27D4EB4F) ^ z * np.uint64(0x165667B19E3779F9)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        hashed = (hashed ^ (hashed >> np.uint64(shift))) * np.uint64(factor)
    return ((hashed ^ (hashed >> np.uint64(31))) >> np.uint64(40)) / float(1 << 24)


class Noise:
    """Lattice values interpolated with cubic weights over a grid of x, y and z: first along x, then y; slice() does
    z."""

    def __init__(self, x, y, z):
        (x, u), (y, v), (self._z, self._w) = map(self._cells, (x, y, z))
        xs, ys, zs = (np.arange(each[0], each[-1] + 2) for each in (x, y, self._z))
        x, y, self._z = (each - each[0] for each in (x, y, self._z))
        values = lattice_values(xs, ys[:, None], zs[:, None, None])
        values = self._mix(values[:, :, x], values[:, :, x + 1], u)
        self._planes = self._mix(values[:, y], values[:, y + 1], v[:, None])

    @staticmethod
    def _cells(at):
        low = np.floor(at)
        t = at - low
        return low.astype(int), t * t * (3 - 2 * t)

    @staticmethod
    def _mix(a, b, t):
        return a + (b - a) * t

    def slice(self, k):
        return self._mix(self._planes[self._z[k]], self._planes[self._z[k] + 1], self._w[k])


class CloudyNoise:
    """Three octaves, 0..1, of a lattice of so many voxels."""

    def __init__(self, dims, lattice):
        axes = [(1 / lattice) * np.arange(size, dtype=float) for size in dims]
        self._octaves = [Noise(*(scale * axis + offset for axis, offset in zip(axes, offsets)))
                         for scale, offsets in ((1, (0, 0, 0)), (2, (17, 5, 29)), (4, (3, 41, 11)))]

    def slice(self, k):
        wide, middle, narrow = (octave.slice(k) for octave in self._octaves)
        return (4 * wide + 2 * middle + narrow) / 7


def voxelise(dims, density):
    """A volume of 12 bits of density(k), 0..1 over the slice z = k."""
    words = np.empty(dims[::-1], "u2")
    for k in range(dims[2]):
        words[k] = np.floor(4095 * np.clip(density(k), 0.0, 1.0) + 0.5)
    return gicube.Volume(words, sample_type=gicube.SampleType.UINT12)


def of_edge(opacity, edge):
    """Opacity of a voxel in a volume of `edge`, so that all sizes look the same."""
    return 1 - (1 - opacity) ** (DESIGN_EDGE / edge)


class SceneData:
    """Input of a board: a volume and a look per tag, or the setup of a scene file with lights. `be_whole`: views show
    the whole volume, not only its visible part."""

    def __init__(self, volume, looks, setup=None, be_whole=True):
        self.volume, self.looks, self.setup = volume, looks, setup
        self.lit = setup is not None and setup.is_lit
        self.low, self.high = (np.zeros(3), np.array(volume.dims) - 1.0) if be_whole else visible_box(volume, looks[0])
        self.background = setup.background if setup and not self.lit else (0, 0, 0)


def visible_box(volume, look):
    """Corners of the smallest box of visible voxels, and one voxel more."""
    values, opacities = zip(*((point.value, point.opacity) for point in look.opacities))
    # chosen: like gicube-render's cameras
    seen = (np.interp(np.arange(4096), values, opacities) > 0.005)[volume.samples]
    planes = [np.flatnonzero(seen.any(axis=others)) for others in ((0, 1), (0, 2), (1, 2))]
    low, high = (np.array([float(each[end]) for each in planes]) for end in (0, -1))
    return np.maximum(low - 1, 0), np.minimum(high + 1, np.array(volume.dims) - 1.0)


def make_head(dims, edge):
    half = [0.5 * (size - 1) for size in dims]
    noise = CloudyNoise(dims, edge / 16)
    x, y, z = ((np.arange(size) - h) / (share * h) for size, h, share in zip(dims, half, (0.76, 0.92, 0.88)))

    def step(low, high, radius):
        return np.clip((radius - low) / (high - low), 0.0, 1.0)

    def density(k):
        # 1 on an ellipsoid that almost touches the volume's faces; a few per cent rough.
        radius = np.sqrt(x * x + (y * y)[:, None] + z[k] * z[k])
        rough = noise.slice(k) - 0.5
        shell = radius + 0.06 * rough
        skin, skull = 0.3 * (1 - step(0.96, 0.985, shell)), 0.6 * (1 - step(0.87, 0.89, shell))
        brain = -0.5 * (1 - step(0.79, 0.81, shell)) + 0.25 * (1 - step(0.76, 0.79, shell)) * (0.5 + rough)
        return np.where(radius > 1.05, 0.0, skin + skull + brain)

    # Transparent skin over the skull, and slightly transparent bone over the brain.
    skin, bone, brain = (of_edge(opacity, edge) for opacity in (0.02, 0.12, 0.05))
    look = gicube.TransferFunction(
        [(0, (0.8, 0.6, 0.5)), (1300, (0.85, 0.65, 0.55)), (1800, (0.7, 0.45, 0.45)), (3000, (0.95, 0.92, 0.85))],
        [(200, 0), (900, skin), (1400, skin), (1800, brain), (2300, brain), (3000, bone)])
    return SceneData(voxelise(dims, density), [look], be_whole=False)


def make_noise(dims, edge, low, high, dark, light):
    """Noise in the whole volume: no block is empty."""
    noise = CloudyNoise(dims, edge / 8)
    look = gicube.TransferFunction([(1000, dark), (3000, light)],
                                   [(1000, of_edge(low, edge)), (3000, of_edge(high, edge))])
    return SceneData(voxelise(dims, lambda k: 0.1 + 0.8 * noise.slice(k)), [look])


@functools.cache
def load_scan(name):
    """Samples 0..255 [z, y, x]; every second one in slices with longer edges than the design point's."""
    samples = gicube.read_volume(SCANS[name][0]).samples
    return samples[:, ::2, ::2] if max(samples.shape) > DESIGN_EDGE else samples


def make_scan(name):
    words = load_scan(name).astype("u2") * 16
    look = gicube.TransferFunction([(400, (0.8, 0.6, 0.5)), (2400, (1, 0.95, 0.9))],
                                   [(16 * value, opacity) for value, opacity in SCANS[name][1]])
    return SceneData(gicube.Volume(words, sample_type=gicube.SampleType.UINT12), [look], be_whole=False)


def make_scene(name, dims, edge):
    """`name`: buckyball, head, cloud, rock, one of SCANS, "mirror-brain", or a file of samples/scenes with a world.
    `edge`: unit of lengths in voxels, or the longest edge of a world. All dims are equal to it, except in boxes of
    cloud and rock, which look the same everywhere. Raises gicube.InputError (a size out of range), OSError (no such
    file)."""
    if name in SCANS:
        return make_scan(name)
    if name == "head":
        return make_head(dims, edge)
    if name == "cloud":
        return make_noise(dims, edge, 0.001, 0.007, (0.5, 0.6, 0.8), (1, 1, 1))
    if name == "rock":
        return make_noise(dims, edge, 0.03, 0.12, (0.3, 0.2, 0.15), (0.8, 0.75, 0.6))
    folder = pathlib.Path(__file__).parent if name == "mirror-brain" else FILES
    if name == "buckyball":
        text = f'volume {{ builtin: "{name}" size: {edge} }}'
    else:
        text = re.sub(r"(?m)^  size: \d+", f"  size: {edge}", (folder / f"{name.replace('-', '_')}.scene").read_text(),
                      count=1)
    setup = gicube.parse_scene(text, name, folder, allow_outside=True).set_up()
    return SceneData(setup.volume, setup.looks, setup)


def faint(look):
    """A look with the same values, but so faint that no ray becomes opaque."""
    points = [gicube.OpacityPoint(point.value, point.opacity * FAINT) for point in look.opacities]
    return replace(look, opacities=points)


def length(vector):
    x, y, z = vector
    return math.sqrt(x * x + y * y + z * z)


def normalise(vector):
    return (1.0 / length(vector)) * np.asarray(vector, dtype=float)


def make_view(scene, name, width, height, orthographic=False):
    """`name`: oblique or one of TOWARDS_THE_EYE. The scene's own camera, or one outside that sees everything;
    `orthographic` has parallel rays, with one pixel per voxel along y."""
    size = {"width": width, "height": height, "samples_per_axis": 1}
    if name == "oblique" and scene.setup is not None:
        return replace(scene.setup.view, **size)
    if name == "oblique":
        box = gicube.VoxelBox(scene.low.astype(int), (scene.high - scene.low).astype(int) + 1)
        return gicube.fit_view(scene.volume, box=box, **size)
    direction = normalise(TOWARDS_THE_EYE[name])
    middle = 0.5 * (scene.low + scene.high)
    up = (0, 1, 0) if name == "along z" else (0, 0, 1)
    view = gicube.View(look_at=tuple(middle), up=up, **size)
    if orthographic:
        away = length(scene.high - scene.low)
        return replace(view, orthographic_height=scene.volume.dims[1], eye=tuple(middle + away * direction))
    # The smallest distance with all corners in view.
    margin = 1.02  # chosen
    right = np.cross(up, direction)
    right, up = normalise(right), np.cross(direction, normalise(right))
    tan_up = math.tan(view.fov_degrees * math.pi / 360)
    tan_side = tan_up * width / height
    distance = 0.0
    for corner in range(8):
        offset = np.where([corner & 1, corner & 2, corner & 4], scene.high, scene.low) - middle
        aside = max(abs(offset @ right) / tan_side, abs(offset @ up) / tan_up)
        distance = max(distance, offset @ direction + margin * aside)
    return replace(view, eye=tuple(middle + distance * direction))
