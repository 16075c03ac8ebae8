"""The charts of gicube-sweep."""
from studies.runs import RunFailed

MOST_LINES = 6  # per panel, which has seven colours


def numbers_of(values):
    """The values as numbers; None if they are not numbers."""
    try:
        return [float(value) for value in values]
    except ValueError:
        return None


def lines_of(draw, rows, name, values, others):
    """Cost over one parameter: a line for each combination of the others, or points if these are too many."""
    places = numbers_of(values) or range(1, len(values) + 1)
    place = dict(zip(values, places))
    lines = {}
    for row in sorted(rows, key=lambda row: place[row.point[name]]):
        label = ", ".join(f"{other} {row.point[other]}" for other in others)
        lines.setdefault(label, []).append((place[row.point[name]], row.cost))
    if len(lines) > MOST_LINES:
        return [draw.Series("runs", *zip(*sum(lines.values(), [])), look="points", mark=0)]
    return [draw.Series(label, *zip(*line)) for label, line in lines.items()]


def panels_of(draw, options, rows):
    """A panel for each varied parameter; without these, one panel of the runs."""
    varied = [(name, values) for name, values in options.parameters if len(values) > 1]
    made = []
    for name, values in varied:
        series = lines_of(draw, rows, name, values, [other for other, _ in varied if other != name])
        is_number = numbers_of(values) is not None
        label = name if is_number else f"{name}: " + ", ".join(f"{i} {value}" for i, value in enumerate(values, 1))
        wide = is_number and min(numbers_of(values)) > 0 and max(numbers_of(values)) > 20 * min(numbers_of(values))
        made.append(draw.Panel(label, options.cost, series, log_x=wide, box_outside=len(series) > 1))
    return made or [draw.Panel(f"row of {options.name}.csv", options.cost,
                               [draw.Series("runs", range(1, len(rows) + 1), [row.cost for row in rows], look="points",
                                            mark=0)])]


def draw_chart(options, rows, path):
    """Writes NAME.svg: all points of cost and error, and the Pareto front as a line. NAME-cost.svg has the cost by each
    parameter; without a comparison, NAME.svg has it. Raises FileError."""
    try:
        from studies import draw
    except ImportError as error:
        raise RunFailed(f"--chart: expected matplotlib (Debian package python3-matplotlib), got {error}") from error
    title = options.title or options.name
    if not options.compares:
        draw.panels(path, title, panels_of(draw, options, rows))
        return
    least = min((row.error for row in rows if row.error > 0), default=0)
    exact = least / 2  # place of rows without error on a logarithmic axis

    def points(label, drawn, **look):
        drawn = sorted(drawn, key=lambda row: row.cost)
        return draw.Series(label, [row.cost for row in drawn], [row.error if row.error > 0 else exact for row in drawn],
                           **look)
    without = [row for row in rows if not row.error > 0]
    series = [points("runs", [row for row in rows if row.error > 0], look="points", colour=-1, mark=0),
              points("no error", without, look="points", colour=-1, mark=0, hollow=True),
              points("Pareto front", [row for row in rows if row.on_front], boxed=True)]
    draw.chart(path, title, options.cost, f"error: {options.error}", [each for each in series if len(each.x)],
               log_x=all(row.cost > 0 for row in rows), log_y=least > 0, box_outside=True)
    draw.panels(str(path).removesuffix(".svg") + "-cost.svg", title, panels_of(draw, options, rows))
