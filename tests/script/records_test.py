"""script/records: the committed files are what it writes, and a field or an enumerator that a header gets arrives
everywhere."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NEEDED = ["script/records", ".clang-format", "driver/include", "driver/scene/include", "driver/hosts/include",
          "driver/python", "driver/src",
          "docs/reference", "tests/driver/c_api/released"]


def run(root, *arguments):
    return subprocess.run([root / "script/records", *arguments], capture_output=True, text=True)


class RecordsTestCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for name in NEEDED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            copy(ROOT / name, self.root / name)

    def change(self, header, before, after):
        path = self.root / "driver/include/gicube" / header
        self.assertIn(before, path.read_text())
        path.write_text(path.read_text().replace(before, after, 1))

    def text(self, name):
        return (self.root / name).read_text()

    def test_HoldWhatTheHeadersSay(self):
        done = run(ROOT, "--check")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_AreWrittenForANewFieldAndEnumerator(self):
        self.change("view.h", "  std::uint32_t seed = 0;",
                    "  double haze = 0.25;  // 0..1, of the air\n  std::uint32_t seed = 0;")
        self.change("view.h", "enum class PixelFilter { kBox, kTent };",
                    "enum class PixelFilter { kBox, kTent, kWideGauss };")
        told = run(self.root, "--check")
        self.assertEqual(told.returncode, 1)
        self.assertIn("c_types.h", told.stderr)
        self.assertEqual(run(self.root).returncode, 0)
        self.assertRegex(self.text("driver/include/gicube/c_types.h"),
                         r"lamp_count;[^}]*\n  double haze; +/\* 0..1, of the air \*/\n\} gicube_view;")
        self.assertIn("copy.number(c.haze, value.haze);", self.text("driver/src/c_api/fields.h"))
        self.assertIn("value.haze", self.text("driver/src/board/saved/fields.h"))
        self.assertIn("F(haze)", self.text("driver/python/core/records.h"))
        self.assertIn('    haze: float = 0.25\n    """0..1, of the air"""\n',
                      self.text("driver/python/gicube/records.py"))
        self.assertRegex(self.text("driver/include/gicube/c_types.h"), r"GICUBE_FILTER_WIDE_GAUSS = 2")
        self.assertIn("PixelFilter::kWideGauss", self.text("driver/src/c_api/fields.h"))
        self.assertIn('WIDE_GAUSS = "wide_gauss"', self.text("driver/python/gicube/records.py"))
        self.assertEqual(run(self.root, "--check").returncode, 0)

    def test_AskHowAListCrossesToC(self):
        self.change("view.h", "  std::uint32_t seed = 0;", "  std::vector<double> hazes{};\n  std::uint32_t seed = 0;")
        self.assertIn("gicube_view lacks hazes (std::vector<double>): decide how it crosses", run(self.root).stderr)

    def test_RefuseAnotherOrderThanThatOfAPastRelease(self):
        path = self.root / "driver/include/gicube/c_types.h"
        path.write_text(path.read_text().replace("  double step;\n  double opacity_threshold;",
                                                 "  double opacity_threshold;\n  double step;"))
        self.assertIn("gicube_view: double opacity_threshold for double step of release 0.2.0", run(self.root).stderr)


if __name__ == "__main__":
    unittest.main()
