"""A board of one's own, by the rules of docs/reference/protocol.md: it opens and renders.

Usage: own_board.py SOCKET
Then gicube-conformance unix:SOCKET --class 0 holds it to that page, and gicube.open("unix:SOCKET") renders on it.

Numbers like P301 are the page's rules. Only register accesses take simulated time; a session ends with its connection.
"""

import collections
import os
import secrets
import socket
import struct
import sys
import threading

import numpy as np

HEADER, VERSION, RENDER = struct.Struct("<IHHIIIIQQII"), struct.Struct("<HHIIIQQQIIII"), struct.Struct("<IHHBBBBHBB12d")
PROTOCOL, MAJOR, TOO_LARGE, BUSY, BAD_ADDRESS, BAD_VALUE, UNSUPPORTED = range(1, 8)
CORRUPTED, NO_SESSION = 10, 14
MAGIC, PAYLOAD, SLOTS, WINDOW, WORD, ONE = 0x55434947, 1 << 20, 64, 1 << 22, 2**32 - 1, 2**24 - 1
BLOCK, CAPACITY = 16, 64  # edge in voxels; blocks that it stores
FIXED = {0x00: 0x42434947, 0x04: 0, 0x10: 0, 0x14: 1, 0x18: WORD, 0x1C: 0, 0x20: 1, 0x24: 1, 0x28: BLOCK,
         0x2C: 4 * BLOCK, 0x30: 256, 0x34: 100_000, 0x38: 0, 0x3C: 0, 0x4C: 1, 0x78: 1}
RULES = {0x60: (65536, 1024, 1 << 20), 0x64: (ONE, 0, ONE), 0x68: (6, 0, 127), 0x6C: (32, 0, 1023),
         0x70: (256, 0, WORD), 0x74: (0, 0, WORD), 0x80: (0, 0, 6), 0x88: (0, 0, 1)}  # reset and range (P1105)
RULES |= {0x40 + i: (0, 2, 1024) for i in (0, 4, 8)} | {0x50 + i: (65536, 1024, 1 << 22) for i in (0, 4, 8)}
RULES |= {i: (0, 0, WORD) for i in range(0x90, 0xF0, 4)} | {i: (65535, 0, WORD) for i in (0x100, 0x104, 0x108)}
CONFIG = {0x00: 0x0C5B4749, 0x04: 0x00100006, 0x08: 0x0B400001, 0x10: 0xE0000000, 0x18: 0x0C, 0x1C: 0x40,
          0x2C: 0x0C5B4749, 0x34: 0x40, 0x3C: 0x100, 0x40: 0x00020001}
CONFIG_BITS = {0x04: 7, 0x10: 0xFFFFF000, 0x1C: 0xFFFFFFF0, 0x3C: 0xFF}  # that can be written
LUT, GRADIENTS, MAP, EMPTY, ABSENT, FRAMEBUFFER, VOLUME = 0, 1 << 20, 2 << 20, 3 << 20, 7 << 19, 1 << 28, 1 << 32
TABLES = {LUT: 196608, GRADIENTS: 8192, MAP: 98304, EMPTY: 1 << 18, ABSENT: 1 << 18, 0x400000: 544, 0x420000: 24,
          0x440000: 1 << 18}
CRC = list(range(256))
for _ in range(8):
    CRC = [word >> 1 ^ 0x82F63B78 * (word & 1) for word in CRC]


def crc32c(data):
    crc = WORD
    for byte in data:
        crc = CRC[(crc ^ byte) & 255] ^ crc >> 8
    return crc ^ WORD


class Fault(Exception):
    """An error code and its text."""


def rounded(x):
    return (np.trunc(x) + (x - np.trunc(x) >= 0.5) - (x - np.trunc(x) <= -0.5)).astype(np.int64)


def over_one(product):  # P1611
    return (product + (1 << 23)) + ((product + (1 << 23)) >> 24) >> 24


LOG2, EXP2 = rounded(np.log2(1 + np.arange(1025) / 1024) * 2**24), rounded(np.exp2(-np.arange(1025) / 1024) * ONE)


def corrected(alpha, exponent):  # P1610
    def log2(word):
        whole = np.frexp(word)[1].astype(np.int64) - 1
        mantissa = word << 16 - whole & 0xFFFF
        low, high = LOG2[mantissa >> 6], LOG2[(mantissa >> 6) + 1]
        return (whole << 24) + low + ((high - low) * (mantissa & 63) + 32 >> 6)
    x = (log2(np.int64(65535)) - log2(np.maximum(65535 - alpha, 1))) * exponent + 32768 >> 16
    segment, whole = x >> 14 & 1023, np.minimum(x >> 24, 25)
    value = (EXP2[segment] << 14) - (EXP2[segment] - EXP2[segment + 1]) * (x & 16383)
    return np.where(alpha == 65535, ONE, ONE - np.where(whole > 24, 0, value + (1 << whole + 13) >> whole + 14))


class Board:
    def __init__(self):
        self.config = dict(CONFIG)
        self.reset()

    def reset(self):
        self.registers = FIXED | {offset: rule[0] for offset, rule in RULES.items()}
        self.memory = {base: bytearray(size) for base, size in TABLES.items()} | {FRAMEBUFFER: b"", VOLUME: bytearray()}

    def clear(self):
        self.size = np.array([self.registers[0x40 + 4 * axis] for axis in range(3)])
        blocks = int(np.prod(-(-self.size // BLOCK)))
        self.memory |= {EMPTY: bytearray(1 << 18), ABSENT: bytearray(1 << 18),
                        VOLUME: bytearray(blocks * BLOCK**3 * 9 // 2 if blocks <= CAPACITY else 0)}

    def bad(self, bit, address):
        self.registers[0x04] |= bit
        self.registers[0x10] = address & WORD

    def write_register(self, offset, value):
        if offset == 0x08:
            self.registers[0x04] &= ~value
        elif offset == 0x0C:
            if value & 1:
                self.reset()
            if value & 2:
                self.clear()
        elif offset not in RULES:
            self.bad(1, offset)
        elif not RULES[offset][1] <= value <= RULES[offset][2]:
            self.bad(2, offset)
        else:
            self.registers[offset] = value
            if 0x40 <= offset <= 0x48:
                self.clear()

    def find(self, address, length):
        for base, data in self.memory.items():
            if base <= address and address + length <= base + len(data):
                return data, slice(address - base, address - base + length)
        return None, None

    def command(self, payload):
        if payload[:4] != b"\1\0\0\0":
            raise Fault(UNSUPPORTED, "opcode: expected 1 (render), got " + payload[:4].hex())
        if len(payload) != RENDER.size:
            raise Fault(BAD_VALUE, f"payload: expected 112 bytes, got {len(payload)}")
        _, width, height, perspective, samples, tent, lamps, strip, part, parts, *vectors = RENDER.unpack(payload)
        has_volume, finite = len(self.memory[VOLUME]) > 0, bool(np.isfinite(vectors).all())
        for name, value, good in (("width", width, range(1, 4096)), ("height", height, range(1, 4096)),
                                  ("projection", perspective, (0, 1)), ("samples_per_axis", samples, (1, 2, 4)),
                                  ("filter", tent, (0, 1)), ("VOLUME_X, VOLUME_Y, VOLUME_Z", has_volume, (1,)),
                                  ("origin, forward, du, dv: finite", finite, (1,))):
            if value not in good:
                raise Fault(BAD_VALUE, f"{name}: expected one of {good}, got {value}")
        others = len({self.registers[0x50 + 4 * axis] for axis in range(3)}) > 1 or self.registers[0x68] & 0x39
        if samples > 1 or tent or lamps or parts or others or self.registers[0x80]:
            raise Fault(UNSUPPORTED, "expected a plain picture of cubic voxels, without jitter, light and cut planes")
        self.memory[FRAMEBUFFER] = self.render(width, height, perspective, np.array(vectors).reshape(4, 3))

    def render(self, width, height, perspective, vectors):
        origin, forward, du, dv = vectors  # P1601
        v, u = (each.reshape(-1, 1) + 0.5 for each in np.mgrid[:height, :width])
        moved, extent = u * du + v * dv, self.size - 1 << 14
        start, towards = (origin + 0 * moved, forward + moved) if perspective else (origin + moved, forward + 0 * moved)
        with np.errstate(all="ignore"):  # P1602
            length = np.sqrt(towards[:, 0]**2 + towards[:, 1]**2 + towards[:, 2]**2)
            value = np.stack([start, extent / 2**14 - start])
            slope = np.stack([towards, -towards])
            begin = np.where(slope > 0, -value / slope, 0).max((0, 2), initial=0)
            end = np.where(slope < 0, value / -slope, np.where((slope == 0) & (value < 0), -1, np.inf)).min((0, 2))
            hit = (begin <= end) & np.isfinite(begin) & np.isfinite(length) & (length > 0)
            at = np.where(hit[:, None], start + begin[:, None] * towards, 0)
            direction = rounded(np.where(hit[:, None], towards / length[:, None], 0) * 2**14)
        position = rounded(np.clip(at * 2**14, 0, extent))
        step = direction * self.registers[0x60] + 32768 >> 16  # P1603
        self.exponent = self.registers[0x60] * self.registers[0x50] + 32768 >> 16
        colour, opacity = np.zeros(moved.shape, np.int64), np.zeros(len(moved), np.int64)
        self.decode()
        active = np.flatnonzero(hit)
        while True:  # P1604
            inside = ((position[active] >= 0) & (position[active] <= extent)).all(1)
            active = active[inside & (opacity[active] < self.registers[0x64])]
            if not len(active):
                break
            self.sample(position[active], colour, opacity, active)
            position[active] += step[active]
        pixels = (colour * 510 + 4095) // 8190, (opacity * 8190 + ONE) // (2 * ONE)  # P1613
        words = pixels[0] @ [1, 1 << 8, 1 << 16] + (pixels[1] << 24)
        return sum(int(word) << 36 * i for i, word in enumerate(words)).to_bytes((36 * len(words) + 7) // 8, "little")

    def decode(self):
        """Words of the voxels, with zeros beyond the volume (P1605)."""
        raw = np.frombuffer(self.memory[VOLUME], np.uint8).reshape(-1, 9).astype(np.int64)
        first, second = raw[:, :5] @ (1 << 8 * np.arange(5)) & 2**36 - 1, raw[:, 4:] @ (1 << 8 * np.arange(5)) >> 4
        x, y, z = -(-self.size // BLOCK)
        words = np.stack([first, second], 1).reshape(z, y, x, BLOCK, BLOCK, BLOCK).transpose(0, 3, 1, 4, 2, 5)
        nx, ny, nz = self.size
        self.words = np.pad(words.reshape(z * BLOCK, y * BLOCK, x * BLOCK)[:nz, :ny, :nx], ((0, 1),) * 3)
        gradients = np.frombuffer(self.memory[GRADIENTS], np.uint32).astype(np.int64)
        self.gradients = [((gradients >> 10 * axis & 1023) ^ 512) - 512 << 5 for axis in range(3)]

    def sample(self, p, colour, opacity, rays):
        (x, y, z), (wx, wy, wz) = (p >> 14).T, ((p & 16383) << 1).T
        corners = [self.words[z + k, y + j, x + i] for k in (0, 1) for j in (0, 1) for i in (0, 1)]

        def interpolated(values):  # P1606
            for weight in (wx, wy, wz):
                values = [a + ((b - a) * weight + 16384 >> 15) for a, b in zip(values[::2], values[1::2])]
            return values[0]
        tag = np.choose((wx >> 14) + 2 * (wy >> 14) + 4 * (wz >> 14), corners) >> 23 & 3  # P1607
        index = tag << 12 | interpolated([(word & 0xFFF) << 3 for word in corners]) + 4 >> 3
        entry = np.frombuffer(self.memory[LUT], np.uint32).reshape(-1, 3).astype(np.int64)[index]
        low, high = entry[:, 0] | (entry[:, 1] & 0xFFFFF) << 32, entry[:, 1] >> 20 | entry[:, 2] << 12
        alpha, colours = low >> 36, [low >> 12 * i & 4095 for i in range(3)]
        if self.registers[0x68] & 2:
            gradient = [interpolated([table[word >> 12 & 2047] for word in corners]) for table in self.gradients]
            colours = self.shade(colours, high & 255, high >> 8 & 255, high >> 16 & 255, -np.stack(gradient))
        blocks = -(-self.size // BLOCK)
        block = x // BLOCK + blocks[0] * (y // BLOCK + blocks[1] * (z // BLOCK))
        empty = np.frombuffer(self.memory[EMPTY], np.uint8)[block >> 3] >> (block & 7) & (self.registers[0x68] >> 2 & 1)
        weight = np.where(empty | (alpha == 0), 0, over_one((ONE - opacity[rays]) * corrected(alpha, self.exponent)))
        for i in range(3):
            colour[rays, i] = np.minimum(colour[rays, i] + over_one(colours[i] * weight), 4095)
        opacity[rays] += weight

    def shade(self, colours, ambient, reflect, knee, normal):  # P1608, P1609
        size = abs(normal)
        axis = np.where(size[2] > np.maximum(size[0], size[1]), 2, np.where(size[1] > size[0], 1, 0))
        main = np.choose(axis, normal)
        major = np.maximum(abs(main), 1).astype(np.float32)
        minors = np.where(axis == 0, normal[1], normal[0]), np.where(axis == 2, normal[1], normal[2])
        column, row = (np.rint(each.astype(np.float32) / major * np.float32(16256)).astype(np.int64) + 16256
                       for each in minors)
        i, j, face = np.minimum(column >> 8, 126), np.minimum(row >> 8, 126), 2 * axis + (main < 0)
        s, t = column - (i << 8), row - (j << 8)
        texels = np.frombuffer(self.memory[MAP], np.uint8).reshape(6, 128, 128).astype(np.int64)
        top, bottom = (texels[face, j + k, i] * (256 - s) + texels[face, j + k, i + 1] * s for k in (0, 1))
        total = (ambient << 8) + (reflect * (top * (256 - t) + bottom * t + 128 >> 8) + 64 >> 7)
        base, flat = np.minimum(total, knee << 8), (size**2).sum(0) < 1022**2
        return [np.where(flat, c, np.minimum(c * base + 4095 * (total - base) + 16384 >> 15, 4095)) for c in colours]


class Session:
    """One connection; `owner` is held while it has the board."""

    def __init__(self, sock, owner):
        self.sock, self.board, self.owner, self.clock, self.id, self.limit = sock, Board(), owner, 0, 0, 4096
        self.inbox, self.results, self.sent, self.taken, self.room = collections.deque(), [], 0, 0, [0, 0]
        self.in_flight, self.consumed, self.kept = [], [], []  # payload bytes of frames

    def receive(self, size):
        data = b""
        while len(data) < size:
            data += self.sock.recv(size - len(data)) or sys.exit()
        return data

    def read(self):
        head = self.receive(48)
        magic, kind, flags, self.id, size, error, slots, time, credit, sequence, checksum = HEADER.unpack(head)
        if magic != MAGIC or not 1 <= kind <= 16:
            raise Fault(CORRUPTED, "expected a header, got " + head.hex())
        if size > self.limit:
            raise Fault(TOO_LARGE, f"size: expected at most {self.limit}, got {size}")
        data = self.receive(size)
        if crc32c(head[:44] + bytes(4) + data) != checksum:
            raise Fault(CORRUPTED, f"checksum: got 0x{checksum:x}")
        return kind, flags, self.id, error, slots, time, credit, sequence, data

    def take(self, kind, flags, number, error, slots, time, credit, sequence, data):
        if kind == 1 and flags == 2:
            sys.exit()  # the client's goodbye
        missing = (number - self.taken if kind == 2 else sequence - self.taken - 1) % 2**32
        if kind not in (1, 2, 14) and missing >= 2**31:
            return  # taken before (P208)
        if kind not in (1, 14) and 0 < missing < 2**31:
            raise Fault(CORRUPTED, f"sequence: expected {self.taken + 1}, got {sequence or number}")
        if kind in (1, 10, 14) or error or kind != 2 and flags != 2 * (kind in (6, 7, 9)) or kind == 2 and data:
            raise Fault(PROTOCOL, f"expected a request, got type {kind}, flags {flags}, error {error}")
        if kind == 8 and len(data) == 16 and struct.unpack("<QQ", data)[1] > self.limit:
            raise Fault(TOO_LARGE, f"length: expected at most {self.limit} bytes, got more")
        if slots > len(self.kept) or credit != sum(self.kept[:slots]):
            raise Fault(PROTOCOL, f"credit: expected at most {len(self.kept)} frames, got {slots}")
        self.room, self.kept = [self.room[0] + slots, self.room[1] + credit], self.kept[slots:]
        if kind == 2:
            return None if flags else self.send(2, 1, self.sent)
        self.taken = sequence
        self.in_flight.append(len(data))
        if len(self.in_flight) > SLOTS or sum(self.in_flight) > WINDOW:
            raise Fault(PROTOCOL, f"expected at most {SLOTS} frames and {WINDOW} bytes in flight")
        self.inbox.append((kind, number, time, data))

    def send(self, kind, flags, number, data=b"", error=0, time=0):
        if kind > 2:
            while self.room[0] < 1 or self.room[1] < len(data):
                self.take(*self.read())
            self.room, self.kept = [self.room[0] - 1, self.room[1] - len(data)], [*self.kept, len(data)]
            self.sent += 1
        credit, self.in_flight, self.consumed = self.consumed, self.in_flight[len(self.consumed):], []
        head = HEADER.pack(MAGIC, kind, flags, number, len(data), error, len(credit), time, sum(credit),
                           self.sent * (kind > 2), 0)
        self.sock.sendall(head[:44] + struct.pack("<I", crc32c(head + data)) + data)

    def shake_hands(self):
        kind, flags, number, *_, data = self.read()
        if kind != 1 or flags or len(data) < 56:
            raise Fault(PROTOCOL, "expected a version frame first")
        major, _, payload, slots, _, window, _, session, _, _, wait, _ = VERSION.unpack(data[:56])
        fits = slots >= 1 and payload >= 4096 and window >= 2 * min(payload, PAYLOAD)
        for code, good, text in ((MAJOR, major == 2, f"major version: expected 2, got {major}"),
                                 (PROTOCOL, fits, "limits: expected room for two of the largest payloads"),
                                 (NO_SESSION, session == 0, "session: expected 0, sessions end here")):
            if not good:
                raise Fault(code, text)
        if not self.owner.acquire(timeout=min(wait, 3_600_000) / 1000):
            raise Fault(BUSY, "the board has an owner")
        try:
            mine = VERSION.pack(2, 3, PAYLOAD, SLOTS, 0, WINDOW, 1, secrets.randbits(63) | 1, 0, 0, 0, 0)
            self.limit, self.room = min(payload, PAYLOAD), [slots, window]
            self.send(1, 1, number, mine)
            while True:
                while not self.inbox:
                    self.take(*self.read())
                self.carry_out(*self.inbox.popleft())
        finally:
            self.owner.release()

    def carry_out(self, kind, number, time, data):
        self.clock, self.id = max(self.clock, time if time <= 2**62 else 0), number
        if kind == 9 and number in [result[0] for result in self.results]:
            raise Fault(PROTOCOL, f"ticket: expected a free one, got {number}")
        try:
            if time > 2**62:
                raise Fault(BAD_VALUE, f"time: expected at most 2^62 ps, got {time}")
            answer, error = self.answer(kind, number, data), 0
        except Fault as fault:
            error, answer = fault.args[0], fault.args[1].encode()
        if kind == 9:
            self.board.registers[4] |= 4 * (error > 0)
            self.results.append((number, self.clock, error, answer or b""))
        elif kind not in (6, 7):
            for ticket, when, fault, result in self.results:  # P403, P404
                self.send(10, 2, ticket, result, fault, when)
            self.results = []
            self.send(kind, 1, number, answer, error, self.clock if not error else time)
        self.consumed.append(len(data))
        if 2 * len(self.consumed) >= SLOTS or 2 * sum(self.consumed) >= WINDOW:  # P603
            self.send(2, 2, self.sent)

    def answer(self, kind, number, data):
        sizes = {3: 4, 4: 8, 5: 4, 6: 8, 8: 16, 12: 0, 13: 0, 15: 4}
        expected = 8 if kind == 7 else 4 if kind == 11 and len(data) != 12 else sizes.get(kind, len(data))
        if len(data) < expected or kind != 7 and len(data) > expected:  # P312
            raise Fault(BAD_VALUE, f"payload: expected {expected} bytes, got {len(data)}")
        board, first, second = self.board, *struct.unpack("<II", (data + bytes(8))[:8])
        address, length = struct.unpack("<QQ", (data + bytes(16))[:16])
        self.clock += 12 * 30_000 * (kind in (3, 4, 5, 15))
        if kind == 3:
            return struct.pack("<I", board.config.get(first, 0) if first % 4 == 0 and first < 256 else WORD)
        if kind == 4 and first in CONFIG_BITS:
            board.config[first] = board.config[first] & ~CONFIG_BITS[first] | second & CONFIG_BITS[first]
        if kind == 5:
            return struct.pack("<I", board.registers.get(first, WORD))
        if kind == 6:
            board.write_register(first, second)
        if kind == 7:
            memory, part = board.find(address, len(data) - 8)
            if isinstance(memory, bytearray):
                memory[part] = data[8:]
            else:
                board.bad(1, address)
        if kind == 8:
            memory, part = board.find(address, length)
            if memory is None:
                raise Fault(BAD_ADDRESS, f"address: expected memory of {length} bytes, got 0x{address:x}")
            return bytes(memory[part])
        if kind == 9:
            return board.command(data)
        if kind == 11 and first not in [result[0] for result in self.results]:
            raise Fault(BAD_VALUE, f"ticket: expected one that has not completed, got {first}")
        if kind == 16:
            raise Fault(UNSUPPORTED, "checkpoints")
        return {13: bytes(4), 15: bytes(4)}.get(kind, b"")

    def run(self):
        try:
            self.shake_hands()
        except Fault as fault:
            self.send(1, 1, self.id, fault.args[1].encode(), fault.args[0], self.clock)
        except OSError:
            pass
        finally:
            self.sock.close()


def main(path):
    owner, listener = threading.Lock(), socket.socket(socket.AF_UNIX)
    if os.path.exists(path):
        os.unlink(path)
    listener.bind(path)
    listener.listen()
    while True:
        threading.Thread(target=Session(listener.accept()[0], owner).run, daemon=True).start()


if __name__ == "__main__":
    main(*sys.argv[1:])
