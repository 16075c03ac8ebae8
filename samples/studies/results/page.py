"""The page of results: Markdown, a CSV file of the same cells for each table and chart, and the charts."""
import csv
import io
import math
from dataclasses import dataclass, field
from typing import NamedTuple

from studies import draw

TOLERANCE = 0.25  # beyond it a difference needs a reason
FOLDER = "results"


@dataclass
class Table:
    name: str  # of its file, NAME.csv
    columns: list
    rows: list = field(default_factory=list)  # cells as they are printed


@dataclass
class Chart:
    """NAME.svg, and NAME.csv: x in the first column, a series in each other."""
    name: str
    title: str
    x_label: str
    y_label: str
    log_x: bool = False
    log_y: bool = False
    bars: bool = False  # a group of bars for each point, labelled by its x
    series: list = field(default_factory=list)
    points: list = field(default_factory=list)  # (x, a value a series); not-a-number where a series has none


class Claim(NamedTuple):
    """One of the paper's claims beside ours."""
    number: int
    claim: str
    paper: str
    ours: str
    differs: bool = False  # by more than a quarter
    why: str = ""  # needed if it differs


def differs(ours, low, high=None):
    """Ours lies more than a quarter outside of low..high; high is low if not given."""
    return ours < (1 - TOLERANCE) * low or ours > (1 + TOLERANCE) * (low if high is None else high)


def number(value, digits=1):
    return f"{value:.{digits}f}"


def percent(share, digits=0):
    """"12%" of 0.12."""
    return f"{100 * share:.{digits}f}%"


def to_markdown(table):
    lines = [table.columns, ["---"] * len(table.columns), *table.rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def csv_text(rows):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def to_csv(item):
    """Of a table or a chart."""
    if isinstance(item, Table):
        return csv_text([item.columns, *item.rows])
    points = [[f"{x:g}", *("" if math.isnan(value) else f"{value:.6g}" for value in values)] for x, values in item.points]
    return csv_text([[item.x_label, *item.series], *points])


def draw_chart(chart, path):
    """Raises as draw.chart()."""
    x = [x for x, _ in chart.points]
    look = "line" if len(x) > 60 else "both"
    series = [draw.Series(name, x, [values[i] for _, values in chart.points], look=look) for i, name in enumerate(chart.series)]
    draw.chart(path, chart.title, chart.x_label, chart.y_label, series, log_x=chart.log_x, log_y=chart.log_y, bars=chart.bars)


class Page:
    def __init__(self):
        self.body = ""
        self._files = []  # tables and charts
        self._claims = []

    def heading(self, text):
        self.body += f"## {text}\n\n" if text else ""

    def text(self, text):
        self.body += text + "\n\n"

    def table(self, name, columns, rows):
        table = Table(name, columns, rows)
        self._files.append(table)
        self.body += to_markdown(table) + f"\n[{FOLDER}/{name}.csv]({FOLDER}/{name}.csv)\n\n"

    def chart(self, chart, caption):
        self._files.append(chart)
        file = f"{FOLDER}/{chart.name}"
        self.body += f"![{chart.title}]({file}.svg)\n\n{caption} [{file}.csv]({file}.csv)\n\n"

    def picture(self, file, caption):
        self.body += f"![{caption}]({FOLDER}/{file})\n\n"

    def claim(self, *fields):
        """Fields of a Claim. Raises ValueError if it differs and does not say why."""
        claim = Claim(*fields)
        if claim.differs and not claim.why:
            raise ValueError(f"row {claim.number} ({claim.claim}): differs by more than a quarter and does not say why")
        self._claims.append(claim)
        self._claims.sort(key=lambda each: each.number)

    def claims_table(self):
        return Table("claims", ["row", "claim (paper's section)", "paper", "ours", "within a quarter"],
                     [[str(each.number), each.claim, each.paper, each.ours, "no" if each.differs else "yes"]
                      for each in self._claims])

    def claims(self):
        """All claims as a table, and a list of the reasons of those that differ."""
        reasons = "".join(f"- **{each.number}, {each.claim}**: {each.why}\n" for each in self._claims if each.differs)
        return (f"{to_markdown(self.claims_table())}\n[{FOLDER}/claims.csv]({FOLDER}/claims.csv)\n\n"
                f"Differences of more than a quarter:\n\n{reasons}\n")

    def write_files(self, folder):
        """The CSV files and charts. Raises OSError."""
        for item in [self.claims_table(), *self._files]:
            (folder / f"{item.name}.csv").write_text(to_csv(item))
            if isinstance(item, Chart):
                draw_chart(item, folder / f"{item.name}.svg")
