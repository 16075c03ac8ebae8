"""Writes docs/studies/truths.md from the tables of docs/studies/charts."""
import math

from studies.charts import CHARTS
from studies.points import ROOT
from studies.table import rows_of, to_markdown, write_whole
from studies.truths import DOMAINS

PAGE = ROOT / "docs/studies/truths.md"
HEAD = """# Published truths

Made by `script/truths`; not edited by hand.

Values that others have published, closed forms, and solvers that share nothing with the board
(`samples/studies/truths/solvers.py`), against what a board says. `script/truths --small --board URI` asks any board
that serves; the small version is a test. Tables: [truths.csv](charts/truths.csv),
[truths_fronts.csv](charts/truths_fronts.csv).

- *board*: its value, and the standard error from independent runs; for pairs the one that the driver states.
- *off*: the difference, in standard errors (s.e., with those of the truth), or for values without noise as a share of
  the truth. A value holds within three standard errors, or within 1%, of absorbers 0.2%.
- *board ms*: simulated, for all values of a case, without loading the volume. The table is measured at the functional
  level, so these are times of bus and DSP; the charts are measured at the cycle level. *host s*: wall-clock time of a
  busy machine with two processors.

"""
TITLES = {"absorption": "Media that only absorb", "ducts": "Void ducts",
          "scattering": "Scattering media by stored light", "light": "Radiance by paths and photons",
          "exchange": "Form factors", "tomography": "Line integrals", "rates": "Peak rates"}
NO_CHART = {"rates"}


def off_of(row):
    return f"{100 * float(row['off']):.2g}%" if float(row["limit"]) else f"{float(row['off']):.1f} s.e."


def counts(rows):
    """How many of them hold: the stochastic ones, and those with a limit."""
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

    lines = [line(f"[{title}](#{title.lower().replace(' ', '-')})", [row for row in rows if row["domain"] == domain])
             for domain, title in TITLES.items()]
    columns = ["domain", "stochastic values within 3 s.e.", "others within their limit", "board ms", "host s"]
    return to_markdown(columns, [*lines, line("all", rows)])


def short(row):
    value, error = float(row["found"]), float(row["error"])
    return f"{value:.6g}" + (f" ± {error:.1g}" if error and math.isfinite(error) else "")


def section(domain, rows):
    out = f"\n## {TITLES[domain]}\n\n"
    if domain not in NO_CHART:
        out += f"![error by cost](charts/truths_{domain}.svg)\n\n"
    lines = []
    for (_, case, method), each in cases_of([row for row in rows if row["domain"] == domain]).items():
        worst = max(each, key=lambda row: abs(float(row["off"])) / (float(row["limit"]) or 3))
        held = " + ".join(part for part in counts(each) if part)
        lines.append([case, method, worst["source"], held, worst["quantity"], f"{float(worst['truth']):.6g}",
                      short(worst), off_of(worst), worst["board_ms"], worst["host_s"]])
    return out + to_markdown(["case", "method", "source", "values that hold", "the one furthest off", "truth", "board",
                              "off", "board ms", "host s"], lines)


def failing(rows):
    lost = [row for row in rows if row["holds"] == "0"]
    lines = [[row["case"], row["method"], row["quantity"], f"{float(row['truth']):.6g}", short(row), off_of(row)]
             for row in lost]
    head = "\n## Values that do not hold\n\n[Their reasons](stability.md#published-truths).\n\n"
    return head + to_markdown(["case", "method", "value", "truth", "board", "off"], lines) if lost else ""


def text(rows):
    return HEAD + summary(rows) + failing(rows) + "".join(section(domain, rows) for domain in DOMAINS)


def main():
    write_whole(PAGE, text(rows_of(CHARTS / "truths.csv")))
    print(f"truths: {PAGE}")


if __name__ == "__main__":
    main()
