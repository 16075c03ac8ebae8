"""How the time of a picture depends on two parameters of the board: a heat map.

Usage: heat_map.py CHART.png
"""

import sys

import matplotlib
import numpy as np

import gicube

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PROCESSORS = [1, 2, 4, 8]
QUEUE_RAYS = [16, 64, 256]
SCENE = 'volume { builtin: "buckyball" size: 64 } image { width: 64 height: 64 }'


def time_of(processors: int, queue_rays: int) -> float:
    """The milliseconds of one picture."""
    setup = gicube.parse_scene(SCENE).set_up()
    uri = (f"emu:?fidelity=cycle&set=asic.block_voxels=8&set=asic.processors={processors}"
           f"&set=asic.queue_rays={queue_rays}")
    with gicube.open(uri) as board:
        view = gicube.load_scene(board, setup)
        begin = board.now
        board.render_to_framebuffer(view)
        return (board.now - begin) * 1e-9


def main(chart: str) -> None:
    times = np.array([[time_of(processors, rays) for processors in PROCESSORS] for rays in QUEUE_RAYS])
    figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
    axes.imshow(times, cmap="viridis_r", norm="log")
    for (row, column), value in np.ndenumerate(times):
        axes.text(column, row, f"{value:.2f} ms", ha="center", va="center",
                  color="white" if value > np.median(times) else "black")
    axes.set_xticks(range(len(PROCESSORS)), [str(each) for each in PROCESSORS])
    axes.set_yticks(range(len(QUEUE_RAYS)), [str(each) for each in QUEUE_RAYS])
    axes.set_xlabel("processors")
    axes.set_ylabel("rays a queue holds")
    axes.set_title("Time of a picture")
    figure.savefig(chart, dpi=150)
    print(f"{times.min():.2f} to {times.max():.2f} ms, {chart}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
