"""Tables of the studies: CSV files, and the Pareto fronts of their rows."""
import contextlib
import csv
import errno
import io
import math
import operator
import os
import pathlib
import shutil


class FileError(Exception):
    """A file can't be read or written."""


def write_whole(path, text):
    """Replaces the file atomically. Like gicube/whole_file.h, it follows links, keeps the file's mode, and refuses a
    read-only file. Raises FileError."""
    place = pathlib.Path(os.path.realpath(path))
    part = place.with_name(f"{place.name}.{os.getpid()}.part")
    try:
        if place.is_file() and not (place.stat().st_mode & 0o222 and os.access(place, os.W_OK)):
            raise PermissionError(errno.EACCES, None)
        part.write_text(text, encoding="utf-8")
        if place.is_file():
            shutil.copymode(place, part)
        part.replace(place)
    except OSError as error:
        with contextlib.suppress(OSError):
            part.unlink()
        raise FileError(f"{path}: file: expected a place to write to, got {os.strerror(error.errno)}") from error


def csv_text(rows):
    """Quotes cells if necessary; lines end with a line feed."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def to_markdown(columns, rows):
    head, *body = (f"| {' | '.join(line)} |\n" for line in [columns, *rows])
    return f"{head}{'|---' * len(columns)}|\n{''.join(body)}"


def cell(value):
    """Six digits of a number; empty for not-a-number."""
    return ("" if math.isnan(value) else f"{value:.6g}") if isinstance(value, float) else value


def rows_of(file):
    """Rows of a table by the names of its columns; empty lines may separate blocks."""
    with open(file, newline="") as stream:
        return list(csv.DictReader(line for line in stream if line.strip()))


def on_front(points):
    """Points are tuples of figures; less is better. Returns for each point whether no other is at least as good in all
    figures and better in one. A point with not-a-number is not on the front."""
    return [not any(map(math.isnan, point)) and not any(all(map(operator.le, other, point)) and other != point
                                                        for other in points)
            for point in points]


def pareto(out, tables, *, error, costs, series=("series",), per=None):
    """Merges the points of several tables, with their fronts. Columns of `out`: series (these columns, joined by
    blanks), error, each cost (divided by the column `per`), front of each cost (1 or 0), command."""
    points = []
    for row in (row for table in tables for row in rows_of(table)):
        share = float(row[per]) if per else 1
        points.append((" ".join(row[column] for column in series), float(row[error]),
                       [float(row[cost]) / share for cost in costs], row["command"]))
    fronts = [on_front([(each[2][i], each[1]) for each in points]) for i in range(len(costs))]
    rows = [[name, cell(miss), *map(cell, paid), *(int(front[i]) for front in fronts), command]
            for i, (name, miss, paid, command) in enumerate(points)]
    write_whole(out, csv_text([["series", "error", *costs, *(f"front {cost}" for cost in costs), "command"], *rows]))
