"""The caches: blocks and queues, sampling distance and image size."""
import math

from bench import QUEUE, SCENES, cells
from figures import asic_ms, hit_ratio, mean_of, miss_histogram, misses_a_sample, ratio, throughput
from page import differs, number, percent

QUEUES = (1, 4, 8, 16, 32, 64, 256, 1024)  # rays
DESIGN_QUEUE, PIPELINE_LATENCY = 256, 32  # rays, cycles
STEPS = (2, 1, 0.5, 0.25, 0.125)  # voxels


def with_queue(run, queue):
    return run if queue == DESIGN_QUEUE else run.on({QUEUE: queue})


class Grid:
    """One scene in blocks of several sizes and with several queues."""

    def __init__(self, bench, name, run):
        self.bench, self.name, self.run = bench, name, run
        self.blocks = [n for n in (8, 16, 32, 64) if n <= bench.edge]  # voxels

    def get(self, block, queue):
        return self.bench.get(with_queue(self.run.on({"asic.block_voxels": block}), queue))

    def hits(self, block, queue=DESIGN_QUEUE):
        return hit_ratio(self.get(block, queue))

    def ms(self, block, queue=DESIGN_QUEUE):
        return asic_ms(self.get(block, queue))

    def report(self, hits_title, ms_title):
        for name, title, label, log_y, figure in (("hit-ratio", hits_title, "hit ratio", False, self.hits),
                                                  ("time", ms_title, "ASIC ms", True, self.ms)):
            series = {f"n = {n}": [figure(n, queue) for queue in QUEUES] for n in self.blocks}
            self.bench.page.chart("", f"{name}-{self.name}", title, "rays of a queue", label, QUEUES, series,
                                  log_x=True, log_y=log_y)
        queue_table(self.bench, f"grid-{self.name}", {f"n = {n}": n for n in self.blocks}, self.get)


def queue_table(bench, name, variants, get):
    """Hits and time of get(variant, queue), a row per queue."""
    rows = []
    for queue in QUEUES:
        rows.append([str(queue)])
        for variant in variants.values():
            m = get(variant, queue)
            rows[-1] += [percent(hit_ratio(m), 1), number(asic_ms(m), 2)]
    bench.page.table(name, ["rays of a queue", *(head for each in variants for head in (f"{each}: hits", "ms"))], rows)


def cache(bench, page):
    """Rows 15 and 16."""
    grids = [Grid(bench, scene, bench.run(scene).at_paper()) for scene in ("buckyball", "head")]
    # A volume as large as the largest block, and one processor: n = N.
    whole = grids[0].blocks[-1]
    small = Grid(bench, "small", bench.run("head", dims=3 * (whole,), edge=whole, width=whole,
                                           height=whole).on({"asic.processors": 1}).at_paper())
    page.say("cache", whole=whole)
    for grid in grids:
        grid.report(f"Figure 13: large blocks n and long queues hit more often ({grid.name})",
                    f"Figure 14: large blocks n need long queues ({grid.name})")
    small.report("Figure 13 with n = N: large blocks hit more often",
                 "Figure 14 with n = N: large blocks need long queues")

    def of_ways(ways, queue):
        run = with_queue(grids[0].run, queue)
        return grids[0].get(bench.block, queue) if ways == 1 else bench.get(run.on({"cache.ways": ways}))

    page.say("associativity")
    queue_table(bench, "associativity", {"1 way": 1, "2 ways": 2, "4 ways": 4}, of_ways)
    (mean, of_mean), without_leaps = blocks_table(bench, grids[0].blocks)
    hit_claim(bench, grids, small.hits(whole))

    fastest = {grid.name: min(grid.blocks, key=grid.ms) for grid in grids}
    least, most = small.ms(whole, 64), small.ms(whole, 1024)
    best = ", ".join(f"{name}: n = {n} ({bench.edge // n}^3 grid)" for name, n in fastest.items())
    # "In general, a wide variety of scenes" [P §5.1]: the mean decides, not each scene.
    page.claim(16, of_mean != bench.block or differs(least, most), least=least, most=most, mean=mean, best=best,
               without_leaps=without_leaps)


def blocks_table(bench, blocks):
    """The best block, with leaps and without (by reordering only): for the scenes' geometric mean with leaps as a text
    and as voxels, and for each scene without leaps as a text."""
    rows, best = [], []
    for leap in (True, False):
        times = [[Grid(bench, scene, bench.run(scene, leap=leap).at_paper()).ms(n) for n in blocks] for scene in SCENES]
        times.append([math.prod(of_block) ** (1 / len(SCENES)) for of_block in zip(*times)])
        best.append([blocks[of_scene.index(min(of_scene))] for of_scene in times])
        rows += [[scene, "yes" if leap else "no", *(number(time, 2) for time in of_scene), str(fastest)]
                 for scene, of_scene, fastest in zip([*SCENES, "geometric mean"], times, best[-1])]
    bench.page.say("blocks")
    bench.page.table("blocks", ["scene", "leaps", *(f"n = {n}, ms" for n in blocks), "best n"], rows)
    of_mean = best[0][-1]
    return (f"n = {of_mean} ({bench.edge // of_mean}^3 grid)", of_mean), ", ".join(f"{scene} {n}" for scene,
        n in zip(SCENES, best[1]))


def hit_claim(bench, grids, whole):
    n, twice = bench.block, 2 * PIPELINE_LATENCY
    with_queues = all(grid.hits(n, 1) < grid.hits(n, 64) < grid.hits(n, 1024) for grid in grids)
    with_blocks = all(grid.hits(a) < grid.hits(b) for grid in grids for a, b in zip(grid.blocks, grid.blocks[1:]))
    jumps = "; ".join(f"{grid.name}: {percent(grid.hits(n, 16), 1)} at 16, {percent(grid.hits(n, twice), 1)} at {twice}"
                      for grid in grids)
    bench.page.claim(15, not (with_queues and with_blocks and whole < 1), with_queues="yes" if with_queues else "no",
                     with_blocks="yes" if with_blocks else "no", jumps=jumps, whole=whole)


def at_image(run, image):
    return run.but(width=image, height=image)


def sampling(bench, page):
    """Rows 17 and 19."""
    for scene in ("buckyball", "cloud"):
        shares = {f"step {step:g}": miss_histogram(bench.get(bench.run(scene, step=step))) for step in STEPS}
        page.chart("By distance of the samples in voxels.", f"misses-{scene}",
                   f"Figure 9: the closer the samples, the more of them miss nothing ({scene})", "misses of a sample",
                   "share of samples",
                   range(9), shares, bars=True)
    steps_table(bench)
    image_sizes(bench)
    exact, second_hits, fetched, words = one_block(bench)

    def without_miss(step):
        return mean_of([miss_histogram(bench.get(run.at_step(step)))[0] for run in bench.oblique()])

    few, many = ([at_image(run, image) for run in bench.oblique()] for image in (bench.image // 8, 2 * bench.image))
    small, big = bench.mean(few, throughput), bench.mean(many, throughput)
    page.claim(17, not second_hits or big < small, second="100%" if second_hits else "not always", one=without_miss(1),
               half=without_miss(0.5),
               quarter=without_miss(0.25), small=small, few=bench.image // 8, big=big, many=2 * bench.image)
    page.claim(19, not exact, words=words, fetched=words if exact else fetched)


def steps_table(bench):
    others = {"misses a sample": lambda m: number(misses_a_sample(m), 2)}
    columns = ["misses a sample", "memory GB/s", "memory in use", "throughput", "Hz"]
    variants = [(f"{step:g}", step, False) for step in STEPS] + [("1, jittered", 1, True)]
    rows = []
    for name, step, jitter in variants:
        runs = [bench.run(scene, step=step, jitter=jitter) for scene in SCENES]
        rows.append([name, *(cell for run in runs for cell in cells(bench.get(run), columns, others))])
    bench.page.say("steps")
    bench.page.table("steps", ["step, voxels", *(f"{scene}: {column}" for scene in SCENES for column in columns)], rows)


def image_sizes(bench):
    """Figure 17."""
    images = [bench.image // 8, bench.image // 4, bench.image // 2, bench.image, 2 * bench.image]
    measured = {image: [bench.get(at_image(run, image)) for run in bench.oblique()] for image in images}
    busy = {scene: [throughput(measured[image][i]) for image in images] for i, scene in enumerate(SCENES)}
    rows = [[f"{image}^2", *(cell for m in of_scenes for cell in cells(m, ["throughput", "hit ratio"]))] for image,
            of_scenes in measured.items()]
    bench.page.chart("Oblique views.", "image-size", "Figure 17: larger images keep the pipelines busier",
                     "pixels an edge", "throughput",
                     images, busy, log_x=True)
    bench.page.table("image-sizes",
                     ["image", *(head for scene in SCENES for head in (f"{scene}: throughput", "hit ratio"))], rows)


def one_block(bench):
    """Rays through one block: whether its voxels are fetched once, whether second samples of a cell hit, the last
    number of fetched voxels, and the number of voxels."""
    n = bench.block
    words = (n + 1) ** 3
    rows, exact, second_hits, fetched = [], True, True, 0
    for scene in ("buckyball", "cloud", "rock"):
        for step in (1, 0.5, 0.25):
            m = bench.get(bench.run(scene, step=step, kind="fill_block", faint=True, leap=False))
            fetched, samples = m["processor.cache.filled_voxels"], m["processor.samples"]
            hits = m["processor.cache.samples_with_misses.0"]
            if step == 1:
                hits_at_one = hits
            # All samples except the first of each cell hit.
            second_hits = second_hits and samples - hits <= n ** 3 - hits_at_one
            exact = exact and fetched == words
            rows.append([scene, f"{step:g}", str(samples), str(fetched), str(words), percent(ratio(hits, samples), 1)])
    bench.page.say("one block", n=n)
    bench.page.table("one-block", ["scene", "step, voxels", "samples", "voxels fetched", "(n+1)^3",
                                   "samples without a miss"], rows)
    return exact, second_hits, fetched, words
