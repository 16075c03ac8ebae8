"""The program itself on tiny volumes: the page is whole, and so are its CSV files."""
import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(os.environ["GICUBE_BIN_DIR"]) / "gicube-results"


def run(*arguments, **streams):
    return subprocess.run([sys.executable, PROGRAM, *arguments], **streams).returncode


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.reader(file))


class ResultsProgram(unittest.TestCase):
    def expect_every_row(self, page, claims):
        self.assertEqual({int(row[0]) for row in claims}, set(range(1, 24)))
        for row in claims:
            self.assertEqual(f"- **{row[0]}, {row[1]}**: paper " in " ".join(page.split()), row[5] == "no", row[:2])
        self.assertIn("script/results", page)
        self.assertNotRegex(page, "[^a-z](nan|inf)[^a-z]")

    def expect_the_claims_of_before(self, claims):
        """Simulated figures are the same everywhere. Where they change on purpose, docs/studies/results.md has to be
        made anew too."""
        known = pathlib.Path(__file__).parent / "small_claims.csv"
        self.assertEqual(claims.read_text(), known.read_text(),
                         "run script/results, and let gicube-results --edge 32 --image 32 "
                         f"write {known.name} anew")

    def expect_the_files(self, page, folder):
        tables = re.findall(r"\[results/([a-z0-9-]+)\.csv\]\(results/\1\.csv\)", page)
        self.assertEqual(sorted(f"{name}.csv" for name in tables), sorted(path.name for path in folder.glob("*.csv")))
        for name in tables:
            names, *cells = rows_of(folder / f"{name}.csv")
            self.assertTrue(cells, name)
            self.assertEqual({len(row) for row in cells}, {len(names)}, name)

    def expect_pictures(self, page, folder):
        pictures = re.findall(r"!\[[^\]]*\]\(results/([a-z0-9-]+)\.(svg|png)\)", page)
        for name, extension in pictures:
            self.assertTrue((folder / f"{name}.{extension}").exists(), name)
        self.assertGreaterEqual(len(pictures), 12)

    def expect_causes_of_all_cycles(self, causes):
        names, *rows = causes
        for column, name in enumerate(names[1:], 1):
            total = sum(float(row[column].rstrip("%")) for row in rows)
            self.assertAlmostEqual(total, 100, delta=0.05 * len(rows), msg=name)

    def test_WritesAWholePageOfItsFilesNumbers(self):
        """One test: its program takes seconds."""
        with tempfile.TemporaryDirectory() as temporary:
            self.assertEqual(run("--edge", "32", "--image", "32", "--quiet", temporary), 0)
            folder = pathlib.Path(temporary) / "results"
            page = (folder.parent / "RESULTS.md").read_text()
            self.expect_every_row(page, rows_of(folder / "claims.csv")[1:])
            self.expect_the_claims_of_before(folder / "claims.csv")
            self.expect_the_files(page, folder)
            self.expect_pictures(page, folder)
            self.expect_causes_of_all_cycles(rows_of(folder / "causes.csv"))
            self.expect_causes_of_all_cycles(rows_of(folder / "lit-causes.csv"))
            # Row 19 is exact at any size: a block of 8^3 voxels has 9^3 words.
            blocks = (folder / "one-block.csv").read_text().splitlines()
            self.assertGreater(len(blocks), 3)
            for line in blocks[1:]:
                self.assertIn(",729,729,", line)

    def test_WritesThePageOfOneSection(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(run("--only", "cost", "--quiet", folder), 0)
            claims = rows_of(pathlib.Path(folder) / "results/claims.csv")[1:]
            self.assertEqual([row[0] for row in claims], ["22"])

    def test_RefusesASizeThatIsNoPowerOfTwo(self):
        self.assertEqual(run("--edge", "33", ".", stderr=subprocess.DEVNULL), 2)

    def test_ShardsLeaveThePageNothingToMeasure(self):
        """Two at the same time in one folder, as a batch system has them."""
        size = ["--edge", "32", "--image", "8", "--only", "baseline", "--quiet"]
        with tempfile.TemporaryDirectory() as whole, tempfile.TemporaryDirectory() as parts:
            self.assertEqual(run(*size, whole), 0)
            shards = [subprocess.Popen([sys.executable, PROGRAM, *size, "--jobs", "1", "--shard", f"{i}/2", parts])
                      for i in (1, 2)]
            self.assertEqual([shard.wait() for shard in shards], [0, 0])
            for i in (1, 2):  # what depends on both parts
                self.assertEqual(run(*size, "--shard", f"{i}/2", parts), 0)
            files = sorted(path.name for path in (pathlib.Path(parts) / "measured").rglob("*"))
            self.assertGreater(len(files), 10)
            self.assertFalse([name for name in files if name.endswith(".part")])
            self.assertFalse((pathlib.Path(parts) / "RESULTS.md").exists())
            self.assertEqual(run(*size, parts), 0)
            self.assertEqual((pathlib.Path(parts) / "RESULTS.md").read_text(),
                             (pathlib.Path(whole) / "RESULTS.md").read_text())

    def test_RefusesWhatIsNoShard(self):
        for shard in ("0/2", "3/2", "2"):
            self.assertEqual(run("--shard", shard, ".", stderr=subprocess.DEVNULL), 2)
