"""Tables of the charts: fronts of several tables, rows of held-out pairs; each chart of the documents is its table's."""
import itertools
import pathlib

import pytest

from studies import charts, held_out, plots, sampled
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


def test_pairs_without_their_scans_are_left_out(tmp_path, monkeypatch, capsys):
    file = tmp_path / "pairs.txt"
    file.write_text("# NAME PROGRAM ARGUMENTS\n\nball    render builtin:buckyball --set asic.queue_rays=64\nscan  render @head/a.nrrd --step 1\n")
    monkeypatch.setattr(held_out, "DATA", tmp_path / "none")
    ball = ("ball", "render", "", "builtin:buckyball --set asic.queue_rays=64")
    assert list(held_out.pairs_of(file)) == [ball]
    assert capsys.readouterr().out == "scan: no scans, left out\n"
    monkeypatch.setattr(held_out, "DATA", tmp_path)
    assert list(held_out.pairs_of(file)) == [ball, ("scan", "render", "", "@head/a.nrrd --step 1")]
    assert held_out.queue_rays(ball[3]) == 64 and held_out.queue_rays("") == 256


def test_a_pair_is_measured_on_every_level_with_its_light_and_goes_on_where_it_was(tmp_path, monkeypatch):
    """By a program of as many milliseconds, cycles, packets and missed voxels as it is told by its level, in a picture and a pass."""
    program = tmp_path / "gicube-render"
    program.write_text(f'''#!/usr/bin/python3
import json, pathlib, sys
words = sys.argv[1:]
with open("{tmp_path}/calls", "a") as calls:
    print(words[0], file=calls)
size = [90, 98, 100, 101][["functional", "approximate", "cycle"].index(words[words.index("--fidelity") + 1]) + ("asic.queue_rays=63" in words)]
counters = {{"asic.cycles": size, "rdram.reads": size, "rdram.writes": 0, "processor.cache.checks": 25, "processor.cache.missed_voxels": size}}
counters = {{name: {{"value": value}} for name, value in counters.items()}}
pathlib.Path(words[words.index("--stats") + 1]).write_text(json.dumps(
    {{"frame_ms": size, "counters": counters, "lighting": [{{"reused": False, "pass_ms": size, "counters": counters}}]}}))
''')
    program.chmod(0o755)
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("ball  render @ball --set asic.queue_rays=64\n")
    monkeypatch.setattr(held_out, "DATA", tmp_path)  # scans are beside the source's folder, or nowhere
    for _ in range(2):
        held_out.measure(pairs, tmp_path / "runs", tmp_path, tmp_path / "out.csv")
        assert (tmp_path / "calls").read_text().splitlines() == [f"{tmp_path}/ball"] * 4
    (row,) = rows_of(tmp_path / "out.csv")
    assert list(row) == held_out.COLUMNS
    assert [row[name] for name in held_out.COLUMNS[:10]] == ["ball", "-0.02", "-0.02", "-0.02", "0.5", "0.01", "0.01", "0.01", "-0.1", "approximate"]
    assert row["command"] == "render @ball --set asic.queue_rays=64"


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(FileError, match="none/a.csv: file: expected a place to write to, got No such file or directory"):
        write_whole(tmp_path / "none/a.csv", "x")
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileError, match="folder: file: expected a place to write to, got Is a directory"):
        write_whole(tmp_path / "folder", "x")
    assert [file.name for file in tmp_path.iterdir()] == ["folder"]


def test_a_link_is_followed_and_a_mode_kept_and_what_is_read_only_refused(tmp_path):
    (tmp_path / "a").touch(0o640)
    (tmp_path / "link").symlink_to("a")
    write_whole(tmp_path / "link", "x")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "a").read_text() == "x"
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640
    (tmp_path / "a").chmod(0o444)
    with pytest.raises(FileError, match="link: file: expected a place to write to, got Permission denied"):
        write_whole(tmp_path / "link", "y")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a", "link"] and (tmp_path / "a").read_text() == "x"


def test_a_files_rights_are_those_that_the_user_gives_new_files(tmp_path):
    write_whole(tmp_path / "a", "ä\n")
    pathlib.Path(tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode and (tmp_path / "a").read_bytes() == b"\xc3\xa4\n"


def test_series_of_commands_have_their_input_made_once_and_are_measured_in_four_ways(tmp_path):
    """By a program of 100 cycles and packets, 101 and 98 where it samples, and 90 at other levels, that says how it was called."""
    program = tmp_path / "gicube-cone-beam"
    program.write_text(f'''#!/usr/bin/python3
import json, pathlib, sys
words = sys.argv[1:]
with open("{tmp_path}/calls", "a") as calls:
    print(*words[:2], file=calls)
if "--stats" in words:
    sampled = "--sample" in words
    cycles = 101 if sampled else 100 if words[words.index("--fidelity") + 1] == "cycle" else 90
    counters = {{"asic.cycles": cycles, "ddr.reads": 60, "ddr.writes": 38 if sampled else 40, "processor.cache.missed_voxels": 8}}
    stats = {{"board_ms": cycles, "counters": {{name: {{"value": value}} for name, value in counters.items()}}}}
    if sampled:
        stats["sampled"] = {{"commands": 7, "estimated_commands": 3, "cycles": {{"sum": 101, "within": 2.02}},
                            "packets": {{"sum": 98, "within": 0.98}}, "missed_voxels": {{"sum": 8, "within": 0}}}}
    pathlib.Path(words[words.index("--stats") + 1]).write_text(json.dumps(stats))
''')
    program.chmod(0o755)
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("# NAME\nviews  cone-beam project a -o {work}/a.nrrd ; reconstruct {work}/a --size 4,4,4\n")
    for _ in range(2):
        sampled.measure(pairs, tmp_path / "runs", tmp_path, tmp_path / "out.csv")
        calls = (tmp_path / "calls").read_text().splitlines()
        assert calls == ["project a", *[f"reconstruct {tmp_path}/runs/views/a"] * (4 * sampled.ROUNDS)]
    (row,) = rows_of(tmp_path / "out.csv")
    assert list(row) == sampled.COLUMNS
    assert [row[name] for name in sampled.COLUMNS[:12]] == ["views", "7", "4", "0.01", "0.02", "-0.02", "0.01", "0", "0", "-0.1", "0", "-0.1"]
    assert row["command"] == "cone-beam reconstruct {work}/a --size 4,4,4"
