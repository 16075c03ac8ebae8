"""Damaged files of every volume format: each is read, or refused with its name, within a bound of memory.

PYTHONPATH=build/release/python python3 tests/driver/python/hostile_files_test.py 10000   # more than the test's
"""

import io
import json
import os
import pathlib
import random
import resource
import subprocess
import sys
import tempfile
import warnings

import numpy as np

import gicube

CORPUS = pathlib.Path(__file__).parents[2] / "fuzz" / "corpus"
SUFFIXES = {"dicom": ".dcm", "hdf5": ".h5", "openvdb": ".vdb", "vti": ".vti", "legacy_vtk": ".vtk", "numpy": ".npy",
            "npz": ".npz", "tiff": ".tif", "nifti": ".nii", "nrrd": ".nrrd", "meta_image": ".mha"}
EXTREMES = [0, 1, 0x7F, 0x7FFF, 0xFFFF, 0x40000000, 0x7FFFFFFF, 0xFFFFFFFF, 0x7FF0000000000000, 0xFFFFFFFFFFFFFFFF]
TEXT = b"0123456789-. \n:=%,()<>\"/eE"
# What reading_child.cpp allows: a GiB, and 16384 bytes for each of the file.
MEMORY, RATIO = 1 << 30, 16384


def whole_files(name):
    samples = np.arange(6 * 5 * 4, dtype="u2").reshape(6, 5, 4)
    packed = io.BytesIO()
    if name == "npz":
        np.savez_compressed(packed, a=samples)
    elif name == "tiff":
        try:
            import tifffile
        except ImportError:
            return []
        tifffile.imwrite(packed, samples, imagej=True, metadata={"spacing": 2.0, "unit": "um", "axes": "ZYX"})
    else:
        return [file.read_bytes() for file in sorted((CORPUS / name).iterdir())]
    return [packed.getvalue()]


def damaged(whole, chance):
    """Up to four changes: bytes, numbers of 1 to 8 bytes, pieces that are gone or there twice; or the file's start."""
    out = bytearray(whole)
    for _ in range(chance.randint(1, 4)):
        at, some = chance.randrange(len(out) + 1), chance.randint(1, 8)
        kind = chance.randrange(6)
        if kind == 0:
            out[at:at + 1] = bytes([chance.randrange(256)])
        elif kind == 1:
            out[at:at + 1] = bytes([chance.choice(TEXT)])
        elif kind == 2:
            out[at:at + some] = chance.choice(EXTREMES).to_bytes(8, chance.choice(["little", "big"]))[:some]
        elif kind == 3:
            del out[at:at + some]
        elif kind == 4:
            out[at:at] = out[at:at + 8 * some]
        elif chance.random() < 0.25:
            del out[at:]
    return bytes(out)


def own_memory(field):
    """Bytes: VmRSS as it is, VmHWM the most."""
    status = pathlib.Path("/proc/self/status").read_text()
    return int(status.split(field + ":")[1].split()[0]) << 10


def read_all(name, rounds, folder):
    """Prints each file's number before it is read, and the counts at the end."""
    wholes, path = whole_files(name), pathlib.Path(folder) / ("v" + SUFFIXES[name])
    counts = {"read": 0, "refused": 0, "mib": 0.0}
    for number in range(rounds):
        content = damaged(wholes[number % len(wholes)], random.Random(f"{name} {number}"))
        path.write_bytes(content)
        print(number, flush=True)
        pathlib.Path("/proc/self/clear_refs").write_text("5")  # VmHWM starts anew
        before = own_memory("VmRSS")
        try:
            gicube.read_volume(path)
            counts["read"] += 1
        except gicube.FileError as error:
            assert folder in str(error), f"{name} {number}: {error}"  # the file, or one that it names
            counts["refused"] += 1
        # The children's number is the most of all that have been, which began with this process's memory.
        child = max(0, (resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss << 10) - before)
        used = own_memory("VmHWM") - before + child
        assert used <= 1.5 * (MEMORY + RATIO * len(content)), f"{name} {number}: {used >> 20} MiB"
        counts["mib"] = max(counts["mib"], used / (1 << 20))
    print(json.dumps(counts), flush=True)


def hostile(rounds):
    """The counts of each format; an AssertionError names the file that ended the process that read."""
    out = {}
    for name in SUFFIXES:
        if not whole_files(name):
            continue
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, __file__, "--read", name, str(rounds), folder], env=os.environ,
                                  capture_output=True, text=True)
        last = done.stdout.splitlines()[-1:]
        assert done.returncode == 0, f"{name}, file {last}: {done.returncode}, {done.stderr[-2000:]}"
        out[name] = json.loads(last[0])
    return out


def test_damaged_files_are_read_or_refused_by_name_within_memory():
    for name, counts in hostile(40).items():
        assert counts["refused"] >= 5, (name, counts)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    if sys.argv[1] == "--read":
        read_all(sys.argv[2], int(sys.argv[3]), sys.argv[4])
    else:
        each = -(-int(sys.argv[1]) // len(SUFFIXES))
        for name, counts in hostile(each).items():
            print(f"{name:<11}{counts['refused']:>6} refused{counts['read']:>6} read{counts['mib']:>8.1f} MiB at most")
