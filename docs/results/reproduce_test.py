#!/usr/bin/env python3
"""Checks that reproduce.py finds all differences from a printed table, and no others."""

import contextlib
import io
import json
import os
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import reproduce  # noqa: E402
from figures import Figure, unless  # noqa: E402
from programs import Programs, is_whole  # noqa: E402


class Agreement(unittest.TestCase):
    def test_one_unit_of_the_last_digit_is_rounding(self):
        self.assertTrue(reproduce.agree("0.559 s", "0.560 s", False))
        self.assertFalse(reproduce.agree("0.559 s", "0.561 s", False))
        self.assertTrue(reproduce.agree("1.2e-08", "1.3e-08", False))
        self.assertFalse(reproduce.agree("100 %", "102 %", False))

    def test_words_count_to_the_letter(self):
        self.assertFalse(reproduce.agree("yes", "fell at 3.32 s", False))
        self.assertFalse(reproduce.agree("12 mm", "12 N", False))
        self.assertFalse(reproduce.agree("", "0.1", False))

    def test_counts_have_no_rounding(self):
        self.assertFalse(reproduce.agree("23 of 24", "24 of 24", False))
        self.assertFalse(reproduce.agree("0 of 3, 0.41 to 0.45", "1 of 3, 0.41 to 0.45", True))
        self.assertTrue(reproduce.agree("3 of 3, 0.41 to 0.45", "3 of 3, 0.41 to 0.46", False))
        self.assertTrue(reproduce.agree("takes 1.4 of 5.0", "takes 1.5 of 5.1", False))
        self.assertFalse(reproduce.agree("55", "54", False, exact=True))
        self.assertTrue(reproduce.agree("18.1", "18.2", False, exact=True))

    def test_times_may_be_three_times_as_long(self):
        self.assertTrue(reproduce.agree("0.10 s", "0.29 s", True))
        self.assertFalse(reproduce.agree("0.10 s", "0.40 s", True))

    def test_table_is_read_without_its_rule(self):
        text = "| push | yes |\n| --- | --- |\n| 6 N s | no |\n"
        self.assertEqual(reproduce.cells(text), [["push", "yes"], ["6 N s", "no"]])


class Tables(unittest.TestCase):
    def test_every_table_is_in_its_readme(self):
        for name, table in reproduce.ALL.items():
            there = reproduce.printed(name, table)
            self.assertIsNotNone(there, name)
            rows = reproduce.cells(there)
            titles, count = table.shape()
            self.assertEqual(rows[0], [title.strip() for title in titles], name)
            self.assertEqual(len(rows) - 1, count, name)

    def test_exact_columns_exist_in_their_table(self):
        for name, table in reproduce.ALL.items():
            self.assertLessEqual({*table.exact, *table.timed}, set(table.shape()[0]), name)

    def test_counts_and_names_of_rows_differ_by_one(self):
        for name, before, after, title in (("solvers", "| riccati | 54 | 54 |", "| riccati | 54 | 53 |", "within tolerance"),
                                           ("map_dart", "| back | 8 | 7 | 6 |", "| back | 7 | 7 | 6 |", "MPC"),
                                           ("dart", "| 8 N s |", "| 7 N s |", "push")):
            table = reproduce.ALL[name]
            there = reproduce.printed(name, table)
            self.assertIn(before, there)
            self.assertEqual(reproduce.differences(name, table, there), [])
            found = reproduce.differences(name, table, there.replace(before, after))
            self.assertEqual(len(found), 1, name)
            self.assertIn(f", {title}: printed", found[0])

    def test_every_picture_exists(self):
        for path in reproduce.PICTURES:
            self.assertTrue(os.path.exists(os.path.join(reproduce.ROOT, path)), path)


class Skipped(unittest.TestCase):
    def told(self, pictures, points=0.0):
        """Status and output for pictures that can or cannot be drawn."""
        def draw(is_here):
            def picture(programs):
                if not is_here:
                    raise reproduce.NotHere("no program")
                return "drawn.png"
            return picture
        out = io.StringIO()
        with mock.patch.object(reproduce, "PICTURES", {f"README{k}.md": draw(here) for k, here in enumerate(pictures)}), \
                mock.patch.object(reproduce, "share_of_points", lambda *_: points), \
                mock.patch.object(os.path, "exists", lambda _: True), \
                mock.patch.object(sys, "argv", ["reproduce.py", "saltus", "pictures"]), contextlib.redirect_stdout(out):
            return reproduce.main(), out.getvalue()

    def test_skipped_tables_are_not_as_printed(self):
        self.assertIn("pictures: as printed\n", self.told([True, True])[1])
        self.assertIn("pictures: as printed, 1 of 2 skipped\n", self.told([True, False])[1])
        status, told = self.told([False, False])
        self.assertEqual(status, 0)
        self.assertIn("pictures: skipped; all 2", told)
        self.assertNotIn("as printed", told)
        status, told = self.told([True, False], 0.5)
        self.assertEqual(status, reproduce.DIFFERENT)
        self.assertIn("pictures: 1 differ, 1 of 2 skipped\n", told)


class Kept(unittest.TestCase):
    def test_interrupted_run_is_rejected(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertFalse(is_whole(folder))
            for reason, whole in (("interrupted at 2.78 s", False), ("", True), ("fell at 3 s", True)):
                with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
                    json.dump({"reason": reason}, file)
                self.assertEqual(is_whole(folder), whole, reason)

    def test_kept_runs_name_their_programs(self):
        """A program with a version that runs this many cells of a map at a time."""
        with tempfile.TemporaryDirectory() as folder:
            def look(version, cells, what):
                path = os.path.join(folder, "saltus")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(f"""#!{sys.executable}
import os, sys
words = sys.argv[1:]
if words == ["--version"]:
    print("{version}")
elif words[0] == "suite":
    open(words[words.index("--json") + 1], "w").write("[]")
else:
    out = os.path.join(words[words.index("--out") + 1], "map.csv")
    done = open(out).read().count("cell") if os.path.exists(out) else 0
    open(out, "w").write("cell\\n" * min(3, done + {cells}))
""")
                os.chmod(path, 0o755)
                programs = Programs(path, folder, 1)
                what(programs)
                return programs.made_by()
            self.assertEqual(look("old", 0, lambda p: p.suite("ipopt")), "old")
            self.assertEqual(look("new", 0, lambda p: p.suite("ipopt")), "old")
            self.assertEqual(look("old", 2, lambda p: p.survival_map()), "old")
            self.assertEqual(look("none", 0, lambda p: p.survival_map()), "old")
            self.assertEqual(look("new", 2, lambda p: p.survival_map()), "new, old")
            self.assertEqual(look("newer", 2, lambda p: p.survival_map()), "new, old")


class OneFigure(unittest.TestCase):
    def test_words_and_numbers_are_in_their_fields(self):
        class Made:
            def run(self, settings):
                return {}
        figure = Figure("settles", "in {:.2f} s{}", [{}], lambda s: [0.123, unless(False)])
        self.assertEqual(figure.make(Made()), "in 0.12 s VIOLATED")
        self.assertFalse(reproduce.agree("in 0.12 s", figure.make(Made()), False))


if __name__ == "__main__":
    unittest.main()
