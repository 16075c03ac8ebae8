"""One warm board for many configurations: a volume is loaded and lit once, and each board goes on from there.

    python3 fork.py
"""

import tempfile
from pathlib import Path
from typing import Dict, Tuple

import numpy as np

import gicube

EDGE = 64  # voxels
# bus and queue policy
FORKS = [("pci33", "most_rays"), ("agp1x", "most_rays"), ("agp4x", "most_rays"), ("agp4x", "longest_wait")]


def warm_up(checkpoint: Path) -> gicube.View:
    """Saves a board at cycle level with a ball of fog in the light, and returns the view of it."""
    z, y, x = np.indices((EDGE, EDGE, EDGE)) - (EDGE - 1) / 2
    volume = gicube.Volume(np.clip(255 - 8 * np.sqrt(x * x + y * y + z * z), 0, 255).astype("u1"))
    look = gicube.TransferFunction([(0, (1, 0.8, 0.6))], [(60, 0), (255, 0.2)])
    with gicube.open("emu:?fidelity=cycle") as board:
        board.load_volume(volume)
        board.set_transfer_function(look)
        board.set_material(gicube.Material(scattering=0.5, bsdf=gicube.Bsdf.ISOTROPIC))
        board.illuminate([gicube.PointLight((-40, 20, 20), 1000)], gicube.Illumination(step=1))
        board.save(checkpoint)
    return gicube.fit_view(volume, [look], width=48, height=48, irradiance=True)


def frame_of(checkpoint: Path, bus: str, policy: str, view: gicube.View) -> Tuple[float, gicube.Image]:
    """Simulated milliseconds of a frame, and the picture."""
    with gicube.open(f"emu:?restore={checkpoint}&bus={bus}&set=sorter.policy={policy}") as board:
        begin = board.now
        image = board.render(view)
        return (board.now - begin) * 1e-9, image


def main() -> Dict[Tuple[str, str], float]:
    times = {}
    with tempfile.TemporaryDirectory() as folder:
        checkpoint = Path(folder) / "warm.checkpoint"
        view = warm_up(checkpoint)
        pictures = []
        for bus, policy in FORKS:
            times[bus, policy], image = frame_of(checkpoint, bus, policy, view)
            pictures.append(image)
            print(f"{bus:6} {policy:13} {times[bus, policy]:8.3f} ms")
        assert all(image == pictures[0] for image in pictures)  # values never depend on time
    return times


if __name__ == "__main__":
    main()
