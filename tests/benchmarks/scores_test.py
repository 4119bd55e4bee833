#!/usr/bin/env python3
"""Checks statistics, exports and pages on results made here. Needs numpy."""

import contextlib
import csv
import importlib.util
import io
import json
import math
import os
import sys
import unittest

from own_folder import OwnFolder

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../benchmarks/suite/scripts"))
if importlib.util.find_spec("numpy") is None:
    print("skipped: numpy is not installed")
    sys.exit(77)
import bench
import figures
import records
import report
import scores
import table


def line(task, solver, instance, verdict, seconds=1.0):
    problem, start = task.split()
    return {"problem": problem, "start": start, "solver": solver, "instance": instance, "verdict": verdict, "claimed": "<b>&",
            "asked": 1e-6, "setting": "own start", "swept": {"own start": [1, 7]}, "iterations": 7, "objective": 2.0, "size": [3, 4],
            "kkt": {"stationarity": 1e-9, "feasibility": 0.0, "complementarity": 0.0}, "machine": {"version": "v_1"},
            "times": {"wall_us": [1e6 * seconds], "cpu_us": [1e6 * seconds]}}


def made(tasks, kinds=(), tolerance=1e-6, solvers=("riccati", "riccati-generic", "sparse", "piqp", "highs", "qoco")):
    head = {"format": records.FORMAT, "saltus": {key: "1" for key in ("version", "commit", "compiler", "type", "march")},
            "machine": {"processor": "P", "system": "S"}, "packages": {"piqp": "9"},
            "matrix": {"tasks": list(tasks), "horizons": {}, "solvers": list(solvers), "kinds": dict(kinds), "instances": 2,
                       "repetitions": 1, "tolerance": tolerance, "limits": {"solve": 10.0}}}
    return records.Records(head, tasks)


TASKS = {"a cold": [*(line("a cold", "sparse", i, "solved", 0.1 * i) for i in (1, 2)), line("a cold", "piqp", 1, "solved", 0.05),
                    line("a cold", "piqp", 2, "wrong", 0.01), line("a cold", "qoco", 1, "gave up")],
         "b cold": [line("b cold", "sparse", 1, "solved", 0.4), line("b cold", "piqp", 0, "not applicable"),
                    line("b cold", "qoco", 0, "missing"), line("b cold", "highs", 1, "too slow")]}


class Statistics(unittest.TestCase):
    def test_only_applicable_instances_count(self):
        self.assertEqual(scores.seconds(made(TASKS), list(TASKS)), {
            "sparse": {("a cold", 1): 0.1, ("a cold", 2): 0.2, ("b cold", 1): 0.4},
            "piqp": {("a cold", 1): 0.05, ("a cold", 2): None}, "qoco": {("a cold", 1): None, ("a cold", 2): None},
            "highs": {("b cold", 1): None}})

    def test_failures_cost_the_limit(self):
        self.assertAlmostEqual(scores.mean([0.05, None], 10.0), math.sqrt(0.051 * 10.001) - 0.001)
        self.assertAlmostEqual(scores.mean([20.0], 10.0), 10.0)
        rows = {row[0]: row for row in scores.summary(made(TASKS), list(TASKS))}
        self.assertEqual(rows["piqp"][1:3], (2, 1))
        self.assertAlmostEqual(rows["piqp"][3], math.sqrt(0.051 * 10.001) - 0.001)
        for solver, _, _, value, low, high in rows.values():
            self.assertTrue(low - 1e-12 <= value <= high + 1e-12, solver)

    def test_solvers_with_fewer_instances_come_last(self):
        self.assertEqual([row[0] for row in scores.summary(made(TASKS), list(TASKS))], ["sparse", "piqp", "highs", "qoco"])
        tasks = {**TASKS, "b cold": [*TASKS["b cold"], line("b cold", "riccati", 1, "solved", 1e-3)]}
        self.assertEqual([row[0] for row in scores.summary(made(tasks), list(tasks))][:2], ["sparse", "riccati"])

    def test_bands_are_repeatable_and_narrow_with_many_instances(self):
        few, many = ({"a cold": [line("a cold", "sparse", i, "solved", 0.1 * (1 + i % 5)) for i in range(1, n + 1)]} for n in (10, 100))
        bands = [scores.summary(made(tasks), ["a cold"])[0][4:] for tasks in (few, many)]
        self.assertEqual(bands[0], scores.summary(made(few), ["a cold"])[0][4:])
        self.assertLess(bands[1][1] - bands[1][0], 0.5 * (bands[0][1] - bands[0][0]))

    def test_profiles(self):
        grid, found = scores.curves(made(TASKS), list(TASKS), ["sparse", "piqp", "qoco"], True)
        share = {name: (of[0][0], of[0][-1]) for name, of in found.items()}
        self.assertEqual(share, {"sparse": (2 / 3, 1.0), "piqp": (0.5, 0.5), "qoco": (0.0, 0.0)})
        self.assertEqual(found["sparse"][0][grid < 2.0].max(), 2 / 3)
        grid, found = scores.curves(made(TASKS), list(TASKS), ["sparse", "highs"], False)
        self.assertEqual(list(found["sparse"][0][[0, -1]]), [0.0, 1.0])
        self.assertAlmostEqual(found["sparse"][0][grid <= 0.25][-1], 2 / 3)
        self.assertEqual(found["highs"][0].max(), 0.0)

    def test_at_most_eight_curves_with_one_of_ours(self):
        names = [f"s{i}" for i in range(9)]
        rows = [(name, 1, 1, 0.1, 0.1, 0.1) for name in names] + [("sparse", 1, 1, 9.0, 9.0, 9.0)]
        self.assertEqual(scores.shown(rows), [*names[:7], "sparse"])

    def test_where_ours_are_not_first_is_said(self):
        tasks = {"a cold": [line("a cold", "sparse", 1, "wrong"), line("a cold", "piqp", 1, "solved", 0.05)]}
        text = " ".join(scores.behind(made(tasks)))
        self.assertIn("piqp has the smallest mean, 0.05 s; our best is sparse with 10 s (1 of 1 and 0 of 1 solved)", text)
        self.assertIn("piqp solves 1 of 1, more than any of ours (0 %)", text)
        self.assertEqual(list(scores.behind(made({"a cold": tasks["a cold"][:1]}))), [])

    def test_ours_are_compared_as_a_user_gets_them(self):
        times = {"riccati": 0.01, "riccati-generic": 0.3, "piqp": 0.1}
        tasks = {"a cold": [line("a cold", solver, 1, "solved", seconds) for solver, seconds in times.items()]}
        cells = figures.by_cell(made(tasks))
        self.assertEqual(list(report.not_first(made(tasks), cells)), ["a cold: piqp takes 100000 us, riccati-generic 300000 us."])
        self.assertEqual(list(report.ratio_rows(list(tasks), cells, list(times)))[0][0], "time / riccati-generic's")

    def test_classes(self):
        tasks = {name: [line(name, "sparse", 1, "solved")] for name in ("library/x cold", "a warm", "restated/y cold", "own/z cold")}
        run = made(tasks, {"library/x cold": "nonlinear", "restated/y cold": "nonlinear", "own/z cold": "complementarity"})
        self.assertEqual([names for _, names in table.groups(run)],
                         [["a warm"], ["library/x cold"], ["restated/y cold"], ["own/z cold"]])

    def test_lists_of_tolerances(self):
        self.assertEqual(bench.tolerances_of("1e-9,1e-3"), [1e-3, 1e-9])
        for text in ("", "0", "1e-3,,", "x", "inf", "-1"):
            with self.assertRaisesRegex(ValueError, "must be a number above 0"):
                bench.tolerances_of(text)


class Output(OwnFolder):
    def report(self, *words):
        paths = []
        for tolerance in (1e-3, 1e-6):
            tasks = {**TASKS, "<i>x cold": [line("<i>x cold", "sparse", 1, "solved")]}
            paths.append(self.path(f"{tolerance}.jsonl"))
            records.write(paths[-1], made(tasks, tolerance=tolerance), list(tasks))
        with contextlib.redirect_stdout(io.StringIO()) as told, contextlib.redirect_stderr(told):
            status = bench.main(["report", *paths, *words])
        return status, told.getvalue()

    def read(self, *names):
        with open(os.path.join(self.folder, *names), encoding="utf-8") as file:
            return file.read()

    def test_tables(self):
        self.assertEqual(self.report("--csv", self.path("a.csv"), "--latex", self.path("a.tex"))[0], 0)
        rows = list(csv.DictReader(io.StringIO(self.read("a.csv"))))
        self.assertEqual(len(rows), 2 * (1 + sum(map(len, TASKS.values()))))
        self.assertEqual([rows[0][key] for key in ("class", "solver", "tolerance", "time_us", "variables", "version", "stationarity")],
                         ["quadratic programs, cold", "sparse", "0.001", "100000.0", "3", "v_1", "1e-09"])
        self.assertEqual(rows[3]["time_us"], "")
        text = self.read("a.tex")
        self.assertIn("95 \\% bootstrap", text)
        self.assertIn("sparse & 4 & 4 & ", text)
        self.assertEqual(text.count("\\begin{tabular}"), text.count("\\end{tabular}"))
        self.assertEqual(scores.latex("a_b 5 % {x} \\ ^"), "a\\_b 5 \\% \\{x\\} \\textbackslash{} \\^{}")

    def test_same_tolerance_twice_is_rejected(self):
        self.report("--csv", self.path("a.csv"))
        path = self.path("0.001.jsonl")
        with contextlib.redirect_stderr(io.StringIO()) as told:
            self.assertEqual(bench.main(["report", path, path]), bench.MISTAKE)
        self.assertIn("same tolerance", told.getvalue())

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "needs matplotlib")
    def test_site(self):
        status, told = self.report("--site", self.path("site"))
        self.assertEqual(status, 0, told)
        index = self.read("site", "index.html")
        self.assertIn('href="instances/a-cold-2.html"', index)
        self.assertIn('href="solvers/piqp.html"', index)
        self.assertLess(index.index("Where Saltus is not first"), index.index("<svg"))
        self.assertEqual(index.count("<h2>Where Saltus is not first, tolerance"), 2)
        self.assertNotIn("<i>", index)
        for name in ("a-cold-1", "a-cold-2", "b-cold-1", "-i-x-cold-1"):
            page = self.read("site", "instances", name + ".html")
            self.assertIn("3 variables, 4 rows", page)
            self.assertNotIn("<b>&", page)
            self.assertNotIn("<i>", page)
        solver = self.read("site", "solvers", "piqp.html")
        self.assertIn("class Piqp(Adapter)", solver)
        self.assertIn("own start: 1 in 7", solver)
        self.assertIn("version in this run: 9", solver)
        self.assertIn("smallest that it accepts", self.read("site", "solvers", "highs.html"))


if __name__ == "__main__":
    unittest.main()
