#!/usr/bin/env python3
"""Checks the readers of problem files and `bench fetch` on small files made here. Needs numpy."""

import contextlib
import importlib.util
import io
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
import bench
import control_problem
import data_problems
import problem_files
import public_sets

QPS = """NAME SMALL
ROWS
 N  COST
 G  LOW
 E  SUM
COLUMNS
    X  COST  1.0  LOW  1.0
    X  SUM  1.0
    Y  LOW  -1.0  SUM  1.0
RHS
    RHS  COST  -4.0  SUM  2.0
RANGES
    RNG  LOW  3.0
BOUNDS
 UP BND  X  5.0
 MI BND  Y
QUADOBJ
    X  X  2.0
    X  Y  1.0
ENDATA
"""


class Files(OwnFolder):
    def written(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text if isinstance(text, str) else json.dumps(text))
        return self.path(name)

    def test_qps_is_read(self):
        program = problem_files.read(self.written("SMALL.QPS", QPS))
        problem_files.validate(program, "SMALL")
        self.assertEqual([program[k] for k in ("lower", "upper", "row_lower", "row_upper", "constant", "gradient")],
                         [[0.0, None], [5.0, None], [0.0, 2.0], [3.0, 2.0], 4.0, [1.0, 0.0]])
        self.assertEqual(program["hessian"], {"row": [0, 1], "col": [0, 0], "value": [2.0, 1.0]})
        with self.assertRaisesRegex(ValueError, "line 9: the section COLUMNS has an invalid entry"):
            problem_files.read(self.written("BAD.QPS", QPS.replace("SUM  1.0\nRHS", "SUM  one\nRHS")))

    def test_statements_are_valid_and_counted(self):
        out = io.StringIO()
        self.assertEqual(problem_files.check([data_problems.STATEMENTS], out, brief=True), 0)
        self.assertIn("2 optimal control of a DAE", out.getvalue())

    def test_mistakes_give_a_sentence(self):
        with open(os.path.join(data_problems.STATEMENTS, "catalyst_mixing.json"), encoding="utf-8") as file:
            text = file.read()
        for old, new, sentence in (("10*x2", "10*x3", "'x3' is not defined"), ("saltus-ocp 1", "other", "the format is 'other'"),
                                   ("u*(10", "u.real*(10", "not part of an expression"), ('"u*(10*x2 - x1)", ', "", "one expression per state")):
            with self.assertRaisesRegex(problem_files.FileError, sentence):
                problem_files.validate(json.loads(text.replace(old, new)), "file")

    def test_collocation_is_exact_for_polynomials(self):
        program = control_problem.ControlProblem({"format": "saltus-ocp 1", "phases": [{
            "time": [0, 2], "states": [{"name": "x", "start": 0}], "dynamics": ["3*t**2"], "integral": "t**4",
            "intervals": 1}],
            "objective": "final(x)"}).program()
        x, function = [0.0] + [(2 * c) ** 3 for c in control_problem.POINTS], program["functions"][0]
        rows, cost = [0.0] * program["rows"], 0.0
        for row, variable, factor in program["linear"]:
            rows[row] += factor * x[variable]
        for block in program["blocks"][:3]:
            arguments = [c + sum(f * x[v] for v, f in pairs) for c, pairs in zip(block["constants"], block["coefficients"])]
            for (row, factor), value in zip(block["outputs"], control_problem.evaluate(function, arguments)):
                if row >= 0:
                    rows[row] += factor * value
                else:
                    cost += factor * value
        self.assertLess(max(map(abs, rows)), 1e-12)
        self.assertAlmostEqual(cost, 2 ** 5 / 5, places=12)

    SHOT = {"format": "saltus-ocp 1", "definitions": {"slope": "3*t**2 + u"}, "phases": [{
        "time": [0, 2], "states": [{"name": "x", "start": 1, "end": 9}, {"name": "y", "start": 0}], "inputs": [{"name": "u"}],
        "dynamics": ["slope", "x"], "integral": "t**3", "intervals": 2}], "objective": "final(y)"}

    def test_steps_of_runge_kutta(self):
        """x = 1 + t^3 + u t, and y is its integral. The method is exact except for the fourth power of t in y."""
        program = control_problem.ControlProblem(self.SHOT).program(is_shooting=True)
        problem_files.validate(program, "shot")
        self.assertEqual((program["variables"], program["rows"]), (8, 7))
        x, y, u = [1.0, 2.5, 10.0], [0.0], [0.5, 0.5]
        w, cost = [x[0], y[0]], 0.0
        for k, block in enumerate(program["blocks"][:2]):
            arguments = [*w[-2:], u[k], *block["constants"][3:]]
            *following, integral = control_problem.evaluate(program["functions"][0], arguments)
            self.assertAlmostEqual(following[0], x[k + 1], places=12)
            self.assertAlmostEqual(following[1] - w[-1], x[k] + u[k] / 2.0 + (3 * k * k / 2.0 + k + 0.25), delta=0.01)
            w += [u[k], *following]
            cost += integral
        self.assertAlmostEqual(cost, 2 ** 4 / 4, places=12)
        rows = [0.0] * program["rows"]
        for row, variable, factor in program["linear"]:
            rows[row] += factor * w[variable]
        self.assertEqual([rows[r] - program["row_lower"][r] for r in (0, 1, 6)], [0.0, 0.0, 1.0])  # start and end are rows

    def test_shot_programs_have_stages(self):
        import fatrop
        from nonlinear_program import NonlinearFile
        stages = fatrop.Stages(NonlinearFile(control_problem.ControlProblem(self.SHOT).program(is_shooting=True)))
        self.assertEqual(stages.sizes, [[0, 3, 2], [2, 1, 0], [2, 0, 1]])
        self.assertEqual(stages.order, [2, 3, 0, 1, 4, 5, 6])
        with self.assertRaisesRegex(fatrop.NotApplicable, "stages"):
            fatrop.Stages(NonlinearFile(control_problem.ControlProblem(self.SHOT).program()))
        with self.assertRaisesRegex(control_problem.Mistake, "shooting needs one phase"):
            control_problem.ControlProblem({**self.SHOT, "parameters": [{"name": "p"}]}).program(is_shooting=True)
        names = [p["name"] for p in data_problems.described() if p["name"].startswith("shooting/")]
        self.assertIn("shooting/catalyst_mixing", names)
        self.assertNotIn("shooting/brachistochrone", names)

    def test_fetch_copies_verifies_and_resumes(self):
        os.makedirs(self.path("source/data"))
        for name in ("ONE", "TWO"):
            self.written(f"source/data/{name}.npz", name)
        listing = [(f"data/{name}.npz", public_sets.blob_name(name.encode())) for name in ("ONE", "TWO")]
        small = public_sets.PublicSet("small", "a/b", "0" * 40, ("data/*.npz",), "none", 2, 1, public_sets.digest_of(listing))
        with unittest.mock.patch.dict(public_sets.SETS, {"small": small}):
            out = io.StringIO()
            public_sets.fetch("small", self.path("source"), 60, out)
            self.assertIn("2 of 2 files", out.getvalue())
            self.assertIn("2 of them new; verified", out.getvalue())
            os.remove(public_sets.files_of("small")["ONE"])
            public_sets.fetch("small", self.path("source"), 60, out)
            self.assertIn("1 of them new", out.getvalue())
            self.written("source/data/TWO.npz", "changed")
            public_sets.fetch("small", self.path("source"), 60, out)
            self.assertIn("not verified", out.getvalue())

    def test_missing_network_has_its_own_status(self):
        with contextlib.redirect_stderr(io.StringIO()) as told, contextlib.redirect_stdout(io.StringIO()), \
                unittest.mock.patch.dict(os.environ, {public_sets.SERVERS_VARIABLE: "http://127.0.0.1:9"}):
            self.assertEqual(bench.main(["fetch", "mpc"]), 5)
        self.assertRegex(told.getvalue(), "no network: 127.0.0.1:9 cannot be reached .* --from FOLDER")

    def test_long_horizon_is_a_program_in_stages(self):
        program = data_problems._box("box/4x1x100", 4, 1, 1, 100)
        problem_files.validate(program, "box")
        self.assertEqual(len(program["stages"]), 101)


if __name__ == "__main__":
    unittest.main()
