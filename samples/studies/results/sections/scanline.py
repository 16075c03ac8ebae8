"""Reordering against scanline order, for rendering and in global illumination."""
from bench import LIT_SCENES, PROCESSORS, SCENES, at_paper, cells, scanline
from figures import asic_ms, frame_ms, mean_of, memory_gb_s, rate_hz, ratio, sum_of, throughput
from page import differs, percent

PAPER_GAIN = 1.77


def queue_chart(page, name, title, y_label, queues, scenes, time):
    """time(scene, queue): of the machine in scanline order."""
    times = {scene: [time(scene, queue) for queue in queues] for scene in scenes}
    page.chart("The baseline's best queue is the lowest point.", name, title, "rays of the queue", y_label, queues, times, log_x=True, log_y=True)


def in_turns(columns, ours, theirs):
    """Cells of both, a column of ours beside one of theirs."""
    return [cell for pair in zip(cells(ours, columns), cells(theirs, columns)) for cell in pair]


def baseline(bench, page):
    """Row 1."""
    queues = (16, 32, 64, 128, 256, 512, 1024, 4096)  # rays
    page.say("baseline")

    def time(scene, queue):
        return asic_ms(bench.get(scanline(bench.run(scene), queue)))

    queue_chart(page, "baseline-queue", "In scanline order a queue may be too short and too long", "ASIC ms", queues, SCENES, time)
    best = {scene: min(queues, key=lambda queue: time(scene, queue)) for scene in SCENES}
    slow = [scanline(run, best[run.scene]) for run in bench.oblique()]
    ours, theirs = bench.over(bench.oblique(), lambda m: m), bench.over(slow, lambda m: m)
    gains = [ratio(rate_hz(a), rate_hz(b)) for a, b in zip(ours, theirs)]
    page.table("baseline", ["scene", "best queue", "throughput, reordered", "scanline", "memory GB/s, reordered", "scanline",
                            "Hz, reordered", "scanline", "rate gained"],
               [[scene, str(best[scene]), *in_turns(["throughput", "memory GB/s", "Hz"], a, b), f"x {gain:.2f}"]
                for scene, a, b, gain in zip(SCENES, ours, theirs, gains)])

    def text(ours, theirs):
        ours, theirs = (", ".join((percent(bench.mean(runs, throughput)), f"{bench.mean(runs, memory_gb_s):.1f} GB/s", f"{bench.mean(runs, rate_hz):.1f} Hz"))
                        for runs in (ours, theirs))
        return f"{ours} against {theirs}"

    # The paper's exact simulator had one processor [P §4.2].
    alone, alone_slow = (at_paper([run.on({PROCESSORS: 1}) for run in runs]) for runs in (bench.oblique(), slow))
    gain = mean_of([ratio(a, b) for a, b in zip(bench.over(alone, rate_hz), bench.over(alone_slow, rate_hz))])
    page.claim("1 rendering", differs(gain, PAPER_GAIN), ours=text(alone, alone_slow), gain=gain, half=text(bench.oblique(), slow), half_gain=mean_of(gains),
               lost=bench.lost_cycles(alone_slow))


class Whole:
    """A lighting pass and its frame. `queue` None: on the reordering machine."""

    def __init__(self, bench, scene, queue, processors=4):
        runs = [bench.light(scene), bench.lit(scene)]
        if processors == 1:
            runs = at_paper(runs)
        if processors != 4:
            runs = [run.on({PROCESSORS: processors}) for run in runs]
        if queue is not None:
            runs = [scanline(run, queue) for run in runs]
        self.light, self.frame = map(bench.get, runs)
        self.both = sum_of(self.light, self.frame)

    def parts(self):
        return [self.light, self.frame, self.both]


def text_of(wholes):
    means = [mean_of([figure(each.both) for each in wholes]) for figure in (throughput, memory_gb_s, rate_hz)]
    return (f"{percent(means[0])}, {means[1]:.1f} GB/s, {means[2]:.1f} Hz with the pass in each frame, "
            f"{mean_of([rate_hz(each.frame) for each in wholes]):.1f} Hz without")


def gain_of(ours, theirs):
    return ratio(frame_ms(theirs), frame_ms(ours))


def lit_baseline(bench, page):
    """Row 1."""
    queues = (16, 64, 256, 1024)  # rays
    page.say("lit baseline")

    def time(scene, queue):
        return frame_ms(Whole(bench, scene, queue).both)

    queue_chart(page, "lit-baseline-queue", "In scanline order a queue may be too short and too long (lighting pass and frame)", "simulated ms",
                queues, LIT_SCENES, time)
    best = {scene: min(queues, key=lambda queue: time(scene, queue)) for scene in LIT_SCENES}
    columns = ["throughput", "memory GB/s", "hit ratio", "frame ms"]
    ours = [Whole(bench, scene, None) for scene in LIT_SCENES]
    theirs = [Whole(bench, scene, best[scene]) for scene in LIT_SCENES]
    page.table("lit-baseline", ["scene", "best queue", "part", "throughput, reordered", "scanline", "memory GB/s, reordered",
                                "scanline", "hit ratio, reordered", "scanline", "ms, reordered", "scanline", "rate gained"],
               [[scene, str(best[scene]), part, *in_turns(columns, x, y), f"x {gain_of(x, y):.2f}"]
                for scene, a, b in zip(LIT_SCENES, ours, theirs)
                for part, x, y in zip(("pass", "frame", "both"), a.parts(), b.parts())])

    # The paper's exact simulator had one processor [P §4.2].
    ours_alone = [Whole(bench, scene, None, 1) for scene in LIT_SCENES]
    theirs_alone = [Whole(bench, scene, best[scene], 1) for scene in LIT_SCENES]
    gains = [gain_of(a.both, b.both) for a, b in zip(ours_alone, theirs_alone)]
    page.say("lit baseline alone")
    page.table("lit-baseline-alone", ["scene", "throughput, reordered", "scanline", "memory GB/s, reordered", "scanline",
                                      "ms, reordered", "scanline", "rate gained"],
               [[scene, *in_turns(["throughput", "memory GB/s", "frame ms"], a.both, b.both), f"x {gain:.2f}"]
                for scene, a, b, gain in zip(LIT_SCENES, ours_alone, theirs_alone, gains)])
    def both(ours, theirs):
        return f"{text_of(ours)} against {text_of(theirs)}"

    gain = mean_of(gains)
    page.claim("1 lighting", differs(gain, 16.3 / 9.2) or differs(mean_of([throughput(each.both) for each in ours_alone]), 0.93) or
               differs(mean_of([memory_gb_s(each.both) for each in ours_alone]), 0.8), ours=both(ours_alone, theirs_alone), gain=gain,
               half=both(ours, theirs), half_gain=mean_of([gain_of(a.both, b.both) for a, b in zip(ours, theirs)]),
               lost=bench.lost_cycles([run.on({PROCESSORS: 1}).at_paper() for run in bench.lights()]))
