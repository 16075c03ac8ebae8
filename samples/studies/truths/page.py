"""Writes docs/studies/truths.md from the tables of docs/studies/charts."""
import math

from studies.charts import CHARTS
from studies.points import ROOT
from studies.table import rows_of, to_markdown, write_whole

PAGE = ROOT / "docs/studies/truths.md"
HEAD = """# Published truths

Made by `script/truths`; not edited by hand.

Asked: does the board agree with values that others have published, with closed forms, and with solvers that share
nothing with it (`samples/studies/truths/solvers.py`)? {held} of {asked} values do. Tables:
[truths.csv](charts/truths.csv) has each value, [truths_fronts.csv](charts/truths_fronts.csv) error by cost.
`script/truths --small --board URI` asks any board that serves; the small version is a test.

- A stochastic value holds within three standard errors (s.e.), from independent runs and the truth; for pairs the
  board's error is the one that the driver states. Another value holds within 1% of the truth, of absorbers 0.2%.
- *board ms*: simulated, without loading the volume, at the functional level: the times of bus and DSP. The charts are
  measured at the cycle level. *host s*: wall-clock time of a busy machine with two processors.
- Mirrored geometry replaces planes that reflect: all octants of Kobayashi's ducts. An index step is a surface layer
  with Fresnel's routine.

"""
FOUND = """
## New to this project

Cases without an earlier test, and their findings:

- MCML's half space of index 1.5: light skipped part of the medium behind a surface; mended
- Pencil beams: low albedo deposits light too deep in long steps
- Layers of depth 0.01: lighting rays round their opacities
- Half spaces in the sun: photon maps are too dark at a face
- Kobayashi's deep shields and ducts: a transmittance needs two rays, a detector more paths
- The trilinear cube, furnaces of two media, MCX's cube, blockers in a medium, data sheets: nothing
"""
TITLES = {"absorption": "Media that only absorb", "ducts": "Void ducts",
          "scattering": "Scattering media by stored light", "light": "Radiance by paths and photons",
          "exchange": "Form factors", "tomography": "Line integrals", "rates": "Peak rates"}
NO_CHART = {"rates"}


def off_of(row):
    return f"{100 * float(row['off']):.2g}%" if float(row["limit"]) else f"{float(row['off']):.1f} s.e."


def counts(rows):
    """Numbers of values that hold: stochastic ones, and those with a limit."""
    out = []
    for exact in (False, True):
        mine = [row for row in rows if (float(row["limit"]) > 0) == exact]
        out.append(f"{sum(row['holds'] == '1' for row in mine)} of {len(mine)}" if mine else "")
    return out


def cases_of(rows):
    cases = {}
    for row in rows:
        cases.setdefault((row["domain"], row["case"], row["method"]), []).append(row)
    return cases


def summary(rows):
    def line(name, mine):
        firsts = [each[0] for each in cases_of(mine).values()]
        costs = [f"{sum(float(row[cost]) for row in firsts):.0f}" for cost in ("board_ms", "host_s")]
        return [name, *counts(mine), *costs]

    lines = [line(title, [row for row in rows if row["domain"] == domain]) for domain, title in TITLES.items()]
    columns = ["domain", "stochastic values within 3 s.e.", "others within their limit", "board ms", "host s"]
    return to_markdown(columns, [*lines, line("all", rows)])


def short(row):
    value, error = float(row["found"]), float(row["error"])
    return f"{value:.4g}" + (f" ± {error:.1g}" if error and math.isfinite(error) else "")


def charts():
    plan = ("The orange cross is what a plan chooses for 1%: the cheapest setting that differs by at most 1% from the "
            "finest of\nits method, with twice its error bar. For line integrals it knows only their mean.\n\n")
    pictures = "".join(f"![{title}](charts/truths_{domain}.svg)\n" for domain, title in TITLES.items()
                       if domain not in NO_CHART)
    return "\n## Error by cost\n\n" + plan + pictures


def failing(rows):
    """A line for each case with values that do not hold."""
    lines = []
    for (_, case, method), each in cases_of([row for row in rows if row["holds"] == "0"]).items():
        worst = max(each, key=lambda row: abs(float(row["off"])))
        lines.append([f"{case}, {method}", str(len(each)), f"{float(worst['truth']):.4g}", short(worst), off_of(worst)])
    head = "\n## Values that do not hold\n\n[Their reasons](stability.md#published-truths); the worst of each case.\n\n"
    return head + to_markdown(["case", "values", "truth", "board", "off"], lines) if lines else ""


def text(rows):
    head = HEAD.format(held=sum(row["holds"] == "1" for row in rows), asked=len(rows))
    return head + summary(rows) + failing(rows) + FOUND + charts()


def main():
    write_whole(PAGE, text(rows_of(CHARTS / "truths.csv")))
    print(f"truths: {PAGE}")


if __name__ == "__main__":
    main()
