import math
import pathlib
import re
import tempfile
import unittest

from page import Chart, Page, Table, differs, draw_chart, number, percent, to_csv, to_markdown
from studies import draw


class ResultPage(unittest.TestCase):
    def test_AQuarterIsCountedFromTheNearerEndOfTheRange(self):
        self.assertFalse(differs(2.5, 2, 4))
        self.assertFalse(differs(1.5, 2, 4))
        self.assertTrue(differs(1.49, 2, 4))
        self.assertFalse(differs(5, 2, 4))
        self.assertTrue(differs(5.01, 2, 4))

    def test_TableHasTheSameCellsAsItsCsv(self):
        table = Table("t", ["name", "value"], [["a, b", "1"], ['say "c"', "2"]])
        self.assertEqual(to_markdown(table), '| name | value |\n| --- | --- |\n| a, b | 1 |\n| say "c" | 2 |\n')
        self.assertEqual(to_csv(table), 'name,value\n"a, b",1\n"say ""c""",2\n')

    def test_ChartLeavesAMissingValueEmpty(self):
        chart = Chart("c", "Title", "x", "y", log_x=True, series=["one", "two"], points=[(1, [0.5, 2]), (2, [math.nan, 3])])
        self.assertEqual(to_csv(chart), "x,one,two\n1,0.5,2\n2,,3\n")
        with tempfile.TemporaryDirectory() as folder:
            draw_chart(chart, pathlib.Path(folder) / "c.svg")
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
