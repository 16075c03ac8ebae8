"""script/mutate: what it finds in a source, and that a seeded fault is there when it is switched on, and only then."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent.parent / "script"))
import mutants  # noqa: E402

MAIN = """
#include <cstdio>
int capped(int a, int b);
int main() {
  const int got[] = {capped(3, 4), capped(9, 4), capped(-30, 5), capped(10, 0), capped(0, -7)};
  for (int i : got) std::printf("%d ", i);
}
"""
RIGHT = "10 20 -20 20 -7 "


class MutantsTestCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.finder = mutants.Finder(str(FOLDER / "toy.cpp"), "toy.cpp", ["-std=c++20"])
        cls.numbered = dict(enumerate(cls.finder.mutants(), 1))
        cls.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.folder.name)
        (folder / "mutant.h").write_text(mutants.HEADER)
        (folder / "toy.cpp").write_bytes(mutants.write(cls.finder.source, cls.numbered, cls.finder.constexpr,
                                                       b'#include "mutant.h"\n'))
        (folder / "main.cpp").write_text(MAIN)
        subprocess.run(["c++", "-std=c++20", "-w", "toy.cpp", "main.cpp", "-o", "toy"], cwd=folder, check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def printed(self, number, **more):
        run = subprocess.run([self.folder.name + "/toy"], env={"GICUBE_MUTANT": str(number), **more}, check=True,
                             capture_output=True, text=True)
        return run.stdout

    def number(self, line, kind, text):
        found = [n for n, m in self.numbered.items() if (m.line, m.kind, m.text) == (line, kind, text)]
        self.assertEqual(len(found), 1, (line, kind, text))
        return found[0]

    def test_FindsNothingWrongWithTheSource(self):
        self.assertEqual(self.finder.errors, set())

    def test_FindsEveryKindOfFaultWhereItIs(self):
        self.number(4, "constant", "2 + 1")
        self.number(4, "arithmetic", "2 + a")
        self.number(8, "relation", "a >= b")
        self.number(8, "statement", "")
        self.number(13, "arithmetic", "twice(a) - b")
        self.number(14, "arguments", "larger(sum > kLimit ? kLimit : sum, -kLimit)")

    def test_LeavesNamedConstantsAloneAndMutatesTheirUses(self):
        self.assertNotIn(2, {m.line for m in self.numbered.values()})
        self.assertIn("kLimit * 9 / 10", {m.text for m in self.numbered.values() if m.line == 14})

    def test_SaysWhichLinesAFaultMakesWrong(self):
        line = f'#include "{self.folder.name}/mutant.h"\n'.encode()
        whole = mutants.write(self.finder.source, self.numbered, self.finder.constexpr, line)
        self.assertEqual(self.finder.wrong_lines(whole), set())
        wrong = self.numbered[self.number(13, "arithmetic", "twice(a) - b")]._replace(text="nothing()")
        self.assertEqual(self.finder.wrong_lines(mutants.write(self.finder.source, {1: wrong}, [], line)), {13})

    def test_ChangesNothingWhileNoMutantIsOn(self):
        self.assertEqual(self.printed(0), RIGHT)

    def test_SwitchesOneFaultOn(self):
        self.assertEqual(self.printed(self.number(4, "arithmetic", "2 + a")), "9 15 -20 12 -5 ")
        self.assertEqual(self.printed(self.number(13, "arithmetic", "twice(a) - b")), "2 14 -20 20 7 ")
        self.assertEqual(self.printed(self.number(8, "statement", "")), "10 20 -55 20 -7 ")

    def test_AnEquivalentFaultShowsNothing(self):
        self.assertEqual(self.printed(self.number(8, "relation", "a >= b")), RIGHT)

    def test_NotesWhichMutantsAProgramComesBy(self):
        with tempfile.NamedTemporaryFile() as file:
            file.write(bytes(4096))
            file.flush()
            self.printed(0, GICUBE_MUTANTS_REACHED=file.name)
            file.seek(0)
            reached = {i for i, b in enumerate(file.read()) if b}
        self.assertEqual(reached, set(self.numbered))


if __name__ == "__main__":
    unittest.main()
