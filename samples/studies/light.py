"""Error of the board's light: pictures by each method, their time on the board, and their difference from paths in
double precision (gicube-light-reference)."""
import itertools
import json
import pathlib
import re
import tempfile

import numpy as np

from studies.pictures import read_picture
from studies.points import ROOT, Table, run, statistics
from studies.table import on_front, to_markdown

SCENES = {name: ROOT / f"samples/scenes/{name}.scene" for name in ("fog_box", "golden_ring", "mirror_head")}
SIZE = "96x96"
VOXELS = {"fog_box": 32}  # along the longest edge; nearly all its voxels receive light
MANY_VOXELS = 64
TILE = 4  # pixels along an edge
PATHS = {"fog_box": 100, "golden_ring": 200, "mirror_head": 100}  # per pixel of the truth
LAMP = 0.3  # world units: radius of the ball that replaces a point light, which no path from the eye can hit

# Pictures of gicube-render by method: settings of the illumination and of the board. k: rays_per_face_voxel.
LIGHTING = {
    **{f"low-k{k}": ({"rays_per_face_voxel": k}, "") for k in (1, 4, 16)},
    "low-k16-step2": ({"step": 2}, ""),
    "high-k16": ({"albedo": '"high"'}, ""),
    "low-k16-paper": ({}, "asic.datapath=paper"),
    "low-k16-words3": ({}, "asic.irradiance_words=3"),  # all colours in one pass
    "low-k16-opaque": ({"opacity": 1}, ""),  # surfaces one voxel thick
}
# Pictures by rays of the host: the method of gicube-light, and its options.
HOST_RAYS = {
    **{f"eye-{n}": ("path", f"--light-scatterings 0 --passes {n}") for n in (4, 16)},
    "both-ends-4": ("path", "--passes 4"),
    **{f"photons-{n}": ("photon-map", f"--photons 100000 --neighbours 60 --passes {n}") for n in (1, 4)},
}


def braces(text, start):
    """End of the first message at or after `start`."""
    depth = 0
    for at in range(text.index("{", start), len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return at + 1
    raise ValueError("unbalanced")


def judged(file, opacity=None, **of_illumination):
    """Text of a scene file with the same light for all methods: materials show their scattering, mirrors and glass no
    colour of their own; no ambient light, no background; balls for point lights. Sets fields of the illumination, and
    `opacity` for all surfaces."""
    text = file.read_text()
    if opacity:
        text = re.sub(r"\bopacity: 0\.\d+", f"opacity: {opacity}", text)

    def look(material):
        share = float(re.search(r"scattering: ([\d.]+)", material)[1])
        colour = re.search(r"scattering_colour \{ red: ([\d.]+) green: ([\d.]+) blue: ([\d.]+) \}", material)
        shown = np.zeros(3) if "seen_through" in material else share * np.array(colour.groups() if colour else (1, 1,
            1), float)
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


def radiances(file, shape):
    """Means and standard errors [row, column, channel] from the pixel files of the path programs."""
    columns = np.genfromtxt(file, delimiter=",", skip_header=1)
    return columns[:, 2:5].reshape(shape), columns[:, 5:8].reshape(shape)


def tiles(picture, edge=TILE):
    """Means of squares of pixels."""
    rows, columns = (length // edge for length in picture.shape[:2])
    return picture[:rows * edge, :columns * edge].reshape(rows, edge, columns, edge, -1).mean(axis=(1, 3))


def error(shown, truth, noise):
    """Error of tiles: root mean square difference over root mean square truth, without the part of the truth's standard
    errors; white is 1 in both. And the same after a fit of the brightness."""
    own = tiles(noise ** 2 * (truth < 1)).sum() / TILE ** 2
    shown, truth = tiles(np.minimum(shown, 1)), tiles(np.minimum(truth, 1))
    def off(factor):
        return float(np.sqrt(max(0, ((factor * shown - truth) ** 2).sum() - own) / (truth ** 2).sum()))
    return off(1), off((shown * truth).sum() / (shown ** 2).sum())


def reference(scene, file, size=SIZE, voxels=None, paths=None):
    """The displayed truth, its standard errors (as nested lists), and the factor from radiances to display."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "x.scene").write_text(judged(file))
        run(folder, "../tests/gicube-light-reference",
            f"@x.scene --allow-outside --volume-size {voxels or VOXELS.get(scene, MANY_VOXELS)} --size {size} --paths "
            f"{paths or PATHS[scene]} --pixels @x.csv")
        said = json.loads((folder / "log").read_text())
        width, height = map(int, size.split("x"))
        mean, noise = radiances(folder / "x.csv", (height, width, 3))
    factor = np.pi * said["exposure"]
    return {**said, "factor": factor, "shown": (factor * mean).round(6).tolist(),
            "noise": (factor * noise).round(6).tolist()}


def measured(kept, scene, method, file, size=SIZE, voxels=None, paths=None, fidelity="cycle"):
    """Milliseconds of the board for light and picture, and for light only; the picture's errors."""
    truth = kept.of(f"truth/{scene}", lambda: reference(scene, file, size, voxels, paths))
    shown, noise = (np.array(truth[name]) for name in ("shown", "noise"))
    fields, board = LIGHTING.get(method, ({}, ""))
    by_host = method in HOST_RAYS
    program = "gicube-light" if by_host else "gicube-render"
    command, words = HOST_RAYS.get(method, ("", "-o @x.exr"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "x.scene").write_text(judged(file, **{"rays_per_face_voxel": 16, "step": 0.5, **fields}))
        settings = " ".join(f"--set {each}" for each in dict.fromkeys(["asic.datapath=wide", board]) if each)
        run(folder, program, f"{command} @x.scene --allow-outside --volume-size "
                             f"{voxels or VOXELS.get(scene, MANY_VOXELS)} --size {size} --fidelity {fidelity} --quiet "
                             f"--stats @x.json {settings} {words}"
            + " --pixels @x.csv" * by_host)
        picture = truth["factor"] * radiances(folder / "x.csv",
                                              shown.shape)[0] if by_host else read_picture(folder / "x.exr")[...,
                                                  :3].astype(float)
        stats = statistics(folder / "x.json")
    light = sum(each["pass_ms"] for each in stats.get("lighting", []))
    return {"ms": stats["board_ms"] if by_host else stats["frame_ms"] + light, "light_ms": light,
            "errors": error(picture, shown, noise)}


LAW = ("""world {{ size: 48
  node {{ material: "m" box {{ low {{ x: -1.3 y: -1.3 z: -1.3 }} high {{ x: 1.3 y: 1.3 z: {top} }} }} }} }}
material {{ name: "m" {look} scattering: 0.5 }}
light {{ point {{ position {{ x: {x} z: {z} }} }} power: 100 }}
illumination {{ albedo: "low" rays_per_face_voxel: 64 step: 0.5 exposure: 1 }}
camera {{ eye {{ y: -4 z: 2.7 }} look_at {{ z: -0.3 }} fov_degrees: 10 }}
""")  # seen under a cosine of 0.6


def law(material, degrees):
    """Mean brightness of a floor of this opacity, or of fog, under a lamp at this height: the board's and the truth."""
    height, is_fog = np.radians(degrees), material == "fog"
    colour = "colour { red: 0.5 green: 0.5 blue: 0.5 }"
    look = (f'fog {{ extinction: 0.3 {colour} }} bsdf: "isotropic"' if is_fog
            else f'solid {{ opacity: {material} {colour} }} bsdf: "diffuse"')
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file = folder / "a.scene"
        file.write_text(LAW.format(top=1.3 if is_fog else -0.3, look=look, x=4 * np.cos(height),
                                   z=-0.3 + 4 * np.sin(height)))
        (folder / "x.scene").write_text(judged(file))
        run(folder, "gicube-render",
            "@x.scene --allow-outside --size 32x32 --fidelity functional --quiet --set asic.datapath=wide -o @x.exr")
        shown = float(read_picture(folder / "x.exr")[..., 0].mean())
        return shown, float(np.mean(reference("law", file, "32x32", 48, 200 if is_fog else 30)["shown"]))


def law_rows(found):
    for name, (shown, truth) in found:
        _, material, degrees = name.split("/")
        # Lommel and Seeliger's over Lambert's
        expected = 4 if material == "fog" else 1 / (np.sin(np.radians(float(degrees))) + 0.6)
        yield name, [material, degrees, f"{shown:.4g}", f"{truth:.4g}", f"{shown / truth:.4g}", f"{expected:.4g}"]


def of_scenes(found):
    """Scene, method, measurement, and whether it is on the scene's front of time and error."""
    scenes = {}
    for name, each in found:
        scenes.setdefault(name.split("/")[1], []).append((name, each))
    for scene, points in scenes.items():
        for (name, each), front in zip(points, on_front([(each["ms"], each["errors"][0]) for _, each in points])):
            yield name, scene, name.split("/")[2], each, front


def rows(found):
    for name, scene, method, each, front in of_scenes(found):
        yield name, [scene, method, f"{each['ms']:.6g}", f"{each['light_ms']:.6g}",
                     *(f"{off:.4g}" for off in each["errors"]), int(front)]


def tables():
    points = {f"light/{scene}/{method}": lambda kept, each=(scene, method, file): measured(kept, *each)
              for (scene, file), method in itertools.product(SCENES.items(), [*LIGHTING, *HOST_RAYS])
              if method != "low-k16-words3" or "colour_passes: true" in file.read_text()}
    return [Table("light", ["scene", "method", "board_ms", "light_ms", "error", "error_at_best_brightness", "front"],
                  points, rows),
            Table("light_laws", ["material", "lamp_degrees", "shown", "truth", "shown_over_truth",
                                 "soft_matter_over_truth"],
                  {f"light_laws/{material}/{degrees}": lambda _, each=(material, degrees): law(*each)
                   for material, degrees in [*itertools.product((0.2, 0.5, 1), (80, 45, 20)), ("fog", 80)]}, law_rows)]


def summary(rows):
    """The table of docs/studies/light.md: error in per cent at milliseconds of the board, bold on the front."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    cells = {(row["method"], row["scene"]): "{1}{0:.3g}{1} at {2:.0f}".format(100 * float(row["error"]),
        "**" * int(row["front"]), float(row["board_ms"]))
             for row in rows}
    return to_markdown(["method", *scenes], ([method, *(cells.get((method, scene), "") for scene in scenes)]
                                            for method in dict.fromkeys(row["method"] for row in rows)))
