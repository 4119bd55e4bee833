#!/usr/bin/env python3
"""Checks that `saltus bench` rejects or reports every adapter of misbehaving_adapters.py. Argument: the program
saltus-bench. Needs numpy."""

import importlib.util
import json
import os
import subprocess
import sys
import time
import unittest

from own_folder import OwnFolder

PROGRAM = sys.argv.pop(1)
HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPTS = os.path.join(HERE, "../../benchmarks/suite/scripts")
sys.path[:0] = [SCRIPTS, HERE]
if importlib.util.find_spec("numpy") is None:
    print("skipped: numpy is not installed")
    sys.exit(77)
import figures
import misbehaving_adapters as adapters

FATAL = ("crashed", "too slow", "out of memory")


class Liars(OwnFolder):
    def run_with(self, liars, **limits):
        """(solver -> its line, printed text) of a run on the program of own_problem(), together with an honest solver."""
        folder = self.path("fake/misbehaving-9.dist-info")
        os.makedirs(folder)
        with open(os.path.join(folder, "METADATA"), "w", encoding="utf-8") as file:
            file.write("Metadata-Version: 2.1\nName: misbehaving\nVersion: 9\n")
        with open(os.path.join(folder, "entry_points.txt"), "w", encoding="utf-8") as file:
            print("[saltus_bench]", *(f"{one.name} = misbehaving_adapters:{one.__name__}" for one in adapters.ALL), sep="\n", file=file)
        self.own_problem(-1.0)
        names = [*(one.name for one in liars), "honest"]
        limits = {"PATIENCE": 60, "IMPORT_LIMIT": 60, "SETUP_LIMIT": 60, **limits}
        done = subprocess.run(
            [sys.executable, "-B", os.path.join(SCRIPTS, "bench.py"), "run", "--problems", "own/one", "--start", "cold", "--solvers",
             ",".join(names), "--repetitions", "2", "--out", self.path("a.jsonl")], text=True, capture_output=True, check=False,
            cwd=self.folder, timeout=300,
            env={**os.environ, "SALTUS_PROGRAM": PROGRAM, "PYTHONPATH": os.pathsep.join((self.path("fake"), HERE)),
                 "SALTUS_BENCH_PROGRAMS": self.path("own"), **{"SALTUS_BENCH_" + key: str(value) for key, value in limits.items()}})
        self.assertIn(done.returncode, (0, 3), done.stderr)
        found = [line for line in self.lines("a.jsonl") if "solver" in line]
        self.assertEqual(sorted(line["solver"] for line in found), sorted(names), done.stderr)
        return {line["solver"]: line for line in found}, done.stdout

    def check(self, liars, **limits):
        lines, printed = self.run_with(liars, **limits)
        for one in (*liars, adapters.Honest):
            line = lines[one.name]
            with self.subTest(one.name):
                self.assertEqual(line["verdict"], one.verdict, line)
                self.assertIn(one.told, printed + json.dumps(line))
                self.assertGreaterEqual(figures.time_of(line) or 0.0, one.at_least_us)
        self.assertLess(figures.time_of(lines["honest"]), 2e4)
        self.assertNotIn("honest:", printed)
        return lines

    def test_answers_and_times(self):
        lines = self.check([one for one in adapters.ALL if one.verdict not in FATAL and one is not adapters.Honest])
        self.assertEqual(lines["own-timer"]["times"]["own_us"], [0.01, 0.01])
        self.assertGreater(lines["at-set-up"]["times"]["setup_us"], 4e4)
        self.assertLessEqual({"import_us", "setup_us", "first_us", "reading_us", "wall_us", "cpu_us"}, set(lines["honest"]["times"]))
        for name, line in lines.items():
            self.assertEqual(set(line["machine"]), {"host", "processor", "version"}, name)
            self.assertIn("numpy", line["machine"]["version"])
        with open(self.path("daemon"), encoding="ascii") as file:
            daemon = int(file.read())
        with self.assertRaises(ProcessLookupError):
            os.kill(daemon, 0)

    def test_processes(self):
        self.check([one for one in adapters.ALL if one.verdict in FATAL], PATIENCE=4, IMPORT_LIMIT=2, SETUP_LIMIT=2, MEMORY=0.2)

    def test_number(self):
        self.assertGreaterEqual(len(adapters.ALL) - 1, 28)


if __name__ == "__main__":
    unittest.main()
