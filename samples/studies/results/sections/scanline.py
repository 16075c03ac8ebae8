"""Reordering against scanline order, for rendering and in global illumination."""
from bench import LIT_SCENES, PROCESSORS, SCENES, Bench, at_paper, cells, scanline
from figures import asic_ms, frame_ms, mean_of, memory_gb_s, rate_hz, ratio, sum_of, throughput
from page import differs, percent

PAPER_GAIN = 1.77


def queue_chart(page, name, title, y_label, queues, scenes, time):
    """time(scene, queue): time of the machine in scanline order."""
    times = {scene: [time(scene, queue) for queue in queues] for scene in scenes}
    page.chart("The baseline's best queue is the lowest point.", name, title, "rays of the queue", y_label, queues,
               times, log_x=True, log_y=True)


def in_turns(columns, ours, theirs):
    """Cells of both, our columns beside theirs."""
    return [cell for pair in zip(cells(ours, columns), cells(theirs, columns)) for cell in pair]


def baseline(bench, page):
    """Row 1."""
    queues = (16, 32, 64, 128, 256, 512, 1024, 4096)  # rays
    page.say("baseline")

    def time(scene, queue):
        return asic_ms(bench.get(scanline(bench.run(scene), queue)))

    queue_chart(page, "baseline-queue", "In scanline order a queue may be too short and too long", "ASIC ms", queues,
                SCENES, time)
    best = {scene: min(queues, key=lambda queue: time(scene, queue)) for scene in SCENES}
    slow = [scanline(run, best[run.scene]) for run in bench.oblique()]
    ours, theirs = bench.over(bench.oblique(), lambda m: m), bench.over(slow, lambda m: m)
    gains = [ratio(rate_hz(a), rate_hz(b)) for a, b in zip(ours, theirs)]
    page.table("baseline", ["scene", "best queue", "throughput, reordered", "scanline", "memory GB/s, reordered",
                            "scanline",
                            "Hz, reordered", "scanline", "rate gained"],
               [[scene, str(best[scene]), *in_turns(["throughput", "memory GB/s", "Hz"], a, b), f"x {gain:.2f}"]
                for scene, a, b, gain in zip(SCENES, ours, theirs, gains)])

    def text(ours, theirs):
        ours, theirs = (", ".join((percent(bench.mean(runs, throughput)), f"{bench.mean(runs, memory_gb_s):.1f} GB/s",
                                   f"{bench.mean(runs, rate_hz):.1f} Hz"))
                        for runs in (ours, theirs))
        return f"{ours} against {theirs}"

    # The paper's exact simulator had one processor [P §4.2].
    alone, alone_slow = (at_paper([run.on({PROCESSORS: 1}) for run in runs]) for runs in (bench.oblique(), slow))
    gain = mean_of([ratio(a, b) for a, b in zip(bench.over(alone, rate_hz), bench.over(alone_slow, rate_hz))])
    page.claim("1 rendering", differs(gain, PAPER_GAIN), ours=text(alone, alone_slow), gain=gain,
               half=text(bench.oblique(), slow), half_gain=mean_of(gains),
               lost=bench.lost_cycles(alone_slow))


class Whole:
    """A lighting pass and its frame on one processor, at the paper's operating point, with volumes of the size of
    `sized`, a Bench. `queue` None: on the reordering machine."""

    def __init__(self, bench, sized, scene, queue=None):
        runs = [run.on({PROCESSORS: 1}) for run in at_paper([sized.light(scene), sized.lit(scene)])]
        if queue is not None:
            runs = [scanline(run, queue) for run in runs]
        self.light, self.frame = map(bench.get, runs)
        self.both = sum_of(self.light, self.frame)

    def parts(self):
        return [self.light, self.frame, self.both]


def text_of(ours, theirs):
    """Frames without and with a pass in each; our speed-up."""
    def part(figure_of):
        ms, slow = (", ".join((percent(mean_of([throughput(figure_of(each)) for each in wholes])),
                               f"{mean_of([memory_gb_s(figure_of(each)) for each in wholes]):.1f} GB/s",
                               f"{mean_of([rate_hz(figure_of(each)) for each in wholes]):.1f} Hz"))
                    for wholes in (ours, theirs))
        return (f"{ms} against {slow}: x "
                f"{mean_of([gain_of(figure_of(a), figure_of(b)) for a, b in zip(ours, theirs)]):.2f}")
    return f"frames {part(lambda each: each.frame)}; with a pass in each {part(lambda each: each.both)}"


def gain_of(ours, theirs):
    return ratio(frame_ms(theirs), frame_ms(ours))


def lit_baseline(bench, page):
    """Row 1, with volumes and images of half the edge."""
    queues = (16, 64, 256)  # rays
    small = Bench(max(32, bench.edge // 2), max(8, bench.image // 2))
    page.say("lit baseline", edge=small.edge, block=small.block, image=small.image)
    slow = {(scene, queue): Whole(bench, small, scene, queue) for scene in LIT_SCENES for queue in queues}

    def time(scene, queue):
        return frame_ms(slow[scene, queue].both)

    queue_chart(page, "lit-baseline-queue", "In scanline order a long queue takes longer (lighting pass and frame)",
                "simulated ms",
                queues, LIT_SCENES, time)
    best = {scene: min(queues, key=lambda queue: time(scene, queue)) for scene in LIT_SCENES}
    # Their 16.3 Hz are frames only, because they leave no time for their pass of 361 ms.
    ours, theirs = [Whole(bench, small, scene) for scene in LIT_SCENES], [slow[each] for each in best.items()]
    parts_table(page, "lit-baseline", best, ours, theirs)
    gain = mean_of([gain_of(a.frame, b.frame) for a, b in zip(ours, theirs)])
    # Compares only the gain: throughput and traffic are those of the smaller volumes.
    page.claim("1 lighting", differs(gain, PAPER_GAIN), edge=small.edge, ours=text_of(ours, theirs),
               lost=bench.lost_cycles([run.on({PROCESSORS: 1}).at_paper() for run in small.lit_scenes()]))


def parts_table(page, name, best, ours, theirs):
    columns = ["throughput", "memory GB/s", "hit ratio", "frame ms"]
    page.table(name, ["scene", "best queue", "part", "throughput, reordered", "scanline", "memory GB/s, reordered",
                      "scanline", "hit ratio, reordered", "scanline", "ms, reordered", "scanline", "rate gained"],
               [[scene, str(queue), part, *in_turns(columns, x, y), f"x {gain_of(x, y):.2f}"]
                for (scene, queue), a, b in zip(best.items(), ours, theirs)
                for part, x, y in zip(("pass", "frame", "both"), a.parts(), b.parts())])
