"""Tables of the charts: fronts of several tables, rows of pairs; each chart of the documents is its table's."""
import itertools
import pathlib
import sys

import pytest

from studies import charts, levels, plots
from studies.table import FileError, pareto, rows_of, write_whole


def test_points_of_several_tables_have_a_front_for_each_cost(tmp_path):
    (tmp_path / "a.csv").write_text("series,e,ms,bus,n,command\nx y,1,10,9,10,\"do, a\"\n\n\nx y,3,5,1,10,b\n")
    (tmp_path / "b.csv").write_text("series,e,ms,bus,n,command\nz,2,40,0.5,10,c\n")
    pareto(tmp_path / "out.csv", [tmp_path / "a.csv", tmp_path / "b.csv"], error="e", costs=["ms", "bus"], per="n")
    assert (tmp_path / "out.csv").read_text() == (
        "series,error,ms,bus,front ms,front bus,command\nx y,1,1,0.9,1,1,\"do, a\"\n"
                                                  "x y,3,0.5,0.1,1,0,b\nz,2,4,0.05,0,1,c\n")


def test_the_fronts_of_the_documents_are_those_of_their_tables(tmp_path):
    pareto(tmp_path / "front.csv", [charts.CHARTS / "form_factors_trade.csv"], error="error",
           costs=["board_ms", "bus_ms"], per="pairs",
           series=("bus", "made"))
    assert (tmp_path / "front.csv").read_text() == (charts.CHARTS / "form_factors_front.csv").read_text()


def test_every_chart_is_drawn_from_its_tables_and_no_other_is_in_the_folder(tmp_path):
    for table in charts.CHARTS.glob("*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    assert plots.DRAWN.keys() == charts.MEASURED.keys()
    for draw in itertools.chain(*plots.DRAWN.values()):
        draw(tmp_path)
    drawn = {file.name: file.read_text() for file in tmp_path.glob("*.svg")}
    assert drawn == {file.name: file.read_text() for file in charts.CHARTS.glob("*.svg")}


def test_the_program_measures_and_draws_what_is_named(tmp_path, monkeypatch):
    log = []
    monkeypatch.setitem(charts.MEASURED, "boards", lambda jobs: log.append(("measured", jobs)))
    monkeypatch.setitem(plots.DRAWN, "boards", [lambda folder: log.append(("drawn", folder))])
    monkeypatch.setattr(charts, "CHARTS", tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setenv("GICUBE_BOARD", "")
    monkeypatch.chdir(charts.ROOT)
    for arguments, done in ((["boards", "--jobs", "3"], [("measured", 3), ("drawn", tmp_path)]),
                            (["--draw", "boards"], [("drawn", tmp_path)])):
        monkeypatch.setattr(sys, "argv", ["script/charts", *arguments])
        charts.main()
        assert log == done
        log.clear()


def test_pairs_without_their_scans_are_left_out(tmp_path, monkeypatch, capsys):
    file = tmp_path / "pairs.txt"
    file.write_text("# NAME PROGRAM ARGUMENTS\n\nball    render builtin:buckyball --set asic.queue_rays=64\nscan  "
                    "render @head/a.nrrd --step 1\n")
    monkeypatch.setattr(levels, "DATA", tmp_path / "none")
    ball = ("ball", "render", "", "builtin:buckyball --set asic.queue_rays=64")
    assert list(levels.pairs_of(file)) == [ball]
    assert capsys.readouterr().out == "scan: no scans, left out\n"
    monkeypatch.setattr(levels, "DATA", tmp_path)
    assert list(levels.pairs_of(file)) == [ball, ("scan", "render", "", "@head/a.nrrd --step 1")]


def test_a_pair_is_measured_at_both_levels_with_its_light_and_goes_on_where_it_was(tmp_path, monkeypatch):
    """By a program whose picture and pass take as many milliseconds as its level says; its input is made once."""
    program = tmp_path / "gicube-render"
    program.write_text(f'''#!/usr/bin/python3
import json, pathlib, sys
words = sys.argv[1:]
with open("{tmp_path}/calls", "a") as calls:
    print(words[0], file=calls)
if "--stats" in words:
    ms = {{"functional": 90, "cycle": 100}}[words[words.index("--fidelity") + 1]]
    lighting = [{{"reused": False, "pass_ms": ms}}]
    pathlib.Path(words[words.index("--stats") + 1]).write_text(json.dumps({{"frame_ms": ms, "lighting": lighting}}))
''')
    program.chmod(0o755)
    pairs = tmp_path / "pairs.txt"
    pairs.write_text("ball  render make ; @ball --step 1\n")
    monkeypatch.setattr(levels, "DATA", tmp_path)  # scans are beside the source's folder, or nowhere
    for _ in range(2):
        levels.measure(pairs, tmp_path / "runs", tmp_path, tmp_path / "out.csv")
        assert (tmp_path / "calls").read_text().splitlines() == ["make"] + [f"{tmp_path}/ball"] * 2
    (row,) = rows_of(tmp_path / "out.csv")
    assert list(row) == levels.COLUMNS
    assert (row["pair"], row["functional_time_error"], row["command"]) == ("ball", "-0.1", "render @ball --step 1")
    assert all(float(row[f"{level}_s"]) > 0 for level in levels.LEVELS)


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(FileError,
                       match="none/a.csv: file: expected a place to write to, got No such file or directory"):
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
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode and (tmp_path /
        "a").read_bytes() == b"\xc3\xa4\n"
