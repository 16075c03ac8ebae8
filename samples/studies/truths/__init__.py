"""Published values and closed forms against a board. Each is a case of a domain, with measured numbers and their cost.

`tables()`: the table of values, and the settings of each domain's chart, for studies.points."""
import importlib
import math

from studies.points import Table
from studies.table import on_front
from studies.truths.case import Bench

DOMAINS = ("absorption", "ducts", "scattering", "light", "exchange", "tomography", "rates")
COLUMNS = ["domain", "case", "method", "quantity", "source", "truth", "truth_error", "found", "error", "limit", "off",
           "holds", "board_ms", "host_s"]
FRONT_COLUMNS = ["domain", "case", "method", "settings", "board_ms", "host_s", "error", "front_ms", "front_s",
                 "plan_ms", "plan_s"]
FEW = 8  # chosen
PLAN_ERROR = 0.01  # chosen: the target of the plans in the charts
uri = "emu:"  # script/truths --board


def all_cases():
    return [case for domain in DOMAINS for case in importlib.import_module(f"studies.truths.{domain}").cases()]


def measured(case, changes, fidelity="functional"):
    """Values of the case, and their total cost."""
    bench = Bench(uri, fidelity)
    values = case.measure(bench, **{**case.settings, **changes})
    ms, seconds = bench.cost()
    numbers = ("truth", "truth_error", "found", "error", "limit", "off")
    rows = [[each.quantity, *(float(getattr(each, name)) for name in numbers), int(each.holds)] for each in values]
    return {"values": rows, "ms": float(ms), "seconds": seconds}


def point_name(case):
    return "truths/" + case.name.replace(" ", "_").replace(",", "")


def value_rows(found):
    cases = {point_name(case): case for case in all_cases()}
    for name, each in found:
        case = cases[name]
        domain, what, method = case.name.split("/")
        for quantity, truth, truth_error, value, error, limit, off, holds in each["values"]:
            yield name, [domain, what, method, quantity, case.source,
                         *(f"{part:.7g}" for part in (truth, truth_error, value)), f"{error:.3g}", f"{limit:g}",
                         f"{off:.3g}", holds, f"{each['ms']:.4g}", f"{each['seconds']:.2g}"]


def relative_error(each):
    """Root mean square of the values' relative errors; absolute for a truth of 0. A few values may be right by chance,
    so for these the error bar counts."""
    few = len(each["values"]) < FEW
    off = [max(abs(value - truth), few * error) / (truth or 1) for _, truth, _, value, error, *_ in each["values"]]
    return math.sqrt(sum(part * part for part in off) / len(off))


def predicted_error(each, finest):
    """Root mean square of the relative errors that a plan predicts: it knows the values of the method's finest setting
    and error bars, but no truth."""
    pairs = [(value, error, best) for (_, truth, _, value, error, *_), (_, _, _, best, *_) in
             zip(each["values"], finest["values"]) if truth]
    return math.sqrt(sum((max(abs(value - best), 2 * error) / best)**2 for value, error, best in pairs) / len(pairs))


def plans(rows):
    """For simulated ms and host seconds: which of the rows (method, measurement) a plan chooses for PLAN_ERROR. It is
    the cheapest one whose predicted error keeps it, or else the one with the least predicted error."""
    finest = {}
    for method, each in rows:
        finest[method] = max(finest.get(method, each), each, key=lambda found: found["ms"])
    errors = [predicted_error(each, finest[method]) for method, each in rows]
    keeps = [row for row, error in enumerate(errors) if error <= PLAN_ERROR]
    chosen = [min(keeps or [errors.index(min(errors))], key=lambda row: rows[row][1][cost]) for cost in
              ("ms", "seconds")]
    return [[row == each for row in range(len(rows))] for each in chosen]


def front_points():
    return {f"{point_name(case)}/{number}": (case, changes)
            for case in all_cases() for number, changes in enumerate(case.sweep)}


def front_rows(found):
    points, domains = front_points(), {}
    for name, each in found:
        domains.setdefault(points[name][0].domain, []).append((name, each, relative_error(each)))
    for domain, rows in domains.items():
        fronts = [on_front([(each[cost], error) for _, each, error in rows]) for cost in ("ms", "seconds")]
        methods = [(points[name][0].name, points[name][1].get("datapath")) for name, *_ in rows]
        choices = plans([(method, each) for method, (_, each, _) in zip(methods, rows)])
        for (name, each, error), *marks in zip(rows, *fronts, *choices):
            case, changes = points[name]
            settings = " ".join(f"{key}={value:g}" if isinstance(value, float) else f"{key}={value}" for key,
                                value in changes.items())
            yield name, [domain, *case.name.split("/")[1:], settings, f"{each['ms']:.6g}", f"{each['seconds']:.3g}",
                         f"{error:.4g}", *map(int, marks)]


def tables():
    """Charts use the cycle level, the table the functional one; the values are bit-identical."""
    return [Table("truths", COLUMNS, {point_name(case): lambda _, case=case: measured(case, {})
                                      for case in all_cases()}, value_rows),
            Table("truths_fronts", FRONT_COLUMNS, {name: lambda _, case=case,
                                                   changes=changes: measured(case, changes, "cycle")
                                                   for name, (case, changes) in front_points().items()}, front_rows)]
