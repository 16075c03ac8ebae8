"""The chart of gicube-sweep."""
from studies.runs import RunFailed


def draw_chart(options, rows, path):
    """All points, and the Pareto front as a line; cost alone by the rows of the table. Raises FileError."""
    try:
        from studies import draw
    except ImportError as error:
        raise RunFailed(f"--chart: expected matplotlib (Debian package python3-matplotlib), got {error}") from error
    title = options.title or options.name
    if not options.compares:
        draw.chart(path, title, f"row of {options.name}.csv", options.cost,
                   [draw.Series("runs", range(1, len(rows) + 1), [row.cost for row in rows], look="points", mark=0)])
        return
    least = min((row.error for row in rows if row.error > 0), default=0)
    exact = least / 2  # where rows without error are on an axis that has no 0

    def points(label, drawn, **look):
        drawn = sorted(drawn, key=lambda row: row.cost)
        return draw.Series(label, [row.cost for row in drawn], [row.error if row.error > 0 else exact for row in drawn], **look)
    without = [row for row in rows if not row.error > 0]
    series = [points("runs", [row for row in rows if row.error > 0], look="points", colour=-1, mark=0),
              points("no error", without, look="points", colour=-1, mark=0, hollow=True),
              points("Pareto front", [row for row in rows if row.on_front], boxed=True)]
    draw.chart(path, title, options.cost, f"error: {options.error}", [each for each in series if len(each.x)],
               log_x=all(row.cost > 0 for row in rows), log_y=least > 0, box_outside=True)
