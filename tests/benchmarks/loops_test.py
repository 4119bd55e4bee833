#!/usr/bin/env python3
"""Checks the closed loops: programs, plant, cost. Argument: the program saltus-bench. Needs numpy."""

import contextlib
import importlib.util
import os
import subprocess
import sys
import unittest

from own_folder import OwnFolder

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported
PROGRAM = sys.argv.pop(1)
SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../benchmarks/suite/scripts")
sys.path.insert(0, SCRIPTS)
if importlib.util.find_spec("numpy") is None:
    print("skipped: numpy is not installed")
    sys.exit(77)
import figures
import loops
import numpy as np
import peers
import table
import task
from quadratic_program import QuadraticProgram, kkt_residual


def solution(qp):
    """(w, lambda) of a program without active bounds, as a linear system."""
    H, J = np.zeros((qp.n, qp.n)), np.zeros((qp.m, qp.n))
    H[qp.hessian.row, qp.hessian.col], J[qp.jacobian.row, qp.jacobian.col] = qp.hessian.value, qp.jacobian.value
    fixed = np.flatnonzero(qp.lower == qp.upper)
    unit = np.eye(qp.n)[fixed]
    rows = np.vstack([J, unit])
    matrix = np.block([[H, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    found = np.linalg.solve(matrix, np.concatenate([-qp.gradient, qp.row_lower, qp.lower[fixed]]))
    return found[:qp.n], found[qp.n:qp.n + qp.m]


class Linear(peers.Adapter):
    """Solves the program without its bounds, and then clips the inputs."""
    name, factor = "linear", 1.0

    def __init__(self, qp, tolerance):
        self.qp = qp

    def run(self):
        w, rows = solution(self.qp)
        w = self.factor * np.clip(w, self.qp.lower, self.qp.upper)
        self.found = peers.Answer(w, rows, np.zeros(self.qp.n), "done", True, 1)

    def read(self):
        return self.found


class NoInput(Linear):
    name, factor = "no-input", 0.0


class Nothing(Linear):
    name, factor = "nothing", np.nan


class Loops(OwnFolder):
    def loop(self, name, seed=1):
        return loops.Loop("loop/" + name, seed, self.folder)

    def test_programs_have_the_feedback_of_the_infinite_horizon(self):
        for name in ("masses", "pendulum"):
            loop = self.loop(name)
            zeros = tuple(np.zeros(loop.data[key]) for key in ("variables", "rows", "variables"))
            x = 1e-3 * loop.start
            qp = QuadraticProgram(loop.program(x, zeros))
            w, rows = solution(qp)
            gain = np.linalg.solve(loop.R + loop.B.T @ loop.end @ loop.B, loop.B.T @ loop.end @ loop.A)
            np.testing.assert_allclose(w[loop.nx:loop.nx + loop.nu], -gain @ x, atol=1e-9)
            self.assertLess(np.abs(qp.jacobian.times(w)).max(), 1e-9)
            self.assertEqual(qp.stages, [[loop.nx, loop.nu, 0]] * loop.N + [[loop.nx, 0, 0]])
            # The shifted point solves the program of the next predicted state, except for the last stage.
            shifted = loop.shifted((w, rows, np.zeros(qp.n)))
            following = QuadraticProgram(loop.program(shifted[0][:loop.nx], zeros))
            self.assertLess(np.abs(following.jacobian.times(shifted[0])).max(), 1e-9)
            residual = kkt_residual(following, *shifted)
            self.assertLess(residual["feasibility"], 1e-9)
            self.assertLess(np.abs(shifted[0] - solution(following)[0]).max(), 1e-3)

    def cost(self, adapter, name="pendulum"):
        loop = self.loop(name)
        of_task = {"problem": "loop/" + name, "start": "warm", "kind": None}
        run = loops.LoopRun(loop, contextlib.nullcontext, lambda _, qp: task.Peer(adapter, of_task, qp, lambda step: None))
        return run.run(1e-6, "own start", is_timed=False)[0]

    def test_cost_is_that_of_the_plant(self):
        good, bad, nothing = (self.cost(adapter) for adapter in (Linear, NoInput, Nothing))
        self.assertLess(good["objective"], 10.0)
        self.assertGreater(bad["objective"], 100.0 * good["objective"])  # the pendulum falls
        self.assertEqual(nothing["objective"], np.inf)
        self.assertEqual(task.verdict(nothing, 1e-6), "wrong")
        self.assertEqual(task.verdict(bad, 1e-6), "wrong")
        loop, x = self.loop("pendulum"), np.array([0.0, 0.01, 0.0, 0.0])
        np.testing.assert_allclose(loop.following(x, np.zeros(1), 0) - loop.noise[0], loop.A @ x, atol=1e-6)  # cubic in the angle
        self.assertEqual(loop.cost(np.ones(4), np.zeros(1)), 0.5 * np.trace(loop.Q))

    def test_our_solvers_reach_equal_closed_loop_costs(self):
        done = subprocess.run(
            [sys.executable, "-B", os.path.join(SCRIPTS, "bench.py"), "run", "--problems", "loop/pendulum", "--instances", "1",
             "--repetitions", "1", "--solvers", "sparse,riccati,riccati-generic", "--out", self.path("a.jsonl")], text=True,
            capture_output=True, check=False, cwd=self.folder, timeout=200, env={**os.environ, "SALTUS_PROGRAM": PROGRAM})
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = {line["solver"]: line for line in self.lines("a.jsonl") if "solver" in line}
        self.assertEqual({name: line["verdict"] for name, line in lines.items()}, {"sparse": "solved", "riccati-generic": "solved"})
        costs = [line["objective"] for line in lines.values()]
        self.assertAlmostEqual(costs[0], costs[1], delta=1e-6 * costs[0])
        self.assertEqual(lines["sparse"]["setting"], "warm")
        self.assertLess(costs[0], 10.0)
        self.assertIn("loop/pendulum cold: closed-loop cost", done.stdout)
        self.assertIsNotNone(figures.time_of(lines["sparse"]))
        self.assertEqual(table.class_of("loop/pendulum cold", {"loop/pendulum cold": "loop"}), "closed loops")


if __name__ == "__main__":
    unittest.main()
