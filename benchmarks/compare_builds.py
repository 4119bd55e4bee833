#!/usr/bin/env python3
"""Compares builds of the program for other processors, compilers and optimisation levels.

Usage: compare_builds.py NAME=PROGRAM NAME=PROGRAM... [--plants centroidal,dart] [--impulses 4,7,8] [--solvers riccati,ipopt]
                         [--only PATTERN] [--keep FOLDER]

Each program executes the same runs of push recovery and solves the problems of the library. A table compares the
results with those of the first program: bit-identical results, identical verdicts, and the largest differences. The
first program executes everything twice, and both results must be identical.
"""

import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

OF_COMPUTING = ("_us", "time [us]")  # computing times
COM = ("com_x", "com_y", "com_z")
ICP = ("icp_x", "icp_y")
FORCES = ("left_fx", "left_fy", "left_fz", "right_fx", "right_fy", "right_fz")


def call(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


class Run:
    """One run of push recovery: its outcome and its table."""

    def __init__(self, folder):
        with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
            self.summary = json.load(file)
        with open(os.path.join(folder, "trajectory.csv"), encoding="utf-8") as file:
            rows = list(csv.reader(file))
        self.columns = {name.split(" [")[0]: [float(v) for v in column]
                        for name, *column in zip(*rows) if not name.endswith(OF_COMPUTING)}

    def outcome(self):
        return "recovered" if self.summary["recovered"] else f"not recovered: {self.summary['reason']}"

    def largest_difference(self, other, names):
        """The largest difference in the columns and rows that both have."""
        pairs = [pair for name in names if name in self.columns for pair in zip(self.columns[name], other.columns[name])]
        return max((abs(a - b) for a, b in pairs if not math.isnan(a - b)), default=0.0)

    def first_difference(self, other):
        """Time of the first row that differs in any bit; None if there is none."""
        for row, t in enumerate(self.columns["t"]):
            for name, column in self.columns.items():
                a = column[row]
                b = other.columns[name][row] if row < len(other.columns[name]) else math.inf
                if a != b and not (math.isnan(a) and math.isnan(b)):
                    return t
        return None


def run_push(program, plant, impulse, folder):
    status, printed = call([program, "run", "push_recovery", "--plant", plant, "--push.impulse", str(impulse),
                            "--pictures", "false", "--quiet", "--out", folder])
    if not os.path.exists(os.path.join(folder, "summary.json")):
        sys.exit(f"compare_builds: {program}: status {status}\n{printed[-2000:]}")
    return Run(folder)


def run_suite(program, solver, only, file):
    status, printed = call([program, "suite", "--set", f"solver={solver}", "--json", file]
                           + (["--only", only] if only else []))
    if not os.path.exists(file):
        sys.exit(f"compare_builds: {program}: status {status}\n{printed[-2000:]}")
    with open(file, encoding="utf-8") as stream:
        cases = json.load(stream)["cases"]
    return {case["id"]: case for case in cases}


def small(value, unit=""):
    return "0" if value == 0.0 else f"{value:.1e} {unit}".rstrip()


def compare_pushes(first, other):
    """Cells of a row."""
    began = first.first_difference(other)
    landed = [run.summary.get("touchdown_s") for run in (first, other)]
    same = first.outcome() == other.outcome() and landed[0] == landed[1]
    return [
        first.outcome() if same else f"{first.outcome()} / {other.outcome()}",
        "never" if began is None else f"{began:g} s",
        small(1e3 * first.largest_difference(other, COM), "mm"),
        small(1e3 * first.largest_difference(other, ICP), "mm"),
        small(first.largest_difference(other, FORCES), "N"),
    ]


def compare_suites(first, other):
    """Cells of a row."""
    both = sorted(set(first) & set(other))
    verdicts = [name for name in both if first[name]["verdict"] != other[name]["verdict"]]
    iterations = [name for name in both if first[name]["iterations"] != other[name]["iterations"]]
    same, furthest, where = 0, 0.0, ""
    for name in both:
        values = [[entry["value"] for entry in suite[name]["checked"]] for suite in (first, other)]
        same += values[0] == values[1]
        for was, value in zip(first[name]["checked"], values[1]):
            if was["value"] is None or value is None:
                continue
            part = abs(was["value"] - value) / was["tolerance"] if was["tolerance"] else 0.0
            if part > furthest:
                furthest, where = part, name
    return [
        f"{len(both)}",
        f"{len(both) - len(verdicts)}" + (f" (not {', '.join(verdicts)})" if verdicts else ""),
        f"{same}",
        f"{len(both) - len(iterations)}" + (f" (not {', '.join(iterations)})" if iterations else ""),
        f"{furthest:.1e} ({where})" if where else "0",
    ]


def table(head, rows):
    print("| " + " | ".join(head) + " |\n|" + " --- |" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print(flush=True)


def main(arguments):
    builds = [word.partition("=")[::2] for word in arguments.builds]
    if len(builds) < 2 or not all(name and program for name, program in builds):
        sys.exit("compare_builds: at least two builds are needed, as NAME=PROGRAM")
    first = builds[0][0]
    again = [(f"{first}, again", builds[0][1])]
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or temporary
        os.makedirs(folder, exist_ok=True)

        def place(*words):
            return os.path.join(folder, "_".join(word.replace(" ", "").replace(",", "_") for word in words))

        rows = []
        for plant in filter(None, arguments.plants.split(",")):
            for impulse in arguments.impulses.split(","):
                runs = {name: run_push(program, plant, impulse, place(name, plant, impulse))
                        for name, program in builds + again}
                rows += [[f"{plant}, {impulse} N s", name, *compare_pushes(runs[first], runs[name])]
                         for name in list(runs)[1:]]
        if rows:
            table(["push", f"against {first}", "outcome", "first bit differs at", "CoM", "ICP", "forces"], rows)
        rows = []
        for solver in filter(None, arguments.solvers.split(",")):
            suites = {name: run_suite(program, solver, arguments.only, place(name, solver) + ".json")
                      for name, program in builds + again}
            rows += [[solver, name, *compare_suites(suites[first], suites[name])] for name in list(suites)[1:]]
        if rows:
            table(["solver", f"against {first}", "cases", "same verdict", "all digits", "same iterations",
                   "largest difference, in tolerances of the suite"], rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", nargs="+", metavar="NAME=PROGRAM")
    parser.add_argument("--plants", default="centroidal,dart")
    parser.add_argument("--impulses", default="4,7,8", help="towards -y, N s")
    parser.add_argument("--solvers", default="riccati,ipopt")
    parser.add_argument("--only", default="", help="part of a case's name")
    parser.add_argument("--keep", metavar="FOLDER", help="keep the runs in this folder")
    main(parser.parse_args())
