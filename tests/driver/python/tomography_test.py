"""The operator pair in Python, and the conventions of views."""

import os
import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gicube

VIEWS = gicube.circular_views(60, 100, np.linspace(0, 2 * np.pi, 9, endpoint=False), pitch=(1.5, 2), offset=(1, -2),
                              heights=np.arange(9) - 4.0)


@pytest.fixture
def projector():
    with gicube.open("emu:?set=asic.block_voxels=16") as board:
        yield gicube.Projector(board, dims=(16, 14, 12), spacing=(1, 1, 1.5), columns=20, rows=30, views=VIEWS,
                               step=0.5)


def seen_at(view, place):
    """Column and row from the detector's middle, by the definition."""
    source, centre, u, v = view.reshape(4, 3)
    on = np.linalg.solve(np.stack([u, v, source - np.asarray(place)], 1), source - centre)
    return on[0], on[1]


def test_project_and_backproject_are_each_others_transpose(projector):
    random = np.random.default_rng(1)
    x, y = random.random((12, 14, 16), "f4"), random.random((9, 30, 20), "f4")
    seen, back = projector.project(x), projector.backproject(y)
    assert seen.shape == (9, 30, 20) and back.shape == (12, 14, 16)
    assert np.vdot(seen.astype("f8"), y) == pytest.approx(np.vdot(x, back.astype("f8")), rel=1e-3)
    assert np.array_equal(projector.project(x, [7, 2]), seen[[7, 2]])
    assert projector.counts[0] > 1000 and projector.counts[2] == 0


def test_a_ball_is_seen_where_the_view_puts_it(projector):
    volume = np.zeros((12, 14, 16))
    volume[9, 4, 12] = 1
    place = (12 - 7.5, 4 - 6.5, 1.5 * (9 - 5.5))
    for view, seen in zip(VIEWS, projector.project(volume)):
        rows, columns = np.mgrid[0:30, 0:20]
        wanted = seen_at(view, place)
        assert (columns * seen).sum() / seen.sum() - 9.5 == pytest.approx(wanted[0], abs=0.1)
        assert (rows * seen).sum() / seen.sum() - 14.5 == pytest.approx(wanted[1], abs=0.1)


def test_circular_views_are_those_of_the_drawing():
    view = gicube.circular_views(500, 800, np.radians(30), pitch=2, offset=(5, 7))[0]
    c, s = np.cos(np.radians(30)), 0.5
    assert np.allclose(view, [500 * c, 250, 0, -300 * c - 2.5, -150 + 5 * c, 7, -1, 2 * c, 0, 0, 0, 2])


def test_tigre_puts_places_where_its_own_formulas_do():
    # TIGRE's computeDeltas_Siddon for one view, step by step: a corner and its neighbours are turned and moved, then
    # taken differences of.
    geo = SimpleNamespace(mode="cone", DSD=900.0, DSO=600.0, dDetector=np.array([1.5, 2.0]),
                          nDetector=np.array([10, 12]),
                          offOrigin=np.array([3.0, -2.0, 1.0]), offDetector=np.array([4.0, -6.0]),
                          rotDetector=np.array([0.1, -0.05, 0.2]), COR=1.5)
    angles = np.array([[0.4, 0.1, -0.3], [1.0, 0.0, 0.0]])
    for view, (alpha, theta, psi) in zip(gicube.tigre_views(geo, angles), angles):

        def euler(p):
            ca, sa, ct, st, cp, sp = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta), np.cos(psi), np.sin(
                psi)
            return np.array([[ca * ct * cp - sa * sp, -ca * ct * sp - sa * cp, ca * st],
                             [sa * ct * cp + ca * sp, -sa * ct * sp + ca * cp, sa * st], [-st * cp, st * sp, ct]]) @ p

        def tilted(p):
            (r, q, w) = geo.rotDetector
            cr, sr, cq, sq, cw, sw = np.cos(r), np.sin(r), np.cos(q), np.sin(q), np.cos(w), np.sin(w)
            return np.array([[cr * cq, cr * sq * sw - sr * cw, cr * sq * cw + sr * sw],
                             [sr * cq, sr * sq * sw + cr * cw, sr * sq * cw - cr * sw], [-sq, cq * sw, cq * cw]]) @ p

        def pixel(i, j):  # column and row of the projection as it is stored, rows upwards
            flat = tilted(np.array([0, 2.0 * (i - 6 + 0.5), 1.5 * (5 - 0.5 - (10 - 1 - j))]))
            moved = euler(flat + [-(900.0 - 600.0), -6.0, 4.0]) - geo.offOrigin[::-1]
            return moved + 1.5 * np.array([-np.sin(alpha), np.cos(alpha), 0])

        source = euler(np.array([600.0, 0, 0])) - geo.offOrigin[::-1] + 1.5 * np.array([-np.sin(alpha), np.cos(alpha),
            0])
        assert np.allclose(view[:3], source)
        for i, j in [(0, 0), (11, 0), (3, 9)]:
            mine = view[3:6] + (i - 5.5) * view[6:9] + (j - 4.5) * view[9:]
            assert np.allclose(mine, pixel(i, j)), (i, j)
    assert gicube.tigre_views(geo, [0.0, 1.0]).shape == (2, 12)
    geo.offDetector = np.array([[4.0, -6.0], [4.0, -6.0]])
    assert np.allclose(gicube.tigre_views(geo, angles[:, 0])[1], gicube.tigre_views(geo, angles[1:, 0].repeat(2))[0])


def test_what_is_wrong_is_named(projector):
    for call, words in [
        (lambda: projector.project(np.zeros((12, 14, 15))), r"volume: expected the shape \(12, 14, 16\)"),
        (lambda: projector.project(np.full((12, 14, 16), np.nan)), "volume: expected finite values"),
        (lambda: projector.backproject(np.zeros((9, 30, 19))), "values: expected the shape"),
        (lambda: projector.project(np.zeros((12, 14, 16)), [9]), r"views: expected indices of 0\.\.8"),
        (lambda: gicube.Projector(None, dims=(4, 4, 4), columns=4, rows=4, views=np.zeros((2, 11))),
         "views: expected the shape"),
        (lambda: gicube.tigre_views(SimpleNamespace(mode="parallel"), [0.0]), "geo.mode: expected \"cone\""),
    ]:
        with pytest.raises(gicube.BadArgument, match=words):
            call()


def test_a_closed_board_is_named():
    board = gicube.open("emu:?set=asic.block_voxels=16")
    projector = gicube.Projector(board, dims=(8, 8, 8), columns=4, rows=4, views=VIEWS)
    board.close()
    with pytest.raises(gicube.DeviceLost):
        projector.project(np.zeros((8, 8, 8)))


def test_a_scan_of_dxchange_shows_a_ball_where_it_is(tmp_path):
    h5py = pytest.importorskip("h5py")
    degrees = np.arange(0, 360, 6.0)
    place, radius, mu = np.array([6.0, -3.0, 4.0]), 4.0, 0.1
    chords = []  # of the rays to all pixels through the ball, in closed form
    for view in gicube.circular_views(200, 400, np.radians(degrees), pitch=2):
        source, centre, u, v = view.reshape(4, 3)
        rows, columns = np.mgrid[0:26, 0:30]
        ray = centre + (columns - 14.5)[..., None] * u + (rows - 12.5)[..., None] * v - source
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        beside = np.linalg.norm(np.cross(ray, place - source), axis=-1)
        chords.append(2 * np.sqrt(np.maximum(radius**2 - beside**2, 0)))
    lines = mu * np.array(chords)
    scan = tmp_path / "scan.textproto"
    scan.write_text('dxchange: "tomo.h5" source_to_axis: 200 source_to_detector: 400 '
                    'detector { pitch_u: 2 } volume { size: [30, 30, 26] }')

    def reconstructed(**data_sets):
        with h5py.File(tmp_path / "tomo.h5", "w") as file:
            for name, values in data_sets.items():
                file["exchange/" + name] = values
        program = Path(os.environ["GICUBE_BOARD"]).parent / "gicube-cone-beam"
        done = subprocess.run([program, "reconstruct", scan, "-o", "v.nrrd", "--quiet"], cwd=tmp_path,
                              capture_output=True, text=True)
        return gicube.read_volume(tmp_path / "v.nrrd").samples if done.returncode == 0 else done.stderr

    def expect_the_ball(volume):
        weight = volume > mu / 2
        z, y, x = ((weight * index).sum() / weight.sum() for index in np.mgrid[0:26, 0:30, 0:30])
        assert (x - 14.5, y - 14.5, z - 12.5) == pytest.approx(tuple(place), abs=0.3)
        assert volume[16:18, 11:13, 20:22].mean() == pytest.approx(mu, rel=0.03)
        assert abs(volume[8:10, 17:19, 8:10].mean()) < 0.02 * mu  # through the middle from there

    counts = np.round(100 + 60000 * np.exp(-lines)).astype("u2")
    flat = {"data_white": np.full((3, 26, 30), 60100, "u2"), "data_dark": np.full((2, 26, 30), 100, "u2")}
    expect_the_ball(reconstructed(data=counts, theta=degrees, **flat))
    expect_the_ball(reconstructed(data=lines[::-1].astype("f4"), theta=degrees[::-1]))
    assert "views: expected 59, one an angle, got 60" in reconstructed(data=lines, theta=degrees[1:])
    assert '"/exchange/theta"' in reconstructed(data=lines)
