"""Tables of the charts: fronts of several tables, rows of held-out pairs; each chart of the documents is its table's."""
import itertools
import pathlib

import pytest

from studies import charts, held_out, plots
from studies.table import FileError, pareto, rows_of, write_whole


def test_points_of_several_tables_have_a_front_for_each_cost(tmp_path):
    (tmp_path / "a.csv").write_text("series,e,ms,bus,n,command\nx y,1,10,9,10,\"do, a\"\n\n\nx y,3,5,1,10,b\n")
    (tmp_path / "b.csv").write_text("series,e,ms,bus,n,command\nz,2,40,0.5,10,c\nnoisy z,0,0,0,1,d\n")
    pareto(tmp_path / "out.csv", [tmp_path / "a.csv", tmp_path / "b.csv"], error="e", costs=["ms", "bus"], per="n", without="noisy")
    assert (tmp_path / "out.csv").read_text() == ("series,error,ms,bus,front ms,front bus,command\nx y,1,1,0.9,1,1,\"do, a\"\n"
                                                  "x y,3,0.5,0.1,1,0,b\nz,2,4,0.05,0,1,c\n")


def test_the_fronts_of_the_documents_are_those_of_their_tables(tmp_path):
    names = [charts.CHARTS / f"cone_beam_{name}.csv" for name in ("views", "ray_spacing", "accumulator", "sart")]
    pareto(tmp_path / "front.csv", names, error="relative_l2", costs=["board_ms", "bus_ms"], without="photons")
    assert (tmp_path / "front.csv").read_text() == (charts.CHARTS / "cone_beam_front.csv").read_text()


def test_every_chart_is_drawn_from_its_tables_and_no_other_is_in_the_folder(tmp_path):
    for table in charts.CHARTS.glob("*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    assert plots.DRAWN.keys() == charts.MEASURED.keys()
    for draw in itertools.chain(*plots.DRAWN.values()):
        draw(tmp_path)
    drawn = {file.name: file.read_text() for file in tmp_path.glob("*.svg")}
    assert drawn == {file.name: file.read_text() for file in charts.CHARTS.glob("*.svg")}


def test_pairs_are_lines_with_a_name_and_arguments_and_those_without_their_scans_are_left_out(tmp_path, monkeypatch, capsys):
    file = tmp_path / "pairs.txt"
    file.write_text("# NAME ARGUMENTS\n\nball    builtin:buckyball --set asic.queue_rays=64\nscan    @head/a.nrrd --step 1\n")
    monkeypatch.setattr(held_out, "DATA", tmp_path / "none")
    ball = ("ball", "builtin:buckyball --set asic.queue_rays=64", ["builtin:buckyball", "--set", "asic.queue_rays=64"])
    assert list(held_out.pairs_of(file)) == [ball]
    assert capsys.readouterr().out == "scan: no scans, left out\n"
    monkeypatch.setattr(held_out, "DATA", tmp_path)
    assert list(held_out.pairs_of(file)) == [ball, ("scan", "@head/a.nrrd --step 1", [f"{tmp_path}/head/a.nrrd", "--step", "1"])]
    assert held_out.queue_rays(ball[2]) == 64 and held_out.queue_rays([]) == 256


def test_a_pair_is_measured_on_every_level_by_its_least_seconds_and_goes_on_where_it_was(tmp_path):
    """By a program that says how often it has run, and takes one millisecond more for each level."""
    render = tmp_path / "render"
    render.write_text(f'''#!/usr/bin/python3
import json, pathlib, sys
count = pathlib.Path("{tmp_path}/count")
runs = int(count.read_text()) + 1 if count.exists() else 1
count.write_text(str(runs))
words = sys.argv[1:]
level = ["functional", "approximate", "cycle"].index(words[words.index("--fidelity") + 1])
pathlib.Path(words[words.index("-o") + 1]).write_text("")
pathlib.Path(words[words.index("--stats") + 1]).write_text(json.dumps(dict(
    frame_ms=1.0 + level + ("asic.queue_rays=63" in words), hit_ratio=0.5 + level / 8, memory_gb_s=2.0 ** level, host_seconds=10.0 * level + runs,
    host=dict(board_cpu_s=float(runs)), counters={{"rdram.reads": 1, "rdram0.reads": 1, "rdram1.reads": 1}})))
''')
    render.chmod(0o755)
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("ball  builtin:buckyball --set asic.queue_rays=64\n")
    for _ in range(2):
        held_out.measure(pairs, tmp_path / "runs", render, tmp_path / "out.csv")
        (row,) = rows_of(tmp_path / "out.csv")
        assert (tmp_path / "count").read_text() == "13"  # three levels, four times, and the shorter queues
    assert list(row) == held_out.COLUMNS
    assert list(row.values()) == ["ball", "-0.33333", "0.75", "-0.125", "4", "-0.5", "-0.625", "0.33333", "0", "-0.66667", "1", "12", "23", "2",
                                  "3", "builtin:buckyball --set asic.queue_rays=64"]


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(FileError, match="none/a.csv: file: expected a place to write to, got No such file or directory"):
        write_whole(tmp_path / "none/a.csv", "x")
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileError, match="folder: file: expected a place to write to, got Is a directory"):
        write_whole(tmp_path / "folder", "x")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_a_files_rights_are_those_that_the_user_gives_new_files(tmp_path):
    write_whole(tmp_path / "a", "ä\n")
    pathlib.Path(tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode and (tmp_path / "a").read_bytes() == b"\xc3\xa4\n"
