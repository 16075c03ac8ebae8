"""gicube-view as tests run it, and its page's side of the WebSocket without a browser."""

from __future__ import annotations

import base64
import http.client
import json
import os
import pathlib
import select
import signal
import socket
import ssl
import struct
import subprocess
import urllib.parse
from typing import Any, Iterator, Optional

import numpy as np

BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])


def write_ball(path: pathlib.Path, size: int = 48, hole: bool = True) -> None:
    """A NRRD of 8 bit: a ball that is dense in its middle, with a box cut out of it, so that no two of its sides look
    alike."""
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, size)] * 3, indexing="ij")
    values = np.clip(255 * (1.1 - np.sqrt(x * x + y * y + z * z) * 1.2), 0, 255)
    if hole:
        values[(x > 0.1) & (z > 0) & (y < 0)] = 0
    head = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {size} {size} {size}\nencoding: raw\n\n"
    path.write_bytes(head.encode() + values.astype("u1").tobytes())


class Running:
    """A gicube-view that somebody has started, by its address; `trust`: the certificate of one with TLS."""

    def __init__(self, address: str, trust: Optional[pathlib.Path] = None) -> None:
        parts = urllib.parse.urlsplit(address)
        assert parts.port is not None
        self.address, self.port, self.token, self.scheme = address, parts.port, parts.query.removeprefix(
            "token="), parts.scheme
        self.tls = ssl.create_default_context(cafile=str(trust)) if trust else None

    def get(self, path: str, method: str = "GET", body: Optional[bytes] = None, **headers: str) -> tuple[int, bytes]:
        kind = http.client.HTTPSConnection if self.tls else http.client.HTTPConnection
        connection = kind("127.0.0.1", self.port, timeout=60, **({"context": self.tls} if self.tls else {}))
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, content


class Program(Running):
    """One of our own, which ends with the block; `how`: of subprocess.Popen."""

    def __init__(self, *arguments: object, trust: Optional[pathlib.Path] = None, **how: Any) -> None:
        words = [str(word) for word in (BIN / "gicube-view", "--no-open", *arguments)]
        self.process = subprocess.Popen(words, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True,
                                                  **how})
        assert self.process.stdout is not None
        address = self.process.stdout.readline().strip()
        assert address, self.process.communicate()[1]
        super().__init__(address, trust)

    def __enter__(self) -> "Program":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.send_signal(signal.SIGTERM)
        self.process.communicate(timeout=60)

    def post(self, name: str, content: bytes) -> tuple[int, bytes]:
        origin = f"{self.scheme}://127.0.0.1:{self.port}"
        return self.get(f"/file?token={self.token}&name={urllib.parse.quote(name)}", "POST", content, Origin=origin)

    def boards(self) -> list[int]:
        """Processes of the boards that it has started."""
        found = subprocess.run(["pgrep", "-P", str(self.process.pid)], capture_output=True, text=True)
        return [int(line) for line in found.stdout.split()]


class Page:
    """The page's side of a WebSocket. Messages come as (header, bytes)."""

    def __init__(self, program: Running, *, token: Optional[str] = None, origin: Optional[str] = None) -> None:
        self.socket = socket.create_connection(("127.0.0.1", program.port), timeout=120)
        if program.tls:
            self.socket = program.tls.wrap_socket(self.socket, server_hostname="127.0.0.1")
        origin = f"{program.scheme}://127.0.0.1:{program.port}" if origin is None else origin
        lines = [
            f"GET /socket?token={program.token if token is None else token} HTTP/1.1",
            f"Host: 127.0.0.1:{program.port}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Origin: {origin}",
            f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}",
            "Sec-WebSocket-Version: 13",
        ]
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self._receive()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        self.status = int(head.split()[1])

    def __enter__(self) -> "Page":
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def _receive(self) -> None:
        part = self.socket.recv(1 << 20)
        if not part:
            raise ConnectionError("the program has ended the connection")
        self.buffer += part

    def _take(self, count: int) -> bytes:
        while len(self.buffer) < count:
            self._receive()
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def readable(self, seconds: float) -> bool:
        return bool(self.buffer) or bool(select.select([self.socket], [], [], seconds)[0])

    def send(self, message: Any) -> None:
        body = json.dumps(message).encode() if not isinstance(message, bytes) else message
        size = bytes([0x80 | len(body)]) if len(body) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(body))
        # A mask of zeros is one too.
        self.socket.sendall(b"\x81" + size + bytes(4) + body)

    def receive(self) -> tuple[dict[str, Any], bytes]:
        while True:
            first, second = self._take(2)
            size = second & 0x7F
            if size == 126:
                size = struct.unpack(">H", self._take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self._take(8))[0]
            body = self._take(size)
            if first & 15 == 1:
                return json.loads(body), b""
            if first & 15 == 2:
                length = struct.unpack("<I", body[:4])[0]
                return json.loads(body[4 : 4 + length]), body[4 + length :]
            if first & 15 == 8:
                raise ConnectionError(f"closed with {struct.unpack('>H', body[:2])[0] if body else 'no code'}")

    def all(self) -> Iterator[tuple[dict[str, Any], bytes]]:
        while True:
            yield self.receive()

    def wait_for(self, kind: str, **fields: Any) -> tuple[dict[str, Any], bytes]:
        """The next message of a type, with these values."""
        for header, content in self.all():
            if header["type"] == kind and all(header.get(name) == value for name, value in fields.items()):
                return header, content
            assert header["type"] != "error", header
        raise AssertionError
