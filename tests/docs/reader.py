"""A driver and a pipeline that were written from the reference pages alone.

Their author had read docs/reference/protocol.md, docs/reference/hardware.md with its tables, and
proto/gicube/wire/README.md, but no source of the board. Each function cites the rules that it follows. If a rule
changes, change this file from the page, not from the product's code.
"""

import itertools
import math
import socket
import struct

import numpy

EDGE = 8  # voxels of a block
ONE = 2**24 - 1
AXES = range(3)


# The driver: frames of the data plane.


def crc32c_table():
    table = list(range(256))
    for _ in range(8):
        table = [each >> 1 ^ (0x82F63B78 if each & 1 else 0) for each in table]
    return table


TABLE = crc32c_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


class Session:
    """One session with a board (P101 to P105). It sends fewer frames than the board's window has (P601)."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(str(path))
        self.sequence = self.clock = self.id = 0
        self.ask(1, struct.pack("<HHIIIQQQIIII", 2, 3, 4 << 20, 64, 0, 16 << 20, 1, 0, 0, 0, 10000, 0))

    def send(self, kind, flags, payload):
        self.id += 1
        self.sequence += kind > 2  # P304
        head = struct.pack("<4sHHIIIIQQI", b"GICU", kind, flags, self.id, len(payload), 0, 0, self.clock, 0,
                           self.sequence if kind > 2 else 0)
        self.socket.sendall(head + struct.pack("<I", crc32c(head + bytes(4) + payload)) + payload)
        return self.id

    def receive(self, size):
        data = b""
        while len(data) < size:
            part = self.socket.recv(size - len(data))
            assert part, "the board closed the connection"
            data += part
        return data

    def ask(self, kind, payload=b""):
        """The response to a non-posted frame (P306), and the completions before it by their tickets (P401)."""
        number, completions = self.send(kind, 0, payload), {}
        while True:
            head = self.receive(48)
            _, got, flags, its, size, error, _, stamp, _, _, checksum = struct.unpack("<4sHHIIIIQQII", head)
            data = self.receive(size)
            assert crc32c(head[:44] + bytes(4) + data) == checksum
            assert error == 0, data.decode()
            if flags & 1 and its == number:
                self.clock = max(self.clock, stamp)  # P804
                return data, completions
            if got == 10:
                completions[its] = data

    def command(self, payload):
        ticket = self.send(9, 2, payload)
        return self.ask(11, struct.pack("<I", ticket))[1][ticket]

    def set(self, offset, value):
        self.send(6, 2, struct.pack("<II", offset, value & 0xFFFFFFFF))

    def get(self, offset):
        return struct.unpack("<I", self.ask(5, struct.pack("<I", offset))[0])[0]

    def write(self, address, data):
        for begin in range(0, len(data), 3 << 20):
            self.send(7, 2, struct.pack("<Q", address + begin) + data[begin : begin + (3 << 20)])

    def read(self, address, size):
        return self.ask(8, struct.pack("<QQ", address, size))[0]

    def close(self):
        self.send(1, 2, b"")  # P203
        self.socket.close()


# The pipeline: a ray of a picture, or of the host.


def rounded(value):
    return math.floor(abs(value) + 0.5) * (1 if value >= 0 else -1)


def mix64(x):  # H924
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    x = (x ^ x >> 27) * 0x94D049BB133111EB % 2**64
    return x ^ x >> 31


def factors_of_jitter():  # H803
    factors = [2**15 + (2 * i + 1) * 2**15 // 512 for i in range(256)]
    for i in range(255, 0, -1):
        other = mix64(i) % (i + 1)
        factors[i], factors[other] = factors[other], factors[i]
    return factors


JITTER = factors_of_jitter()
LOG2 = [rounded(math.log2(1 + i / 1024) * 2**24) for i in range(1025)]
EXP2 = [rounded(2 ** (-i / 1024) * ONE) for i in range(1025)]


def log2(word):  # P1610
    whole = word.bit_length() - 1
    mantissa = (word << 16 - whole) % 2**16
    i = mantissa >> 6
    return (whole << 24) + LOG2[i] + ((LOG2[i + 1] - LOG2[i]) * (mantissa % 64) + 32 >> 6)


def corrected(opacity, exponent):  # P1610
    if opacity == 65535:
        return ONE
    x = (log2(65535) - log2(65535 - opacity)) * exponent + 2**15 >> 16
    k, i = x >> 24, (x >> 14) % 1024
    if k > 24:
        return ONE
    return ONE - ((EXP2[i] << 14) - (EXP2[i] - EXP2[i + 1]) * (x % 2**14) + (1 << k + 13) >> k + 14)


def over_one(product):  # P1611
    t = product + 2**23
    return t + (t >> 24) >> 24


def interpolated(corners, position):  # P1606; corners with x fastest
    for coordinate in position:
        weight = 2 * (coordinate % 2**14)
        corners = [a + ((b - a) * weight + 2**14 >> 15) for a, b in zip(corners[::2], corners[1::2])]
    return corners[0]


def shaded(scene, entry, gradient):  # P1608, P1609
    if sum(each * each for each in gradient) < 1022**2:
        return entry["colour"]
    normal = [-each for each in gradient]
    main = max(AXES, key=lambda axis: (abs(normal[axis]), -axis))
    face = scene.map[2 * main + (normal[main] < 0)]
    places = []
    for axis in AXES:
        if axis != main:
            quotient = numpy.float32(normal[axis]) / numpy.float32(abs(normal[main]))
            value = int(numpy.rint(quotient * numpy.float32(16256))) + 16256
            texel = min(value >> 8, 126)
            places.append((texel, value - (texel << 8)))
    (column, s), (row, t) = places
    around = ((0, 0, (256 - s) * (256 - t)), (0, 1, s * (256 - t)), (1, 0, (256 - s) * t), (1, 1, s * t))
    reflectance = sum(int(face[row + j][column + i]) * weight for j, i, weight in around) + 128 >> 8
    total = (entry["ambient"] << 8) + (entry["reflect"] * reflectance + 64 >> 7)
    base = min(total, entry["knee"] << 8)
    return [min(4095, c * base + 4095 * (total - base) + 2**14 >> 15) for c in entry["colour"]]


def line(scene, x, y):  # P1601
    moved = [x * scene.du[axis] + y * scene.dv[axis] for axis in AXES]
    if scene.perspective:
        return scene.origin, [scene.forward[axis] + moved[axis] for axis in AXES]
    return [scene.origin[axis] + moved[axis] for axis in AXES], scene.forward


def start(scene, x, y):
    """Position, direction and the cut plane of entry of an image point's ray, or None (P1602, P1620)."""
    origin, direction = line(scene, x, y)
    half_spaces = [(origin[axis], direction[axis]) for axis in AXES]
    half_spaces += [(scene.size[axis] - 1 - origin[axis], -direction[axis]) for axis in AXES]
    for normal, offset in scene.cuts:
        value, slope = (sum(n / 2**14 * c for n, c in zip(normal, each)) for each in (origin, direction))
        half_spaces.append((value - offset / 2**10, slope))
    begin, plane = 0, None
    for i, (value, slope) in enumerate(half_spaces):
        if slope > 0 and -value / slope > begin:
            begin, plane = -value / slope, i - 6 if i > 5 else None
    if any(begin > value / -slope if slope < 0 else slope == 0 and value < 0 for value, slope in half_spaces):
        return None
    clamped = [min(max(origin[axis] + begin * direction[axis], 0), scene.size[axis] - 1) for axis in AXES]
    length = math.sqrt(sum(each * each for each in direction))
    return [rounded(each * 2**14) for each in clamped], [rounded(d / length * 2**14) for d in direction], plane


def step_length(scene, position, u, v):  # P1619, H803
    if not scene.pipeline & 1:
        return scene.step
    drawn = mix64(mix64(position[0] + (position[1] << 24)) ^ position[2] + (u << 24) + (v << 40))
    return scene.step * JITTER[drawn % 256] + 2**15 >> 16


def steps_of_skip(block, position, step):  # H801
    counts = [1]
    for low, p, s in zip((index * EDGE << 14 for index in block), position, step):
        if s > 0:
            counts.append(-(-(low + (EDGE << 14) - p) // s))
        elif s < 0:
            counts.append((p - low) // -s + 1)
    return max(1, min(counts[1:]))


def sample(scene, position, plane):
    """Colour and opacity of one voxel length, or None where nothing is visible (P1605 to P1607)."""
    x, y, z = (each >> 14 for each in position)
    corners = [scene.voxel(x + i, y + j, z + k) for k, j, i in itertools.product((0, 1), repeat=3)]
    density = interpolated([8 * voxel[0] for voxel in corners], position)
    nearest = sum((each % 2**14 >= 2**13) << axis for axis, each in enumerate(position))
    entry = scene.entry(corners[nearest][2], density + 4 >> 3)
    if not entry["opacity"] or not scene.pipeline & 2:
        return entry["colour"], entry["opacity"]
    if scene.pipeline & 64 and plane is not None:  # P1620
        normal, offset = scene.cuts[plane]
        if sum(n * p for n, p in zip(normal, position)) - (offset << 18) < 2**28:
            return entry["colour"], entry["opacity"]
    gradient = [interpolated([32 * int(scene.gradients[voxel[1]][axis]) for voxel in corners], position)
                for axis in AXES]
    return shaded(scene, entry, gradient), entry["opacity"]


def traced(scene, ray, u, v):
    """Colour and opacity words of a ray (P1603 to P1611)."""
    position, direction, plane = ray
    physical = scene.spacing[0]
    if len(set(scene.spacing)) > 1:  # P1617
        squares = sum((d * spacing) ** 2 for d, spacing in zip(direction, scene.spacing))
        physical = rounded(math.sqrt(squares / sum(d * d for d in direction)))
    colour, opacity = [0, 0, 0], 0
    while opacity < scene.threshold and all(0 <= p <= size - 1 << 14 for p, size in zip(position, scene.size)):
        if any(sum(n * d for n, d in zip(normal, direction)) < 0
               and sum(n * p for n, p in zip(normal, position)) < offset << 18 for normal, offset in scene.cuts):
            break
        length = step_length(scene, position, u, v)
        step = [d * length + 2**15 >> 16 for d in direction]
        block = [(p >> 14) // EDGE for p in position]
        steps = 1
        if scene.pipeline & 4 and scene.empty[block[0] + scene.blocks[0] * (block[1] + scene.blocks[1] * block[2])]:
            steps = steps_of_skip(block, position, step)
        else:
            seen, alpha = sample(scene, position, plane)
            if alpha:
                weight = over_one((ONE - opacity) * corrected(alpha, length * physical + 2**15 >> 16))
                colour = [min(4095, c + over_one(s * weight)) for c, s in zip(colour, seen)]
                opacity += weight
        position = [p + steps * s for p, s in zip(position, step)]
    return [*colour, opacity]


def picture(scene):  # P1613, P1615
    pixels = []
    for y, x in itertools.product(range(scene.height), range(scene.width)):
        total = [0] * 4
        for j, i in itertools.product(range(scene.samples), repeat=2):
            at = x + (i + 0.5) / scene.samples, y + (j + 0.5) / scene.samples
            ray = start(scene, *at)
            if ray:
                words = traced(scene, ray, *(rounded(16 * each) for each in at))
                total = [a + b for a, b in zip(total, words)]
        rays = scene.samples**2
        scales = [(255, 4095 * rays)] * 3 + [(4095, ONE * rays)]
        pixels.append([(2 * value * top + full) // (2 * full) for value, (top, full) in zip(total, scales)])
    return pixels
