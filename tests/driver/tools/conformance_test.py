"""gicube-conformance and samples/small/own_board: what they say, and that the rules they cite are the protocol's."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree

from OpenImageIO import UINT8, ImageBuf

ROOT = pathlib.Path(__file__).resolve().parents[3]
BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])


def suite(*words):
    return subprocess.run([BIN / "gicube-conformance", *words], capture_output=True, text=True, timeout=500)


class OwnBoard:
    """samples/small/own_board/own_board.py at a socket."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = pathlib.Path(self.folder.name) / "board"
        self.process = subprocess.Popen(
            [sys.executable, "-B", ROOT / "samples/small/own_board/own_board.py", self.socket]
        )
        while not self.socket.exists() and self.process.poll() is None:
            time.sleep(0.02)
        return f"unix:{self.socket}"

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.folder.cleanup()


class Conformance(unittest.TestCase):
    def test_CitesSentencesOfTheProtocol(self):
        text = (ROOT / "docs/reference/protocol.md").read_text()
        rules = {}
        for rule in re.finditer(r"\*\*(P\d+)\*\*(.*?)(?=\n- \*\*P\d|\n\n|\n\| \*\*P)", text, re.S):
            rules[rule[1]] = " ".join(rule[2].split())
        lines = suite("--list").stdout.splitlines()
        self.assertGreater(len(lines), 200)
        for head, sentence in zip(lines[::2], lines[1::2]):
            level, rule, name = head.split()
            self.assertIn(int(level), range(6), name)
            self.assertEqual(" ".join(sentence.split()), rules.get(rule, "").strip(), f"{name}: {rule}")
        names = [head.split()[2] for head in lines[::2]]
        self.assertEqual(len(names), len(set(names)))

    def test_TheBoardInPythonIsOfClassZero(self):
        with OwnBoard() as uri:
            ran = suite(uri, "--class", "0", "-q", "--timeout", "60000")
        self.assertEqual(ran.returncode, 0, ran.stdout)
        self.assertIn("this board may claim class 0\n", ran.stdout)

    def test_TheBoardInPythonHasTheBitsOfAnyBoard(self):
        pictures = []
        view = ["--size", "40x40", "--eye", "100,-30,70", "--look-at", "20,20,20", "--step", "0.3", "--quiet"]
        with OwnBoard() as uri, tempfile.TemporaryDirectory() as folder:
            for board in (uri, "emu:"):
                picture = pathlib.Path(folder) / f"{len(pictures)}.png"
                ran = subprocess.run(
                    [
                        BIN / "gicube-render",
                        "builtin:buckyball",
                        "--volume-size",
                        "45",
                        *view,
                        "--board",
                        board,
                        "-o",
                        picture,
                    ],
                    capture_output=True,
                    text=True,
                    timeout=500,
                )
                self.assertEqual(ran.returncode, 0, ran.stderr)
                pictures.append(ImageBuf(str(picture)).get_pixels(UINT8))  # the file has the command, which differs
        self.assertGreater(pictures[0].max(), pictures[0].min())
        self.assertTrue((pictures[0] == pictures[1]).all())

    def test_ReportsFailuresWithTheirRules(self):
        with OwnBoard() as uri, tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "junit.xml"
            ran = suite(uri, "--filter", "ray.", "--junit", file, "--timeout", "60000")
            root = xml.etree.ElementTree.parse(file).getroot()
        self.assertEqual(ran.returncode, 1)
        self.assertIn("may claim no class", ran.stdout)
        cases = root.findall("testcase")
        self.assertEqual(int(root.get("failures")), len(root.findall("testcase/failure")))
        self.assertGreater(int(root.get("failures")), 5)
        self.assertTrue(
            any(
                case.get("name") == "ray.integrate" and case.find("properties/property").get("value") == "P1703"
                for case in cases
            )
        )

    def test_RefusesWhatItCannotTest(self):
        for words, text in (
            (["tls:localhost:1"], "plain|emu:, unix:PATH or tcp"),
            (["--class", "6"], "class"),
            (["--filter", "no such case"], "--list"),
            (["--fliter", "x"], "--filter"),
        ):
            ran = suite(*words)
            self.assertEqual(ran.returncode, 2, words)
            self.assertRegex(ran.stderr, text)

    def test_SeesSomeFaults(self):
        for name in ("none", "ERROR_ADDRESS", "interpolation along x only", "13 clocks", "hits a step further"):
            ran = subprocess.run(
                [sys.executable, "-B", ROOT / "script/faulty_boards.py", BIN, "--only", name],
                capture_output=True,
                text=True,
                timeout=500,
            )
            self.assertEqual(ran.returncode, 0, f"{name}: {ran.stdout}{ran.stderr}")


if __name__ == "__main__":
    unittest.main()
