"""A second count of a board's energy, in Python, from its prices as --explain-config prints them, its hardware as
--hardware-cost does, and its counters."""

import os
import re
import subprocess

import numpy as np
import pytest

import gicube
import gicube.plot

from conftest import LOOK, ball, view_of_ball

PARTS = {"memory", "memory_interface", "sdram", "dsp", "queues", "sorters", "cache", "tables", "pipelines", "links",
         "ray_bus", "clock", "leakage", "host_bus"}


def printed(option, settings):
    command = [os.environ["GICUBE_BOARD"], option] + [word for field in settings for word in ("--set", field)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def recounted(settings, counters, now):
    """Joules by part."""
    price = {name: int(value) for name, value in re.findall(r"^(\S+) +(\d+) ", printed("--explain-config", settings),
                                                            re.MULTILINE)}
    explained = dict(re.findall(r"^(\S+) +(\S+) ", printed("--explain-config", settings), re.MULTILINE))
    hardware = printed("--hardware-cost", settings)
    bits = {name: int(each) for name, each in re.findall(r"^(\S.*?\S) {2,}.*?(\d+) bit", hardware, re.MULTILINE)}
    each = {name: int(count) * int(of) for name, count,
            of in re.findall(r"^  (\S.*?\S) +(\d+) x (\d+) ", hardware, re.MULTILINE)}
    held = sum(int(count) for name, count in re.findall(r"^  (bits .*?\S) +(\d+) x \d+ ", hardware,
                                                        re.MULTILINE) if name != "bits of tags")
    p = price["asic.processors"]
    of = lambda name: price["energy." + name]
    seen = lambda name: counters.get(name, 0)
    seconds, femto = now * 1e-12, 1e-15
    ddr, agp = explained["memory"] == "ddr", explained["bus.model"] != "pci33"
    kind, clocks = ("ddr", price["ddr.clock_khz"]) if ddr else ("rdram", price["rdram.clock_khz"])
    standby = of("ddr_rank_uw" if ddr else "rdram_standby_uw")
    attention = standby if ddr else of("rdram_attention_uw")
    devices = 4  # a volume of 32^3 needs one in each channel
    packets = seen(f"{kind}.reads") + seen(f"{kind}.writes")
    refreshes = now * clocks // 10**9 // price[f"{kind}.refresh_interval"] * devices
    sdram = seen("sdram.reads") + seen("sdram.writes")
    rows = seen("sdram.row_misses") + seen("sdram.row_conflicts")
    ranks = price["sdram.ranks"]
    sdram_refreshes = now * price["sdram.clock_khz"] // 10**9 // price["sdram.refresh_interval"] * ranks
    busy = min(seen("dsp.busy_ps"), now) * 1e-12
    mhz = price["dsp.clock_khz"] / 1000
    voxel, ray = 36, 256
    units = ["interpolators", "opacity correction", "reflectance", "shading", "compositing", "steps and leaps"]
    logic = lambda names: sum(each[name] // 1 for name in names) // p * of("logic_aj") * 1e-18
    checks = seen("processor.cache.checks")
    return {
        "memory": (standby * devices * seconds +
                   (attention - standby) * seen(f"{kind}.data_busy") / (clocks * 1e3)) * 1e-6
        + femto * (seen(f"{kind}.activates") * of(f"{kind}_activate_fj") +
                   seen(f"{kind}.reads") * of(f"{kind}_read_fj"))
        + femto * (seen(f"{kind}.writes") * of(f"{kind}_write_fj") + refreshes * of(f"{kind}_refresh_fj")),
        "memory_interface": femto * packets * of(f"{kind}_io_fj") +
        (0 if ddr else of("rdram_interface_uw") * 1e-6 * 4 * seconds),
        "sdram": of("sdram_rank_uw") * 1e-6 * ranks * seconds
        + femto * (rows * of("sdram_activate_fj") + sdram * (of("sdram_burst_fj") + of("sdram_io_fj")) +
                   sdram_refreshes * of("sdram_refresh_fj")),
        "dsp": mhz * 1e-6 * (busy * of("dsp_busy_uw_per_mhz") + (seconds - busy) * of("dsp_idle_uw_per_mhz")),
        "queues": femto * (seen("processor.sorter.written") +
                           seen("processor.sorter.issued")) * ray * of("edram_bit_fj"),
        "sorters": seen("processor.sorter.inserts") * logic(["ranks of the sorters"]),
        "cache": femto * of("sram_bit_fj") * voxel * (8 * checks +
                                                      4 * (seen("processor.cache.packets") +
                                                           seen("processor.splat.tiles")))
        + checks * logic(["comparators of eight voxels"]),
        "tables": femto * of("sram_bit_fj") * ((8 * 30 + 84) * seen("processor.samples") +
                                               4 * 8 * seen("pipeline.visible_samples")),
        "pipelines": seen("processor.samples") * logic(units)
        + seen("processor.cycles.leap") * logic(["steps and leaps"])
        + seen("processor.splat.deposits") * logic(["splats"])
        + seen("pipeline.deposits") * logic(["parts of lighting rays"]),
        "links": femto * seen("link.busy") * price["link.bits"] * of("link_bit_fj"),
        "ray_bus": femto * (seen("dsp.rays_sent") + seen("dsp.rays_taken") +
                            seen("dsp.overflows")) * ray * of("ray_bus_bit_fj"),
        "clock": femto * (now * price["asic.core_khz"] // 10**9) * (p * bits["Registers, each processor"] +
            held) * of("clock_bit_fj"),
        "leakage": 1e-6 * seconds * (bits["Total eDRAM"] * of("edram_uw_per_mbit") +
                                     bits["Total SRAM"] * of("sram_uw_per_mbit")) / 2**20,
        "host_bus": femto * (seen("bus.down.bytes") + seen("bus.up.bytes")) * of("agp_byte_fj" if agp
            else "pci_byte_fj"),
    }


@pytest.mark.parametrize("more", [[], ["memory=ddr", "bus.model=agp2x", "link.bits=64"]])
def test_a_second_count_finds_the_same_energy(more):
    settings = ["fidelity=cycle", "asic.max_volume_voxels=64", "asic.block_voxels=8", "asic.partition=skewed_block",
                *more]
    with gicube.open("emu:?" + "&".join(f"set={field}" for field in settings)) as board:
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        board.illuminate([gicube.PointLight((16, 16, -20), 1)], gicube.Illumination())
        board.render(view_of_ball())
        counters, now = board.counters, board.now
    found = recounted(settings, counters, now)
    assert set(found) == PARTS
    for part, joules in found.items():
        assert counters[f"energy.{part}"] * 1e-12 == pytest.approx(joules, rel=1e-9, abs=2e-12), part
        assert joules > 0 or part == "links", part
    assert counters["energy.total"] == sum(counters[f"energy.{part}"] for part in PARTS)


def test_energy_of_a_window_is_its_end_minus_its_begin_and_goes_on_from_a_checkpoint(tmp_path):
    uri = "emu:?fidelity=cycle&set=asic.max_volume_voxels=64"
    with gicube.open(uri) as board:
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        begin = board.counters
        board.save(tmp_path / "half.ckpt")
        board.render(view_of_ball())
        end = board.counters
    assert 0 < begin["energy.total"] < end["energy.total"]
    assert (end - begin)["energy.pipelines"] > 0
    with gicube.open(uri) as board:
        board.restore(tmp_path / "half.ckpt")
        board.render(view_of_ball())
        again = board.counters
    assert {name: again[name] for name in again if name.startswith("energy.")} == {name: end[name]
        for name in end if name.startswith("energy.")}


def test_the_power_of_a_trace_sums_up_to_the_energy(tmp_path):
    with gicube.open(f"emu:?fidelity=cycle&set=asic.max_volume_voxels=64&trace={tmp_path / 'trace'}") as board:
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        board.illuminate([gicube.PointLight((16, 16, -20), 1)], gicube.Illumination())
        board.render(view_of_ball(width=64, height=64))
        counters, now = board.counters, board.now
    found = gicube.plot.loads_over_time(tmp_path / "trace")

    def joules(name):
        times, milliwatts = found[f"power, mW {name}"]
        return milliwatts @ np.diff(times, append=now) * 1e-15
    shown = {part: joules(part) for part in PARTS - {"host_bus"}}
    shown["host_bus"] = joules("host_bus down") + joules("host_bus up")
    # Values are rounded to microwatts, and at rest a refresh is a mean power.
    refresh = {"sdram": 8 * 314e-9, "memory": 4 * 5.05e-9}
    for part in PARTS:
        counted, within = counters[f"energy.{part}"] * 1e-12, 0.5e-6 * now * 1e-12 + refresh.get(part, 0)
        assert shown[part] == pytest.approx(counted, rel=1e-6, abs=within), part
    assert sum(shown.values()) == pytest.approx(counters["energy.total"] * 1e-12, rel=2e-5)


def test_peaks_are_of_windows_since_the_counters_were_first_read():
    with gicube.open("emu:?fidelity=cycle&set=asic.max_volume_voxels=64") as board:
        board.load_volume(ball())
        board.set_transfer_function(LOOK)
        board.render(view_of_ball(width=128, height=128))
        begin, then = board.counters, board.now
        assert begin["energy.total.peak"] == 0  # nobody asked
        board.render(view_of_ball(width=128, height=128))
        end = board.counters
        spent, seconds = end - begin, (board.now - then) * 1e-12
    assert end["asic.cycles"] - begin["asic.cycles"] > 200_000  # a window
    for part in PARTS - {"host_bus"} | {"total"}:
        low, value, high = (end[f"energy.{part}.peak{bound}"] for bound in ("_low", "", "_high"))
        assert low <= value <= high
        mean = spent[f"energy.{part}"] * 1e-6 / seconds
        if part != "total" and mean > 1000:  # the total has the host bus in its mean
            assert mean <= 1.01 * value, part
    assert 1 < end["energy.total.peak"] * 1e-6 < 1.2 * spent["energy.total"] * 1e-12 / seconds


def test_the_functional_level_has_none():
    with gicube.open("emu:?fidelity=functional") as board:
        assert not [name for name in board.counters if name.startswith("energy.")]
