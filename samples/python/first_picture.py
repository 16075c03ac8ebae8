"""The first picture of a scan.

Usage: first_picture.py SCAN PRESET PICTURE.png     as in: first_picture.py head.nrrd ct-bone head.png
"""

import sys

import gicube


def main(scan: str, preset: str, picture: str) -> None:
    volume = gicube.read_volume(scan)
    look = gicube.transfer_function(preset, volume)
    with gicube.open("emu:?set=asic.max_volume_voxels=512") as board:
        board.load_volume(volume)
        board.set_transfer_function(look)
        board.render(gicube.fit_view(volume, [look])).save(picture, background=(0, 0, 0))
        print(f"{volume}: {board.now * 1e-9:.1f} ms of simulated time, {picture}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(f"{__doc__}\nPresets: {', '.join(gicube.presets())}")
    main(*sys.argv[1:])
