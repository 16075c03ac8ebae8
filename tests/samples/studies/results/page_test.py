import math
import pathlib
import re
import tempfile
import unittest

from figures import Spread
from page import WORDS, Page, differs, number, percent
from studies import draw


class ResultPage(unittest.TestCase):
    def test_AQuarterIsCountedFromTheNearerEndOfTheRange(self):
        self.assertFalse(differs(2.5, 2, 4))
        self.assertFalse(differs(1.5, 2, 4))
        self.assertTrue(differs(1.49, 2, 4))
        self.assertFalse(differs(5, 2, 4))
        self.assertTrue(differs(5.01, 2, 4))

    def test_ATableIsInItsFile(self):
        page = Page()
        page.table("t", ["name", "value"], [["a, b", "1"], ['say "c"', "2"]])
        self.assertEqual(page.body, "[results/t.csv](results/t.csv)\n\n")
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

    def test_AClaimHasTheWordsOfItsRowAndSaysWhyIfItDiffers(self):
        page = Page()
        page.claim(22, False, edram=32, sram=15.1, logic=9.4)
        page.claim(10, True, times=Spread(1.5, 3, 4), half=Spread(1, 2, 3))
        claims = " ".join(page.claims().split())
        self.assertEqual(page.rows_within(), {"within": 1, "rows": 2})
        self.assertIn("- **10, a view along which each ray crosses all slabs, against one across (5.4)**: paper about "
                      "twice the time; ours 3.00 times (mean of scenes; 1.50 to 4.00). Reason: the mean follows the "
                      "scenes", claims)
        self.assertNotIn("- **22", claims)
        with tempfile.TemporaryDirectory() as folder:
            page.write_files(pathlib.Path(folder))
            _, first, second = (pathlib.Path(folder) / "claims.csv").read_text().splitlines()
        self.assertRegex(first, r"^10,.*,no$")
        self.assertEqual(second, '22,hardware cost (Table 1),"32 Mb eDRAM, 15 Mb SRAM, 9.5 M transistors of logic",'
                         '"32.0 Mb eDRAM, 15.1 Mb SRAM, 9.4 M transistors",-,yes')

    def test_EveryRowOfTheWordsHasItsLines(self):
        rows = [WORDS[name] for name in WORDS if re.fullmatch(r"row \d+( \w+)?", name)]
        self.assertGreaterEqual(len(rows), 27)
        for text in rows:
            if not text.startswith("{scene}"):
                self.assertEqual([line[:7].split(":")[0] for line in text.splitlines()],
                                 ["- claim", "- paper", "- ours", *["- half"] * ("\n- half: " in text), "- why"])

    def test_TextNeedsItsFigures(self):
        page = Page()
        page.say("large", edge=512)
        self.assertEqual(page.body, "16 processors on 512^3 voxels, oblique views.\n\n")
        with self.assertRaises(KeyError):
            page.say("large")

    def test_NumbersArePrintedWithTheirDigits(self):
        self.assertEqual(number(1.25, 1), "1.2")
        self.assertEqual(number(-3, 0), "-3")
        self.assertEqual(percent(0.375, 1), "37.5%")
