"""Errors and costs of cone-beam tomography on the board: gicube-cone-beam projects, reconstructs and compares phantoms.
Lengths are millimetres."""
import csv
import functools
import math
import pathlib
import tempfile
from dataclasses import dataclass, replace

import gicube
import numpy as np

from studies.points import Table, run, statistics

RADIANS = math.pi / 180
# one ray a pixel sent once, so that charts show one effect
PLAIN = {"method": "fdk", "rays": 1, "sharpen": 0.1, "no-normalise": ""}
NORMALISED = {"method": "fdk", "rays": 1, "sharpen": 0.1}
SART = {"method": "sart", "iterations": 4, "relaxation": 0.3}
HEAD = "builtin:shepp-logan-high-contrast --radius 42 --value 0.05"  # the skull absorbs 0.05 per millimetre
DISCS = "builtin:discs --radius 36 --value 0.05"
COLUMNS = "x,rmse,bias,relative_l2,psnr,ssim,bus_ms,rays,deposits,clipped,residual,iterations,diverged".split(",")


@dataclass(frozen=True)
class Scan:
    """A whole turn around a volume. Defaults: 90 mm, source 400 from the axis, 800 from a detector of 200 mm."""
    voxels: int
    detector: tuple  # columns, rows
    views: int
    edge: float = 0  # of a voxel; 0: the volume has 90 mm
    pitch: float = 0  # of a pixel; 0: the detector has 200 mm
    first: float = 0.1  # radians
    to_axis: float = 400
    to_detector: float = 800

    def __post_init__(self):
        object.__setattr__(self, "edge", self.edge or 90 / self.voxels)
        object.__setattr__(self, "pitch", self.pitch or 200 / self.detector[0])

    def angles(self):
        return [self.first + 2 * math.pi * i / self.views for i in range(self.views)]

    def text(self):
        """A scan file in degrees that convert to nearly the same radians."""
        def degrees(angle):
            near = angle / RADIANS
            return min((near, *(math.nextafter(near, to) for to in (0, 999))),
                       key=lambda each: abs(RADIANS * each - angle))
        angles = " ".join(f"angle: {degrees(angle)!r}" for angle in self.angles())
        columns, rows = self.detector
        return (f"source_to_axis: {self.to_axis!r} source_to_detector: {self.to_detector!r} "
                f"detector {{ columns: {columns} rows: {rows} pitch_u: {self.pitch!r} }} "
                f"volume {{ {3 * f'size: {self.voxels} '} spacing: {self.edge!r} }} {angles}")


def chart_scan(voxels, pixels, views):
    return Scan(voxels, (pixels, pixels), views)


@dataclass
class Case:
    """One reconstruction: its object, scan, method and board."""
    phantom: str
    scan: Scan
    method: dict
    field: tuple = (40, 20)  # of the comparison: distances from the axis and the middle plane
    photons: float = 0  # per pixel; 0: no noise
    settings: str = ""  # of the board

    def reconstruct(self, fidelity="functional", more=lambda folder: {}):
        """Statistics of the reconstruction, and results of `more` for the folder of scan.textproto and volume.nrrd."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "scan.textproto").write_text(self.scan.text())
            noise = f"--photons {self.photons} --seed 1" if self.photons else ""
            method = " ".join(f"--{option} {value}" for option, value in self.method.items())
            run(folder, "gicube-cone-beam",
                f"project {self.phantom} --scan @scan.textproto {noise} -o @views.nrrd --quiet")
            run(folder, "gicube-cone-beam",
                f"reconstruct @scan.textproto --projections @views.nrrd {method} --fidelity {fidelity} "
                f"{self.settings} -o @volume.nrrd --stats @made.json --quiet")
            made = statistics(folder / "made.json")
            return {key: made[key]
                    for key in "rays_ms bus_ms rays deposits clipped residuals iterations diverged".split()} | more(
                        folder)

    def compare(self, folder):
        """Compares the volume with the phantom; writes profiles.csv."""
        radius, height = self.field
        run(folder, "gicube-cone-beam",
            f"compare @volume.nrrd {self.phantom} --field-radius {radius!r} --field-height {height!r} "
            "--stats @error.json --profiles @profiles.csv")
        return statistics(folder / "error.json")

    def measured(self, _):
        """On a functional board, which has the values and the bus's time."""
        return self.reconstruct(more=self.compare)


def case_rows(series):
    def rows(found):
        for name, m in found:
            x = float(name.split("/")[2])
            yield name, [name, series[name], f"{x:g}", f"{m['rmse']:.5g}", f"{m['bias']:.4g}",
                         f"{m['relative_l2']:.5g}", f"{m['psnr']:.4g}",
                         f"{m['ssim']:.4g}", f"{m['bus_ms']:.1f}", m["rays"], m["deposits"], f"{m['clipped']:.4g}",
                         f"{(m['residuals'] or [0])[-1]:.4g}", m["iterations"], int(m["diverged"])]
    return rows


def case_table(name, *series):
    """Series: title, name, values of x, and the case at one."""
    points, titles = {}, {}
    for title, short, xs, case_at in series:
        for x in xs:
            point = f"{name}/{short}/{x:g}"
            points[point], titles[point] = case_at(x).measured, title
    return Table(f"cone_beam_{name}", ["point", "series", *COLUMNS], points, case_rows(titles))


def cone(degrees, phantom=DISCS, method=PLAIN):
    """The source comes nearer to the same object. The detector sees all of it; its pixels at the axis stay the same."""
    to_axis = 40 / math.tan(degrees / 2 * RADIANS)
    return Case(phantom, Scan(64, (96, 112), 120, pitch=2.5, to_axis=to_axis, to_detector=2 * to_axis), method,
                (34, 40))


def cone_angles():
    degrees = (5, 10, 15, 20, 25, 30, 35, 40)
    return case_table("cone_angle", ("discs by FDK", "fdk", degrees, cone),
                      ("discs by SART", "sart", (5, 20, 40), lambda x: cone(x, method=SART)),
                      ("head by FDK", "head", degrees, lambda x: cone(x, HEAD)))


def truncation():
    """A detector that sees a part of the head's width at the axis; compares the field of half of it."""
    width = 2 * 42 * 0.92

    def of(method):
        def at(seen):
            scan = chart_scan(64, 96, 120)
            columns = math.floor(seen * width * 2 / scan.pitch + 0.5)
            return Case(HEAD, replace(scan, detector=(columns, 96)), method, (0.5 * width / 2 * 0.9, 20))
        return at
    return case_table("truncation", ("FDK", "fdk", (1.2, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5), of(PLAIN)),
                      ("SART", "sart", (1.2, 0.9, 0.7, 0.5), of(SART)))


def views():
    return case_table("views",
                      ("FDK", "fdk", (20, 40, 60, 90, 120, 180, 360, 720),
                       lambda x: Case(HEAD, chart_scan(64, 96, x), PLAIN)),
                      ("SART", "sart", (20, 40, 60, 90, 180), lambda x: Case(HEAD, chart_scan(64, 96, x), SART)))


def accumulator():
    def by(setting, board=""):
        """A point of irradiance words, with one setting changed to x."""
        return lambda x: Case(HEAD, chart_scan(64, 96, 120), PLAIN | {"accumulator": "irradiance", setting: x},
                              settings=board)
    return case_table("accumulator",
                      ("sums of 36 bits", "sums", (120,), lambda _: Case(HEAD, chart_scan(64, 96, 120), PLAIN)),
                      ("11 bits read every x views", "read_every", (1, 2, 4, 8, 20, 40, 120), by("read-every")),
                      ("x bits read every 8 views", "bits", (8, 10, 11, 12, 14, 16),
                       by("bits", "--set asic.datapath=wide")),
                      ("11 bits full at x of the bound", "headroom", (1, 0.5, 0.25, 0.12, 0.06, 0.03), by("headroom")))


def times():
    """Times of the whole board at the cycle level, which needs minutes of the host."""
    cases = {"fdk/60": Case(HEAD, chart_scan(64, 96, 60), PLAIN),
             "read_every/20": Case(HEAD, chart_scan(64, 96, 120),
                                   PLAIN | {"accumulator": "irradiance", "read-every": 20})}

    def rows(found):
        for point, m in found:
            yield point, [point, f"{m['rays_ms']:.1f}", f"{m['bus_ms']:.1f}"]
    return Table("cone_beam_times", ["point", "board_ms", "bus_ms"],
                 {f"times/{name}": lambda _, case=case: case.reconstruct("cycle") for name, case in cases.items()},
                 rows)


ALGEBRAIC = (("sart", "SART", {"method": "sart"}, 0.3),
             ("os_sart", "OS-SART 10 x 6", {"method": "os-sart", "subsets": 10}, 1.0),
             ("sirt", "SIRT", {"method": "sirt"}, 1.8))


def sart():
    def noisy(photons):
        def case(method):
            return Case(HEAD, chart_scan(64, 96, 60), method, photons=photons)
        noise, end = ("_noisy", f" of {photons} photons") if photons else ("_noiseless", "")
        yield (f"FDK by Ram-Lak / Shepp-Logan / Hann{end}", f"fdk{noise}", (1, 2, 3),
               lambda x: case(PLAIN | {"window": ("ram-lak", "shepp-logan", "hann")[x - 1]}))
        for name, title, method, relaxation in ALGEBRAIC:
            yield (f"{title} by {relaxation:.1f}{end}", name + noise, (1, 2, 4, 8, 16),
                   lambda x, method=method | {"relaxation": relaxation}: case(method | {"iterations": x}))
    return case_table("sart", *noisy(0), *noisy(3000))


def relaxation():
    return case_table("relaxation", *((title, name, (0.1, 0.3, 1.0, 1.5, 1.9, 2.0, 2.2, 2.5, 3.0),
                                       lambda x,
                                       method=method: Case(HEAD, chart_scan(48, 64, 60),
                                                           method | {"iterations": 6, "relaxation": x}))
                                      for name, title, method, _ in ALGEBRAIC))


def spaced(spacing, views):
    """A scan with pixels of this many voxels at the axis."""
    pitch = 2 * spacing * (90 / 64)
    return Scan(64, 2 * (int(200 / pitch),), views, pitch=pitch, first=0.1 if views > 1 else 0)


def ray_spacing():
    return case_table("ray_spacing", *((title, name, (0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0),
                                        lambda x, method=method: Case(HEAD, spaced(x, 120), method))
                                       for name, title, method in (("one", "one ray a pixel", PLAIN),
                                                                   ("normalised", "the same normalised", NORMALISED),
                                                                   ("four", "2 x 2 rays a pixel",
                                                                       PLAIN | {"rays": 2}))))


def splat(board, scan, fine, slope):
    """Deposits [z, y, x] of rays with density 1 at the axis; `slope` is its relative rise along the detector."""
    near, edge, step = scan.to_axis / scan.to_detector, scan.edge, 0.5
    u, v = ((((np.arange(count * fine) + 0.5) / fine - 0.5) - (count - 1) / 2) * scan.pitch for count in scan.detector)
    u, v = u[None, :], v[:, None]
    slant = scan.to_detector / np.sqrt(scan.to_detector * scan.to_detector + u * u + v * v)
    densities = (1 + slope * u) * slant * scan.pitch * scan.pitch * near * near / (fine * fine * edge * edge * edge)
    corner = (scan.voxels - 1) / 2 * edge
    nearest = (scan.to_axis - math.hypot(corner, corner)) / scan.to_detector
    # of a voxel near the source
    most = edge * max(1, edge * edge / (scan.pitch * scan.pitch * nearest * nearest / (fine * fine)))
    # The unit of gicube-cone-beam: half of the largest sum; a step adds at most 2^15 - 1 units.
    board.clear_sums(densities.max() * max(edge * step / (2 ** 15 - 1), most * scan.views / (8 * 2 ** 30)))
    for angle in scan.angles():
        out, along = np.array((math.cos(angle), math.sin(angle), 0)), np.array((-math.sin(angle), math.cos(angle), 0))
        pixels = (scan.to_axis - scan.to_detector) * out + u[..., None] * along + v[..., None] * np.array((0, 0, 1))
        start = scan.to_axis * out / edge + (scan.voxels - 1) / 2
        ways = pixels / edge + (scan.voxels - 1) / 2 - start
        rays = gicube.rays(start, ways.reshape(-1, 3), length=math.inf, energy=densities.ravel())
        board.receive(board.submit(gicube.clip_to_volume(rays, 3 * (scan.voxels,)), type="backproject", step=step))
    return board.read_sums()


def ripple(spacing, views, fine, normalised):
    """Root mean square of deposits over their ideal, minus 1, in the middle of the volume, where all rays and their
    neighbours pass; and the hat's share of the rays' wave. `normalised`: the deposits are the quotient of rays with a
    slope and rays without one."""
    scan, slope = spaced(spacing, views), 0.004 if normalised else 0  # chosen: from 0.6 to 1.4 over the detector
    with gicube.open("emu:") as board:
        board.load_volume(gicube.Volume(np.zeros(3 * (64,), "u1"), spacing=3 * (scan.edge,)))
        sums, ones = (splat(board, scan, fine, each).astype(float)[3 * (slice(16, 48),)] if each is not None else 1
                      for each in (slope, 0 if normalised else None))
    y, x = ((np.arange(16, 48) - 31.5) * scan.edge for _ in "yx")
    y, wanted, plain = y[:, None], 0, 0
    for angle in scan.angles():
        depth = scan.to_axis - (x * math.cos(angle) + y * math.sin(angle))
        near = scan.to_axis / depth
        wanted += near * near * (1 + slope * (scan.to_detector / depth * (y * math.cos(angle) - x * math.sin(angle))))
        plain += near * near
    with np.errstate(divide="ignore", invalid="ignore"):  # places without rays have no value
        part = np.where(ones == 0, 0, sums / ones / (wanted / plain)) if normalised else sums / wanted
    return [math.sqrt(((part - 1) ** 2).sum() / part.size), (math.sin(math.pi / spacing) / (math.pi / spacing)) ** 2]


def moire():
    kinds = {"view": ("one view along an axis", 1, 1, False), "fine": ("the same by 2 x 2 rays a pixel", 1, 2, False),
             "quotient": ("the same divided by splatted weights", 1, 1, True), "turn": ("90 views", 90, 1, False)}
    points = {f"moire/{name}/{x:g}": lambda _, x=x, kind=kind: ripple(x, *kind[1:]) for name, kind in kinds.items()
              for x in (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0)}

    def rows(found):
        for point, each in found:
            _, name, x = point.split("/")
            yield point, [point, kinds[name][0], x, *(f"{value:.5g}" for value in each)]
    return Table("cone_beam_moire", ["point", "series", "x", "ripple", "hat_at_the_rays_wave"], points, rows)


def profile_table(name, columns, points, title, formats):
    """Several rows per point, lists of numbers."""
    def rows(found):
        for point, lines in found:
            for line in lines:
                yield point, [point, title(point), *(f"{value:{digits}}" for value, digits in zip(line, formats))]
    return Table(f"cone_beam_{name}", ["point", "series", *columns], points, rows)


def axial_profiles():
    def slices(folder):
        run(folder, "gicube-cone-beam",
            f"project {DISCS} --scan @scan.textproto -o @again.nrrd --voxels @truth.nrrd --quiet")
        values, truth = (gicube.read_volume(folder / f"{name}.nrrd").samples.astype(float)
                         for name in ("volume", "truth"))
        place = (np.arange(64) - 31.5) * (90 / 64)
        off = np.hypot(place, place[:, None])
        means = [each[:, off <= radius].mean(axis=1) for each, radius in ((truth, 34), (values, 8), (values, 34))]
        return {"lines": np.column_stack([place, *means]).tolist()}
    points = {f"axial_profile/fdk/{x}": lambda _, x=x: cone(x).reconstruct(more=slices)["lines"]
              for x in (5, 10, 20, 30, 40)}
    return profile_table("axial_profile", ("z", "truth", "within_8", "within_34"), points,
                         lambda point: f"{point.split('/')[2]} degrees",
                         (".3f", ".4f", ".5f", ".5f"))


def profiles():
    """Profiles of the method's reference scans along x through the middle, without and with normalising."""
    sizes, phantoms = {128: 180, 256: 360}, {"sphere": "builtin:sphere --radius 70 --value 1",
                                             "head": "builtin:shepp-logan --radius 85 --value 1"}

    def along_x(case, folder):
        case.compare(folder)
        with open(folder / "profiles.csv") as file:
            lines = [row for row in csv.DictReader(file) if row["axis"] == "x"]
        return {"lines": [[float(row["position"]), *(float(np.float32(row[name])) for name in ("truth", "value"))]
                          for row in lines]}

    def measured(phantom, voxels):
        scan = Scan(voxels, (256, 256), sizes[voxels], edge=180 / voxels, pitch=400 / 256, first=0, to_axis=500,
                    to_detector=1000)
        cases = [Case(phantoms[phantom], scan, method, (85, 45)) for method in (PLAIN, NORMALISED)]
        plain, normalised = (case.reconstruct(more=functools.partial(along_x, case))["lines"] for case in cases)
        return [[*line, other[2]] for line, other in zip(plain, normalised)]

    def title(point):
        _, phantom, voxels = point.split("/")
        return f"{phantom} of {voxels}^3 from {sizes[int(voxels)]} views"
    points = {f"profile/{name}/{voxels}": lambda _, each=(name, voxels): measured(*each) for voxels in sizes
              for name in phantoms}
    return profile_table("profile", ("x", "truth", "value", "normalised"), points, title, (".4f", ".5f", ".5f", ".5f"))


def tables():
    return [cone_angles(), axial_profiles(), truncation(), views(), moire(), ray_spacing(), accumulator(), times(),
            sart(), relaxation(), profiles()]
