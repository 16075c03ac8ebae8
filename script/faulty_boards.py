"""Shows gicube-conformance boards with one fault each, and says which faults it sees (docs/guide/conformance.md).

Usage: faulty_boards.py BIN_DIR [--only REGEX] [--jobs N] [--csv FILE]
BIN_DIR has gicube-conformance and gicube-board.

Most faults are a relay between the suite and a gicube-board, which changes one thing of what passes. The others are
samples/small/own_board with one place of its code changed, and are shown class 0 alone. Exit code 1: fewer than 95%
were seen, or a board without a fault was refused.
"""

import argparse
import concurrent.futures
import csv
import pathlib
import re
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "samples/small/own_board"))
from own_board import HEADER, MAGIC, crc32c  # noqa: E402

SHADE, LEAP, JITTER, LIT = 2, 4, 1, 8
LUT, GRADIENTS, MAP, EMPTY, MATERIALS, FRAMEBUFFER = 0, 1 << 20, 2 << 20, 3 << 20, 4 << 20, 1 << 28
VOLUME, SUMS, IRRADIANCE = 1 << 32, 0x240000000, 0x400000000


@dataclass
class Frame:
    kind: int
    flags: int
    id: int
    error: int
    slots: int
    time: int
    credit: int
    sequence: int
    data: bytes
    checksum: int = None  # a wrong one that stays so; None: the right one

    def packed(self):
        head = HEADER.pack(
            MAGIC,
            self.kind,
            self.flags,
            self.id,
            len(self.data),
            self.error,
            self.slots,
            self.time,
            self.credit,
            self.sequence,
            0,
        )
        checksum = self.checksum if isinstance(self.checksum, int) else crc32c(head + self.data)
        return head[:44] + struct.pack("<I", checksum) + self.data

    def word(self, at=0):
        return struct.unpack_from("<I", self.data, at)[0] if len(self.data) >= at + 4 else None

    def long(self, at=0):
        return struct.unpack_from("<Q", self.data, at)[0] if len(self.data) >= at + 8 else None

    def put(self, form, at, value):
        data = bytearray(self.data)
        struct.pack_into("<" + form, data, at, value)
        self.data = bytes(data)


@dataclass
class Link:
    """The state of a connection for a fault: requests by id, and room of its own."""

    asked: dict = field(default_factory=dict)
    own: dict = field(default_factory=dict)

    def to(self, frame):
        return self.asked.get((frame.kind, frame.id))


FAULTS = []  # (name, direction, function of frame and link: a list of frames, or nothing for the same frame)


def fault(name, direction):
    def add(function):
        FAULTS.append((name, direction, function))
        return function

    return add


def each(direction, rows):
    """Faults of one line: (name, when, change)."""
    for name, when, change in rows:

        def apply(frame, link, when=when, change=change):
            if when(frame, link):
                change(frame)
            return None

        FAULTS.append((name, direction, apply))


def at(offset):  # a register's answer
    return lambda f, link: f.kind == 5 and (q := link.to(f)) is not None and q.word() == offset and not f.error


def writes(offset):
    return lambda f, link: f.kind == 6 and len(f.data) == 8 and f.word() == offset


def stores(base, size=1 << 18):
    return lambda f, link: f.kind == 7 and len(f.data) > 8 and base <= f.long() < base + size


def reads(base, size=1 << 18):
    return (
        lambda f, link: f.kind == 8 and (q := link.to(f)) is not None and not f.error and base <= q.long() < base + size
    )


def command(opcode):
    return lambda f, link: f.kind == 9 and f.word() == opcode


def result(opcode):
    return (
        lambda f, link: f.kind == 10
        and not f.error
        and (q := link.asked.get((9, f.id))) is not None
        and q.word() == opcode
    )


def traced(*types):
    return lambda f, link: result(2)(f, link) and link.asked[(9, f.id)].data[8] in types


def kind(number, flags=None):
    return lambda f, link: f.kind == number and (flags is None or f.flags == flags)


def answers(f, link):
    return f.flags == 1 and f.kind > 2


def set_field(name, value):
    def change(f):
        setattr(f, name, value(f) if callable(value) else value)

    return change


def put(form, place, value):
    return lambda f: f.put(
        form, place, value(struct.unpack_from("<" + form, f.data, place)[0]) if callable(value) else value
    )


def map_bytes(change, skip=0):
    def apply(f):
        f.data = f.data[:skip] + bytes(change(i, b) & 255 for i, b in enumerate(f.data[skip:]))

    return apply


def map_rays(change):
    def apply(f):
        rays = [bytearray(f.data[i : i + 32]) for i in range(0, len(f.data), 32)]
        for ray in rays:
            change(ray)
        f.data = b"".join(map(bytes, rays))

    return apply


def pixel_words(change):
    def apply(f):
        bits, count = int.from_bytes(f.data, "little"), len(f.data) * 8 // 36
        words = change([bits >> 36 * i & (1 << 36) - 1 for i in range(count)])
        f.data = sum(word << 36 * i for i, word in enumerate(words)).to_bytes(len(f.data), "little")

    return apply


each(
    "up",
    [
        ("major version 3 in the answer", lambda f, link: f.kind == 1 and not f.error, put("H", 0, 3)),
        ("the session's token is 0", lambda f, link: f.kind == 1 and not f.error, put("Q", 32, 0)),
        ("all sessions have one token", lambda f, link: f.kind == 1 and not f.error, put("Q", 32, 5)),
        ("a window of no frames", lambda f, link: f.kind == 1 and not f.error, put("I", 8, 0)),
        ("no capabilities", lambda f, link: f.kind == 1 and not f.error, put("Q", 24, 0)),
        ("refusals without a text", lambda f, link: f.kind == 1 and f.error, set_field("data", b"")),
        (
            "other majors refused as a protocol error",
            lambda f, link: f.kind == 1 and f.error == 2,
            set_field("error", 1),
        ),
        ("an unknown session is called busy", lambda f, link: f.kind == 1 and f.error == 14, set_field("error", 4)),
        ("the last frame has no id", lambda f, link: f.kind == 1 and f.error, set_field("id", 0)),
        (
            "damaged frames called a protocol error",
            lambda f, link: f.kind == 1 and f.error == 10,
            set_field("error", 1),
        ),
        ("responses with the next id", answers, set_field("id", lambda f: (f.id + 1) & 0xFFFFFFFF)),
        ("responses with the posted flag", answers, set_field("flags", 3)),
        ("register reads answered as configuration reads", kind(5), set_field("kind", 3)),
        ("answers all have number 1", lambda f, link: f.kind > 2, set_field("sequence", 1)),
        ("wrong checksums of answers", kind(8), set_field("checksum", 1)),
        ("completions with the next id", kind(10), set_field("id", lambda f: f.id + 1)),
        ("completions without the posted flag", kind(10), set_field("flags", 0)),
        ("errors without a text", lambda f, link: f.error and f.kind > 2, set_field("data", b"")),
        ("texts that name no field", lambda f, link: f.error and f.kind == 10, set_field("data", b"bad command")),
        ("an unknown ticket is a bad address", lambda f, link: f.kind == 11 and f.error == 6, set_field("error", 5)),
        ("failed commands report success", kind(10), set_field("error", 0)),
        (
            "credit is never returned",
            lambda f, link: f.kind != 1,
            lambda f: (set_field("slots", 0)(f), set_field("credit", 0)(f)),
        ),
        ("credit for four bytes too many", lambda f, link: f.slots > 0, set_field("credit", lambda f: f.credit + 4)),
        ("answers to queries for credit without the number", kind(2, 1), set_field("id", 0)),
        ("another vendor", lambda f, link: f.kind == 3 and link.to(f).word() == 0, put("I", 0, 0x0C5B8086)),
        (
            "BAR0 of 64 KiB",
            lambda f, link: f.kind == 3 and link.to(f).word() == 16,
            put("I", 0, lambda v: v & 0xFFFF0000),
        ),
        (
            "configuration beyond 256 bytes is 0",
            lambda f, link: f.kind == 3 and (link.to(f).word() or 0) >= 256,
            put("I", 0, 0),
        ),
        ("another ID", at(0), put("I", 0, 0x42434948)),
        (
            "unmapped registers read 0",
            lambda f, link: f.kind == 5 and len(f.data) == 4 and f.word() == 0xFFFFFFFF,
            put("I", 0, 0),
        ),
        ("STATUS is always 0", at(4), put("I", 0, 0)),
        ("bad_command is not set", at(4), put("I", 0, lambda v: v & ~4)),
        ("ERROR_ADDRESS of the register after", at(16), put("I", 0, lambda v: v + 4)),
        ("LIFETIME reads its reset value", at(0x6C), put("I", 0, 32)),
        ("BLOCK_VOXELS of 12", at(0x28), put("I", 0, 12)),
        ("bad addresses called bad values", lambda f, link: f.kind == 8 and f.error == 5, set_field("error", 6)),
        ("memory reads swap the bytes of a word", reads(MAP), map_bytes(lambda i, b: b ^ 1)),
        (
            "pixels with alpha less by 1",
            reads(FRAMEBUFFER),
            pixel_words(lambda ws: [w - (1 << 24) if w >> 24 else w for w in ws]),
        ),
        (
            "red and blue change places",
            reads(FRAMEBUFFER),
            pixel_words(lambda ws: [w & ~0xFF00FF | (w & 255) << 16 | w >> 16 & 255 for w in ws]),
        ),
        ("pixels in reverse order", reads(FRAMEBUFFER), pixel_words(lambda ws: ws[::-1])),
        ("rays without their ids", traced(0, 1, 2, 3, 5), map_rays(lambda r: r.__setitem__(slice(0, 4), bytes(4)))),
        (
            "rays in reverse order",
            traced(0, 1, 2, 3, 5),
            set_field("data", lambda f: b"".join(f.data[i : i + 32] for i in range(0, len(f.data), 32)[::-1])),
        ),
        (
            "opacities of rays with 16 bits",
            traced(0, 1, 2, 3),
            map_rays(lambda r: r.__setitem__(23, r[23] & 0x0F | 0x00) or r.__setitem__(24, 0)),
        ),
        (
            "hits a step further",
            traced(1),
            map_rays(
                lambda r: r.__setitem__(
                    slice(10, 13), (int.from_bytes(r[10:13], "little") + 16384).to_bytes(3, "little")
                )
            ),
        ),
        ("integrals without fraction bits", traced(5), map_rays(lambda r: r.__setitem__(19, r[19] & 0x0F))),
        ("a sample too many in the ledger of sums", traced(6), put("Q", 8, lambda v: v + 1)),
        ("pairs with twice their factor", result(6), put("f", 8, lambda v: 2 * v)),
        (
            "light escapes by the opposite face",
            result(3),
            lambda f: f.put("Q", 96, f.long(104)) if f.long(96) < f.long(104) else None,
        ),
        (
            "a unit of light is lost",
            lambda f, link: traced(4)(f, link) or result(3)(f, link),
            put("Q", 16, lambda v: max(v - 1, 0)),
        ),
        (
            "irradiance reads half",
            reads(IRRADIANCE, 1 << 32),
            lambda f: setattr(
                f, "data", b"".join(struct.pack("<I", w >> 1) for w, in struct.iter_unpack("<I", f.data))
            ),
        ),
        (
            "times are those of the wall clock",
            answers,
            set_field("time", lambda f: f.time + time.monotonic_ns() % 1000),
        ),
        ("times are all 0", answers, set_field("time", 0)),
        ("register reads take 13 clocks", kind(5), set_field("time", lambda f: f.time + 30_000)),
        ("kPoll takes a microsecond", kind(12), set_field("time", lambda f: f.time + 10**6)),
        ("completions at the time 0", kind(10), set_field("time", 0)),
        ("nothing is ever cancelled", kind(15), lambda f: None if f.error else f.put("I", 0, 0)),
        ("all is cancelled", kind(15), lambda f: None if f.error else f.put("I", 0, 1)),
        (
            "kDeadline later than the deadline",
            lambda f, link: f.kind == 11 and f.error == 11,
            set_field("time", lambda f: f.time + 1),
        ),
        (
            "counters of the bus are 0",
            kind(13),
            set_field("data", lambda f: f.data.replace(b"bus.down.bytes", b"bus.down.bites")),
        ),
        (
            "one frame fewer was taken before",
            lambda f, link: f.kind == 1 and not f.error and f.word(40) > 0,
            put("I", 40, lambda v: v - 1),
        ),
    ],
)
each(
    "down",
    [
        ("checksums are not verified", lambda f, link: True, set_field("checksum", "the right one")),
        (
            "flags are ignored",
            lambda f, link: f.kind > 2,
            set_field("flags", lambda f: 2 if f.kind in (6, 7, 9) else 0),
        ),
        ("errors of requests are ignored", lambda f, link: True, set_field("error", 0)),
        (
            "false credit is believed",
            lambda f, link: f.slots > 0 and f.kind == 2,
            lambda f: (set_field("slots", 0)(f), set_field("credit", 0)(f)),
        ),
        (
            "the host's window is ignored",
            kind(1),
            lambda f: f.put("I", 8, 64) if len(f.data) >= 56 and 0 < f.word(8) < 64 else None,
        ),
        ("the minor version is ignored", kind(1), lambda f: f.put("H", 2, 3) if len(f.data) >= 56 else None),
        (
            "small limits are accepted",
            kind(1),
            lambda f: f.put("I", 4, max(f.word(4), 4096)) if len(f.data) >= 56 else None,
        ),
        ("kForce is ignored", kind(1), lambda f: f.put("I", 12, 0) if len(f.data) >= 56 else None),
        ("STATUS_CLEAR clears all", writes(8), put("I", 4, 0xFFFFFFFF)),
        ("STEP takes any value", writes(0x60), put("I", 4, lambda v: min(max(v, 1024), 1 << 20))),
        ("CONTROL does not reset", writes(0x0C), put("I", 4, lambda v: v & ~1)),
        ("CONTROL does not clear the volume", writes(0x0C), put("I", 4, lambda v: v & ~2)),
        ("CONTROL does not clear sums", writes(0x0C), put("I", 4, lambda v: v & ~8)),
        (
            "the last byte of a write is lost",
            stores(MAP),
            lambda f: setattr(f, "data", f.data[:-1]) if len(f.data) > 9 else None,
        ),
        ("writes begin a byte later", stores(MAP), put("Q", 0, lambda v: v + 1)),
        (
            "writes over a region's end are cut",
            stores(MAP),
            lambda f: setattr(f, "data", f.data[: 8 + MAP + 98304 - f.long()]),
        ),
        (
            "NaN is taken for 0",
            command(1),
            lambda f: [
                f.put("d", p, 0.0)
                for p in range(16, 112, 8)
                if len(f.data) >= 112 and f.data[p + 6] & 0xF0 == 0xF0 and f.data[p + 7] & 0x7F == 0x7F
            ],
        ),
        ("empty flags do not count", stores(EMPTY), map_bytes(lambda i, b: 0, 8)),
        ("tags are lost", stores(VOLUME, 1 << 32), lambda f: voxels(f, ~(3 << 23))),
        ("the low bit of densities is lost", stores(VOLUME, 1 << 32), lambda f: voxels(f, ~1)),
        (
            "gradients point the other way",
            stores(GRADIENTS),
            lambda f: setattr(
                f,
                "data",
                f.data[:8]
                + b"".join(
                    struct.pack("<I", sum((-(w >> 10 * i) & 1023) << 10 * i for i in range(3)))
                    for w, in struct.iter_unpack("<I", f.data[8:])
                ),
            ),
        ),
        (
            "opacities lose their low byte",
            stores(LUT),
            lambda f: setattr(
                f,
                "data",
                f.data[:8]
                + bytes(b & 0x0F if i % 12 == 4 else b & 0xF0 if i % 12 == 5 else b for i, b in enumerate(f.data[8:])),
            ),
        ),
        (
            "perspective pictures are orthographic",
            command(1),
            lambda f: f.put("B", 8, 0) if len(f.data) > 8 and f.data[8] == 1 else None,
        ),
        (
            "one sample a pixel",
            command(1),
            lambda f: f.put("B", 9, 1) if len(f.data) > 9 and f.data[9] in (2, 4) else None,
        ),
        (
            "the tent filter is a box",
            command(1),
            lambda f: f.put("B", 10, 0) if len(f.data) > 10 and f.data[10] == 1 else None,
        ),
        (
            "parts of pictures are whole",
            command(1),
            lambda f: f.put("I", 12, 0) if len(f.data) > 16 and f.data[14] < f.data[15] else None,
        ),
        (
            "the printed rules for the conserving ones",
            command(2),
            lambda f: f.put("B", 10, 0) if len(f.data) > 10 and f.data[8] == 4 else None,
        ),
        (
            "materials scatter half",
            stores(MATERIALS),
            lambda f: f.put("H", 10, f.word(8) >> 17) if len(f.data) > 12 else None,
        ),
        (
            "unknown materials do nothing",
            stores(MATERIALS),
            lambda f: f.put("B", 8, 0) if len(f.data) > 8 and f.data[8] > 6 else None,
        ),
        ("resume returns all that wait", command(4), lambda f: f.put("I", 8, 60000)),
        ("deadlines are ignored", kind(11), lambda f: setattr(f, "data", f.data[:4]) if len(f.data) == 12 else None),
        ("times beyond 2^62 ps are taken", lambda f, link: f.time > 1 << 62, set_field("time", 1 << 61)),
        (
            "no session resumes",
            kind(1),
            lambda f: f.put("Q", 32, f.long(32) ^ 1) if len(f.data) >= 56 and f.long(32) else None,
        ),
    ],
)


def voxels(f, mask):
    if (len(f.data) - 8) % 9 == 0:
        mask &= (1 << 36) - 1
        pairs = (int.from_bytes(f.data[i : i + 9], "little") & (mask | mask << 36) for i in range(8, len(f.data), 9))
        f.data = f.data[:8] + b"".join(pair.to_bytes(9, "little") for pair in pairs)


def hidden_register(name, offset, least, most, change):
    """The board's logic has another value than the host wrote and reads."""

    def down(f, link):
        if writes(0x0C)(f, link) and f.word(4) & 1:
            link.own.pop("value", None)
        if writes(offset)(f, link) and least <= f.word(4) <= most:
            link.own["value"] = f.word(4)
            f.put("I", 4, change(f.word(4)))

    def up(f, link):
        if at(offset)(f, link) and "value" in link.own and link.own["value"] != f.word():
            f.put("I", 0, link.own["value"])

    FAULTS.append((name, "both", (down, up)))


hidden_register("STEP counts twice", 0x60, 1024, 1 << 20, lambda v: min(2 * v, 1 << 20))
hidden_register("OPACITY_THRESHOLD does not count", 0x64, 0, (1 << 24) - 1, lambda v: (1 << 24) - 1)
hidden_register("nothing is shaded", 0x68, 0, 127, lambda v: v & ~SHADE)
hidden_register("empty blocks are not skipped", 0x68, 0, 127, lambda v: v & ~LEAP)
hidden_register("no jitter", 0x68, 0, 127, lambda v: v & ~JITTER)
hidden_register("irradiance lights nothing", 0x68, 0, 127, lambda v: v & ~LIT)
hidden_register("spacing along z does not count", 0x58, 1024, 1 << 22, lambda v: 65536)
hidden_register("cut planes a voxel further", 0x9C, 0, (1 << 32) - 1, lambda v: (v + 1024) & 0xFFFFFFFF)
hidden_register("only one cut plane", 0x80, 0, 6, lambda v: min(v, 1))
hidden_register("EXPOSURE counts half", 0x70, 0, (1 << 32) - 1, lambda v: v // 2)
hidden_register("SEED does not count", 0x74, 0, (1 << 32) - 1, lambda v: 1)


@fault("answers come twice", "up")
def twice(f, link):
    return [f, f] if f.kind == 5 else [f]


@fault("completions are lost", "up")
def lost(f, link):
    return [] if f.kind == 10 else [f]


@fault("queries for credit are not answered", "up")
def unanswered(f, link):
    return [] if f.kind == 2 and f.flags == 1 else [f]


@fault("sessions end without a last frame", "up")
def wordless(f, link):
    return [] if f.kind == 1 and f.error else [f]


@fault("completions come after their answer", "up")
def late(f, link):
    if f.kind == 10:
        link.own.setdefault("held", []).append(f)
        return []
    held = link.own.pop("held", [])
    if held and f.kind > 2:  # in the order of their numbers
        f.sequence, *numbers = [frame.sequence for frame in (*held, f)]
        for frame, number in zip(held, numbers):
            frame.sequence = number
    return [f, *held] if f.kind > 2 else [*held, f]


@fault("gaps in the numbers are accepted", "down")
def renumbered(f, link):
    if f.kind not in (1, 2, 14):
        f.sequence = link.own["number"] = link.own.get("number", 0) + 1
    return [f]


@fault("a ticket may be used twice", "down")
def fresh_ticket(f, link):
    if f.kind == 9:
        if f.id in link.own.setdefault("tickets", set()):
            f.id += 1 << 30
        link.own["tickets"].add(f.id)
    return [f]


# Faults of the board in Python: what its code has, and what instead.
OWN = [
    (
        "positions are rounded down",
        "position = rounded(np.clip(at * 2**14, 0, extent))",
        "position = np.clip(at * 2**14, 0, extent).astype(np.int64)",
    ),
    ("directions are not normalised", "towards / length[:, None]", "towards"),
    (
        "rays begin at the box's far side",
        "begin = np.where(slope > 0, -value / slope, 0)",
        "begin = np.where(slope < 0, value / -slope, 0)",
    ),
    ("interpolation without rounding", "((b - a) * weight + 16384 >> 15)", "((b - a) * weight >> 15)"),
    ("interpolation along x only", "for weight in (wx, wy, wz):", "for weight in (wx, 0 * wy, 0 * wz):"),
    ("x and y change places", "for weight in (wx, wy, wz):", "for weight in (wy, wx, wz):"),
    ("densities are cut, not rounded", "for word in corners]) + 4 >> 3", "for word in corners]) >> 3"),
    ("the tag of the lower voxel", "np.choose((wx >> 14) + 2 * (wy >> 14) + 4 * (wz >> 14), corners)", "corners[0]"),
    ("opacities are not corrected", "corrected(alpha, self.exponent)", "(alpha * ONE // 65535)"),
    ("the last sample is not taken", "(position[active] <= extent)", "(position[active] < extent)"),
    ("samples add up without the opacity before", "(ONE - opacity[rays]) * corrected", "ONE * corrected"),
    ("colours are not premultiplied", "over_one(colours[i] * weight)", "colours[i]"),
    ("flags of the block after", "block = x // BLOCK", "block = 1 + x // BLOCK"),
    ("normals point inwards", "-np.stack(gradient))", "np.stack(gradient))"),
    ("the knee does not count", "np.minimum(total, knee << 8)", "total"),
    ("rows and columns of the map change places", "column, row = (np.rint", "row, column = (np.rint"),
    ("blocks in another order", "reshape(z, y, x, BLOCK", "reshape(x, y, z, BLOCK"),
    ("pixels are rounded down", "(colour * 510 + 4095) // 8190", "(colour * 510) // 8190"),
]


def read_exactly(sock, size):
    data = bytearray()
    while len(data) < size:
        part = sock.recv(size - len(data))
        if not part:
            return None
        data += part
    return bytes(data)


def relay_frames(source, target, link, change, is_down):
    try:
        while (head := read_exactly(source, 48)) is not None:
            magic, kind_, flags, number, size, error, slots, when, credit, sequence, checksum = HEADER.unpack(head)
            data = read_exactly(source, size) if magic == MAGIC and 1 <= kind_ <= 16 and size <= 1 << 22 else None
            if data is None:  # not a frame: as it is
                target.sendall(head)
                while part := source.recv(1 << 16):
                    target.sendall(part)
                break
            frame = Frame(kind_, flags, number, error, slots, when, credit, sequence, data)
            before = Frame(**vars(frame))
            if is_down:
                link.asked[(kind_, number)] = before
            changed = change(frame, link)
            if not isinstance(changed, list) and frame == before:
                target.sendall(head + data)
                continue
            if frame.checksum is None and crc32c(head[:44] + bytes(4) + data) != checksum:
                frame.checksum = checksum
            for each_frame in changed if isinstance(changed, list) else [frame]:
                target.sendall(each_frame.packed())
    except OSError:
        pass
    for end in (source, target):
        try:
            end.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass


def same(frame, link):
    return None


def serve_relay(listener, board, direction, function):
    down, up = function if direction == "both" else ((function, same) if direction == "down" else (same, function))
    while True:
        try:
            client, _ = listener.accept()
        except OSError:
            return
        server = socket.socket(socket.AF_UNIX)
        server.connect(board)
        link = Link()
        for source, target, change, is_down in ((client, server, down, True), (server, client, up, False)):
            threading.Thread(target=relay_frames, args=(source, target, link, change, is_down), daemon=True).start()


def start(words, path):
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for _ in range(600):
        probe = socket.socket(socket.AF_UNIX)
        if probe.connect_ex(str(path)) == 0:
            probe.close()
            return process
        time.sleep(0.05)
    raise RuntimeError(f"no board at {path}")


def suite(binaries, path, *options):
    begin = time.monotonic()
    ran = subprocess.run(
        [binaries / "gicube-conformance", f"unix:{path}", "--quiet", "--stop", "--timeout", "6000", *options],
        capture_output=True,
        text=True,
    )
    lines = ran.stdout.splitlines()
    seen = lines[0].split()[3] if ran.returncode == 1 and lines and lines[0].startswith("FAIL") else ""
    if ran.returncode not in (0, 1):
        raise RuntimeError(ran.stderr)
    return seen, lines[2].strip() if seen else "", time.monotonic() - begin


def try_relayed(binaries, folder, number, direction, function):
    board, front = folder / f"b{number}", folder / f"f{number}"
    process = start([binaries / "gicube-board", "--listen", f"unix:{board}", "--quiet"], board)
    listener = socket.socket(socket.AF_UNIX)
    try:
        listener.bind(str(front))
        listener.listen(64)
        threading.Thread(target=serve_relay, args=(listener, str(board), direction, function), daemon=True).start()
        return suite(binaries, front)
    finally:
        listener.close()
        process.terminate()
        process.wait()


def try_own(binaries, folder, number, old, new):
    code = (ROOT / "samples/small/own_board/own_board.py").read_text()
    if code.count(old) != 1:
        raise RuntimeError(f"own_board.py: expected one place with {old!r}, got {code.count(old)}")
    program, path = folder / f"own{number}.py", folder / f"o{number}"
    program.write_text(code.replace(old, new))
    process = start([sys.executable, program, path], path)
    try:
        return suite(binaries, path, "--class", "0")
    finally:
        process.terminate()
        process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=pathlib.Path)
    parser.add_argument("--only", default="", help="faults whose names match this regular expression")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv", type=pathlib.Path, help="writes the table")
    options = parser.parse_args()
    jobs = [("none, relayed", try_relayed, ("up", same))]
    jobs += [(name, try_relayed, (direction, function)) for name, direction, function in FAULTS]
    jobs += [("none, own_board.py", try_own, ("import collections", "import collections"))]
    jobs += [(f"own_board.py: {name}", try_own, (old, new)) for name, old, new in OWN]
    jobs = [job for job in jobs if re.search(options.only, job[0])]
    begin, rows = time.monotonic(), []
    with tempfile.TemporaryDirectory(prefix="gicube-faults-") as folder:
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            futures = [
                pool.submit(run, options.binaries, pathlib.Path(folder), i, *arguments)
                for i, (_, run, arguments) in enumerate(jobs)
            ]
            for (name, _, _), future in zip(jobs, futures):
                seen, why, seconds = future.result()
                rows.append((name, seen, why, f"{seconds:.1f}"))
                print(
                    f"{'seen  ' if seen else 'passes'} {seconds:5.1f} s  {name}{': ' if seen else ''}{seen}", flush=True
                )
    faulty = [row for row in rows if not row[0].startswith("none")]
    refused = [row for row in rows if row[0].startswith("none") and row[1]]
    count = sum(1 for row in faulty if row[1])
    print(f"{count} of {len(faulty)} faults seen, {time.monotonic() - begin:.0f} s")
    for name, seen, why, _ in refused:
        print(f"a board without a fault ({name}) was refused: {seen}: {why}")
    if options.csv:
        with options.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([("fault", "seen by", "what it said", "seconds"), *rows])
    return 1 if refused or count < 0.95 * len(faulty) else 0


if __name__ == "__main__":
    sys.exit(main())
