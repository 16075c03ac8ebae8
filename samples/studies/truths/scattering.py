"""Slabs, half spaces, cubes, furnaces and beams in scattering media, by the board's deposits."""
import math

import gicube
import numpy as np

from studies.truths.case import Case, Value, even, lambert, mean_of, scatterer, sphere
from studies.truths.solvers import half_space_albedo, photons_in_box, slab

UNIT = 2.0**-20  # part of a ray's energy; words of 32 bits clip larger values, and the board reports it


def spread(board, place, direction, seed, albedo, step=0.5):
    """The board's report on rays of energy 1, in voxels."""
    made = gicube.rays(place, direction, energy=1.0)
    board.clear_irradiance(UNIT)
    sampling = gicube.Sampling(seed=seed)
    return board.receive(board.submit(made, type=gicube.RayType.DEPOSIT, albedo=albedo, step=step, lifetime=1023,
                                      sampling=sampling)).lighting


def shares(report):
    """Shares of the light that leave by the six faces, and that are absorbed."""
    return [*(part / report.emitted for part in report.escaped_by_face),
            (report.deposited + report.clipped) / report.emitted]


def over_runs(board, runs, start, kind, step=0.5, count=shares):
    """Means and standard errors of `count` over runs of the rays that `start` makes with a run's random numbers: places
    and directions."""
    return mean_of([count(spread(board, *start(np.random.default_rng(run)), run, kind, step)) for run in range(runs)])


def down(cosine, count):
    return np.tile([math.sqrt(1 - cosine * cosine), 0, cosine], (count, 1))


def square_beam(random, count, cosine):
    """Through the middle of a face of 65 voxels."""
    return random.uniform((31, 31, 0), (33, 33, 0), (count, 3)), down(cosine, count)


def layer(bench, depth, albedo, g, rays=2048, runs=32, kind="low", step=0.5):
    """A perpendicular beam on the middle of a layer two voxels thick, with 32 voxels on each side."""
    with bench.board(np.ones((3, 65, 65)), even(depth / 2), edge=128) as board:
        scatterer(board, albedo, g)
        mean, error = over_runs(board, runs, lambda random: square_beam(random, rays, 1), kind, step)
    reflected, passed = slab(depth, albedo, g)
    name = f"depth {depth:g}, albedo {albedo:g}, g {g:g}"
    return [Value(f"{name}: reflected", reflected, mean[4], error[4], 1e-6),
            Value(f"{name}: passed", passed, mean[5], error[5], 1e-6),
            Value(f"{name}: absorbed", 1 - reflected - passed, mean[6], error[6], 1e-6)][:2 + (albedo < 1)]


def half_space(bench, albedo, cosine, rays=1024, runs=32, kind="low"):
    """A half space, as a block 64 free paths deep."""
    with bench.board(np.ones((65, 65, 65)), even(1.0), edge=128) as board:
        scatterer(board, albedo)
        mean, error = over_runs(board, runs, lambda random: square_beam(random, rays, cosine), kind)
    return [Value(f"albedo {albedo:g}, cosine {cosine:g}: reflected", half_space_albedo(albedo, cosine), mean[4],
                  error[4], 1e-6)]


CUBE = {(1, 1.0): (.13231, .10538, .76231, 0), (1, 0.5): (.05582, .08070, .59694, .26653),
        (1, 0.0): (0, .0661637, .48780, .44602)}
CUBE_ERROR = 1.1e-4


def cube(bench, depth, albedo, rays=4096, runs=32, kind="low"):
    edge = 16

    def start(random):
        place = np.column_stack([edge * random.random((rays, 2)), np.zeros(rays)])
        return place, lambert(random.random((rays, 2)))

    def parts(report):
        *sides, back, opposite, absorbed = shares(report)
        return back, opposite, sum(sides), absorbed

    with bench.board(np.ones(3 * (edge + 1,)), even(depth / edge)) as board:
        scatterer(board, albedo)
        mean, error = over_runs(board, runs, start, kind, count=parts)
    names = ("back", "opposite", "four sides", "absorbed")
    return [Value(f"depth {depth:g}, albedo {albedo:g}: {name}", truth, a, b, CUBE_ERROR)
            for name, truth, a, b in zip(names, CUBE[depth, albedo], mean, error) if truth or a]


def furnace(bench, albedo, rays=8192, runs=32, kind="low"):
    """A box of two media in radiance 1. Each place absorbs as much as it emits, and as much leaves each face as enters
    it. With albedo 1, only the faces give values."""
    size, kappa = np.array((12, 8, 16)), (0.25, 0.05)
    tags = np.zeros(size[::-1] + 1, "u1")
    tags[:, :, 4:] = 1
    albedos = (albedo, albedo if albedo == 1 else albedo / 2)
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]], float)
    faces = np.repeat(math.pi * areas, 2)
    volumes = size[1] * size[2] * np.array((3.5, 8.5))  # the media meet half way between two voxels
    bodies = 4 * math.pi * volumes * np.array(kappa) * (1 - np.array(albedos))
    powers = np.concatenate([faces, bodies])

    def start(random):
        where = random.choice(8, rays, p=powers / powers.sum())
        place, direction = size * random.random((rays, 3)), sphere(random.random((rays, 2)))
        for face in range(6):
            mine, axis, far = where == face, face // 2, face % 2
            place[mine, axis] = far * size[axis]
            inward = lambert(random.random((mine.sum(), 2)))[:, np.roll([0, 1, 2], axis + 1)]
            inward[:, axis] = abs(inward[:, axis]) * (1 - 2 * far)
            direction[mine] = inward
        for body, (low, high) in enumerate(((0, 3.5), (3.5, 12))):
            mine = where == 6 + body
            place[mine, 0] = random.uniform(low, high, mine.sum())
        return place, direction

    with bench.board(np.ones(tags.shape), even(kappa[0]), tags, [even(kappa[1])]) as board:
        for tag, each in enumerate(albedos):
            scatterer(board, each, tag=tag)

        def parts(report):
            near = board.read_irradiance()[:, :, :3].sum() / report.emitted  # entirely in the first medium
            return *shares(report), near

        mean, error = over_runs(board, runs, start, kind, count=parts)
    total = powers.sum()
    out = [Value(f"albedo {albedo:g}: out by {name}", power / total, a, b)
           for name, power, a, b in zip(("x = 0", "x = 12", "y = 0", "y = 8", "z = 0", "z = 16"), faces, mean, error)]
    if albedo < 1:
        out.append(Value(f"albedo {albedo:g}: absorbed", bodies.sum() / total, mean[6], error[6]))
        out.append(Value(f"albedo {albedo:g}: absorbed within x < 2.5", bodies[0] * 2.5 / 3.5 / total, mean[7],
                         error[7]))
    return out


def beam(bench, albedo, g, rays, runs=10, kind="low", step=0.5):
    """Moments of the places at which an infinite medium absorbs a pencil beam. Free paths of mean 1 and cosines of mean
    g give <z> = 1 / (1 - a g) and <r^2> = 2 / ((1 - a) (1 - a g))."""
    edge, kappa = 64, 1.0
    place = np.array([edge / 2, edge / 2, edge / 2 - 2])
    axis = np.arange(edge + 1.0)
    with bench.board(np.ones(3 * (edge + 1,)), even(kappa), edge=128) as board:
        scatterer(board, albedo, g)
        found = []
        for run in range(runs):
            # A deposit is divided among eight voxels, which adds a sixth of a voxel's square on each axis.
            middle = place + np.random.default_rng(run).random((rays, 3))
            spread(board, middle, down(1, rays), run, kind, step)
            kept = board.read_irradiance().astype(float)
            total = kept.sum()
            means = [(kept.sum(axis=tuple({0, 1, 2} - {2 - i})) * axis).sum() / total for i in range(3)]
            squares = [(kept.sum(axis=tuple({0, 1, 2} - {2 - i})) * axis**2).sum() / total for i in range(3)]
            start, square = middle.mean(axis=0), (middle**2).mean(axis=0)
            along = means[2] - start[2]
            # Starts are independent of the paths, so squares of sums separate.
            across = sum(squares[i] - square[i] - 2 * start[i] * (means[i] - start[i]) for i in range(3)) - 0.5
            found.append([along, across])
    mean, error = mean_of(found)
    name = f"albedo {albedo:g}, g {g:g}"
    return [Value(f"{name}: mean depth", 1 / (1 - albedo * g), mean[0], error[0]),
            Value(f"{name}: mean square distance", 2 / ((1 - albedo) * (1 - albedo * g)), mean[1], error[1])]


def index_step(bench, rays=2048, runs=16, kind="high", step=0.5):
    """A half space of index 1.5 and albedo 0.9. A surface layer, whose routine is Fresnel's, covers it."""
    values, tags = np.ones((65, 65, 65)), np.zeros((65, 65, 65), "u1")
    values[:2] = np.array((0, 0.5))[:, None, None]  # the rise has the layer's normal
    tags[:3] = 1
    with bench.board(values, even(0.5), tags, [gicube.TransferFunction([(0, (1, 1, 1))], [(0, 1)])], edge=128,
                     gradients=True) as board:
        scatterer(board, 0.9)
        board.set_material(gicube.Material(scattering=1, bsdf=gicube.Bsdf.TRAP, routine=gicube.FRESNEL_ROUTINE,
                                           parameters=[1.5], surface=True), 1)
        mean, error = over_runs(board, runs, lambda random: square_beam(random, rays, 1), kind, step)
    return [Value("reflected, with the surface's share", 0.26, mean[4], error[4], 5e-5)]


MCX = (1.005, 1 / 1.005, 0.01)  # extinction per mm, albedo, g


def cube60(bench, rays=512, runs=16, photons=50000):
    """A pencil beam on a cube of 60 mm."""
    with bench.board(np.ones((61, 61, 61)), even(MCX[0]), edge=128) as board:
        scatterer(board, MCX[1], MCX[2])
        mean, error = over_runs(board, runs, lambda _: (np.tile([29.0, 29, 0], (rays, 1)), down(1, rays)), "high")
    absorbed, faces = photons_in_box((60, 60, 60), *MCX, np.tile([29.0, 29, 0], (photons, 1)), down(1, photons), seed=7)
    spread_of = absorbed.std() / math.sqrt(photons)
    return [Value("absorbed", absorbed.mean(), mean[6], error[6], spread_of),
            Value("back through z = 0", faces[4], mean[4], error[4], math.sqrt(faces[4] * (1 - faces[4]) / photons))]


ORDINATES = "discrete ordinates and doubling, 64 streams (van de Hulst, Multiple Light Scattering, 1980)"
SLABS = [(2, .9, .75), (1, 1, 0), (1, .95, 0), (1, .5, 0), (4, .95, 0), (.25, .8, .3), (8, 1, 0), (1, .9, .9),
         (2, .9, -.5)]


def cases():
    out = []
    for depth, albedo, g in SLABS:
        mcml = ", MCML's slab (Wang, Jacques, Zheng 1995, table 1)" if g == .75 else ""
        sweep = tuple({"rays": 4**i} for i in range(2, 6)) if g == .75 else ()
        for kind in ("low", "high"):
            out.append(Case(f"scattering/slab {depth:g} {albedo:g} {g:g}/stored light, {kind} albedo", ORDINATES + mcml,
                            layer, {"depth": depth, "albedo": albedo, "g": g, "kind": kind},
                            {"rays": 512} if g in (.75, .3) else None, sweep))
    for albedo in (.3, .7, .95):
        for cosine in (1, .5, .2):
            out.append(Case(f"scattering/half space {albedo:g} {cosine:g}/stored light, low albedo",
                            "Chandrasekhar's H (Radiative Transfer, 1960)", half_space,
                            {"albedo": albedo, "cosine": cosine},
                            {"rays": 256} if cosine == .5 and albedo < .9 else None))
    for (depth, albedo) in CUBE:
        for kind in ("low", "high"):
            out.append(Case(f"scattering/cube {depth:g} {albedo:g}/stored light, {kind} albedo",
                            "20 million paths; opposite of albedo 0: quadrature", cube,
                            {"depth": depth, "albedo": albedo, "kind": kind}, {"rays": 1024} if albedo == .5 else None))
    for albedo in (.3, .7, 1.0):
        out.append(Case(f"scattering/furnace {albedo:g}/stored light, low albedo", "equilibrium", furnace,
                        {"albedo": albedo}, {"rays": 1024}))
    for albedo, g in ((.7, .5), (.8, .8), (.5, -.4)):
        for kind, step in (("low", .5), ("low", .125), ("high", .5)):
            out.append(Case(f"scattering/beam {albedo:g} {g:g}/stored light, {kind} albedo, step {step:g}",
                            "moments of a random walk, closed form", beam,
                            {"albedo": albedo, "g": g, "kind": kind, "step": step,
                             "rays": 2048 if kind == "low" else 4096},
                            {"rays": 512} if albedo == .5 and kind == "high" else None))
    for kind in ("low", "high"):
        out.append(Case(f"scattering/MCML half space, index 1.5/stored light, {kind} albedo",
                        "Giovanelli 1955, after Wang, Jacques, Zheng 1995, table 2", index_step,
                        {"kind": kind, "rays": 512 if kind == "low" else 2048},
                        {"rays": 256, "runs": 8} if kind == "high" else None))
    out.append(Case("scattering/MCX cube60/stored light, high albedo",
                    "plain Monte Carlo of 50,000 photons; MCX's own test expects 17.x%", cube60, {}, None))
    return out
