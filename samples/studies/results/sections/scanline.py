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


def text_of(ours, theirs):
    """Frames alone, and with a pass in each; how much faster ours are."""
    def part(figure_of):
        ms, slow = (", ".join((percent(mean_of([throughput(figure_of(each)) for each in wholes])),
                               f"{mean_of([memory_gb_s(figure_of(each)) for each in wholes]):.1f} GB/s",
                               f"{mean_of([rate_hz(figure_of(each)) for each in wholes]):.1f} Hz")) for wholes in (ours, theirs))
        return f"{ms} against {slow}: x {mean_of([gain_of(figure_of(a), figure_of(b)) for a, b in zip(ours, theirs)]):.2f}"
    return f"frames {part(lambda each: each.frame)}; with a pass in each {part(lambda each: each.both)}"


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
    ours, theirs = ([Whole(bench, scene, queue) for scene, queue in each] for each in (dict.fromkeys(LIT_SCENES).items(), best.items()))
    parts_table(page, "lit-baseline", best, ours, theirs)

    # The paper's exact simulator had one processor [P §4.2]; its 16.3 Hz leave no time for its pass of 361 ms: they are of frames.
    alone, alone_slow = ([Whole(bench, scene, queue, 1) for scene, queue in each] for each in (dict.fromkeys(LIT_SCENES).items(), best.items()))
    page.say("lit baseline alone")
    parts_table(page, "lit-baseline-alone", best, alone, alone_slow)
    gain = mean_of([gain_of(a.frame, b.frame) for a, b in zip(alone, alone_slow)])
    page.claim("1 lighting", differs(gain, PAPER_GAIN) or differs(mean_of([throughput(each.frame) for each in alone]), 0.93) or
               differs(mean_of([memory_gb_s(each.frame) for each in alone]), 0.8), ours=text_of(alone, alone_slow), half=text_of(ours, theirs),
               lost=bench.lost_cycles([run.on({PROCESSORS: 1}).at_paper() for run in bench.lit_scenes()]))


def parts_table(page, name, best, ours, theirs):
    columns = ["throughput", "memory GB/s", "hit ratio", "frame ms"]
    page.table(name, ["scene", "best queue", "part", "throughput, reordered", "scanline", "memory GB/s, reordered",
                      "scanline", "hit ratio, reordered", "scanline", "ms, reordered", "scanline", "rate gained"],
               [[scene, str(queue), part, *in_turns(columns, x, y), f"x {gain_of(x, y):.2f}"]
                for (scene, queue), a, b in zip(best.items(), ours, theirs)
                for part, x, y in zip(("pass", "frame", "both"), a.parts(), b.parts())])
