#!/usr/bin/env python3
"""Checks that nonlinear programs in files are judged and solved, on small programs with known optima. Argument: the program
saltus-bench. Needs numpy."""

import copy
import importlib.util
import json
import math
import os
import subprocess
import sys
import unittest

from own_folder import OwnFolder

PROGRAM = sys.argv.pop(1)
HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPTS = os.path.join(HERE, "../../benchmarks/suite/scripts")
sys.path[:0] = [SCRIPTS, HERE]
if importlib.util.find_spec("numpy") is None:
    print("skipped: numpy is not installed")
    sys.exit(77)
import numpy as np
import misbehaving_nonlinear
import nonlinear_judge
import nosbench


def program(steps, outputs, n, bounds=None, sides=(), start=None, **more):
    """One function of all variables. Its first output is the cost, the others are rows."""
    lower, upper = bounds or ([None] * n, [None] * n)
    return {"format": "saltus-nlp 1", "problem": "own/one", "instance": 1, "variables": n, "rows": len(sides),
            "start": start or [0.5] * n, "lower": lower, "upper": upper, "row_lower": [low for low, _ in sides],
            "row_upper": [high for _, high in sides], "functions": [{"inputs": n, "steps": steps, "outputs": outputs}],
            "blocks": [{"function": 0, "constants": [0.0] * n, "coefficients": [[[i, 1.0]] for i in range(n)],
                        "outputs": [[row, 1.0] for row in range(-1, len(sides))]}],
            "linear": [], "variable_costs": [], **more}


X, Y = ["input", 0], ["input", 1]
# min x^2 + y^2, x y >= 1, x >= -5: 2 at (1, 1)
HYPERBOLA = program([X, Y, ["multiply", 0, 0], ["multiply", 1, 1], ["add", 2, 3], ["multiply", 0, 1]], [4, 5], 2,
                    ([-5.0, None], [None, None]), [(1.0, None)], [2.0, 1.0], optimum=2.0, optimum_tolerance=1e-6)
# min (x - 1)^2 + (y - 2)^2, 0 <= x perp y >= 0: 1 at (0, 2)
CORNER = program([X, Y, ["constant", 1.0], ["constant", 2.0], ["subtract", 0, 2], ["subtract", 1, 3], ["multiply", 4, 4],
                  ["multiply", 5, 5], ["add", 6, 7]], [8, 0, 1], 2, None, [(0.0, None), (0.0, None)], [1.0, 1.0],
                 complementarity=[[0, 1]], optimum=1.0)
# min max(x - 1, 1 - x) + x^2: 3/4 at 1/2; the derivatives of max are not recorded
KINK = program([X, ["constant", 1.0], ["subtract", 0, 1], ["negate", 2], ["max", 2, 3], ["multiply", 0, 0], ["add", 4, 5]], [6], 1,
               optimum=0.75, start=[0.3])


class Judge(unittest.TestCase):
    def test_slopes_agree_with_differences(self):
        unary = ["negate", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs"]
        binary = ["add", "subtract", "multiply", "divide", "min", "max", "atan2", "hypot", "pow"]
        steps = [X, Y, *([op, 0] for op in unary), *([op, 0, 1] for op in binary), ["subtract", 0, 1]]
        steps += [["select", len(steps) - 1, 0, 1]]
        self.assertEqual({op for op, *_ in steps} - {"input"}, set(nonlinear_judge.RULES))
        count = len(steps) - 2
        data = program(steps, list(range(2, len(steps))), 2, None, [(None, 1.0)] * (count - 1))
        data["linear"], data["variable_costs"] = [[0, 1, 3.0], [0, 1, 0.5]], [[1, 0.7, 0.3]]
        judge, random = nonlinear_judge.NonlinearJudge(data), np.random.default_rng(1)
        for _ in range(5):
            w, lam = random.uniform(0.2, 0.8, 2), random.uniform(-1.0, 1.0, count - 1)

            def lagrangian(at):
                cost, rows, _ = judge.evaluate(at, lam)
                return cost + lam @ rows
            slope = judge.evaluate(w, lam)[2]
            step = 1e-6  # differences are exact to its square and to 1e-16 / step
            for i, unit in enumerate(step * np.eye(2)):
                self.assertAlmostEqual(slope[i], (lagrangian(w + unit) - lagrangian(w - unit)) / (2.0 * step), delta=1e-7)

    def test_only_optima_pass(self):
        judge = nonlinear_judge.NonlinearJudge(HYPERBOLA)
        for adapter in misbehaving_nonlinear.ALL:
            found = judge.judged(adapter.w, adapter.rows, adapter.bounds)
            passes = max(found["kkt"].values()) <= 1e-8
            self.assertEqual(passes, adapter.name in ("knows", "other-optimum"), adapter.name)
        self.assertEqual(judge.judged((1.0, 1.0), (-2.0,), (0.0, 0.0))["objective"], 2.0)

    def test_multipliers_of_bounds_count(self):
        judge = nonlinear_judge.NonlinearJudge(program([X], [0], 1, ([1.0], [None])))
        for z, passes in ((-1.0, True), (0.0, False), (1.0, False)):
            self.assertEqual(max(judge.judged((1.0,), (), (z,))["kkt"].values()) <= 1e-8, passes, z)

    def test_large_multipliers_scale_residuals(self):
        data = copy.deepcopy(HYPERBOLA)
        judge = nonlinear_judge.NonlinearJudge(data)
        self.assertAlmostEqual(judge.judged((1.0, 1.0), (-1e6,), (0.0, 0.0))["kkt"]["stationarity"],
                               (1e6 - 2.0) / (1e6 / 3.0 / 100.0), delta=1e-6)

    def test_pairs_are_judged(self):
        judge = nonlinear_judge.NonlinearJudge(CORNER)
        cases = (((0.0, 2.0), (2.0, 0.0), "solved"), ((1.0, 0.0), (0.0, 4.0), "solved"), ((0.0, 2.0), (2.0, 1.0), "complementarity"),
                 ((0.5, 0.5), (0.0, 0.0), "stationarity"), ((-0.5, 2.0), (3.0, 0.0), "feasibility"),
                 ((0.0, 1.0), (2.0, 0.0), "stationarity"))
        for w, rows, wrong in cases:
            kkt = judge.judged(w, rows, (0.0, 0.0))["kkt"]
            self.assertEqual(max(kkt, key=kkt.get) if max(kkt.values()) > 1e-8 else "solved", wrong, (w, rows))
        self.assertEqual(judge.judged((0.5, 0.7), (0.0, 0.0), (0.0, 0.0))["kkt"]["feasibility"], 0.5)


class Conversion(unittest.TestCase):
    def test_lifted_program_keeps_numbers(self):
        lifted = nonlinear_judge.lifted(CORNER)
        self.assertEqual((lifted["variables"], lifted["rows"], lifted["pairs"]), (4, 3, [[2, 3, 2]]))
        self.assertEqual(CORNER["variables"], 2)
        cost, rows, _ = nonlinear_judge.NonlinearJudge(lifted).evaluate([0.5, 3.0, 0.5, 3.0], np.zeros(3))
        self.assertEqual((cost, list(rows)), (1.25, [0.0, 0.0, 1.5]))

    def test_functions_are_split(self):
        # cost: -(x0 x1) + x1 x2, rows: sin(x0), sin(x2); the parameter is input 3
        steps = [["input", 0], ["input", 1], ["input", 2], ["input", 3], ["multiply", 0, 1], ["multiply", 1, 2], ["negate", 4],
                 ["add", 6, 5], ["multiply", 3, 0], ["sin", 8], ["multiply", 3, 2], ["sin", 10]]
        terms = nosbench._terms(steps, 7)
        self.assertEqual(sorted(terms), [(-1.0, 4), (1.0, 5)])
        functions, blocks = nosbench._blocks(steps, [*((-1, s, t) for s, t in terms), (0, 1.0, 9), (1, 1.0, 11)], 3, [2.0])
        self.assertEqual(len(functions), 2)
        data = {**program([], [], 3, None, [(None, None)] * 2), "functions": functions, "blocks": blocks}
        cost, rows, _ = nonlinear_judge.NonlinearJudge(data).evaluate([0.3, 0.5, 0.7], np.zeros(2))
        self.assertAlmostEqual(cost, -0.15 + 0.35)
        np.testing.assert_allclose(rows, [math.sin(0.6), math.sin(1.4)])


class Runs(OwnFolder):
    def run_on(self, data, solvers, status=0, **environment):
        os.makedirs(self.path("own"), exist_ok=True)
        with open(self.path("own/one.json"), "w", encoding="utf-8") as file:
            json.dump(data, file)
        out = self.path("out.jsonl")
        done = subprocess.run(
            [sys.executable, "-B", os.path.join(SCRIPTS, "bench.py"), "run", "--problems", "own/one", "--solvers", solvers,
             "--repetitions", "1", "--out", out], text=True, capture_output=True, check=False, cwd=self.folder, timeout=120,
            env={**os.environ, "SALTUS_PROGRAM": PROGRAM, "SALTUS_BENCH_PROGRAMS": self.path("own"), **environment})
        self.assertIn(done.returncode, status if isinstance(status, tuple) else (status,), done.stderr)
        if status == 2:
            return done.stderr
        with open(out, encoding="utf-8") as file:
            lines = [json.loads(line) for line in file]
        os.remove(out)
        return {line["solver"]: line for line in lines if "solver" in line}

    def test_ours_solve_programs_in_files(self):
        for data in (HYPERBOLA, CORNER):
            for solver, line in self.run_on(data, "sparse,ipopt").items():
                self.assertEqual(line["verdict"], "solved", (solver, line))
                self.assertAlmostEqual(line["objective"], data["optimum"], delta=1e-6)
                self.assertEqual(line["size"], [2, data["rows"]])

    def test_steps_without_recorded_derivatives(self):
        line = self.run_on(KINK, "ipopt")["ipopt"]
        self.assertEqual(line["verdict"], "solved", line)
        self.assertAlmostEqual(line["objective"], 0.75, delta=1e-6)

    def test_false_answers_are_detected(self):
        folder = self.path("fake")
        os.makedirs(os.path.join(folder, "liars-9.dist-info"))
        with open(os.path.join(folder, "liars-9.dist-info/METADATA"), "w", encoding="utf-8") as file:
            file.write("Metadata-Version: 2.1\nName: liars\nVersion: 9\n")
        with open(os.path.join(folder, "liars-9.dist-info/entry_points.txt"), "w", encoding="utf-8") as file:
            print("[saltus_bench]", *(f"{one.name} = misbehaving_nonlinear:{one.__name__}" for one in misbehaving_nonlinear.ALL),
                  sep="\n", file=file)
        names = [one.name for one in misbehaving_nonlinear.ALL]
        data = copy.deepcopy(HYPERBOLA)
        data["optimum"], data["lower"] = 1.9, [-5.0, None]  # no point reaches it, so a margin of 10 % decides
        data["optimum_tolerance"] = 0.1
        lines = self.run_on(data, ",".join(names), status=(0, 3), PYTHONPATH=os.pathsep.join((folder, HERE)))
        self.assertEqual({name: line["verdict"] for name, line in lines.items()},
                         {name: {"knows": "solved", "other-optimum": "solved", "too-short": "error"}.get(name, "wrong")
                          for name in names})
        data["optimum"], data["optimum_tolerance"] = 1.0, 1e-6
        lines = self.run_on(data, "knows", PYTHONPATH=os.pathsep.join((folder, HERE)))
        self.assertEqual(lines["knows"]["verdict"], "worse optimum")
        self.assertEqual(self.run_on(CORNER, "knows,sparse", PYTHONPATH=os.pathsep.join((folder, HERE))).keys(), {"sparse"})

    def test_invalid_files_give_a_sentence(self):
        for change, sentence in (({"blocks": [{**HYPERBOLA["blocks"][0], "function": 3}]}, "block 0: there is no function 3"),
                                 ({"start": [1.0]}, "'start' must have 2 entries")):
            self.assertIn(sentence, self.run_on({**HYPERBOLA, **change}, "sparse", status=2))
            os.remove(self.path("out.jsonl"))


if __name__ == "__main__":
    unittest.main()
