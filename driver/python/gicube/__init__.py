"""GI-Cube: a volumetric ray tracing board, emulated, from Python.

    import gicube

    volume = gicube.read_volume("head.nrrd")
    look = gicube.transfer_function("ct-bone", volume)
    with gicube.open("emu:?fidelity=cycle") as board:
        board.load_volume(volume)
        board.set_transfer_function(look)
        board.render(gicube.fit_view(volume, [look])).save("head.png")
        print(board.now, "ps of simulated time")

Positions are (x, y, z) in voxels, arrays over voxels are indexed [z, y, x], times are simulated picoseconds.
"""

from gicube._core import LightPlan as LightPlan, Plan as Plan, Scene as Scene, SceneSetup as SceneSetup
from gicube._core import __version__ as __version__
from gicube.arrays import *
from gicube.board import (NO_DEADLINE as NO_DEADLINE, Board as Board, RayExchange as RayExchange,
                          enumerate as enumerate, open as open)
from gicube.board_group import BoardGroup as BoardGroup
from gicube.counters import Counters as Counters, fidelity_report as fidelity_report
from gicube.errors import *
from gicube.image import Image as Image
from gicube.images import *
from gicube.pending import Pending as Pending
from gicube.records import *
from gicube.scenes import *
from gicube.tomography import *
from gicube.volume import Volume as Volume, VolumeStream as VolumeStream
