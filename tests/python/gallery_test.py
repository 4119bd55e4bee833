#!/usr/bin/env python3
"""The gallery in Python: problems of the library and the tutorial have the results of C++.

Usage: gallery_test.py BUILD COSTS, with the folder python of the build and the program library_costs. The programs of
the tutorial are in the folder of COSTS.
"""

import csv
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
BUILD, COSTS = os.path.abspath(sys.argv.pop(1)), os.path.abspath(sys.argv.pop(1))
sys.path[:0] = [os.path.join(ROOT, "python"), BUILD, os.path.join(ROOT, "docs", "python")]
import numpy as np  # noqa: E402

import library  # noqa: E402
import saltus as sl  # noqa: E402

TOLERANCE = 1e-9  # the solver stops at 1e-10; rounding differs, because Python's formulas are recorded


class Library(unittest.TestCase):
    def test_costs_durations_and_states(self):
        names = [case.__name__ for case in library.CASES]
        printed = subprocess.run([COSTS, *names], capture_output=True, text=True, check=True).stdout
        expected = {line.split()[0]: np.array(line.split()[1:], dtype=float) for line in printed.splitlines()}
        self.assertEqual(sorted(expected), sorted(names))
        for case in library.CASES:
            with self.subTest(case.__name__):
                problem, options, optimum = case()
                shooting = sl.MultipleShooting(problem, **options)
                plan = sl.solve(shooting, sl.make_native_solver(tolerance=1e-10))
                cost, others = expected[case.__name__][0], expected[case.__name__][1:]
                self.assertLessEqual(abs(plan.cost - cost), TOLERANCE * (1.0 + abs(cost)), (plan.cost, cost))
                found = np.concatenate([plan.durations, plan.trajectory.final_state])
                # Costs are flat in durations and states: the square root of the tolerance.
                np.testing.assert_allclose(found, others, rtol=3e-5, atol=3e-5)
                self.assertLessEqual(abs(plan.cost - optimum), 1e-3 * (1.0 + abs(optimum)))


class Tutorial(unittest.TestCase):
    def test_steps(self):
        for step in range(1, 7):
            with self.subTest(step=step), tempfile.TemporaryDirectory() as folder:
                program = os.path.join(os.path.dirname(COSTS), f"tutorial_{step}")
                script = os.path.join(ROOT, "docs", "tutorial", "python", f"step_{step}.py")
                done = [self.run_in(os.path.join(folder, name), command)
                        for name, command in (("cpp", [program]), ("python", [sys.executable, "-B", script]))]
                self.assertEqual(done[0].strip(), done[1].strip())
                tables = [self.table(os.path.join(folder, name, f"step_{step}", "trajectory.csv"))
                          for name in ("cpp", "python")]
                self.assertEqual(tables[0][0], tables[1][0])
                # A tick of step 6 may end by rounding before or after an event: rows at the same instant change places.
                keep = ~self.at_events(tables[0][1]) if step == 6 else slice(None)
                # Its ticks are solved to 1e-8 relative to forces of 100 N.
                np.testing.assert_allclose(tables[1][1][keep], tables[0][1][keep], rtol=0,
                                           atol=1e-6 if step == 6 else TOLERANCE)

    def at_events(self, table):
        t = table[:, 0]
        same = np.diff(t) < 1e-9
        return np.concatenate([[False], same]) | np.concatenate([same, [False]])

    def run_in(self, folder, command):
        os.mkdir(folder)
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": os.pathsep.join((os.path.join(ROOT, "python"), BUILD))})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def table(self, file):
        with open(file, encoding="utf-8") as lines:
            rows = list(csv.reader(lines))
        return rows[0], np.array([[float(x or "nan") if i != 1 else 0.0 for i, x in enumerate(row)] for row in rows[1:]])


if __name__ == "__main__":
    unittest.main()
