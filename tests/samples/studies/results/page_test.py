import math
import pathlib
import re
import tempfile
import unittest

from page import Page, differs, number, percent
from studies import draw


class ResultPage(unittest.TestCase):
    def test_AQuarterIsCountedFromTheNearerEndOfTheRange(self):
        self.assertFalse(differs(2.5, 2, 4))
        self.assertFalse(differs(1.5, 2, 4))
        self.assertTrue(differs(1.49, 2, 4))
        self.assertFalse(differs(5, 2, 4))
        self.assertTrue(differs(5.01, 2, 4))

    def test_TableHasTheSameCellsAsItsCsv(self):
        page = Page()
        page.table("t", ["name", "value"], [["a, b", "1"], ['say "c"', "2"]])
        self.assertEqual(page.body, '| name | value |\n| --- | --- |\n| a, b | 1 |\n| say "c" | 2 |\n\n[results/t.csv](results/t.csv)\n\n')
        with tempfile.TemporaryDirectory() as folder:
            page.write_files(pathlib.Path(folder))
            self.assertEqual((pathlib.Path(folder) / "t.csv").read_text(), 'name,value\n"a, b",1\n"say ""c""",2\n')

    def test_ChartLeavesAMissingValueEmpty(self):
        page = Page()
        page.chart("Caption.", "c", "Title", "x", "y", [1, 2], {"one": [0.5, math.nan], "two": [2, 3]}, log_x=True)
        with tempfile.TemporaryDirectory() as folder:
            page.write_files(pathlib.Path(folder))
            self.assertEqual((pathlib.Path(folder) / "c.csv").read_text(), "x,one,two\n1,0.5,2\n2,,3\n")
            svg = (pathlib.Path(folder) / "c.svg").read_text()
        for words in ("Title", "x", "y", "one", "two"):
            self.assertIn(f">{words}</text>", svg)
        marks = [len(re.findall(f"<use[^>]*{colour.lower()}", svg)) for colour in draw.COLOURS[:2]]
        self.assertEqual(marks, [1, 2])

    def test_ClaimThatDiffersMustSayWhy(self):
        page = Page()
        with self.assertRaises(ValueError):
            page.claim(5, "bandwidth", "2", "1", True, "")
        page.claim(6, "use", "40%", "41%", False, "")
        page.claim(5, "bandwidth", "2", "1", True, "because")
        claims = page.claims()
        self.assertIn("| 6 | use", claims)
        self.assertLess(claims.index("| 5 | bandwidth"), claims.index("| 6 | use"))
        self.assertIn("- **5, bandwidth**: because\n", claims)
        self.assertNotIn("- **6", claims)

    def test_NumbersArePrintedWithTheirDigits(self):
        self.assertEqual(number(1.25, 1), "1.2")
        self.assertEqual(number(-3, 0), "-3")
        self.assertEqual(percent(0.375, 1), "37.5%")
