"""Does the runs of bench.py on emulated boards, in parallel, without those that have files."""
import functools
import os
import pathlib
import threading
import zlib
from dataclasses import replace

import gicube
import numpy as np
import scenes
from scenes import faint, make_view, normalise
from studies.points import Kept
from studies.runs import all_at_once

PRESET = pathlib.Path(__file__).resolve().parents[3] / "board_emu/config/presets/paper.textproto"
SCENES = threading.Lock()  # makes one scene at a time, and each once
scene_of = functools.cache(scenes.make_scene)


def open_board(run):
    settings = "".join(f"&set={field}={value}" for field, value in run.settings)
    preset = f"&config={PRESET}" if run.paper else ""
    return gicube.open(f"emu:?fidelity=cycle&threads=1{preset}{settings}")


def load(board, scene, be_faint):
    if scene.lit:
        return gicube.load_scene(board, scene.setup, light=False)
    if scene.setup is not None:
        board.set_shading(scene.setup.shading)
    board.load_volume(scene.volume)
    for tag, look in enumerate(scene.looks):
        board.set_transfer_function(faint(look) if be_faint else look, tag)


def window(board, work):
    """Growth of the board's counters and clock during `work`: arguments of Measurement in figures.py."""
    counters, begin = board.counters, board.now
    work()
    return {"time_ps": board.now - begin, "counters": dict(board.counters - counters),
            "processors": board.info.processors,
            "core_hz": 1e3 * board.info.core_khz}


def rays_of(view, dims):
    """The view's rays from their entry into the volume; omits rays that miss it."""
    eye = np.array(view.eye, dtype=float)
    forward = normalise(np.array(view.look_at) - eye)
    right = normalise(np.cross(forward, view.up))
    up = np.cross(right, forward)
    tangent = np.tan(view.fov_degrees * np.pi / 360)
    x = tangent * (2 * (np.arange(view.width) + 0.5) - view.width) / view.height
    y = tangent * (view.height - 2 * (np.arange(view.height)[:, None] + 0.5)) / view.height
    along = forward + x[..., None] * right + y[..., None] * up
    along = along / np.sqrt((along * along).sum(axis=-1))[..., None]
    rays = gicube.clip_to_volume(gicube.rays(eye, along.reshape(-1, 3), length=1e9), dims)
    rays["length"] = 0
    return rays


def trace(board, view, rays):
    """Host rays with the view's sampling. A view beside the volume, without rays for the ASIC, first sends registers
    and tables."""
    past = replace(view, width=1, height=1, look_at=tuple(2 * eye - at for eye, at in zip(view.eye, view.look_at)))
    board.render_to_framebuffer(past)
    sampling = gicube.Sampling.of(past)
    return window(board, lambda: board.receive(board.submit(rays, step=view.step, leap=view.leap, sampling=sampling)))


def fill_block(board, view):
    """Rays through one block along z, one per column of its cells, which end at a cut plane."""
    n = board.info.block_voxels
    y, x = (each.ravel() + 0.5 for each in np.mgrid[:n, :n])
    rays = gicube.rays(np.stack([x, y, np.full(n * n, 0.5 * view.step)], axis=1), (0, 0, 1))
    return trace(board, replace(view, cut_planes=[gicube.CutPlane((0, 0, -1), -n)], shade=False), rays)


def illuminate(board, run, scene):
    settings = replace(scene.setup.illumination, rays_per_face_voxel=run.light_rays, step=run.step, leap=run.leap,
                       jitter=run.jitter, albedo=gicube.Albedo.HIGH if run.high_albedo else gicube.Albedo.LOW)
    return board.illuminate(scene.setup.lights, settings)


def measure_run(board, run, scene, is_lit, picture):
    view = replace(make_view(scene, run.view, run.width, run.height, run.orthographic), step=run.step,
                   opacity_threshold=0.98,
                   leap=run.leap, jitter=run.jitter, irradiance=run.light_rays > 0, scatter=scene.lit,
                   lamps=[])  # lamps outside the volume do not change the scenes' work
    if run.kind == "light":
        reports = []
        result = window(board, lambda: reports.append(illuminate(board, run, scene)))
        emitted = reports[0].emitted
        return result | {"clipped": reports[0].clipped / emitted if emitted else 0.0}
    if run.kind == "host_rays":
        return trace(board, view, rays_of(view, scene.volume.dims))
    if run.kind == "fill_block":
        return fill_block(board, view)
    if run.light_rays > 0 and not is_lit:
        illuminate(board, run, scene)
    images = []
    result = window(board, lambda: images.append(board.render(view)))
    if picture:
        images[0].save(picture, scene.background)
    return result


def measure_board(runs, pictures):
    """The runs must share scene, settings and light. Raises RuntimeError with a run's name and the driver's message."""
    run = runs[0]
    try:
        with SCENES:
            scene = scene_of(run.scene, run.dims, run.edge)
        with open_board(run) as board:
            load(board, scene, run.faint)
            results, is_lit = [], False
            for run in runs:
                results.append(measure_run(board, run, scene, is_lit, pictures.get(run)))
                is_lit = run.light_rays > 0
            return results
    except (gicube.Error, OSError) as error:
        raise RuntimeError(f"{run.name()}: {error}") from error


def kept_in(folder):
    """The measurement, for the same board, driver and scenes alone."""
    return Kept(folder, [os.environ["GICUBE_BOARD"], gicube._core.__file__, __file__, scenes.__file__, PRESET])


def name_of(runs):
    return "\n".join(run.name() for run in runs)


def measure_boards(kept, jobs, pictures, boards):
    """Yields (run, result) for lists of runs, one per board, when a board is done. `pictures`: files of runs whose
    image is kept. Raises what measure_board() raises; then, and on Ctrl-C, running boards finish first, and their
    results are kept."""
    def measured(runs):
        name = name_of(runs)
        if not all(pictures[run].exists() for run in runs if run in pictures):
            kept.forget(name)
        return zip(runs, kept.of(name, lambda: measure_board(runs, pictures)))
    for results in all_at_once([functools.partial(measured, runs) for runs in boards], jobs):
        yield from results


def measure_shard(kept, shard, measure, boards):
    """Yields like measure(boards) for the lists of shard (I, N), which their names determine. Yields the others too
    when all are kept, because the next requests depend on all."""
    number, shards = shard
    is_mine = [zlib.crc32(name_of(runs).encode()) % shards == number - 1 for runs in boards]
    yield from measure([runs for runs, mine in zip(boards, is_mine) if mine])
    others = [runs for runs, mine in zip(boards, is_mine) if not mine]
    if all(kept.has(name_of(runs)) for runs in others):
        yield from measure(others)
