#!/usr/bin/env python3
"""Checks mixed-integer programs, their judge and the choice of solvers. Needs numpy."""

import importlib.util
import itertools
import json
import os
import sys
import unittest
import unittest.mock

from own_folder import OwnFolder

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../benchmarks/suite/scripts"))
if importlib.util.find_spec("numpy") is None:
    print("skipped: numpy is not installed")
    sys.exit(77)
import data_problems
import integer_problems
import matrix
import numpy as np
import problem_files
import task
from quadratic_program import QuadraticProgram
from task import judged

ROUNDING = 1e-9


def program(problem, seed=1):
    return QuadraticProgram(integer_problems.program("integer/" + problem, seed))


def verdict(qp, w, says_solved=True):
    return task.verdict({**judged(qp, np.asarray(w, dtype=float), None, None), "says_solved": says_solved}, 1e-6)


class Programs(unittest.TestCase):
    def test_optimum_of_the_switched_system_is_the_best_of_all_sequences(self):
        intervals, modes = 5, integer_problems.MODES
        with unittest.mock.patch.multiple(integer_problems, INTERVALS=intervals, DWELL=2):
            qp, count = program("dwell"), 0
            best = np.inf
            for sequence in itertools.product(range(modes), repeat=intervals):
                w = np.zeros(qp.n)
                for k, mode in enumerate(sequence):
                    w[modes * k + mode] = 1.0
                    w[modes * intervals + modes * k + mode] = float(k == 0 or sequence[k - 1] != mode)
                # The rows of the dynamics are sparse and triangular: each ends with its own state.
                first = 2 * modes * intervals
                for i in range(2 * intervals):
                    row = next(r for r in range(qp.m) if qp.row_lower[r] == qp.row_upper[r]
                               and (first + i, -1.0) in self.terms(qp, r))
                    w[first + i] = sum(a * w[v] for v, a in self.terms(qp, row) if v != first + i) - qp.row_lower[row]
                found = judged(qp, w, None, None)
                if max(found["kkt"].values()) <= ROUNDING:
                    count, best = count + 1, min(best, found["objective"])
            changes = itertools.product((0, 1), repeat=intervals - 1)  # 1: the mode changes
            allowed = [s for s in changes if not any(a and b for a, b in zip((1, *s), s))]
            self.assertEqual(count, sum(modes * (modes - 1) ** sum(s) for s in allowed))
            self.assertAlmostEqual(qp.optimum, best, delta=ROUNDING)

    @staticmethod
    def terms(qp, row):
        chosen = np.flatnonzero(qp.jacobian.row == row)
        return list(zip(qp.jacobian.col[chosen], qp.jacobian.value[chosen]))

    def test_optimum_of_the_commitment_is_the_best_of_all_schedules(self):
        for seed in (3, 9):
            self.check_schedules(seed)

    def check_schedules(self, seed):
        with unittest.mock.patch.multiple(integer_problems, PERIODS=4, UNITS=2, LASTS=2):
            qp, units, periods, best = program("commitment", seed), 2, 4, np.inf
            at = {name: units * periods * i for i, name in enumerate(("on", "begins", "ends", "power"))}
            for bits in itertools.product((0.0, 1.0), repeat=units * periods):
                w, on = np.zeros(qp.n), np.reshape(bits, (periods, units))
                before = np.vstack([np.zeros(units), on[:-1]])
                w[:at["begins"]] = on.ravel()
                w[at["begins"]:at["ends"]] = (on > before).ravel()
                w[at["ends"]:at["power"]] = (on < before).ravel()
                for t in range(periods):
                    power = self.dispatch(qp, on[t], t, at["power"])
                    if power is None:
                        break
                    w[at["power"] + units * t:at["power"] + units * (t + 1)] = power
                else:
                    found = judged(qp, w, None, None)
                    if max(found["kkt"].values()) <= ROUNDING:
                        best = min(best, found["objective"])
            self.assertAlmostEqual(qp.optimum, best, delta=ROUNDING)

    def dispatch(self, qp, on, t, first):
        """The cheapest powers of two units. One unit runs at a limit of its range, and the other one covers the rest."""
        units = len(on)
        demand = next(qp.row_lower[r] for r in range(qp.m) if {v for v, _ in self.terms(qp, r)} == {
            first + units * t + u for u in range(units)})
        sides = []
        for u in range(units):
            pair = {first + units * t + u, units * t + u}
            rows = [r for r in range(qp.m) if {v for v, _ in self.terms(qp, r)} == pair]
            sides.append(sorted(on[u] * next(-a for v, a in self.terms(qp, r) if v == units * t + u) for r in rows))
        price, best = qp.gradient[first + units * t:first + units * (t + 1)], None
        for u in range(units):
            for limit in sides[u]:
                power = np.empty(units)
                power[u], power[1 - u] = limit, np.clip(demand - limit, *sides[1 - u])
                if power.sum() >= demand - 1e-12 and (best is None or price @ power < price @ best):
                    best = power
        return best


class Judge(OwnFolder):
    # min -x - y + y^2, x integer in [0, 3], x + y <= 2.5: x = 2, y = 0.5, cost -2.25
    DATA = {"format": "saltus-qp 1", "problem": "own/mixed", "instance": 1, "variables": 2, "rows": 1,
            "hessian": {"row": [1], "col": [1], "value": [2.0]}, "jacobian": {"row": [0, 0], "col": [0, 1], "value": [1.0, 1.0]},
            "gradient": [-1.0, -1.0], "constant": 0.0, "lower": [0.0, None], "upper": [3.0, None], "row_lower": [None],
            "row_upper": [2.5], "stages": [], "integer": [0], "optimum": -2.25}

    def test_only_optima_pass(self):
        qp = QuadraticProgram(self.DATA)
        for w, expected in (((2.0, 0.5), "solved"), ((2.0 + 1e-7, 0.5), "solved"), ((2.0 + 1e-5, 0.5 - 1e-5), "wrong"),
                            ((2.5, 0.0), "wrong"), ((3.0, 0.5), "wrong"), ((1.0, 0.5), "worse optimum"),
                            ((2.0, 0.49), "worse optimum"), ((np.nan, 0.5), "wrong"), ((4.0, -1.5), "wrong")):
            self.assertEqual(verdict(qp, w), expected, w)
        self.assertEqual(verdict(qp, (2.5, 0.0), says_solved=False), "gave up")

    def test_cost_and_feasibility_are_those_of_the_rounded_point(self):
        found = judged(QuadraticProgram(self.DATA), np.array([2.4, 0.1]), None, None)
        self.assertAlmostEqual(found["objective"], -2.0 - 0.1 + 0.01)
        self.assertAlmostEqual(found["kkt"]["integrality"], 0.4)
        self.assertEqual(found["kkt"]["feasibility"], 0.0)

    def test_choice_of_solvers(self):
        os.makedirs(self.path("own"))
        for name, more in (("mixed", {}), ("relaxed", {"optimum_of": "relaxation"})):
            with open(self.path(f"own/{name}.json"), "w", encoding="utf-8") as file:
                json.dump({**self.DATA, **more}, file)
        with unittest.mock.patch.dict(os.environ, SALTUS_BENCH_PROGRAMS=self.path("own")):
            problems = {p["name"]: p for p in data_problems.described()}
            data_problems.write("own/mixed", 1, self.path("a.json"))
            data_problems.write("own/relaxed", 1, self.path("b.json"))
        solvers = {name: [s for s in matrix.solver_names() if matrix.suits(s, problems[name])]
                   for name in ("own/mixed", "own/relaxed", "integer/logic")}
        self.assertEqual(solvers["own/mixed"], ["highs", "scip"])
        self.assertEqual(solvers["integer/logic"], ["highs", "scip"])
        self.assertIn("piqp", solvers["own/relaxed"])
        self.assertIn("sparse", solvers["own/relaxed"])
        self.assertNotIn("scip", solvers["own/relaxed"])
        for path, integer, optimum in (("a.json", [0], -2.25), ("b.json", None, -2.25)):
            with open(self.path(path), encoding="utf-8") as file:
                data = json.load(file)
            self.assertEqual((data.get("integer"), data["optimum"]), (integer, optimum))

    def test_made_programs_are_valid(self):
        for p in integer_problems.described():
            for seed in (1, p["instances"]):
                data = integer_problems.program(p["name"], seed)
                problem_files.validate(data, p["name"])
                self.assertIn("mixed-integer", problem_files.kind_of(data))
                self.assertTrue(np.isfinite(data["optimum"]), p["name"])

    def test_installed_solvers_find_the_optimum_twice(self):
        import peers
        asked = 0
        for adapter in peers.all_peers():
            if not getattr(adapter, "takes_integers", False) or peers.why_missing(adapter):
                continue
            for problem in ("dwell-l1", "commitment", "logic", "logic-l1"):
                qp = program(problem, 2)
                try:
                    solver = adapter(qp, 1e-8)
                except peers.NotApplicable:
                    continue
                first, second = solver.solve(None), solver.solve(None)
                self.assertEqual((verdict(qp, first.w), verdict(qp, second.w)), ("solved", "solved"), f"{adapter.name} on {problem}")
                self.assertEqual(first.iterations, second.iterations, f"{adapter.name} on {problem}")
                asked += 1
        if not asked:
            self.skipTest("no solvers of mixed-integer programs are installed")


if __name__ == "__main__":
    unittest.main()
