"""What Python costs, beside C++: a million host rays through each, in turns, and the memory that loading 256^3 float32
voxels takes.

  cmake --build --preset release --target gicube_python gicube_bench gicube-board
  PYTHONPATH=build/release/python GICUBE_BOARD=build/release/bin/gicube-board /usr/bin/python3
  tests/bench/python_bench.py [TURNS]

The C++ case is host_rays/262144 of tests/bench/host_ray_bench.cpp; this is the same in Python. On a machine that does
nothing else.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import gicube

ROOT = Path(__file__).resolve().parents[2]
RAYS, UNDER_WAY, BATCHES = 262_144, 4, 16  # a batch; batches; batches a turn


def fog_board():
    board = gicube.open("emu:?threads=1")
    board.load_volume(np.full((64, 64, 64), 100, "u1"))
    board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(0, 0.02), (255, 0.02)]))
    return board


def short_rays():
    i = np.arange(RAYS)
    position = np.stack([1.0 + i % 59, 1.0 + i // 59 % 59, np.full(RAYS, 8.5)], axis=1)
    return gicube.rays(position, (0.1, 0.2, 1), length=4)


def python_rate(out):
    """Rays a second. out: an array for those that come back, or None for a new one each time."""
    with fog_board() as board:
        rays = short_rays()
        tickets = [board.submit(rays, type=gicube.RayType.OPACITY) for _ in range(UNDER_WAY)]
        begin = time.perf_counter()
        for i in range(BATCHES):
            board.receive(tickets[i % UNDER_WAY], out=out)
            tickets[i % UNDER_WAY] = board.submit(rays, type=gicube.RayType.OPACITY)
        return BATCHES * RAYS / (time.perf_counter() - begin)


def cpp_rate():
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        command = [ROOT / "build/release/tests/gicube_bench", f"--benchmark_filter=^host_rays/{RAYS}/",
                   f"--benchmark_out={out.name}"]
        subprocess.run([*command, "--benchmark_out_format=json", "--benchmark_min_time=2"], check=True,
                       stdout=subprocess.DEVNULL)
        return json.load(open(out.name))["benchmarks"][0]["items_per_second"]


LOAD = """
import numpy as np
import gicube

def mebibytes(name):
    return next(int(line.split()[1]) / 1024 for line in open("/proc/self/status") if line.startswith(name))

samples = np.random.default_rng(1).random((256, 256, 256), "f4")
samples = {layout}
with gicube.open() as board:
    before = mebibytes("VmRSS")
    board.load_volume(gicube.Volume(samples, range=gicube.ValueRange(0, 1)))
    print(before, mebibytes("VmHWM"))
"""


def main():
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    out = np.empty(RAYS, gicube.TRACED_RAY)
    into, new = [], []
    for turn in range(turns):
        cpp, own, fresh = cpp_rate(), python_rate(out), python_rate(None)
        into.append(own / cpp)
        new.append(fresh / cpp)
        print(f"turn {turn + 1}: C++ {cpp / 1e6:.3f}, Python {own / 1e6:.3f}, into new arrays {fresh / 1e6:.3f} "
              f"million rays a second", flush=True)
    for what, ratios in (("receive(out=...)", into), ("receive()", new)):
        print(f"{what}: {statistics.median(ratios):.3f} of the C++ rate ({min(ratios):.3f} to {max(ratios):.3f})")
    for layout in ("samples", "samples.T"):
        before, peak = map(float, subprocess.check_output([sys.executable, "-c", LOAD.format(layout=layout)],
                                                          text=True).split())
        print(f"load_volume({layout}), {256**3 * 4 / 2**20:.0f} MiB: {before:.1f} MiB before, {peak:.1f} at most, "
              f"{peak - before:.1f} more")


main()
