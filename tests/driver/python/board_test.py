"""The whole API from Python."""

import asyncio
import ctypes
import math
import re
import sys
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import LOOK, ball, view_of_ball

import gicube
from gicube.testing import BoardSetup, Window, assert_counter, assert_share, assert_time


def test_a_closed_board_says_so_and_may_be_closed_again():
    with gicube.open() as board:
        assert board.info.processors == 4
    board.close()
    assert "closed" in repr(board)
    with pytest.raises(gicube.DeviceLost) as lost:
        board.now
    assert lost.value.cause is gicube.Loss.CLOSED


def test_a_uri_that_means_nothing_is_refused():
    with pytest.raises(gicube.BadArgument):
        gicube.open("gopher://board")
    with pytest.raises(gicube.OpenFailed):
        gicube.open("unix:/no/such/socket")
    with pytest.raises(gicube.BadArgument, match="watchdog: expected seconds, 0 or more, got -1"):
        gicube.open(watchdog=-1)


def test_all_levels_make_the_same_picture():
    images = []
    for fidelity in (gicube.Fidelity.FUNCTIONAL, gicube.Fidelity.CYCLE):
        with gicube.open(f"emu:?fidelity={fidelity.value}") as board:
            assert board.info.fidelity is fidelity
            board.load_volume(ball())
            board.set_transfer_function(LOOK)
            images.append(board.render(view_of_ball()))
    assert images[0].alpha.max() == 4095 and images[0].alpha.min() == 0
    assert images[0] == images[1]


def test_light_that_goes_in_comes_out(loaded):
    report = loaded.illuminate([gicube.PointLight((15.5, 15.5, 1))], gicube.Illumination(rays_per_face_voxel=2))
    assert report.emitted == pytest.approx(report.deposited + report.escaped + report.scattered_away + report.clipped)
    irradiance = loaded.read_irradiance()
    assert irradiance.shape == (32, 32, 32)
    assert irradiance.sum() == pytest.approx(report.deposited, rel=1e-5)
    assert loaded.render(view_of_ball(irradiance=True)).rgb.max() > 0


def test_light_has_three_colours_on_a_board_of_three_irradiance_words():
    with gicube.open("emu:?set=asic.irradiance_words=3") as board:
        assert board.info.irradiance_words == 3
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        board.set_material(gicube.Material(scattering=0.5, bsdf=gicube.Bsdf.DIFFUSE, scattering_colour=(1, 0.5, 0)))
        settings = gicube.Illumination(rays_per_face_voxel=2, light_colours=[(1, 0.5, 0.25)])
        report = board.illuminate([gicube.PointLight((15.5, 15.5, 1))], settings)
        assert report.emitted == pytest.approx(sum(colour.emitted for colour in report.colours))
        red, green, blue = report.colours
        assert green.emitted == pytest.approx(red.emitted / 2,
                                              rel=0.02) and blue.emitted == pytest.approx(red.emitted / 4, rel=0.02)
        irradiance = board.read_irradiance()
        assert irradiance.shape == (32, 32, 32, 3)
        assert irradiance.sum(axis=(0, 1, 2)) == pytest.approx([colour.deposited for colour in report.colours],
            rel=1e-5)
        board.write_irradiance(irradiance[:, :, :, ::-1])
        assert (board.read_irradiance() == irradiance[:, :, :, ::-1]).all()
        with pytest.raises(gicube.BadArgument, match="values: expected"):
            board.write_irradiance(irradiance[:, :, :, 0])


def test_sums_of_rays_are_what_they_carried(loaded):
    loaded.clear_sums(2.0**-16)
    rays = gicube.rays_between([[2, 16, 16]], [[12, 16, 16]], energy=3)
    report = loaded.receive(loaded.submit(rays, type=gicube.RayType.BACKPROJECT)).deposits
    assert report.kept == pytest.approx(30, rel=1e-3)
    assert loaded.read_sums().sum() == pytest.approx(30, rel=1e-3)


def test_a_mirror_shows_the_lamps_of_a_view(loaded):
    loaded.set_material(gicube.Material(scattering=1, bsdf=gicube.Bsdf.SPECULAR, seen_through_scattering=True))
    view = view_of_ball(scatter=True)
    dark = loaded.render(view)
    back = np.subtract(view.eye, view.look_at)
    radius = 0.9 * float(np.linalg.norm(back))
    lamp = gicube.SphereLight(tuple(view.look_at + 2 * back), radius, 4 * math.pi * radius**2)
    view.lamps = [gicube.Lamp(lamp, (0.25, 0.5, 1))]
    lit = loaded.render(view)
    seen = (lit.alpha == 4095) & (dark.alpha < 4095)
    assert seen.sum() > 20
    assert abs(np.median(lit.rgb[seen], axis=0) - (64, 128, 255)).max() <= 1


def test_a_routine_of_the_application_scatters(loaded):
    seen = []

    def back(event):
        seen.append((event.tag, event.lighting, len(event.parameters)))
        return gicube.ScatterAnswer(tuple(-x for x in event.direction), 0.5)

    loaded.set_material(
        gicube.Material(scattering=1, bsdf=gicube.Bsdf.TRAP, routine=gicube.HOST_ROUTINE, surface=True,
                        parameters=[1, 2])
    )
    loaded.set_scattering_routine(back)
    report = loaded.illuminate([gicube.PointLight((15.5, 15.5, 1))])
    assert seen and seen[0] == (0, True, 2)
    assert report.scattered_away > 0


def test_what_a_routine_or_a_progress_raises_leaves_the_call_and_the_board_goes_on(loaded):
    def fail(*_):
        raise KeyError("mine")

    loaded.set_material(gicube.Material(scattering=1, bsdf=gicube.Bsdf.TRAP, routine=gicube.HOST_ROUTINE))
    loaded.set_scattering_routine(fail)
    with pytest.raises(KeyError, match="mine"):
        loaded.illuminate([gicube.PointLight((15.5, 15.5, 1))])
    with pytest.raises(KeyError, match="mine"):
        loaded.load_volume(ball(), progress=fail)
    loaded.load_volume(ball())
    assert loaded.render(view_of_ball()).alpha.max() == 4095


def test_a_routine_may_not_call_its_board(loaded):
    loaded.set_material(gicube.Material(scattering=1, bsdf=gicube.Bsdf.TRAP, routine=gicube.HOST_ROUTINE))
    loaded.set_scattering_routine(lambda event: loaded.counters)
    with pytest.raises(gicube.Error, match="now.. and info.. only"):
        loaded.illuminate([gicube.PointLight((15.5, 15.5, 1))])


def test_progress_counts_up_to_all(loaded):
    told = []
    loaded.load_volume(np.ones((64, 64, 64), "u1"), progress=lambda done, all: told.append((done, all)))
    assert told[0][0] == 0 and told[-1][0] == told[-1][1] == 8


def test_a_bar_is_full_at_the_end_however_quick_the_call(loaded, monkeypatch, capsys):
    import tqdm.auto

    bars = []

    class Kept(tqdm.auto.tqdm):
        def close(self):
            if not self.disable:  # as it is once closed
                bars.append((self.desc.removesuffix(": "), self.n, self.total))
            super().close()

    monkeypatch.setattr(tqdm.auto, "tqdm", Kept)
    loaded.render(view_of_ball(width=8, height=8), progress=True)
    loaded.illuminate([gicube.PointLight((15.5, 15.5, 1))], progress=True)
    loaded.load_volume(ball(), progress=True)
    loaded.set_transfer_function(LOOK)
    loaded.pair_factors(gicube.elements(gicube.ElementKind.BOX, [[1, 1, 1], [30, 30, 30]], (1, 0, 0), (0, 1, 0),
                                        (0, 0, 1)), gicube.pairs(0, 1), progress=True)
    assert [what for what, _, _ in bars] == ["rendering", "lighting", "loading", "pairs"]
    assert all(done == all > 0 for what, done, all in bars), bars
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)  # not installed
    capsys.readouterr()
    loaded.render(view_of_ball(width=8, height=8), progress=True)
    last = capsys.readouterr().err.split("\r")[-1]
    assert re.fullmatch(r"rendering: (\d+) of \1\n", last)


def test_batches_are_polled_cancelled_and_awaited(loaded):
    rays = gicube.rays(np.full((5000, 3), 16.0), (0, 0, 1))
    first, second = loaded.submit(rays), loaded.submit(rays)
    taken_back = loaded.cancel(second)
    assert len(asyncio.run(loaded.receive_async(first)).rays) == 5000
    loaded.host_compute(10**12)
    [batch] = loaded.poll()
    assert batch.ticket == second.id and batch.cancelled == taken_back
    assert len(batch.rays) == (0 if taken_back else 5000)
    with pytest.raises(gicube.BadArgument, match="ticket"):
        loaded.receive(first)


def test_calls_that_were_started_end_as_those_that_wait(loaded):
    with gicube.open() as plain:
        plain.load_volume(ball())
        plain.set_transfer_function(LOOK)
        picture = loaded.start_render(view_of_ball())
        assert picture.wait() and picture.ready
        done, every = picture.progress
        assert done == every
        expected = plain.render(view_of_ball())
        assert np.array_equal(picture.result().pixels, expected.pixels)
        with pytest.raises(gicube.BadArgument, match="pending"):
            picture.result()
        rays = gicube.rays(np.full((50, 3), 16.0), (0, 0, 1))
        before = loaded.now
        batch = loaded.start_rays(rays)
        assert loaded.now == before
        assert np.array_equal(batch.result().rays, plain.receive(plain.submit(rays)).rays) and loaded.now > before
        light = loaded.start_illuminate([gicube.DirectionalLight((0, 0, -1), 1.0)])
        assert light.result().emitted == plain.illuminate([gicube.DirectionalLight((0, 0, -1), 1.0)]).emitted
        volume = ball()
        assert loaded.start_load(volume).result() is None
        assert loaded.dims == (32, 32, 32)

    async def awaited():
        return await asyncio.gather(*(wrapped(loaded.start_rays(rays)) for _ in range(3)))

    async def wrapped(pending):
        return await pending

    assert [len(each.rays) for each in asyncio.run(awaited())] == [50] * 3
    other = gicube.open()
    other.load_volume(ball())
    left = other.start_rays(rays)
    other.close()
    with pytest.raises(gicube.DeviceLost):
        left.result()


def test_rays_are_sampled_as_their_request_says(loaded):
    rays = gicube.rays(np.array([[16.0, 16.0, 0.0]]), (0, 0, 1))
    view = view_of_ball()
    view.cut_planes = [gicube.CutPlane((0, 0, 1), 30)]  # the ball ends before it
    whole = loaded.receive(loaded.submit(rays)).rays
    loaded.render(view)
    assert np.array_equal(loaded.receive(loaded.submit(rays)).rays, whole)
    cut = loaded.receive(loaded.submit(rays, sampling=gicube.Sampling.of(view))).rays
    assert cut["opacity"][0] < whole["opacity"][0]


def test_deadlines_are_simulated_times(loaded):
    ticket = loaded.submit(gicube.rays(np.full((5000, 3), 16.0), (0, 0, 1)))
    with pytest.raises(gicube.DeadlinePassed):
        loaded.receive(ticket, deadline=loaded.now + 1)
    assert len(loaded.receive(ticket).rays) == 5000
    loaded.set_time_limit(1)
    with pytest.raises(gicube.DeadlinePassed):
        loaded.render(view_of_ball())


def test_empty_flags_hide_blocks(loaded):
    flags = loaded.empty_flags
    assert loaded.dims == (32, 32, 32) and flags.shape == loaded.blocks[::-1]
    loaded.empty_flags = np.ones_like(flags)
    assert loaded.render(view_of_ball()).alpha.max() == 0
    assert loaded.verify_volume() == []


def test_a_picture_in_which_nothing_is_visible_is_warned_of_with_the_reason():
    mask = np.zeros((16, 16, 16), "u1")
    mask[4:12, 4:12, 4:12] = 1
    view = gicube.View(eye=(7.5, 7.5, -60), look_at=(7.5, 7.5, 7.5), width=16, height=16)
    with gicube.open() as board:
        board.load_volume(mask)
        with pytest.warns(UserWarning, match="nothing is visible in the picture: no transfer function is set") as told:
            board.render(view)
        assert told[0].filename == __file__
        board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(100, 0), (255, 0.5)]))
        with pytest.warns(UserWarning, match="voxels have values of 0 to 1, .*a mask"):
            board.render(view)
        board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(0, 0), (1, 0.5)]))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            board.render(view)


def test_a_saved_board_goes_on_from_its_file_and_from_its_bytes(loaded, tmp_path):
    ticket = loaded.submit(gicube.rays([[1, 2, 3], [4, 5, 6]], [[1, 1, 1], [1, 0, 0]]))
    saved = loaded.save()
    assert isinstance(saved, bytes) and loaded.save(tmp_path / "saved") is None
    image, rays, now = loaded.render(view_of_ball()), loaded.receive(ticket).rays, loaded.now
    for_file = gicube.open(f"emu:?restore={tmp_path / 'saved'}")
    for_bytes = gicube.open()
    for_bytes.restore(saved)
    loaded.restore(tmp_path / "saved")
    for board in (for_file, for_bytes, loaded):
        assert board.render(view_of_ball()) == image and board.dims == (32, 32, 32)
        assert (board.receive(ticket).rays == rays).all() and board.now == now
    with pytest.raises(gicube.BadArgument, match="checkpoint.crc32c: expected"):
        loaded.restore(saved[:100] + bytes([saved[100] ^ 1]) + saved[101:])
    with pytest.raises(gicube.OpenFailed, match="expected a board process with --restore"):
        gicube.open(go_on=True)
    assert loaded.now == now


def test_boards_on_several_threads_work_at_once():
    images = []

    def work():
        with gicube.open() as board:
            board.load_volume(ball())
            board.set_transfer_function(LOOK)
            images.append(board.render(view_of_ball()))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(images) == 4 and all(image == images[0] for image in images)


def test_threads_take_turns_on_one_board(loaded):
    rays = gicube.rays(np.full((1000, 3), 16.0), (0, 0, 1))
    sizes = []

    def work():
        for _ in range(20):
            sizes.append(len(loaded.receive(loaded.submit(rays)).rays))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sizes == [1000] * 80


def test_a_plan_keeps_its_error(loaded):
    volume = gicube.Volume(ball(64, 20))
    view = gicube.fit_view(volume, [LOOK], width=128, height=128)
    plan = gicube.make_plan(loaded, volume, [LOOK], view, max_error=0.2)
    assert plan.kept and plan.chosen.error_bound <= 0.2
    assert any("error" in line for line in plan.explain())
    assert loaded.render(plan.view(view)).width == 128
    with gicube.open() as other:
        gicube.load_planned(other, plan, volume, [LOOK])
        assert other.render(plan.view(view)) == loaded.render(plan.view(view))


def test_a_plan_of_light_is_for_illuminate(loaded):
    lights = [gicube.PointLight((15.5, 15.5, 1))]
    plan = gicube.plan_light(loaded, lights, view=view_of_ball(), max_error=0.5, max_rays=4, pilot_pixels=16)
    assert loaded.illuminate(lights, plan.settings(gicube.Illumination())).rays > 0


def test_an_error_is_shared_between_light_and_picture(loaded):
    light = gicube.share_of_light(0.1)
    assert 0 < light < 0.1
    plan = gicube.plan_light(loaded, [gicube.PointLight((15.5, 15.5, 1))], view=view_of_ball(), max_error=light,
                             max_rays=2, pilot_pixels=16)
    assert 0 <= gicube.left_for_picture(0.1, plan) <= 0.1


def test_error_bars_of_photons_fall_with_their_number():
    report = gicube.LightingReport(400, 4.0, 4.0, 0, (0,) * 6, 0, 0, 0, 1, [])
    assert report.standard_error([0.0, 1.0, 4.0]).tolist() == [0, 0.1, 0.2]


def test_a_transfer_function_says_its_values():
    look = gicube.TransferFunction([(0, (0, 0, 0)), (10, (1, 0.5, 0))], [(5, 0), (5, 1)])
    assert look.colour_at(5) == (0.5, 0.25, 0)
    assert look.opacity_at(4.9) == 0 and look.opacity_at(5) == 1


def test_coarser_volumes_say_where_they_lie():
    volume = gicube.Volume(ball(), spacing=(1, 1, 2))
    half = gicube.coarser(volume, 1)
    assert half.dims == (16, 16, 16) and half.placement.edge == 2 and half.samples.dtype == np.float32
    error = gicube.level_error(volume, half, [LOOK])
    assert error.largest_density > 0 and 0 < error.rms_density < error.largest_density and error.largest_opacity == 1
    far = gicube.fit_view(volume, width=8, height=8)
    edges = gicube.voxels_a_pixel(far, gicube.VoxelBox((0, 0, 0), volume.dims), volume.spacing)
    assert edges > 2 and gicube.level_for(edges) == int(np.log2(edges))
    part = gicube.cropped(volume, gicube.VoxelBox((4, 5, 6), (10, 11, 12)))
    assert part.dims == (10, 11, 12) and part.placement.low == (4, 5, 6)
    assert (part.samples == volume.samples[6:18, 5:16, 4:14]).all()


def test_volumes_come_back_from_files_as_they_were(tmp_path):
    values = np.random.default_rng(2).random((5, 6, 7)).astype("f4")
    gicube.write_volume(tmp_path / "a.nrrd", values, spacing=(1, 2, 3))
    with pytest.raises(TypeError, match="not ndarray"):
        gicube.write_volume(values, "a.nrrd")
    again = gicube.read_volume(tmp_path / "a.nrrd")
    assert (again.samples == values).all() and again.spacing == (1, 2, 3)
    values.astype(">u2").tofile(tmp_path / "a.raw")
    raw = gicube.RawLayout((7, 6, 5), gicube.SampleType.UINT16, big_endian=True)
    assert gicube.read_volume(tmp_path / "a.raw", raw).dims == (7, 6, 5)
    with pytest.raises(gicube.FileError) as fault:
        gicube.read_volume(tmp_path / "none.nrrd")
    assert fault.value.faults[0].file.endswith("none.nrrd")


def test_equal_records_are_equal_as_bytes(loaded):
    # glibc fills what it hands out and takes back, so that what nobody has written shows.
    libc = ctypes.CDLL(None)
    perturb = -6
    rays = gicube.rays_between([(3, 4, 5)] * 64, [(20, 21, 22)] * 64)
    try:
        bytes_of = []
        for fill in (0x5A, 0xC3):
            libc.mallopt(perturb, fill)
            image = loaded.render(view_of_ball(width=24))
            traced = loaded.receive(loaded.submit(rays, type=gicube.RayType.SEGMENT)).rays
            bytes_of.append((image.pixels.tobytes(), traced.tobytes()))
    finally:
        libc.mallopt(perturb, 0)
    assert bytes_of[0] == bytes_of[1]


def test_a_scene_is_rendered(tmp_path):
    scene = gicube.parse_scene('volume { builtin: "buckyball" size: 32 } image { width: 40 height: 30 }')
    with gicube.open() as board:
        image = board.render(gicube.load_scene(board, scene.set_up()))
    image.save(tmp_path / "a.png", (1, 1, 1))
    image.save(tmp_path / "a.exr")
    assert image.rgb.max() > 100 and (tmp_path / "a.exr").stat().st_size > 100
    with pytest.raises(gicube.InputError) as fault:
        gicube.parse_scene("volume { file: 3 }\nnonsense: 1")
    assert fault.value.faults[0].line == 1


def test_a_scene_names_files_of_its_own_folder_unless_it_is_trusted(tmp_path):
    (tmp_path / "own").mkdir()
    text = 'volume { builtin: "buckyball" size: 16 } transfer_function { file: "../a.tf" }'
    (tmp_path / "own" / "a.scene").write_text(text)
    (tmp_path / "a.tf").write_text("values absolute\ncolour 0 1 0 0\nopacity 0 0\nopacity 9 1\n")
    for read in (gicube.read_scene, lambda _, **how: gicube.parse_scene(text, folder=tmp_path / "own", **how)):
        with pytest.raises(gicube.InputError, match="transfer_function.file: expected a file in this file's folder"):
            read(tmp_path / "own" / "a.scene")
        read(tmp_path / "own" / "a.scene", allow_outside=True)


def test_a_lit_scene_keeps_its_exposure_and_may_be_loaded_without_light():
    path = Path(__file__).parents[3] / "samples/scenes/golden_ring.scene"
    scene = gicube.parse_scene(path.read_text().replace("size: 128", "size: 32").replace("rays_per_face_voxel: 32",
        "")).set_up()
    assert scene.is_lit and scene.view.exposure > 0
    with gicube.open() as board:
        assert not gicube.load_scene(board, scene, light=False).irradiance
        assert "dsp.lighting_rays" not in board.counters or board.counters["dsp.lighting_rays"] == 0
        view = gicube.load_scene(board, scene)
        assert view.irradiance and view.exposure == scene.view.exposure
        assert board.counters["dsp.lighting_rays"] > 0


def test_a_view_of_a_box_is_nearer_than_that_of_the_whole():
    volume = gicube.Volume(np.zeros((16, 16, 16), "u1"))
    whole, part = gicube.fit_view(volume), gicube.fit_view(volume, box=gicube.VoxelBox((4, 4, 4), (4, 4, 4)))
    assert part.look_at == pytest.approx((5.5, 5.5, 5.5)) and whole.look_at == pytest.approx((7.5, 7.5, 7.5))
    assert math.dist(part.eye, part.look_at) < 0.5 * math.dist(whole.eye, whole.look_at)


def test_a_counter_that_is_not_there_is_named_with_the_nearest(loaded):
    counters = loaded.counters
    for read in (counters.__getitem__, counters.unit):
        with pytest.raises(KeyError, match="expected a counter .* 'bus.down.byte'; the nearest is 'bus.down.bytes'"):
            read("bus.down.byte")
    assert counters.get("bus.down.byte", 7) == 7 and "bus.down.byte" not in counters


def test_counters_only_grow(loaded):
    begin = loaded.counters
    loaded.render(view_of_ball())
    window = loaded.counters - begin
    assert window["bus.up.bytes"] > 64 * 64 * 4 and window.unit("bus.up.bytes") == "byte"
    assert "<table>" in window._repr_html_()
    assert window.get("no.such", 0) == 0


@pytest.mark.board(bus=["pci33", "agp2x"])
def test_a_faster_bus_takes_less_time(board, board_setup):
    with Window(board) as upload:
        board.load_volume(np.random.default_rng(3).integers(1, 255, (64, 64, 64)).astype("u1"))
    assert_counter(upload, "bus.volume.bytes", 64**3 * 36 / 8)
    rate = {"pci33": 131.8e6, "agp2x": 470.6e6}[board_setup.bus]
    assert_time(upload, 64**3 * 36 / 8 / rate * 1e12, 0.1)
    with pytest.raises(AssertionError, match="expected 0.5 within 1%"):
        assert_share(upload, "bus.down.busy_ps", 0.5, 0.01)


def test_a_setup_is_read_from_the_environment():
    made = BoardSetup.from_environment({"GICUBE_TEST_BUS": "pci33", "GICUBE_TEST_SET": "a=1 b=2",
                                        "GICUBE_TEST_SEED": "7"})
    assert made.uri() == "emu:?bus=pci33&set=a=1&set=b=2" and made.seed == 7


@pytest.mark.board(faults="fault { direction: down message: 60 kind: kill }")
def test_a_card_that_dies_is_reopened(board):
    with pytest.raises(gicube.DeviceLost) as lost:
        for _ in range(100):
            board.counters
    assert lost.value.cause is gicube.Loss.CLOSED
    assert not board.reopen().resumed
    board.load_volume(ball())


@pytest.mark.parametrize("edge", [32, 128])  # of the card; the smaller one does not store the volume whole
def test_a_volume_in_planes_has_the_pictures_of_one_in_memory(edge):
    samples = ball(40, 15).astype("float32")
    view = gicube.fit_view(gicube.Volume(samples), [LOOK], width=24, height=24)
    asked = []

    def read(first, count):
        asked.append((first, count))
        return samples[first : first + count]

    def broken(first, count):
        raise OSError("no such plane")

    pictures = []
    for volume in (samples, gicube.VolumeStream(read, (40, 40, 40), gicube.SampleType.FLOAT32)):
        with gicube.open(f"emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels={edge}") as board:
            board.load_volume(volume)
            board.set_transfer_function(LOOK)
            pictures.append(board.render(view).pixels)
            with pytest.raises(OSError, match="no such plane"):
                board.load_volume(gicube.VolumeStream(broken, (40, 40, 40)))
            with pytest.raises(gicube.BadArgument, match="^read: "):
                board.load_volume(gicube.VolumeStream(lambda first, count: samples[:1], (40, 40, 40)))
            assert (board.render(view).pixels == pictures[-1]).all()
    assert (pictures[0] == pictures[1]).all()
    assert sum(count for _, count in asked) == 2 * 40


def test_blocks_seen_from_afar_are_sent_in_cells():
    volume = ball(40, 15)
    view = gicube.fit_view(gicube.Volume(volume), [LOOK], width=8, height=8)  # a pixel is some five voxels wide
    with gicube.open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=32", max_waiting_rays=1024) as board:
        board.load_volume(volume)
        board.set_transfer_function(LOOK)
        exact = board.render(view).pixels
        detail = board.brick_detail()
        assert detail.blocks[0] > 0 and detail.blocks[1:] == (0, 0, 0)
        assert detail.largest_density == detail.largest_opacity == 0
        board.set_brick_detail(1)
        assert board.render(view).pixels.tobytes() != exact.tobytes()
        detail = board.brick_detail()
        assert detail.blocks[2] > 0 and detail.blocks[0] == 0
        assert 0 < detail.largest_density < 4096 and 0 < detail.largest_opacity <= 1
        with pytest.raises(gicube.BadArgument, match="detail: expected 0..64"):
            board.set_brick_detail(-1)
    with pytest.raises(gicube.BadArgument, match="max_waiting_rays: expected at least 1024"):
        gicube.open(max_waiting_rays=10)
    with gicube.open() as board:
        board.load_volume(volume)
        board.set_transfer_function(LOOK)
        board.render(view)
        assert board.brick_detail() is None


class ThreadRank:
    """A rank of a job whose ranks are threads."""

    def __init__(self, rank, ranks, barrier, letters):
        self.rank, self.ranks = rank, ranks
        self._barrier, self._letters = barrier, letters

    def _all(self, own):
        self._letters[self.rank] = own
        self._barrier.wait(60)
        came = list(self._letters)
        self._barrier.wait(60)
        return came

    def exchange(self, parts):
        return [each[self.rank] for each in self._all(parts)]

    def sum(self, value):
        return sum(self._all(value))


def test_boards_that_share_blocks_make_the_picture_of_one():
    view = gicube.fit_view(gicube.Volume(ball(40, 15)), [LOOK], width=24, height=24)
    barrier, letters, pictures = threading.Barrier(2), [None, None], [None, None]

    def work(rank):
        with gicube.open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=32") as board:
            board.share_blocks(ThreadRank(rank, 2, barrier, letters))
            board.load_volume(ball(40, 15))
            board.set_transfer_function(LOOK)
            pictures[rank] = board.render(view).pixels
            assert board.counters["dsp.forwarded_rays"] > 0

    threads = [threading.Thread(target=work, args=(rank,)) for rank in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with gicube.open() as board:
        board.load_volume(ball(40, 15))
        board.set_transfer_function(LOOK)
        expected = board.render(view).pixels
    assert (pictures[0] == expected).all() and (pictures[1] == expected).all()


def test_a_request_of_another_kind_is_named(loaded):
    rays = gicube.rays_between([(1, 1, 1)], [(9, 9, 9)])
    with pytest.raises(gicube.BadArgument,
                       match="request: expected a RayRequest, or its fields by their names, got <RayType.DEPOSIT"):
        loaded.submit(rays, gicube.RayType.DEPOSIT)
    request = gicube.RayRequest(gicube.RayType.OPACITY, step=1)
    one, other = (loaded.receive(loaded.submit(rays, *given, **fields)).rays
                  for given, fields in (((request,), {}),
                                        ((gicube.RayRequest(),), {"type": gicube.RayType.OPACITY, "step": 1})))
    assert (one == other).all()


def test_calls_take_a_record_or_its_fields(loaded):
    view = view_of_ball(irradiance=True)
    lamp = gicube.PointLight((15.5, 15.5, 30), 1)
    pictures = []
    for by_fields in (False, True):
        if by_fields:
            loaded.set_material(scattering=0.5, bsdf=gicube.Bsdf.DIFFUSE)
            report = loaded.illuminate([lamp], rays_per_face_voxel=4)
            pictures.append(loaded.render(view_of_ball(), irradiance=True))
        else:
            loaded.set_material(gicube.Material(scattering=0.5, bsdf=gicube.Bsdf.DIFFUSE))
            report = loaded.illuminate([lamp], gicube.Illumination(rays_per_face_voxel=4))
            pictures.append(loaded.render(view))
        assert report.rays > 0
    assert pictures[0] == pictures[1] and pictures[0].rgb.max() > 0
    with pytest.raises(gicube.BadArgument, match="view: expected a View, or its fields by their names, got <Bsdf"):
        loaded.render(gicube.Bsdf.DIFFUSE)
    with pytest.raises(TypeError, match="step_size"):
        loaded.render(step_size=1)


def test_an_exchange_that_is_wrong_is_named(board):
    class Wrong(ThreadRank):
        def exchange(self, parts):
            return ["no bytes"]

    with pytest.raises(gicube.BadArgument, match="exchange: expected a rank of 0..ranks"):
        board.share_blocks(ThreadRank(3, 2, None, None))
    board.share_blocks(Wrong(0, 1, threading.Barrier(1), [None]))
    board.load_volume(ball(40, 15))
    board.set_transfer_function(LOOK)
    with pytest.raises(gicube.BadArgument, match="exchange\\(\\): expected a list of bytes"):
        board.render(view_of_ball())
