"""The scenes that are measured show at any size what they are there for."""
import math
from dataclasses import replace

import numpy as np
import pytest

import scenes
from bench import LIT_SCENES
from scenes import faint, make_scene, make_view

EDGE = 32
DIMS = (EDGE, EDGE, EDGE)


def opacity(look, values):
    points = [(point.value, point.opacity) for point in look.opacities]
    return np.interp(values, *zip(*points))


def depth(scene, value, voxels):
    """Natural logarithm of what a ray of `voxels` through the value lets pass."""
    return -voxels * math.log(1 - opacity(scene.looks[0], value))


def test_a_lattice_value_is_that_of_64_bit_words_by_hand():
    word = 1
    for factor, shift in ((0x9E3779B97F4A7C15, 30), (0xBF58476D1CE4E5B9, 27), (0x94D049BB133111EB, 31)):
        word = word * factor % 2**64
        word ^= word >> shift
    assert scenes.lattice_values([1], [0], [0])[0] == (word >> 40) / 2**24


def test_noise_is_the_lattices_at_its_points_and_their_mean_between_two():
    noise = scenes.Noise(np.array([3.0, 3.5, 4.0]), np.array([5.0]), np.array([7.0]))
    low, high = scenes.lattice_values([3, 4], [5], [7])
    assert list(noise.slice(0)[0]) == [low, low + (high - low) * 0.5, high]


def test_the_cloud_is_visible_everywhere_and_never_opaque():
    cloud = make_scene("cloud", DIMS, EDGE)
    values = cloud.volume.samples
    assert values.size == EDGE**3
    assert opacity(cloud.looks[0], values.min()) > 0
    # even its densest value on the diagonal
    assert depth(cloud, values.max(), math.sqrt(3) * EDGE) < -math.log(1 - 0.98)


def test_the_rock_is_opaque_within_its_edge():
    rock = make_scene("rock", DIMS, EDGE)
    assert depth(rock, rock.volume.samples.min(), EDGE - 1) > -math.log(1 - 0.98)


def test_the_head_leaves_corners_empty():
    head = make_scene("head", DIMS, EDGE)
    assert head.volume.samples[0, 0, 0] == 0 and head.volume.samples[-1, -1, -1] == 0
    assert head.low[0] > 1 and head.high[0] < EDGE - 2


def test_a_box_of_noise_is_cut_from_the_larger_whole():
    whole, part = make_scene("rock", DIMS, EDGE), make_scene("rock", (EDGE, EDGE // 2, 8), EDGE)
    assert (whole.volume.samples[:8, : EDGE // 2] == part.volume.samples).all()


@pytest.mark.parametrize("name", ["buckyball", "head", "cloud", "rock"])
def test_faint_looks_show_the_same_values(name):
    plain = make_scene(name, DIMS, EDGE).looks[0]
    values = np.arange(0, 4096, 65)
    thin = opacity(faint(plain), values)
    assert ((opacity(plain, values) > 0) == (thin > 0)).all()
    assert thin.max() < 0.0031


@pytest.mark.parametrize("name", LIT_SCENES)
def test_lit_scenes_are_the_shipped_ones_at_the_size_asked_for(name):
    scene = make_scene(name, DIMS, EDGE)
    assert max(scene.volume.dims) == EDGE
    assert scene.lit and scene.setup.lights
    assert any(material.scattering > 0 and material.bsdf.value != "none" for material in scene.setup.materials)
    view = make_view(scene, "oblique", 40, 30)
    assert (view.width, view.height) == (40, 30)
    assert view.samples_per_axis == 1  # one ray a pixel, as the paper's images
    assert view.exposure > 0


def test_views_along_an_axis_see_the_whole_volume_from_outside():
    x = make_view(make_scene("cloud", DIMS, EDGE), "along x", 64, 64)
    assert x.eye[1:] == pytest.approx(x.look_at[1:], rel=1e-15)
    assert x.eye[0] < 0
    # The near face just fits: its half edge over its distance is a little below the tangent.
    tangent, half = math.tan(math.radians(15)), 0.5 * (EDGE - 1)
    assert 0.95 * tangent < half / -x.eye[0] < tangent


def test_parallel_rays_are_one_pixel_a_voxel():
    view = make_view(make_scene("cloud", DIMS, EDGE), "along z", 16, 16, orthographic=True)
    assert view.orthographic_height == EDGE
    assert replace(view, orthographic_height=0).eye[2] < -EDGE / 2
