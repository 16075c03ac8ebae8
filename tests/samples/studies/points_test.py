"""Tables that are made of points: how they are measured and kept, and that each point says what it should."""
import csv
import os
import pathlib
import threading

import numpy as np
import pytest

BIN = os.environ["GICUBE_BIN_DIR"]
os.environ["GICUBE_BOARD"] = f"{BIN}/gicube-board"

from studies import (  # noqa: E402
    boards, charts, cone_beam, form_factors, light, lighting, points, truths, volume_texture)
from studies.points import Kept, Table, measure, text_of  # noqa: E402

MODULES = {"boards": boards, "lighting": lighting, "light": light, "cone_beam": cone_beam, "form_factors": form_factors,
           "truths": truths, "volume_texture": volume_texture}


@pytest.fixture(autouse=True)
def in_the_tree(monkeypatch):
    monkeypatch.chdir(points.ROOT)
    monkeypatch.setattr(points, "BIN", pathlib.Path(BIN))


@pytest.fixture
def kept(tmp_path):
    return Kept(tmp_path / "kept")


def rows_of(table, kept, *names):
    """What the table says of these of its points."""
    text = text_of(table, [(name, table.points[name](kept)) for name in names or table.points])
    return list(csv.DictReader(text.splitlines()))


# ---- how they are measured


def counted(log, fails=()):
    def make(name):
        def measured(_):
            log.append(name)
            if name in fails:
                raise RuntimeError(name)
            return len(name)
        return measured
    return Table("t", ["name", "length"], {name: make(name) for name in ("t/a", "t/bb", "t/ccc")},
                 lambda found: ((name, [name, n]) for name, n in found))


def test_a_table_that_was_interrupted_goes_on_where_it_was(kept, tmp_path):
    log = []
    with pytest.raises(RuntimeError, match="t/bb"):
        measure([counted(log, fails=["t/bb"])], kept, tmp_path, jobs=1)
    assert log == ["t/a", "t/bb"] and not (tmp_path / "t.csv").exists()
    measure([counted(log)], kept, tmp_path, jobs=1)
    assert log == ["t/a", "t/bb", "t/bb", "t/ccc"]
    assert (tmp_path / "t.csv").read_text() == ("name,length,command\nt/a,3,script/charts --point t/a\n"
                                                "t/bb,4,script/charts --point t/bb\nt/ccc,5,script/charts --point "
                                                "t/ccc\n")


def test_what_another_board_measured_counts_no_more_and_nothing_is_kept_of_whole_tables(monkeypatch, tmp_path):
    board = tmp_path / "gicube-board"
    for name in ("BIN", "RUNS", "CHARTS"):
        monkeypatch.setattr(charts, name, tmp_path)
    log = []

    def run(fails=()):
        monkeypatch.setattr(charts, "tables_of", lambda _: [counted(log, fails)])
        if fails:
            with pytest.raises(RuntimeError):
                charts.by_points("lighting", 1)
        else:
            charts.by_points("lighting", 1)
        done = list(log)
        log.clear()
        return done
    board.write_text("one")
    assert run(fails=["t/bb"]) == ["t/a", "t/bb"]
    assert run(fails=["t/ccc"]) == ["t/bb", "t/ccc"]
    board.write_text("another")
    assert run(fails=["t/ccc"]) == ["t/a", "t/bb", "t/ccc"]
    assert run() == ["t/ccc"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["gicube-board", "t.csv"]


def test_points_are_measured_at_once_and_what_several_need_once(kept, tmp_path):
    together = threading.Barrier(2, timeout=60)
    made = []

    def measured(on_file):
        together.wait()
        return on_file.of("what both need", lambda: made.append(1) or 7)
    measure([Table("t", ["n"], {"t/a": measured, "t/b": measured}, lambda found: ((name, [n]) for name, n in found),
                   again=False)], kept, tmp_path, jobs=2)
    assert (tmp_path / "t.csv").read_text() == "n\n7\n7\n" and made == [1]


# ---- their names


def test_every_point_has_a_name_of_its_own_that_begins_with_its_table():
    names = []
    for module, programs in charts.POINTS.items():
        for table in MODULES[module].tables():
            assert table.points
            for name in table.points:
                assert name.split("/")[0] in table.name or (name.split("/")[0] == "error" and "slopes" in table.name)
                assert not set(name) & set(' ,"')
            names += table.points if table.again else []
    assert len(set(names)) == len(names) > 300


def test_the_documents_tables_have_those_points_in_that_order():
    for module in charts.POINTS:
        for table in MODULES[module].tables():
            with open(charts.CHARTS / f"{table.name}.csv") as file:
                rows = [row for row in csv.DictReader(file) if None not in row.values()]
            assert list(rows[0]) == [*table.columns, *["command"] * table.again]
            commands = dict.fromkeys(row["command"] for row in rows) if table.again else ()
            assert list(commands) == [f"script/charts --point {name}" for name in (table.points if table.again else ())]


def test_a_point_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(charts, "build", lambda *_: None)
    with pytest.raises(SystemExit, match='--point: expected a point of a table, as views/fdk/20, got "views/fdk/7"'):
        charts.print_point("views/fdk/7")


def test_a_point_by_its_name_is_its_row_of_the_table(monkeypatch, capsys):
    monkeypatch.setattr(charts, "build", lambda *_: None)
    charts.print_point("moire/view/0.5")
    header, row = capsys.readouterr().out.splitlines()
    assert row in (charts.CHARTS / "cone_beam_moire.csv").read_text().splitlines()
    assert header == "point,series,x,ripple,hat_at_the_rays_wave,command"


# ---- lighting


def test_more_lighting_rays_have_less_error():
    few, many = (lighting.measured("low", "conserving", "wide", 0.5, rays, "functional") for rays in (1, 4))
    assert 0 < many[1] < 0.5 * few[1]
    assert lighting.measured("low", "conserving", "wide", 0.5, 4, "functional") == many


def test_the_shares_of_the_light_are_those_of_the_closed_form():
    exact = lighting.closed_form()
    n = np.arange(200_000) + 0.5  # all that does not leave the box on even ways over the sphere
    height, around = 1 - 2 * n / len(n), np.pi * (1 + 5 ** 0.5) * n
    ways = np.column_stack([np.sqrt(1 - height * height) * np.cos(around),
                            np.sqrt(1 - height * height) * np.sin(around), height])
    ends = (np.where(ways > 0, 24, 0) - lighting.LAMP) / ways
    assert exact.sum() == pytest.approx((1 - np.exp(-lighting.EXTINCTION * ends.min(axis=1))).mean(), abs=1e-5)
    x, y, z = 3, 20, 7  # far from the lamp and the faces a voxel's share is the density there
    r = np.linalg.norm((x, y, z) - lighting.LAMP)
    assert exact[z, y, x] == pytest.approx(lighting.EXTINCTION * np.exp(-lighting.EXTINCTION * r) / (4 * np.pi * r * r),
                                           rel=0.01)
    assert exact[12, 11, 12] > 5 * exact[12, 11, 14]


# ---- form factors


def test_closed_forms_are_those_of_the_table():
    """Published values of these pairs, to their last digit; docs/studies/form_factors.md has the larger table."""
    assert form_factors.parallel_squares(0) == pytest.approx(0.199825, abs=5e-7)
    assert form_factors.perpendicular_rectangles(1, 1) == pytest.approx(0.200044, abs=5e-7)
    assert form_factors.parallel_squares(0.1) == pytest.approx(0.1789, abs=1e-4)
    assert form_factors.parallel_squares(1) == pytest.approx(0.0662, abs=5e-5)
    assert form_factors.parallel_squares(3) == pytest.approx(0.0074, abs=5e-5)
    # quadrature and closed form
    assert form_factors.parallel_squares(1e-12) == pytest.approx(form_factors.parallel_squares(0), abs=1e-8)
    assert form_factors.mean_inverse_square(2) == pytest.approx(0.260, abs=5e-4)
    assert form_factors.mean_inverse_square(50) * 2500 == pytest.approx(1, abs=1e-3)


def test_errors_fall_faster_than_those_of_random_points_and_are_small():
    rays = [1 << i for i in range(3, 15)]
    for form in form_factors.FORMS:
        errors = [form_factors.error_of(form, each) for each in rays]
        assert errors[-1] < 0.001, form
        # Of a near pair in a clear volume all but the last digits is known without rays.
        assert form == "common edge" or form_factors.slope_of(rays, errors) < -0.5, form


def rows_of_the_documents(name):
    with open(charts.CHARTS / f"{name}.csv") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("summary,name", [(form_factors.error_summary, "slopes"),
                                          (form_factors.hierarchy_summary, "hierarchy")])
def test_the_documents_tables_of_form_factors_are_those_of_their_points(summary, name):
    assert summary(rows_of_the_documents(f"form_factors_{name}")) in (points.ROOT /
        "docs/studies/form_factors.md").read_text()


def test_slopes_are_of_straight_lines():
    table = form_factors.error_tables()[1]
    text = text_of(table, [(f"error/parallel_kappa_1/{rays}", 3 * rays ** -0.75) for rays in (8, 16, 32)])
    assert text == "form,exact,slope,error at most rays\nparallel kappa 1,0.06616368,-0.75,0.223\n"


def test_the_trade_of_rays_says_error_cost_and_bound(kept):
    table = form_factors.trade_table()
    few, many = rows_of(table, kept, "trade/pci33/board/1", "trade/pci33/board/16")
    assert float(many["error"]) < 0.5 * float(few["error"]) < 0.1
    assert few["pairs"] == "32768" and many["pairs"] == "2048"
    assert many["bound"] == "DSP" and float(many["dsp"]) > 0.5


def test_a_hierarchy_has_fewer_links_and_what_it_misplaces_is_measured(kept):
    table = form_factors.hierarchy_table(scene="samples/scenes/radiosity/glowing_room.scene --volume-size 8",
                                         thresholds=(1e-2, 1e-4))
    coarse, fine, full = rows_of(table, kept)
    assert [row["hierarchy"] for row in (coarse, fine, full)] == ["1", "1", "0"] and full["error"] == "1e-05"
    assert int(coarse["links"]) < int(fine["links"]) < int(full["links"]) <= int(full["all_pairs"])
    assert float(coarse["difference"]) > float(fine["difference"]) > float(full["difference"]) > 0
    assert 0 < float(full["standard_error"]) < float(coarse["standard_error"])


# ---- cone beam


def test_a_points_row_is_the_same_again(kept):
    table = cone_beam.moire()
    one, other = (text_of(table, [("moire/view/0.5", table.points["moire/view/0.5"](kept))]) for _ in range(2))
    assert one == other and one.splitlines()[1].startswith("moire/view/0.5,one view along an axis,0.5,")


def test_a_scan_keeps_its_angles_in_degrees():
    scan = cone_beam.chart_scan(64, 96, 90)
    degrees = [float(word) for word in scan.text().split("angle: ")[1:]]
    assert np.abs(np.radians(degrees) - scan.angles()).max() < 1e-15


def test_a_reconstruction_is_compared_with_its_phantom_and_simulated_whole(kept):
    head = cone_beam.Case("builtin:shepp-logan-high-contrast --radius 42 --value 0.05",
                          cone_beam.chart_scan(16, 24, 12), cone_beam.PLAIN)
    plain = head.measured(kept)
    assert 0.1 < plain["relative_l2"] < 1 and plain["residuals"] == [] and plain["rays"] > 0
    whole = head.reconstruct("cycle", head.compare)
    assert whole["rays_ms"] > plain["rays_ms"] > 0 < plain["bus_ms"]
    assert whole["relative_l2"] == plain["relative_l2"]


def test_a_program_that_fails_is_named_with_what_it_said(kept):
    with pytest.raises(Exception, match="exit code 2: .*os-sart"):
        cone_beam.Case(cone_beam.HEAD, cone_beam.chart_scan(16, 24, 12), {"method": "none"}).reconstruct()


# ---- volumetric textures


def test_a_volumetric_texture_is_bound_by_the_bus_that_its_rays_cross_twice():
    pci, agp = (volume_texture.measured(bus, 1, "24x24", "functional") for bus in ("pci33", "agp4x"))
    assert pci["rays"] == agp["rays"] > 3 * pci["pixels"] > 300
    least = 2 * 32 * pci["rays"] / 132e6 * 1e3  # ms, at the paper's 132 MB/s
    assert least < pci["ms"] < 1.3 * least
    assert agp["ms"] < 0.5 * pci["ms"]


# ---- several boards


def test_several_boards_divide_a_picture_and_wait_for_a_shared_bus():
    one, own, shared = (boards.measured("strong", buses, count, "functional", 32, 64) for buses,
                        count in (("own", 1), ("own", 4), ("shared", 4)))
    assert own["bus_wait_ms"] == 0 < shared["bus_wait_ms"]
    assert one["frame_ms"] / 4 < own["frame_ms"] < 0.5 * one["frame_ms"]
    assert shared["frame_ms"] > own["frame_ms"]
    for each in (own, shared):
        parts = sum(each[part] for part in ("work_ms", "bus_ms", "bus_wait_ms", "skew_ms"))
        assert parts == pytest.approx(each["frame_ms"])
# ---- light


ROOM = """world {
  size: 16
  node { name: "floor" material: "paper" box { low { x: -1.3 y: -1.3 z: -1.3 } high { x: 1.3 y: 1.3 z: -0.3 } } }
}
material {
  name: "paper" solid { opacity: 0.5 colour { red: 0.1 green: 0.1 blue: 0.1 } }
  scattering: 0.5 scattering_colour { red: 1 green: 0.5 blue: 0 } bsdf: "diffuse"
}
light { point { position { x: 0.5 z: 2 } } power: 20 }
illumination { albedo: "low" rays_per_face_voxel: 2 exposure: 1 colour_passes: true }
phong { ambient: 0.3 diffuse: 0.7 specular: 0 }
camera { eye { y: -4 z: 3 } look_at { } fov_degrees: 30 }
background { red: 1 green: 1 blue: 1 }
"""


@pytest.fixture
def room(tmp_path):
    file = tmp_path / "room.scene"
    file.write_text(ROOM)
    return file


def test_all_methods_see_one_light_in_a_judged_scene(room):
    text = light.judged(room, rays_per_face_voxel=8, lifetime=3)
    assert ("colour { red: 0.5 green: 0.25 blue: 0 }" in text
            and "scattering_colour { red: 1 green: 0.5 blue: 0 }" in text)
    assert f"sphere {{ centre {{ x: 0.5 z: 2 }} radius: {light.LAMP} }}" in text and "point {" not in text
    assert "ambient: 0 " in text and "background" not in text
    assert "opacity: 0.5" in text and "opacity: 1 " in light.judged(room, opacity=1)
    assert "rays_per_face_voxel: 8 " in text and "lifetime: 3 " in text and "rays_per_face_voxel: 2" not in text


def test_a_mirror_of_a_judged_scene_shows_nothing_of_its_own(room):
    room.write_text(ROOM.replace('bsdf: "diffuse"', 'bsdf: "specular" seen_through_scattering: true'))
    assert "colour { red: 0 green: 0 blue: 0 }" in light.judged(room)


def test_the_error_of_a_picture_leaves_out_the_truths_own_and_what_is_beyond_white():
    truth = np.full((8, 8, 3), 0.5)
    truth[:4] = 3  # white
    none = np.zeros_like(truth)
    assert light.error(truth, truth, none) == (0, 0)
    assert light.error(np.minimum(truth, 1), truth, none) == (0, 0)
    dark, scaled = light.error(truth / 2, truth, none)  # the white half stays white
    assert dark == pytest.approx(np.sqrt(2 * 0.25 ** 2 / (2 * 1 + 2 * 0.25))) and 0 < scaled < dark
    noise = np.where(truth < 1, 4 * 0.25, 0)  # of pixels; of tiles a quarter of it
    assert light.error(truth / 2, truth, noise)[0] == pytest.approx(0, abs=1e-6)


def test_the_board_and_paths_come_near_the_truth_of_a_floor_under_a_lamp(kept, room):
    found = {method: light.measured(kept, "room", method, room, "32x32", 16, 200, "functional")
             for method in ("low-k4", "eye-16", "photons-4")}
    assert found["eye-16"]["errors"][0] < 0.1
    assert found["photons-4"]["errors"][0] < 0.3
    assert found["low-k4"]["errors"][0] < 0.6 and found["low-k4"]["light_ms"] > 0


def test_a_soft_floor_and_fog_show_the_light_that_is_in_them_and_an_opaque_floor_what_falls_on_it(kept):
    ratios = {name: float(row["shown_over_truth"])
              for name in ("light_laws/0.5/80", "light_laws/0.5/20", "light_laws/1/80", "light_laws/fog/80")
              for row in rows_of(light.tables()[1], kept, name)}
    assert ratios["light_laws/0.5/80"] < 0.8 < 0.95 < ratios["light_laws/0.5/20"]
    assert ratios["light_laws/fog/80"] == pytest.approx(4, rel=0.1)
    assert ratios["light_laws/1/80"] == pytest.approx(1, abs=0.1)


def test_the_documents_table_of_light_is_that_of_its_points():
    assert light.summary(rows_of_the_documents("light")) in (points.ROOT / "docs/studies/light.md").read_text()
