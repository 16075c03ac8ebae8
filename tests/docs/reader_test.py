"""A driver and a pipeline that were written from the reference pages alone (reader.py) have the board's bits."""

import itertools
import math
import os
import pathlib
import struct
import subprocess
import time

import numpy
import pytest
from reader import AXES, EDGE, ONE, Session, picture, rounded, start, traced

BOARD = pathlib.Path(os.environ["GICUBE_BIN_DIR"]) / "gicube-board"


class Scene:
    """A volume, tables, registers and a view, drawn from a seed."""

    def __init__(self, seed):
        draw = numpy.random.default_rng(seed)
        self.size = [int(each) for each in draw.integers(10, 50, 3)]
        self.blocks = [-(-each // EDGE) for each in self.size]
        x, y, z = numpy.indices(self.size)
        waves = 1500 + 1400 * numpy.sin(x / 3.1 + seed) * numpy.cos(y / 4.3) * numpy.sin(z / 5.7 + 1)
        self.density = numpy.clip(waves.astype(int) + draw.integers(0, 300, x.shape), 0, 4095)
        self.tag = draw.integers(0, 4, x.shape)
        self.code = (7 * x + 3 * y + 5 * z) // 4 % 2039 if seed % 3 else draw.integers(0, 2039, x.shape)
        vectors = draw.normal(size=(2048, 3))
        self.gradients = numpy.rint(511 * vectors / numpy.linalg.norm(vectors, axis=1)[:, None]).astype(int)
        self.gradients[0] = 0
        self.map = draw.integers(0, 256, (6, 128, 128))
        self.colours, self.shades = draw.integers(0, 4096, (4, 4096, 3)), draw.integers(0, 200, (4, 4096, 3))
        above = numpy.arange(4096) - 1200 - 300 * numpy.arange(4)[:, None]
        self.opacity = numpy.where(above > 0, numpy.clip(above * (0.2, 1, 4, 20)[seed % 4], 1, 65535), 0).astype(int)
        self.opacity[3, 3900:] = 65535
        self.empty = draw.random(math.prod(self.blocks)) < 0.35
        self.step = int(draw.integers(2**14, 2**17))
        self.threshold = (ONE, int(0.98 * ONE), ONE // 2)[seed % 3]
        self.pipeline = (7, 6, 3, 5, 2, 70, 0, 4, 67)[seed % 9]
        self.spacing = ([65536] * 3, [50000, 65536, 90000], [40000] * 3)[seed // 2 % 3]
        middle = [each / 2 for each in self.size]
        offset = 0.6 * middle[0] - 0.64 * middle[1] + 0.48 * middle[2] - 3
        self.cuts = [([9830, -10486, 7864], rounded(1024 * offset)), ([0, 0, -16384], rounded(-922 * self.size[2]))]
        if seed % 4 == 3:
            self.cuts = []
        self.perspective, self.samples = seed // 3 % 2, (1, 1, 1, 2, 4)[seed % 5]
        self.width, self.height = (20, 14) if self.samples == 1 else (8, 6)
        eye = middle + 1.6 * max(self.size) * numpy.array([0.5, -0.7, -0.6]) * (0.2 if seed % 7 == 6 else 1)
        towards = (middle - eye) / numpy.linalg.norm(middle - eye)
        right = numpy.cross(towards, [0.1, 1, 0.2])
        scale = 1.2 if self.perspective else 1.3 * max(self.size)
        du, dv = right * scale / self.width, numpy.cross(towards, right) * scale / self.height
        corner = -du * self.width / 2 - dv * self.height / 2
        origin, forward = (eye, towards + corner) if self.perspective else (eye + corner, towards)
        self.origin, self.forward, self.du, self.dv = (each.tolist() for each in (origin, forward, du, dv))

    def voxel(self, *at):
        if any(place >= size for place, size in zip(at, self.size)):
            return 0, 0, 0
        return int(self.density[at]), int(self.code[at]), int(self.tag[at])

    def entry(self, tag, density):
        ambient, reflect, knee = (int(each) for each in self.shades[tag, density])
        colour, opacity = [int(each) for each in self.colours[tag, density]], int(self.opacity[tag, density])
        return {"colour": colour, "opacity": opacity, "ambient": ambient, "reflect": reflect, "knee": knee}


def pack(fields):
    """A little-endian integer of (value, bits) from bit 0 on."""
    word = place = 0
    for value, bits in fields:
        word |= (int(value) & 2**bits - 1) << place
        place += bits
    return word


def load(session, scene):
    """Writes registers, tables and volume (wire/README.md, P1202)."""
    for axis in AXES:
        session.set(0x40 + 4 * axis, scene.size[axis])
        session.set(0x50 + 4 * axis, scene.spacing[axis])
    for offset, value in ((0x60, scene.step), (0x64, scene.threshold), (0x68, scene.pipeline), (0x80, len(scene.cuts))):
        session.set(offset, value)
    for i, (normal, offset) in enumerate(scene.cuts):
        for j, word in enumerate([*normal, offset]):
            session.set(0x90 + 16 * i + 4 * j, word)
    entries = [scene.entry(tag, density) for tag in range(4) for density in range(4096)]
    words = [pack([*((c, 12) for c in e["colour"]), (e["opacity"], 16), (e["ambient"], 8), (e["reflect"], 8),
                   (e["knee"], 8)]) for e in entries]
    session.write(0, b"".join(word.to_bytes(12, "little") for word in words))
    session.write(0x100000, b"".join(struct.pack("<I", pack((c, 10) for c in each)) for each in scene.gradients))
    session.write(0x200000, scene.map.astype(numpy.uint8).tobytes())
    session.write(0x300000, numpy.packbits(scene.empty, bitorder="little").tobytes())
    volume = bytearray()
    cells = list(itertools.product(range(EDGE), repeat=3))
    for bz, by, bx in itertools.product(*(range(count) for count in reversed(scene.blocks))):
        words = [pack(zip(scene.voxel(bx * EDGE + x, by * EDGE + y, bz * EDGE + z), (12, 11, 2))) for z, y, x in cells]
        for first, second in zip(words[::2], words[1::2]):
            volume += (first | second << 36).to_bytes(9, "little")
    session.write(0x100000000, bytes(volume))
    assert session.get(0x04) == 0, "STATUS"


def rendered(session, scene):
    view = [*scene.origin, *scene.forward, *scene.du, *scene.dv]
    session.command(struct.pack("<IHHBBBBHBB12d", 1, scene.width, scene.height, scene.perspective, scene.samples, 0, 0,
                                0, 0, 0, *view))
    count = scene.width * scene.height
    bits = int.from_bytes(session.read(0x10000000, (36 * count + 7) // 8), "little")
    return [[bits >> 36 * i + place & 2**width - 1 for place, width in ((0, 8), (8, 8), (16, 8), (24, 12))]
            for i in range(count)]


def cast(session, rays):
    """Colour and opacity words of host rays with the ids 0, 1 and so on (P1701, P1703)."""
    packets = [pack([(i, 32), *((p, 24) for p in position), *((d, 16) for d in direction), (0, 60), (4095, 12),
                     (1023, 10), (0, 16), (32, 6)]) for i, (position, direction, _) in enumerate(rays)]
    data = session.command(struct.pack("<IIBBBBI", 2, len(rays), 0, 0, 0, 0, 0)
                           + b"".join(each.to_bytes(32, "little") for each in packets))
    words = [int.from_bytes(data[i : i + 32], "little") for i in range(0, len(data), 32)]
    return [[word >> 152 & 4095, word >> 164 & 4095, word >> 176 & 4095, word >> 188 & ONE] for word in words]


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    path = tmp_path_factory.mktemp("board") / "socket"
    process = subprocess.Popen([BOARD, "--listen", f"unix:{path}", "--quiet", "--set", f"asic.block_voxels={EDGE}"])
    while not path.exists():
        assert process.poll() is None, "gicube-board ended"
        time.sleep(0.02)
    yield path
    process.terminate()
    process.wait()


@pytest.mark.parametrize("seed", range(24))
def test_the_pages_give_the_bits_of_the_board(board, seed):
    scene, session = Scene(seed), Session(board)
    assert session.get(0x28) == EDGE, "BLOCK_VOXELS"
    load(session, scene)
    pixels = rendered(session, scene)
    points = itertools.product(range(scene.height), range(scene.width))
    rays = [ray for ray in (start(scene, x + 0.5, y + 0.5) for y, x in points) if ray]
    words = cast(session, rays)
    session.close()
    assert sum(pixel[3] > 0 for pixel in pixels) > 5
    assert pixels == picture(scene)
    # Rays of the host come by no cut plane; their u and v are the halves of their ids.
    assert words == [traced(scene, (*ray[:2], None), i, 0) for i, ray in enumerate(rays)]
