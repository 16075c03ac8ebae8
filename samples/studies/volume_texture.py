"""Pictures per second of a volumetric texture on each bus; the host makes all its rays [P §3.6]."""
import pathlib
import tempfile

from studies.points import ROOT, Table, run, statistics

KNOT = ROOT / "samples/scenes/compose/hairy_knot.composition"
BUSES = ("pci33", "agp1x", "agp2x", "agp4x")


def measured(bus, samples, size="128x128", fidelity="cycle"):
    """Figures of a picture after the first: pixels with the texture, their host rays, milliseconds, and the bus's busy
    milliseconds."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(folder, "gicube-compose",
            f"{KNOT} --size {size} --samples {samples} --board emu:?bus={bus} --fidelity {fidelity} --quiet --stats "
            f"@stats.json")
        stats = statistics(folder / "stats.json")
    (hair,) = stats["volumes"]
    return {"pixels": hair["rays"] / samples ** 2, "rays": hair["segments"], "ms": stats["further_frame_ms"]}


def rows(found):
    for name, each in found:
        _, bus, samples = name.split("/")
        yield name, [bus, samples, f"{each['pixels']:.0f}", each["rays"], f"{each['rays'] / each['pixels']:.4g}",
                     f"{each['ms']:.4f}",
                     f"{1000 / each['ms']:.4g}"]


def tables():
    points = {f"texture/{bus}/{samples}": lambda _, each=(bus, samples): measured(*each) for bus in BUSES
              for samples in (1, 2, 4)}
    return [Table("volume_texture", ["bus", "samples", "pixels", "rays", "rays_a_pixel", "ms", "hz"], points, rows)]
