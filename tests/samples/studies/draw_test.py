"""Charts: the same bytes each time, text as text, labels that do not cover one another."""
import re

import pytest

from studies import draw

LINES = [draw.Series("one", [1, 2, 4], [3.0, 5.0, 8.0]), draw.Series("another", [1, 2, 4], [3.0, 5.0, 8.1])]


def drawn(path, *arguments, **fields):
    draw.chart(path, *arguments, **fields)
    return path.read_text()


def test_a_chart_has_the_same_bytes_each_time_and_its_words_as_text(tmp_path):
    text = drawn(tmp_path / "a.svg", "It grows", "edge, voxels", "seconds", LINES, log_x=True)
    assert text == drawn(tmp_path / "b.svg", "It grows", "edge, voxels", "seconds", LINES, log_x=True)
    for words in ("It grows", "edge, voxels", "seconds", "one", "another"):
        assert f">{words}</text>" in text
    assert not re.search(r"20\d\d-|Matplotlib|<!--", text)
    assert len(text) < 20_000


def test_labels_of_lines_that_end_together_are_moved_apart(tmp_path):
    text = drawn(tmp_path / "a.svg", "t", "x", "y", LINES)
    heights = {name: float(re.search(rf'y="([\d.]+)"[^>]*>{name}</text>', text)[1]) for name in ("one", "another")}
    assert heights["one"] - heights["another"] >= 11  # downwards, at nine points of type


def test_a_missing_value_is_left_out_and_a_point_of_a_series_without_line_is_named_in_a_box(tmp_path):
    text = drawn(tmp_path / "a.svg", "t", "x", "y",
                 [draw.Series("runs", [1, 2, 3], [1.0, float("nan"), 2.0], look="points")])
    assert len(re.findall(rf"<use[^>]*{draw.COLOURS[0].lower()}", text)) == 3  # two runs and the box's
    assert ">runs</text>" in text


def test_an_eighth_series_is_refused(tmp_path):
    with pytest.raises(ValueError, match="series of y: expected at most 7, got 8"):
        draw.chart(tmp_path / "a.svg", "t", "x", "y", [draw.Series(str(i), [1], [1]) for i in range(8)])
    with pytest.raises(ValueError, match="one: expected as many x as y, got 2 and 1"):
        draw.chart(tmp_path / "a.svg", "t", "x", "y", [draw.Series("one", [1, 2], [1])])
    assert not list(tmp_path.iterdir())


def test_bars_are_named_by_their_x(tmp_path):
    text = drawn(tmp_path / "a.svg", "t", "x", "y",
                 [draw.Series("a", ["few", "many"], [1, 2]), draw.Series("b", ["few", "many"], [2, 1])],
                 bars=True)
    assert text.count(draw.COLOURS[0].lower()) == 3 and ">few</text>" in text and ">many</text>" in text
