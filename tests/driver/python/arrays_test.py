"""Arrays go in and out without a copy where their layout allows it."""

import os
import warnings

import numpy as np
import pytest
from conftest import LOOK, ball

import gicube


def test_a_volumes_array_is_used_where_it_lies():
    samples = ball()
    assert np.shares_memory(gicube.Volume(samples).samples, samples)


@pytest.mark.parametrize(
    "layout",
    [
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=2)[:, :, ::2],
        lambda a: a[::-1][::-1],
        lambda a: np.ascontiguousarray(a.T).T,
        lambda a: a.astype(">u2").astype("u1"),
    ],
)
def test_any_stride_gives_the_same_picture(board, layout):
    board.set_transfer_function(LOOK)
    view = gicube.fit_view(gicube.Volume(ball()), [LOOK], width=32, height=32)
    board.load_volume(ball())
    expected = board.render(view)
    board.load_volume(layout(ball()))
    assert board.render(view) == expected
    assert expected.alpha.max() == 4095


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", ["u2", "i2", "f4"])
def test_any_byte_order_gives_the_same_values(board, kind, order):
    samples = (ball().astype(kind) * 100).astype(order + kind)
    board.load_volume(gicube.Volume(samples, range=gicube.ValueRange(0, 20000)))
    np.testing.assert_allclose(board.read_volume(), samples.astype("f4"), atol=20000 / 4095)


@pytest.mark.parametrize(
    "samples, words",
    [
        (np.zeros((4, 4, 4), complex), "samples: expected an array of numbers, got complex128"),
        (np.full((4, 4, 4), "a"), "samples: expected an array of numbers, got <U1"),
        (np.zeros((4, 4), "u1"), "samples: expected three axes, [z, y, x], got the shape (4, 4)"),
        (np.zeros((4, 4, 1), "u1"), "dims[0]: expected 2..1024, got 1"),
        (np.full((4, 4, 4), np.nan, "f4"), "samples at voxel (0, 0, 0): expected a finite number, got nan"),
    ],
)
def test_a_wrong_array_names_its_field(board, samples, words):
    with pytest.raises(gicube.BadArgument) as fault:
        board.load_volume(samples)
    assert words in str(fault.value)


def stream(read):
    return gicube.VolumeStream(read, (32, 32, 32))


@pytest.mark.parametrize(
    "field, given",
    [
        ("tags", lambda board, hide: gicube.Volume(ball(), tags=hide(ball() // 100))),
        ("read", lambda board, hide: board.load_volume(stream(lambda z, n: hide(ball()[z : z + n])))),
        ("values", lambda board, hide: board.write_volume(hide(np.zeros((4, 4, 4), "f4")))),
        ("flags", lambda board, hide: setattr(board, "empty_flags", hide(board.empty_flags))),
        ("position", lambda board, hide: gicube.rays(hide(np.zeros((4, 3))), (0, 0, 1))),
        ("energy", lambda board, hide: gicube.rays(np.zeros((4, 3)), (0, 0, 1), energy=hide(np.zeros(4)))),
        ("rays", lambda board, hide: board.submit(hide(gicube.rays(np.zeros((4, 3)), (0, 0, 1))))),
        ("u", lambda board, hide: gicube.elements("patch", (0, 0, 0), hide(np.ones(3)), (0, 1, 0))),
        ("a", lambda board, hide: gicube.pairs(hide(np.arange(4)), 5)),
    ],
)
def test_masked_elements_are_refused_and_a_mask_of_none_is_no_matter(loaded, field, given):
    def hide_one(array):
        return np.ma.array(array, mask=np.arange(array.size).reshape(array.shape) == array.size - 1)

    words = f"^{field}: expected an array without masked elements .*, got one with [0-9]+ masked$"
    with pytest.raises(gicube.BadArgument, match=words):
        given(loaded, hide_one)
    given(loaded, np.ma.array)


def test_axes_are_z_y_x(board):
    samples = np.zeros((8, 16, 32), "u1")
    samples[1, 2, 3] = 255
    board.load_volume(samples)
    assert board.read_volume().shape == (8, 16, 32)
    assert board.read_volume(gicube.VoxelBox((3, 2, 1), (1, 1, 1)))[0, 0, 0] == 255


def test_boxes_are_written_and_read(loaded):
    values = np.arange(24, dtype="f4").reshape(2, 3, 4)
    box = gicube.VoxelBox((5, 6, 7), (4, 3, 2))
    loaded.write_volume(values, box)
    np.testing.assert_allclose(loaded.read_volume(box), values, atol=255 / 4095)
    with pytest.raises(gicube.BadArgument, match=r"values: expected the shape \(2, 3, 4\)"):
        loaded.write_volume(values.T, box)


def test_rays_come_back_in_the_order_in_which_they_were_sent(loaded):
    start = np.zeros((100, 3)) + [0, 15.5, 15.5]
    rays = gicube.rays_between(start, start + [31, 0, 0], id=np.arange(100)[::-1])
    batch = loaded.receive(loaded.submit(rays, type=gicube.RayType.OPACITY))
    assert batch.rays["id"].tolist() == list(range(100))[::-1]
    assert (batch.rays["opacity"] == 1).all()


def test_rays_in_several_arrays_are_one_batch_in_that_order(loaded):
    start = np.zeros((9, 3)) + [0, 15.5, 15.5]
    rays = gicube.rays_between(start, start + [31, 0, 0])
    ticket = loaded.submit([rays[6:], rays[:6]], type=gicube.RayType.OPACITY)
    assert ticket.rays == 9
    assert loaded.receive(ticket).rays["id"].tolist() == [6, 7, 8, 0, 1, 2, 3, 4, 5]


def test_rays_are_received_into_the_callers_array(loaded):
    out = np.zeros(3, gicube.TRACED_RAY)
    ticket = loaded.submit(gicube.rays(np.full((3, 3), 1.0), (0, 0, 1)))
    assert loaded.receive(ticket, out=out).rays is out
    assert (out["direction"] == (0, 0, 1)).all()


def test_a_wrong_ray_names_its_index_and_field(loaded):
    with pytest.raises(gicube.BadArgument, match=r"rays\[1\].position.x: expected 0..31, got nan"):
        loaded.submit(gicube.rays([[1, 1, 1], [np.nan, 1, 1]], (0, 0, 1)))
    with pytest.raises(gicube.BadArgument, match="rays: expected an array of"):
        loaded.submit(np.zeros((3, 3)))
    with pytest.raises(gicube.BadArgument, match="position: expected the shape"):
        gicube.rays(np.zeros((3, 2)), (0, 0, 1))


def test_a_million_rays_are_not_copied_one_by_one(loaded):
    rays = gicube.rays(np.full((10**6, 3), 16.0), np.random.default_rng(1).normal(size=(10**6, 3)), length=5)
    ticket = loaded.submit(rays, type=gicube.RayType.OPACITY)
    assert len(loaded.receive(ticket).rays) == 10**6


def test_a_pictures_views_have_no_memory_of_their_own(loaded):
    image = loaded.render(gicube.fit_view(gicube.Volume(ball()), [LOOK], width=40, height=30))
    assert image.rgb.base is not None and np.shares_memory(image.rgb, image.pixels)
    assert image.rgb.shape == (30, 40, 3) and image.alpha.shape == (30, 40)
    assert np.shares_memory(np.asarray(image), image.pixels) and np.array_equal(np.asarray(image, float), image.rgb)
    assert image._repr_png_().startswith(b"\x89PNG")
    assert (image.over((0, 0, 1))[0, 0] == (0, 0, 255)).all()


def test_views_of_a_scene_stay_valid_while_they_live():
    samples = gicube.parse_scene('volume { builtin: "buckyball" size: 16 }').set_up().volume.samples
    assert samples.shape == (16, 16, 16) and not samples.flags.writeable
    assert samples.max() > 0


def test_a_volume_that_looks_wrong_is_warned_of(tmp_path):
    for z in (0, 1, 4):
        gicube.Image(np.zeros((2, 3), gicube.PIXEL)).save(tmp_path / f"{z}.png", (0, 0, 0))
    text = "files: expected numbers without gaps, got 2 missing, the first between 1.png and 4.png"
    with pytest.warns(UserWarning, match=text) as caught:
        assert gicube.read_volume(tmp_path).samples.shape == (3, 2, 3)
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="got 2 missing"):
            gicube.read_volume(tmp_path)


def test_a_files_name_need_not_be_utf8(tmp_path):
    name = os.fsdecode(bytes(tmp_path) + b"/gr\xfc.nrrd")
    with pytest.raises(gicube.FileError, match="nothing there") as caught:
        gicube.read_volume(name)
    assert caught.value.faults[0].file == name
    gicube.write_volume(name, np.zeros((2, 2, 2)))
    assert gicube.read_volume(name).source == name


@pytest.mark.parametrize("kind", [gicube.ElementKind.PATCH, "patch", ["patch", gicube.ElementKind.PATCH]])
def test_factors_between_patches_are_the_analytic_ones(board, kind):
    board.load_volume(np.zeros((32, 32, 32), "u1"))
    board.set_transfer_function(LOOK)
    squares = gicube.elements(kind, [[8, 8, 8], [8, 8, 18]], (10, 0, 0), [[0, 10, 0], [0, -10, 0]])
    squares["origin"][1] = (8, 18, 18)
    factor = board.pair_factors(squares, gicube.pairs(0, 1), rays=4096)[0]
    # unit cubes' faces
    assert factor["transported"] * 100 == pytest.approx(0.1998, abs=3 * factor["standard_error"] * 100 + 1e-3)
