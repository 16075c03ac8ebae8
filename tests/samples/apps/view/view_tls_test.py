"""gicube-view by TLS: what it needs to be reached from other machines, and what it says to whom."""

from __future__ import annotations

import pathlib
import socket
import ssl
import subprocess

import pytest
from browser import LOOK, Shown
from selenium import webdriver
from view_program import BIN, Page, Program, Running

MOVING = {"do": "picture", "id": 1, "moving": True, "settings": {}}


def make_certificate(folder: pathlib.Path, name: str, names: str) -> tuple[pathlib.Path, pathlib.Path]:
    certificate, key = folder / f"{name}.pem", folder / f"{name}.key"
    words = f"openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN={name} -addext subjectAltName={names}".split()
    made = subprocess.run([*words, "-keyout", str(key), "-out", str(certificate)], capture_output=True)
    if made.returncode != 0:
        pytest.skip("the openssl command is missing or too old")
    return certificate, key


@pytest.fixture(scope="session")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[pathlib.Path, pathlib.Path]:
    return make_certificate(tmp_path_factory.mktemp("tls"), "view", "IP:127.0.0.1,DNS:localhost,DNS:view.example.org")


def refusal(*arguments: object) -> tuple[int, str]:
    ran = subprocess.run([BIN / "gicube-view", "--no-open", *map(str, arguments)], capture_output=True, text=True,
                         timeout=60)
    return ran.returncode, ran.stderr.strip()


def test_page_and_socket_come_by_tls_to_who_has_the_token(
    ball: pathlib.Path, certificate: tuple[pathlib.Path, pathlib.Path]
) -> None:
    file, key = certificate
    with Program(ball, "--tls-cert", file, "--tls-key", key, "--fix", "size=256x256", trust=file) as program:
        assert program.address.startswith("https://127.0.0.1:")
        status, content = program.get(f"/?token={program.token}")
        assert status == 200 and b"<title>gicube-view</title>" in content
        with Page(program) as page:
            page.wait_for("hello")
            page.send({**MOVING, "moving": False})
            header, pixels = page.wait_for("picture", final=True)
            assert len(pixels) == header["width"] * header["height"] * 4 == 256 * 256 * 4  # many records of TLS
        assert program.get(f"/?token={'0' * len(program.token)}")[0] == 403
        with Page(program, token="0" * 32) as wrong:
            assert wrong.status == 403
        # A page of plain HTTP at the same host and port is another origin.
        with Page(program, origin=f"http://127.0.0.1:{program.port}") as plain:
            assert plain.status == 403


def test_host_is_a_name_of_the_certificate(ball: pathlib.Path, certificate: tuple[pathlib.Path, pathlib.Path]) -> None:
    file, key = certificate
    with Program(ball, "--tls-cert", file, "--tls-key", key, trust=file) as program:
        for host, expected in (("view.example.org", 200), ("localhost", 200), ("other.example.org", 403)):
            assert program.get(f"/?token={program.token}", Host=f"{host}:{program.port}")[0] == expected, host
        assert program.get(f"/?token={program.token}", Host="view.example.org")[0] == 403  # of another port


def test_plain_http_gets_nothing_from_a_port_of_tls(ball: pathlib.Path,
                                                    certificate: tuple[pathlib.Path, pathlib.Path]) -> None:
    file, key = certificate
    with Program(ball, "--tls-cert", file, "--tls-key", key, trust=file) as program:
        for _ in range(40):  # more than there may be connections
            with socket.create_connection(("127.0.0.1", program.port), timeout=60) as plain:
                plain.sendall(f"GET /?token={program.token} HTTP/1.1\r\n"
                              f"Host: 127.0.0.1:{program.port}\r\n\r\n".encode())
                answer = b""
                try:
                    while part := plain.recv(4096):
                        answer += part
                except ConnectionResetError:
                    pass
                assert not answer.startswith(b"HTTP") and len(answer) < 16  # an alert of TLS at most
        with pytest.raises(ssl.SSLError):
            Page(Running(program.address, make_certificate(file.parent, "other", "IP:127.0.0.1")[0]))
        assert program.get(f"/?token={program.token}")[0] == 200


def test_every_address_of_this_machine_is_listened_to_with_tls(
    ball: pathlib.Path, certificate: tuple[pathlib.Path, pathlib.Path]
) -> None:
    file, key = certificate
    with Program(ball, "--listen", "0.0.0.0:0", "--tls-cert", file, "--tls-key", key, trust=file) as program:
        assert program.address.startswith(f"https://{socket.gethostname()}:")
        assert program.get(f"/?token={program.token}")[0] == 200


def test_without_tls_nobody_beyond_this_machine_is_listened_to(
    ball: pathlib.Path, certificate: tuple[pathlib.Path, pathlib.Path]
) -> None:
    file, key = certificate
    need = "--listen: expected a loopback address, or TLS by --tls-cert, --tls-key, got "
    for address in ("0.0.0.0:0", "[::]:8443", "192.0.2.1:443"):
        assert refusal(ball, "--listen", address) == (2, f"gicube-view: {need}{address}")
    need = "--listen: expected a numeric address and a port, as 127.0.0.1:8000, got "
    for text in ("here:0", "127.0.0.1", "127.0.0.1:65536", ":0", "", "[127.0.0.1:1"):
        assert refusal(ball, "--listen", text) == (2, f'gicube-view: {need}"{text}"')
    assert refusal(ball, "--tls-cert", file) == (2, "gicube-view: --tls-cert: expected --tls-key beside it, got none")
    assert refusal(ball, "--tls-key", key) == (2, "gicube-view: --tls-key: expected --tls-cert beside it, got none")
    code, text = refusal(ball, "--tls-cert", ball, "--tls-key", key)
    assert code == 1 and "ball.nrrd" in text and "expected a certificate, PEM" in text


def test_the_page_works_by_https_and_wss(
    chromium: webdriver.Chrome, ball: pathlib.Path, certificate: tuple[pathlib.Path, pathlib.Path]
) -> None:
    file, key = certificate
    chromium.execute_cdp_cmd("Security.setIgnoreCertificateErrors", {"ignore": True})
    try:
        with Program(ball, *LOOK, "--tls-cert", file, "--tls-key", key, trust=file) as program:
            page = Shown(chromium, program)
            assert page.picture().shape == (128, 128, 4)
            assert chromium.execute_script("return location.protocol") == "https:"
            assert page.faults() == []
    finally:
        chromium.execute_cdp_cmd("Security.setIgnoreCertificateErrors", {"ignore": False})
