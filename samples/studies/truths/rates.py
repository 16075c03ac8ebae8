"""Peak rates of the card's parts by their data sheets, against the board's data per busy time of a part."""
import gicube
import numpy as np

from studies.truths.case import EXACT, Case, Value, even

PEAKS = {"pci33": 4 * 100 / 3, "agp1x": 4 * 200 / 3, "agp2x": 8 * 200 / 3,
         "agp4x": 16 * 200 / 3}  # 10^6 bytes per second, towards the board
SPECIFICATIONS = {"pci33": "PCI 2.2: 32 bit, 33 1/3 MHz",
                  **{f"agp{n}x": f"AGP 2.0, {n}x: 32 bit, 66 2/3 MHz" for n in (1, 2, 4)}}
SDRAM, RDRAM = 800.0, 1600.0  # 10^6 bytes per second
PACKET, LINE = 16, 32  # bytes


def bound(name, found, peak):
    """No value exceeds the peak; the name has the reached share."""
    return Value(f"{name}: {found:.4g} of {peak:.4g}; over it", 0, max(0.0, found / peak - 1), limit=1e-6)


def host_bus(bench, bus):
    """Transfer of a volume to the board, and of a picture to the host."""
    with bench.board(np.random.default_rng(1).random((64, 64, 64)), even(0.1), edge=64, bus=bus) as board:
        board.write_volume(np.zeros((64, 64, 64), "f4") + 0.5)
        before = board.counters
        board.write_volume(np.random.default_rng(2).random((64, 64, 64)).astype("f4"))
        board.render(gicube.View(eye=(-90, 20, 30), look_at=(32, 32, 32), width=256, height=256))
        spent = board.counters - before
    peaks = {"down": PEAKS[bus], "up": PEAKS["pci33" if bus == "pci33"
                                             else "agp1x"]}  # cards wrote to the host as on PCI
    return [bound(f"{bus} {way}, 10\N{SUPERSCRIPT SIX} bytes a second",
                  spent[f"bus.{way}.bytes"] * 1e6 / spent[f"bus.{way}.busy_ps"], peak)
            for way, peak in peaks.items()]


def memories(bench):
    """Rates of a picture with voxels from RDRAM."""
    bench.fidelity = "cycle"
    with bench.board(np.random.default_rng(1).random((64, 64, 64)), even(0.02), edge=64) as board:
        before = board.counters
        board.render(gicube.View(eye=(-90, 20, 30), look_at=(32, 32, 32), width=128, height=128))
        spent = board.counters - before
    packets = spent["rdram.reads"] + spent["rdram.writes"]
    tick = 2.5e-3  # microseconds: the command clock of 400 MHz
    return [Value("RDRAM, 10\N{SUPERSCRIPT SIX} bytes a second while data are on the wires", RDRAM,
                  packets * PACKET / (spent["rdram.data_busy"] * tick), limit=EXACT),
            bound("RDRAM, 10\N{SUPERSCRIPT SIX} bytes a second and channel",
                  packets * PACKET / (spent["rdram.cycles"] * tick), RDRAM)]


def dsp(bench, rays=65536):
    """The DSP needs whole cycles for host rays that end at once."""
    with bench.board(np.ones((2, 2, 2)), even(0), bus="agp4x") as board:
        before = board.counters
        made = gicube.rays(np.tile([0.5, 0.5, 0.5], (rays, 1)), (0, 0, 1), length=0.1)
        board.receive(board.submit(made, type=gicube.RayType.OPACITY))
        spent = board.counters - before
    cycles = spent["dsp.busy_ps"] / 5000 / rays
    return [Value("C6205, ns a cycle, of the whole cycles of a ray", 5,
                  spent["dsp.busy_ps"] / 1000 / rays / round(cycles), limit=EXACT)]


def cases():
    return [*(Case(f"rates/{bus}/counters", SPECIFICATIONS[bus], host_bus, {"bus": bus}) for bus in PEAKS),
            Case("rates/memories/counters", "Rambus: PC800, 16 bit, 800 MT/s; Samsung K4R271669F-800", memories),
            Case("rates/DSP/counters", "Texas Instruments TMS320C6205, 200 MHz", dsp)]
