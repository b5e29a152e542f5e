"""That what judges figures can judge: a planted regression is named, an equal table passes, slopes are found."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
HEAD = "# of a test\nsubject,instructions,units,unit\n"


def run(script, *arguments):
    command = [sys.executable, str(HERE / script), *map(str, arguments)]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.addCleanup(self.holder.cleanup)

    def file(self, name, text):
        path = pathlib.Path(self.holder.name) / name
        path.write_text(text)
        return path


class Counts(WithFolder):
    def judge(self, now):
        before = self.file("before.csv", HEAD + "a/x,1000,10,points\nb/y,500,1,requests\n")
        return run("counts/counts.py", "--baseline", before, "--of", self.file("now.csv", HEAD + now))

    def test_an_equal_table_passes(self):
        judged = self.judge("a/x,1000,10,points\nb/y,500,1,requests\n")
        self.assertEqual(judged.returncode, 0, judged.stdout)
        self.assertIn("0 regressions\n0 improvements\n0 new", judged.stdout)

    def test_a_tenth_is_no_regression(self):
        self.assertEqual(self.judge("a/x,1100,10,points\nb/y,450,1,requests\n").returncode, 0)

    def test_a_planted_regression_is_named(self):
        judged = self.judge("a/x,1101,10,points\nb/y,500,1,requests\n")
        self.assertEqual(judged.returncode, 1)
        self.assertIn("1 regressions\n  a/x: 1,000 -> 1,101 instructions, +10.1 %", judged.stdout)

    def test_what_is_no_longer_counted_is_a_regression(self):
        judged = self.judge("a/x,1000,10,points\n")
        self.assertEqual(judged.returncode, 1)
        self.assertIn("b/y: no longer counted", judged.stdout)

    def test_improvements_and_new_subjects_are_named_and_pass(self):
        judged = self.judge("a/x,800,10,points\nb/y,500,1,requests\nc/z,1,1,rays\n")
        self.assertEqual(judged.returncode, 0)
        self.assertIn("1 improvements\n  a/x", judged.stdout)
        self.assertIn("1 new\n  c/z", judged.stdout)


class Plot(WithFolder):
    def test_slopes_are_found_and_every_point_is_drawn(self):
        rows = "".join(f"a,{n},{7 * n**1.5}\nb,{n},{n**-2}\n" for n in (1, 10, 100))
        self.file("table.csv", "# remark\nwhat,n,ms\n" + rows)
        panel = {"title": "T<", "x": "n", "y": "ms", "csv": "table.csv", "data": ["n", "ms"],
                 "series": "what", "fits": {"a": {"expected": 1.5}, "b": {"expected": 1, "from": 10}}}
        out = pathlib.Path(self.holder.name) / "out.svg"
        drawn = run("plot.py", self.file("spec.json", json.dumps({"panels": [panel]})), out)
        self.assertEqual(drawn.returncode, 0, drawn.stdout)
        self.assertIn("| a | expected 1.5 | found 1.50", drawn.stdout)
        self.assertIn("| b | expected 1 | found -2.00", drawn.stdout)
        svg = out.read_text()
        self.assertIn("T&lt;", svg)
        self.assertEqual(svg.count('class="mark"'), 2 * 3 + 2)
        self.assertEqual(svg.count('class="expected"'), 2)

    def test_nothing_to_draw_is_said(self):
        self.file("table.csv", "what,n,ms\n")
        panel = {"title": "T", "x": "n", "y": "ms", "csv": "table.csv", "data": ["n", "ms"], "series": "what"}
        spec = self.file("spec.json", json.dumps({"panels": [panel]}))
        self.assertNotEqual(run("plot.py", spec, spec.with_suffix(".svg")).returncode, 0)


if __name__ == "__main__":
    unittest.main()
