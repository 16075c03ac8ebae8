"""How near the board's light comes to the truth: pictures by the board's methods, by their simulated time, against double-precision
paths (gicube-light-reference)."""
import re

import numpy as np

from studies.points import BIN, ROOT, Table
from studies.runs import run_to_end
from studies.table import on_front

LAMP = 0.25  # world units: radius of the ball that stands for a point light, which no path from the eye comes upon


def braces(text, start):
    """The end of the message that opens at or after `start`."""
    depth = 0
    for at in range(text.index("{", start), len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return at + 1
    raise ValueError("unbalanced")


def judged(text, **of_illumination):
    """A scene file's text as both see the same light in it: materials show what they scatter, mirrors and glass nothing else; no
    ambient light, no background; balls for point lights. Fields of the illumination are set."""
    def look(material):
        share = float(re.search(r"scattering: ([\d.]+)", material)[1])
        colour = re.search(r"scattering_colour \{ red: ([\d.]+) green: ([\d.]+) blue: ([\d.]+) \}", material)
        shown = np.zeros(3) if "seen_through" in material else share * np.array(colour.groups() if colour else (1, 1, 1), float)
        shown = "colour {{ red: {:.6g} green: {:.6g} blue: {:.6g} }}".format(*shown)
        material = re.sub(r"(?<!_)colour \{[^}]*\}", shown, material, count=1)
        return material if shown in material else re.sub(r"(solid|fog) \{", rf"\1 {{ {shown}", material, count=1)

    at = 0
    while match := re.compile(r"^material \{", re.M).search(text, at):
        end = braces(text, match.start())
        text = text[:match.start()] + (made := look(text[match.start():end])) + text[end:]
        at = match.start() + len(made)
    text = re.sub(r"point \{ position (\{[^}]*\}) \}", rf"sphere {{ centre \1 radius: {LAMP} }}", text)
    text = re.sub(r"^(phong|background) .*$", "", text, flags=re.M) + "phong { ambient: 0 diffuse: 1 specular: 0 }\n"
    start = text.index("illumination {")
    end = braces(text, start)
    light = text[start:end]
    for field, value in of_illumination.items():
        light = re.sub(rf" {field}: \S+", "", light)[:-1] + f"{field}: {value} }}"
    text = text[:start] + light + text[end:]
    return text
