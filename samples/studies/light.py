"""How near the board's light comes to the truth: pictures by each method, the time of the board that they take, and their distance from
paths in double precision (gicube-light-reference)."""
import itertools
import json
import pathlib
import re
import tempfile

import numpy as np

from studies.pictures import read_picture
from studies.points import ROOT, Table, run, statistics
from studies.table import on_front

SCENES = {**{name: ROOT / f"samples/scenes/{name}.scene" for name in ("fog_box", "golden_ring", "mirror_buckyball_area", "mirror_head")},
          "engine": ROOT / "samples/studies/light_scenes/engine.scene"}
# Plans of light are judged on these; they were named before any plan or method was run on them here.
HELD_OUT = {**{name: ROOT / f"samples/scenes/{name}.scene" for name in ("glass", "mirror_buckyball")},
            "room": ROOT / "samples/studies/light_scenes/held_out_room.scene"}
SIZE = "128x128"
VOXELS = 96
TILE = 4  # pixels along an edge
# Paths a pixel of the truth: standard errors of tiles of 8 x 8 pixels of about 0.5%.
PATHS = {"fog_box": 500, "golden_ring": 900, "mirror_buckyball_area": 320, "mirror_head": 900, "engine": 300,
         "glass": 3000, "mirror_buckyball": 400, "room": 1300}
LAMP = 0.3  # world units: radius of the ball that stands for a point light, which no path from the eye comes upon

# By name: what is set of the illumination, and of the board.
LIGHTING = {
    **{f"low, k={k}": ({"rays_per_face_voxel": k}, "") for k in (1, 4, 16, 64)},
    **{f"low, k=16, step {step}": ({"step": step}, "") for step in (1, 2)},
    **{f"high, k={k}": ({"albedo": '"high"', "rays_per_face_voxel": k}, "") for k in (16, 64)},
    **{f"low, k={k}, paper": ({"rays_per_face_voxel": k}, "--set asic.datapath=paper") for k in (4, 16)},
    "low, k=16, rgb": ({}, "--set asic.voxel_format=rgb"),
    "low, k=16, one pass": ({"colour_passes": "false"}, ""),
}
BY_HOST_RAYS = {
    **{f"paths from the eye, {n} passes": ("gicube-path", f"--light-scatterings 0 --passes {n}") for n in (4, 16, 64)},
    **{f"paths from both ends, {n} passes": ("gicube-path", f"--passes {n}") for n in (4, 16)},
    **{f"photon map, {n} passes": ("gicube-photon-map", f"--photons 100000 --neighbours 60 --passes {n}") for n in (1, 4)},
}


def braces(text, start):
    """The end of the message that opens at or after `start`."""
    depth = 0
    for at in range(text.index("{", start), len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return at + 1
    raise ValueError("unbalanced")


def judged(file, **of_illumination):
    """The text of a scene file as all methods see the same light in it: materials show what they scatter, mirrors and glass nothing of
    their own; no ambient light, no background; balls for point lights. Fields of the illumination are set."""
    text = file.read_text()

    def look(material):
        share = float(re.search(r"scattering: ([\d.]+)", material)[1])
        colour = re.search(r"scattering_colour \{ red: ([\d.]+) green: ([\d.]+) blue: ([\d.]+) \}", material)
        shown = np.zeros(3) if "seen_through" in material else share * np.array(colour.groups() if colour else (1, 1, 1), float)
        shown = "colour {{ red: {:.6g} green: {:.6g} blue: {:.6g} }}".format(*shown)
        material = re.sub(r"(?<!_)colour \{ red[^}]*\}", shown, material, count=1)
        return material if shown in material else re.sub(r"(solid|fog) \{", rf"\1 {{ {shown}", material, count=1)

    at = 0
    while match := re.compile(r"^material \{", re.M).search(text, at):
        end = braces(text, match.start())
        text = text[:match.start()] + (made := look(text[match.start():end])) + text[end:]
        at = match.start() + len(made)
    text = re.sub(r"point \{ position (\{[^}]*\}) \}", rf"sphere {{ centre \1 radius: {LAMP} }}", text)
    text = re.sub(r'file: "(?=[^/])', f'file: "{file.parent}/', text)
    text = re.sub(r"samples_per_axis: \d+", "samples_per_axis: 2", text)
    text = re.sub(r"^(phong|background) .*$", "", text, flags=re.M) + "phong { ambient: 0 diffuse: 1 specular: 0 }\n"
    start = text.index("illumination {")
    end = braces(text, start)
    light = text[start:end]
    for field, value in of_illumination.items():
        light = re.sub(rf" {field}: \S+", "", light)[:-1] + f"{field}: {value} }}"
    text = text[:start] + light + text[end:]
    return text


def radiances(file, size):
    """Means and standard errors [row, column, channel] from the pixels that the programs of paths write."""
    columns = np.genfromtxt(file, delimiter=",", skip_header=1)
    return columns[:, 2:5].reshape(*size, 3), columns[:, 5:8].reshape(*size, 3)


def tiles(picture, edge=TILE):
    """Means of squares of pixels."""
    rows, columns = (length // edge for length in picture.shape[:2])
    return picture[:rows * edge, :columns * edge].reshape(rows, edge, columns, edge, -1).mean(axis=(1, 3))


def error(shown, truth, noise):
    """Of tiles: root mean square difference over root mean square truth, without what the truth's own standard errors add to it; both
    are white at 1. And the same after the brightness that fits best."""
    own = tiles(noise ** 2 * (truth < 1)).sum() / TILE ** 2
    shown, truth = tiles(np.minimum(shown, 1)), tiles(np.minimum(truth, 1))
    def off(factor):
        return float(np.sqrt(max(0, ((factor * shown - truth) ** 2).sum() - own) / (truth ** 2).sum()))
    return off(1), off((shown * truth).sum() / (shown ** 2).sum())


def reference(scene, file, size=SIZE, voxels=VOXELS, paths=None):
    """What is shown of the truth, its standard errors (as nested lists), and the factor from radiances to what is shown."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "x.scene").write_text(judged(file))
        run(folder, "../tests/gicube-light-reference",
            f"@x.scene --volume-size {voxels} --size {size} --paths {paths or PATHS[scene]} --pixels @x.csv")
        said = json.loads((folder / "log").read_text())
        mean, noise = radiances(folder / "x.csv", [int(edge) for edge in size.split("x")][::-1])
    factor = np.pi * said["exposure"]
    return {**said, "factor": factor, "shown": (factor * mean).round(6).tolist(), "noise": (factor * noise).round(6).tolist()}


def measured(kept, scene, method, file, size=SIZE, voxels=VOXELS, paths=None, fidelity="approximate", more=""):
    """Milliseconds of the board for light and picture, the picture's error, the same at the best brightness, rays of one lighting ray a
    face voxel or of the host."""
    truth = kept.of(f"truth/{scene}", lambda: reference(scene, file, size, voxels, paths))
    shown, noise = (np.array(truth[name]) for name in ("shown", "noise"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program, words = BY_HOST_RAYS.get(method, ("gicube-render", ""))
        fields, of_board = LIGHTING.get(method, ({}, ""))
        (folder / "x.scene").write_text(judged(file, **{"rays_per_face_voxel": 16, "step": 0.5, **fields}))
        common = f"@x.scene --volume-size {voxels} --size {size} --fidelity {fidelity} --quiet --stats @x.json {words}{of_board} {more}"
        wide = "" if "datapath" in of_board else " --set asic.datapath=wide"
        if program == "gicube-render":
            run(folder, program, f"{common}{wide} -o @x.exr")
            picture = read_picture(folder / "x.exr")[..., :3].astype(float)
        else:
            run(folder, program, f"{common}{wide} --pixels @x.csv")
            picture = truth["factor"] * radiances(folder / "x.csv", shown.shape[:2])[0]
        stats = statistics(folder / "x.json")
    lighting = stats.get("lighting", [])
    ms = stats["frame_ms"] + sum(each["pass_ms"] for each in lighting) if lighting else stats["board_ms"]
    return {"ms": ms, "light_ms": sum(each["pass_ms"] for each in lighting), "errors": error(picture, shown, noise),
            "plan": stats.get("light_plans"), "mean": picture.mean(axis=(0, 1)).tolist()}


def rows(found):
    by_scene = {scene: [each for name, each in found if name.split("/")[1] == scene] for scene in SCENES}
    fronts = {scene: dict(zip(map(id, each), on_front([(one["ms"], one["errors"][0]) for one in each]))) for scene, each in by_scene.items()}
    for name, each in found:
        _, scene, method = name.split("/")
        absolute, scaled = each["errors"]
        yield name, [scene, method, f"{each['ms']:.6g}", f"{each['light_ms']:.6g}", f"{absolute:.4g}", f"{scaled:.4g}",
                     int(fronts[scene][id(each)])]


def tables():
    points = {f"light/{scene}/{method}": lambda kept, each=(scene, method, file): measured(kept, *each)
              for (scene, file), method in itertools.product(SCENES.items(), [*LIGHTING, *BY_HOST_RAYS])
              if method != "low, k=16, one pass" or "colour_passes: true" in file.read_text()}
    return [Table("light", ["scene", "method", "board_ms", "light_ms", "error", "error_at_best_brightness", "front"], points, rows)]
