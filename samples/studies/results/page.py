"""The page of results: Markdown, charts, and a CSV file for each table and chart."""
import pathlib
import re
import textwrap
from typing import NamedTuple

from studies import draw
from studies.table import cell, csv_text

TOLERANCE = 0.25  # a greater difference needs a reason
FOLDER = "results"
TEXT = pathlib.Path(__file__).with_name("words.md").read_text()


def joined(text):
    """Indented lines continue a line of a list; a figure's words are one line."""
    return re.sub(r"\n  (?! )", " ", text) if text.startswith("- ") else text.replace("\n", " ")


WORDS = {name: joined(text) if name.startswith("row") else text
         for name, text in re.findall(r"^## (.+?)\n\n(.+?)(?=\n+## |\n*\Z)", TEXT, re.M | re.S)}


class Claim(NamedTuple):
    """A claim of the paper and our value."""
    number: int
    differs: bool  # by more than a quarter
    claim: str
    paper: str
    ours: str
    why: str
    half: str = "-"  # ours with half-voxel steps


def differs(ours, low, high=None):
    """Whether our value is more than a quarter outside low..high; high is low by default."""
    return ours < (1 - TOLERANCE) * low or ours > (1 + TOLERANCE) * (low if high is None else high)


def number(value, digits=1):
    return f"{value:.{digits}f}"


def percent(share, digits=0):
    """"12%" of 0.12."""
    return f"{100 * share:.{digits}f}%"


def filled(text, begin=""):
    """Wraps paragraphs at 120 columns, but not headings and code."""
    def paragraph(each):
        return each if each.startswith(("#", "    ")) else textwrap.fill(
            " ".join(each.split()), 120, initial_indent=begin, subsequent_indent=" " * len(begin),
            break_long_words=False, break_on_hyphens=False)
    return "\n\n".join(map(paragraph, text.split("\n\n")))


class Page:
    def __init__(self):
        self.body = ""
        self._tables = {}  # by the names of their CSV files: rows, the first that of the columns' names
        self._charts = {}  # by the names of their SVG files: what draw.chart() takes
        self._claims = []

    def heading(self, text):
        self.body += f"## {text}\n\n" if text else ""

    def say(self, name, **figures):
        """Text of words.md with its figures."""
        self.body += filled(WORDS[name].format(**figures)) + "\n\n"

    def table(self, name, columns, rows):
        """Adds a table of printed cells, and the link to its file."""
        self._tables[name] = [columns, *rows]
        self.body += f"[{FOLDER}/{name}.csv]({FOLDER}/{name}.csv)\n\n"

    def chart(self, caption, name, title, x_label, y_label, x, series, **of_panel):
        """Adds NAME.svg, and NAME.csv with x in the first column and a series in each other. `series`: values by names,
        not-a-number for gaps; `of_panel`: fields of draw.Panel."""
        self._tables[name] = [[x_label, *series],
                              *([f"{at:g}", *map(cell, map(float, values))] for at,
                                *values in zip(x, *series.values()))]
        look = "line" if len(x) > 60 else "both"
        lines = [draw.Series(label, x, values, look=look) for label, values in series.items()]
        self._charts[name] = (title, x_label, y_label, lines), of_panel
        said = f"{caption} " if caption else ""
        self.body += f"![{title}]({FOLDER}/{name}.svg)\n\n{said}[{FOLDER}/{name}.csv]({FOLDER}/{name}.csv)\n\n"

    def picture(self, file, caption):
        self.body += f"![{caption}]({FOLDER}/{file})\n\n"

    def claim(self, row, differs, **figures):
        """Adds a row of words.md with its figures; a number may have several rows, such as "5 lighting"."""
        lines = (line[2:].split(": ", 1) for line in WORDS[f"row {row}"].format(**figures).splitlines())
        self._claims.append(Claim(int(str(row).split()[0]), differs, **dict(lines)))
        self._claims.sort(key=lambda each: each.number)

    def rows_within(self):
        return {"within": sum(not each.differs for each in self._claims), "rows": len(self._claims)}

    def claims(self):
        """The link to the table of all claims, and a list of the differences with their reasons."""
        names = ["row", "claim (paper's section)", "paper", "ours", "ours, half-voxel steps", "within a quarter"]
        rows = [[str(each.number), each.claim, each.paper, each.ours, each.half, "no" if each.differs else "yes"]
                for each in self._claims]
        self._tables["claims"] = [names, *rows]
        listed = "".join(filled(f"**{each.number}, {each.claim}**: paper {each.paper}; ours {each.ours}. Reason: "
                                f"{each.why}", "- ") + "\n" for each in self._claims if each.differs)
        return (f"[{FOLDER}/claims.csv]({FOLDER}/claims.csv) has all {len(rows)} rows. Differences of more than a "
                f"quarter:\n\n{listed}\n")

    def write_files(self, folder):
        """Writes the CSV files and charts. Raises OSError, FileError."""
        for name, rows in self._tables.items():
            (folder / f"{name}.csv").write_text(csv_text(rows))
        for name, (of_chart, of_panel) in self._charts.items():
            draw.chart(folder / f"{name}.svg", *of_chart, **of_panel)
