"""Arrays as people have them, and slips of the pen."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import gicube


def ball(dtype="f8", scale=1.0):
    """Values of -1000 outside of a sphere of 40, with a core of 1200: a CT."""
    z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
    r = np.sqrt(x * x + y * y + z * z)
    return (scale * np.where(r > 0.9, -1000.0, np.where(r < 0.5, 1200.0, 40.0))).astype(dtype)


@pytest.mark.parametrize(
    "given, kind",
    [("f8", "float32"), ("f2", "float32"), (">f4", "float32"), ("i1", "int16"), ("i4", "int16"), ("i8", "int16"),
     ("u4", "uint8"), ("u8", "uint8")],
)
def test_other_types_become_those_of_boards_with_their_values(given, kind):
    values = np.arange(64).reshape(4, 4, 4) - (20 if np.dtype(given).kind in "if" else 0)
    volume = gicube.Volume(values.astype(given))
    assert volume.samples.dtype == kind and volume.sample_type.value == kind
    np.testing.assert_array_equal(volume.samples, values)


def test_integers_beyond_16_bits_become_floats_and_large_floats_are_refused():
    values = np.full((2, 2, 2), 70000)
    values[0] = -70000
    assert gicube.Volume(values).samples.dtype == "float32"
    np.testing.assert_array_equal(gicube.Volume(values).samples, values)
    assert gicube.Volume(values * 0 + 65535).samples.dtype == "uint16"
    with pytest.raises(gicube.BadArgument, match="samples: expected values that float32 holds, got 1e\\+300"):
        gicube.Volume(np.full((2, 2, 2), 1e300))
    with pytest.raises(gicube.BadArgument, match="samples: expected an array of numbers, got complex128"):
        gicube.Volume(np.zeros((2, 2, 2), complex))


def test_a_mask_of_bools_is_a_volume_from_0_to_1(board):
    volume = gicube.Volume(ball() > 0)
    assert volume.range == gicube.ValueRange(0.0, 1.0)
    board.load_volume(volume)
    assert set(np.unique(board.read_volume())) == {0.0, 1.0}


def test_masked_voxels_are_as_the_least_value_and_leave_the_range(board):
    values = ball("i2")
    values[0] = 30000
    hidden = np.ma.masked_equal(values, 30000)
    volume = gicube.Volume(hidden)
    assert volume.range == gicube.ValueRange(-1000.0, 1200.0)
    assert (volume.samples[0] == -1000).all() and (volume.samples[1:] == values[1:]).all()
    board.load_volume([hidden[z] for z in range(32)])
    np.testing.assert_allclose(board.read_volume()[0], -1000, atol=0.5)
    with pytest.raises(gicube.BadArgument, match="samples: expected some voxels without a mask, got none"):
        gicube.Volume(np.ma.masked_all((2, 2, 2)))


def test_helpers_take_arrays():
    array = ball()
    look = gicube.transfer_function("ct-bone", array)
    assert look.opacity_at(100) == 0 and look.opacity_at(900) == 1  # Hounsfield units
    assert gicube.value_range(array) == gicube.ValueRange(-1000.0, 1200.0)
    assert gicube.fit_view(array, look) == gicube.fit_view(gicube.Volume(array), [look])
    assert gicube.fit_view(array).look_at == (15.5, 15.5, 15.5)
    assert gicube.visible_box(array, [look]) == gicube.visible_box(gicube.Volume(array), [look])
    assert gicube.coarser(array, 1).dims == (16, 16, 16)


def test_looks_in_hounsfield_units_find_air_and_tissue_of_other_units():
    rng = np.random.default_rng(1)
    attenuation = 0.02 + 2e-5 * (ball() + rng.normal(0, 10, (32, 32, 32)))
    look = gicube.transfer_function("ct-bone", attenuation)
    at = [point.value for point in look.opacities]
    np.testing.assert_allclose(at, 0.02 + 2e-5 * np.array([180, 320, 520, 800]), rtol=0.05)


def test_auto_is_the_look_that_the_values_suggest():
    assert gicube.transfer_function("auto", ball()).opacity_at(900) == 1
    assert gicube.why_look(ball()).startswith("transfer function: ")
    with pytest.raises(gicube.BadArgument, match="volume: expected a volume, whose values suggest a look"):
        gicube.transfer_function("auto", gicube.ValueRange(0, 1))


def test_a_picture_is_an_array(loaded):
    image = loaded.render(gicube.View(eye=(16, 16, -60), look_at=(16, 16, 16), width=20, height=10))
    assert np.asarray(image).shape == (10, 20, 3) and np.asarray(image).dtype == "u1"
    pyplot = pytest.importorskip("matplotlib.pyplot")
    assert pyplot.imshow(image).get_array().shape == (10, 20, 3)
    pyplot.close("all")


def test_a_field_that_a_record_does_not_have_is_refused_with_the_nearest():
    with pytest.raises(TypeError, match="View has no field 'fov', the nearest is 'fov_degrees'"):
        gicube.View(fov=30)
    view = gicube.View()
    with pytest.raises(AttributeError, match="View has no field 'lookat', the nearest is 'look_at'"):
        view.lookat = (1, 2, 3)
    with pytest.raises(AttributeError,
                       match="Phong has no field 'gloss': it has ambient, diffuse, specular, shininess"):
        gicube.Phong().gloss = 1
    with pytest.raises(TypeError, match="Volume has no field 'spacng', the nearest is 'spacing'"):
        gicube.Volume(ball("f4"), spacng=(1, 1, 2))
    with pytest.raises(TypeError, match="View has no field 'widht'"):
        dataclasses.replace(view, widht=3)


def test_records_are_copied_and_pickled():
    view = gicube.View(width=64, cut_planes=[gicube.CutPlane((0, 0, 1), 3)])
    assert copy.deepcopy(view) == view and pickle.loads(pickle.dumps(view)) == view
    found = gicube.FoundBoard("emu:", 1, "", "", False, "")
    assert pickle.loads(pickle.dumps(found)) == found


def test_a_batchs_repr_is_one_line(loaded):
    rays = gicube.rays(np.full((1000, 3), (16.0, 16.0, 0.0)), (0, 0, 1))
    batch = loaded.receive(loaded.submit(rays))
    assert repr(batch) == f"<gicube.RayBatch {batch.ticket}: 1000 rays, completed at {batch.completed} ps>"
