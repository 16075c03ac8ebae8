"""Runs at the design point, and their measurements, for all sections of the page.

The page needs several passes. Bench.get() of a new run records it and returns an empty measurement; measure() does the
recorded runs; the next pass reads their measurements, and may request further runs."""
import collections
from dataclasses import dataclass, replace

from figures import (Measurement, asic_ms, cause_shares, dsp_use, frame_ms, hit_ratio, mean_of, memory_gb_s, memory_use,
                     overflows_a_ray, rate_hz, samples_per_second, spread_of, throughput)
from page import number, percent
from scenes import BRAIN, DESIGN_EDGE, SCANS, load_scan
from studies.runs import progress

# Scenes and their purposes.
SCENES = {
    "buckyball": "C60 above a floor: opaque surfaces, much empty space",
    "head": "nested rough ellipsoids: translucent skin, skull and brain, empty corners",
    "cloud": "noise that never gets opaque; no block is empty",
    "rock": "noise that is opaque everywhere within a part of its edge; no block is empty"}
LIT_SCENES = {  # in the last one all voxels receive light
    "golden-ring": "caustics: a polished ring on a floor under a point light",
    "mirror-buckyball": "C60 over a mirror before a wall, with its shadow",
    "mirror-head": "a head between two mirrors, a window and a lamp",
    "fog-box": "coloured walls in fog: nearly every voxel takes light"}
VIEWS = ["oblique", "along x", "along y", "along z", "diagonal"]

PARTITION = "asic.partition"
PROCESSORS = "asic.processors"
QUEUE = "asic.queue_rays"
SHARED_MEMORY = {"rdram.processors_per_rdram": 2}
SKEWED = {PARTITION: "skewed_block"}
# No limits in front of the processors: a DSP without work time, runs of 64 rays, and links with a ray per cycle.
IDEAL_DSP = {"ideal.dsp": 1}
RUNS_OF_RAYS = {"dsp.run_rays": 64}
WIDE_LINKS = {"link.bits": 256}
IDEAL_FRONT_END = IDEAL_DSP | RUNS_OF_RAYS | WIDE_LINKS
# on an 8 x 8 x 8 grid for 16 processors (docs/reference/hardware.md)
EVEN = SKEWED | {"asic.skew_y": 2, "asic.skew_z": 7}


@dataclass(frozen=True)
class Run:
    """Measured quantity and settings of the board."""
    scene: str
    dims: tuple  # voxels of the volume
    edge: int  # unit of the scene's lengths, voxels
    width: int
    height: int
    # or light: an illumination pass; host_rays: the view's, made by the host; fill_block: through one block
    kind: str = "frame"
    view: str = "oblique"
    step: float = 0.5  # voxels
    leap: bool = True
    jitter: bool = False
    paper: bool = False  # with the preset of the paper's operating point
    faint: bool = False  # no ray becomes opaque: without early termination
    orthographic: bool = False
    light_rays: int = 0  # per face voxel, k, of the illumination pass (before it); 0 = none
    high_albedo: bool = False  # of that pass
    settings: tuple = ()  # of the board's configuration: (path.to.field, value), sorted

    def but(self, **fields):
        return replace(self, **fields)

    def on(self, settings):
        """The run on a board with further settings."""
        changed = {field: str(value) for field, value in settings.items()}
        return self.but(settings=tuple(sorted((dict(self.settings) | changed).items())))

    def at_step(self, step):
        return self.but(step=step)

    def at_paper(self):
        """The run at the paper's operating point: steps of a voxel, jittered in views [P §2.1], with its preset."""
        return self.but(step=1, jitter=self.kind != "light", paper=True)

    def board(self):
        """Runs on one board share its volume and its light."""
        own = self.step if self.kind == "fill_block" else None  # starts with a cold cache
        return (self.paper, self.faint, self.scene, self.dims, self.edge, self.light_rays, self.high_albedo, own,
                self.settings)

    def name(self):
        fields = [f"{field}={value}" for field, value in vars(self).items() if field not in ("scene", "settings")
                  and value]
        return " ".join([self.scene, *fields, *(f"{field}={value}" for field, value in self.settings)])


def at_paper(runs):
    return [run.at_paper() for run in runs]


def scanline(run, queue):
    """On the reference machine for reordering [P §5.1]: one queue per processor, with rays in the order of arrival."""
    return run.on({"sorter.queues": "single", "cache.tags": "of_voxels", QUEUE: queue})


class Bench:
    def __init__(self, edge, image):
        self.edge = edge  # voxels, N
        self.image = image  # pixels
        self.block = max(8, edge // 8)  # voxels, n: an 8 x 8 x 8 grid
        self._known = {}
        self._wanted = {}  # a dict, in the order of requests
        self.page = None

    def run(self, scene, view="oblique", **fields):
        """A frame of the whole volume at the design point, scaled to the edge."""
        settings = {"asic.block_voxels": self.block} if self.block != 32 else {}
        if self.edge != 256:
            settings["asic.max_volume_voxels"] = self.edge
        return Run(scene, 3 * (self.edge,), self.edge, self.image, self.image, view=view).on(settings).but(**fields)

    def lit(self, scene, k=1, high_albedo=False):
        """A picture of a scene of global illumination with its own camera, lit by a pass of k rays per face voxel."""
        return self.run(scene, light_rays=k, high_albedo=high_albedo)

    def light(self, scene, k=1, high_albedo=False):
        """That pass."""
        return self.lit(scene, k, high_albedo).but(kind="light")

    def all(self):
        return [self.run(scene, view) for scene in SCENES for view in VIEWS]

    def oblique(self):
        return [self.run(scene) for scene in SCENES]

    def scans(self):
        """Available scans at the paper's operating point. They have one size."""
        if self.edge != DESIGN_EDGE:
            return []
        at_hand = [name for name, (path, _) in SCANS.items() if path.exists()]
        return [self.run(name, dims=load_scan(name).shape[::-1]).at_paper() for name in at_hand]

    def mirrors(self):
        """The paper's brain between mirrors, or a head without a scan."""
        return self.lit("mirror-brain" if BRAIN.exists()
                        and self.edge == DESIGN_EDGE else "mirror-head").but(light_rays=0)

    def lit_scenes(self):
        return [self.lit(scene) for scene in LIT_SCENES]

    def lights(self, high_albedo=False):
        return [self.light(scene, 1, high_albedo) for scene in LIT_SCENES]

    def get(self, run):
        if run not in self._known:
            self._wanted[run] = None
            return Measurement()
        return self._known[run]

    def over(self, runs, figure):
        return [figure(self.get(run)) for run in runs]

    def spread(self, runs, figure):
        return spread_of(self.over(runs, figure))

    def mean(self, runs, figure):
        return mean_of(self.over(runs, figure))

    def lost_cycles(self, runs):
        """The most frequent causes of cycles without a sample, with shares: "cache_fill 12%, dsp 8%, latency 5%"."""
        shares = collections.Counter()
        for run in runs:
            shares.update({name: share / len(runs) for name, share in cause_shares(self.get(run)) if name != "busy"})
        largest = sorted(sorted(shares.items()), key=lambda each: -each[1])[:4]
        return ", ".join(f"{name} {percent(share)}" for name, share in largest)

    def causes_table(self, name, columns, runs):
        """The runs' pipeline cycles by their cause, a column each."""
        of_causes = zip(*self.over(runs, cause_shares))
        self.page.table(name, ["cause", *columns],
                        [[each[0][0], *(percent(share, 1) for _, share in each)] for each in of_causes])

    def complete(self):
        return not self._wanted

    def measure(self, measured, quiet):
        """Does the recorded runs; false if other shards have some of them. `measured`: yields (run, result) for lists
        of runs, one per board."""
        boards = {}  # a board's caches carry over between runs, so their order affects results
        for run in self._wanted:
            boards.setdefault(run.board(), []).append(run)
        with progress("results", len(self._wanted), quiet) as bar:
            for run, result in measured(boards.values()):
                self._known[run] = Measurement(**result)
                bar.update()
        done = self._wanted.keys() <= self._known.keys()
        self._wanted = {}
        return done


# Formats of figures in tables, by the head of the column.
CELLS = {
    "frame ms": lambda m: number(frame_ms(m)),
    "Hz": lambda m: number(rate_hz(m)),
    "ASIC ms": lambda m: number(asic_ms(m)),
    "M samples": lambda m: number(m["processor.samples"] * 1e-6, 1),
    "M samples/s": lambda m: number(samples_per_second(m) * 1e-6, 0),
    "throughput": lambda m: percent(throughput(m)),
    "memory GB/s": lambda m: number(memory_gb_s(m), 2),
    "memory in use": lambda m: percent(memory_use(m)),
    "hit ratio": lambda m: percent(hit_ratio(m), 1),
    "DSP busy": lambda m: percent(dsp_use(m)),
    "overflows a ray": lambda m: number(overflows_a_ray(m), 2)}


def cells(m, columns, others=None):
    """Cells of a measurement's row; `others`: further formats like CELLS."""
    return [((others or {}).get(column) or CELLS[column])(m) for column in columns]
