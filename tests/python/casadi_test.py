#!/usr/bin/env python3
"""Functions of CasADi as formulas: every operation, equal optima, the calls of acados and of Opti.

Usage: casadi_test.py BUILD. Skipped with status 77 if neither this Python nor SALTUS_LOG_PYTHON has CasADi.
"""

import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
try:
    import casadi as ca
except ImportError:
    other = os.environ.pop("SALTUS_LOG_PYTHON", "")
    if other:
        os.execv(other, [other, "-B", *sys.argv])
    print("skipped: this Python has no CasADi (pip install casadi)")
    sys.exit(77)
sys.path[:0] = [os.path.join(ROOT, "python"), sys.argv.pop(1)]
import numpy as np  # noqa: E402

import saltus as sl  # noqa: E402


class Operations(unittest.TestCase):
    def compare(self, expression, t, x, u, z):
        f = ca.Function("f", [t, x, u], [expression])
        made = sl.make_function(f, x.numel(), u.numel())
        all_of = ca.vertcat(t, x, u)
        weights = np.arange(1.0, 1.0 + f.numel_out(0))
        columns = [z[0], z[1:1 + x.numel()], z[1 + x.numel():]]
        jacobian = ca.Function("j", [t, x, u], [ca.jacobian(expression, all_of)])
        hessian = ca.Function("h", [t, x, u], [ca.hessian(ca.dot(ca.DM(weights), expression), all_of)[0]])
        np.testing.assert_allclose(made(z), np.array(f(*columns)).ravel(), rtol=1e-13)
        np.testing.assert_allclose(made.jacobian(z), np.array(jacobian(*columns)), rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(made.hessian(z, weights), np.array(hessian(*columns)), rtol=1e-11, atol=1e-12)

    def test_sx_and_mx(self):
        for kind in (ca.SX, ca.MX):
            t, x, u = kind.sym("t"), kind.sym("x", 3), kind.sym("u", 1)
            a, b, c = x[0], x[1], x[2]
            smooth = ca.vertcat(
                ca.sin(a) * ca.cos(b) + ca.tan(0.3 * c), ca.exp(-a) + ca.log(2 + b) - ca.sqrt(1 + c),
                ca.asin(0.3 * a) + ca.acos(0.2 * b) - ca.atan(c), ca.sinh(a) + ca.cosh(b) * ca.tanh(c),
                ca.asinh(a) + ca.acosh(2 + b) + ca.atanh(0.3 * c), a ** 2 + a ** 3 + b ** 1.5 + (2 + c) ** a,
                ca.atan2(a, b) + ca.hypot(a, c) + t * u[0] / c, ca.fabs(a) + ca.log1p(b) + ca.expm1(c) - 2 * a,
                ca.fmin(a, b) + ca.fmax(b, c))
            self.compare(smooth, t, x, u, np.array([0.3, 0.4, 0.5, 0.6, 0.7]))

    def test_sparse_outputs_and_constants(self):
        t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("u")
        made = sl.make_function(ca.Function("f", [t, x, u], [ca.vertcat(ca.SX(1, 1), 3.0, x[1])]), 2, 1)
        np.testing.assert_allclose(made([0.0, 1.0, 2.0, 3.0]), [0.0, 3.0, 2.0])
        self.assertEqual(made.jacobian_pattern.sum(), 1)

    def test_refusals(self):
        t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("u")
        with self.assertRaisesRegex(sl.DefinitionError, r"'f' has inputs of \[1, 2, 1\] entries, but .* have \[1, 3, 1, 0\]"):
            sl.make_function(ca.Function("f", [t, x, u], [x]), 3, 1)
        with self.assertRaisesRegex(sl.DefinitionError, "uses the operation 'floor'"):
            sl.make_function(ca.Function("f", [t, x, u], [ca.floor(x)]), 2, 1)
        with self.assertRaisesRegex(sl.DefinitionError, "must have one output, a column vector"):
            sl.make_function(ca.Function("f", [t, x, u], [x, u]), 2, 1)
        with self.assertRaisesRegex(sl.DefinitionError, r"give casadi.Function"):
            sl.make_function(lambda t, y: x, 2, 1)


class Generated(unittest.TestCase):
    def test_code_is_loaded(self):
        t, x, u, p = ca.MX.sym("t"), ca.MX.sym("x", 2), ca.MX.sym("u"), ca.MX.sym("p", 2)
        f = ca.Function("pendulum", [t, x, u, p], [ca.vertcat(x[1], (u - p[0] * ca.sin(x[0])) / p[1], t * x[0] ** 3)])
        with tempfile.TemporaryDirectory() as folder:
            code, library = os.path.join(folder, "pendulum.c"), os.path.join(folder, "pendulum.so")
            sl.generate_casadi(f, code)
            subprocess.run(["cc", "-O2", "-fPIC", "-shared", code, "-o", library, "-lm"], check=True)
            loaded = sl.load_casadi(library, "pendulum", 2, 1, 2)
            traced = sl.make_function(f, 2, 1, 2)
            z, weights = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), np.array([1.0, 2.0, 3.0])
            np.testing.assert_allclose(loaded(z), traced(z), rtol=1e-14)
            np.testing.assert_allclose(loaded.jacobian(z), traced.jacobian(z), rtol=1e-13, atol=1e-14)
            np.testing.assert_allclose(loaded.hessian(z, weights), traced.hessian(z, weights), rtol=1e-13, atol=1e-14)
            np.testing.assert_array_equal(loaded.jacobian_pattern, traced.jacobian_pattern)
            np.testing.assert_array_equal(loaded.hessian_pattern, traced.hessian_pattern)
            with self.assertRaisesRegex(sl.DefinitionError, "'pendulum' has 2 entries in input 1, but x has 3"):
                sl.load_casadi(library, "pendulum", 3, 1, 2)


class Moved(unittest.TestCase):
    def test_opti_race_car(self):
        # The minimum-time race car of the examples of Opti: 100 intervals of Runge-Kutta 4, a speed limit.
        n = 100
        opti = ca.Opti()
        X, U, T = opti.variable(2, n + 1), opti.variable(1, n), opti.variable()

        def f(x, u):
            return ca.vertcat(x[1], u - x[1])

        def limit(position):
            return 1 - ca.sin(2 * ca.pi * position) / 2
        opti.minimize(T)
        dt = T / n
        for k in range(n):
            k1 = f(X[:, k], U[:, k])
            k2 = f(X[:, k] + dt / 2 * k1, U[:, k])
            k3 = f(X[:, k] + dt / 2 * k2, U[:, k])
            k4 = f(X[:, k] + dt * k3, U[:, k])
            opti.subject_to(X[:, k + 1] == X[:, k] + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
        opti.subject_to(X[1, :] <= limit(X[0, :]))
        opti.subject_to(opti.bounded(0, U, 1))
        opti.subject_to([X[0, 0] == 0, X[1, 0] == 0, X[0, -1] == 1, T >= 0])
        opti.set_initial(X[1, :], 1)
        opti.set_initial(T, 1)
        opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "tol": 1e-10})
        expected = opti.solve().value(T)

        t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("u")
        race = sl.Phase("race", ca.Function("f", [t, x, u], [f(x, u)]), sl.between(0.1, 10.0), nx=2, nu=1)
        race.keep("speed limit", ca.Function("g", [t, x], [x[1] - limit(x[0])]), sl.at_most(0.0))
        race.bound_input(0, sl.between(0.0, 1.0)).reach("line", ca.Function("e", [t, x], [x[0]]), sl.exactly(1.0))
        race.minimise_at_end("time", ca.Function("c", [t, x], [t])).guess_duration(1.0).guess_state([0.5, 1.0])
        problem = sl.OptimalControlProblem("race car").start_at([0, 0]).then(race)
        plan = sl.solve(problem, intervals_per_phase=n, integrator=sl.runge_kutta4(),
                        solver=sl.make_native_solver(tolerance=1e-10))
        self.assertAlmostEqual(plan.cost, expected, places=7)

    def test_acados_pendulum(self):
        # The pendulum on a cart of the examples of acados: x = (p, theta, v, dtheta), u = F, expressions f_expl_expr.
        M, m, g, l = 1.0, 0.1, 9.81, 0.8
        p, theta, v, dtheta, F = (ca.SX.sym(name) for name in "p theta v dtheta F".split())
        x, u, t = ca.vertcat(p, theta, v, dtheta), F, ca.SX.sym("t")
        denominator = M + m - m * ca.cos(theta) ** 2
        f_expl_expr = ca.vertcat(
            v, dtheta, (-m * l * ca.sin(theta) * dtheta ** 2 + m * g * ca.cos(theta) * ca.sin(theta) + F) / denominator,
            (-m * l * ca.cos(theta) * ca.sin(theta) * dtheta ** 2 + F * ca.cos(theta) + (M + m) * g * ca.sin(theta))
            / (l * denominator))
        n, T = 20, 1.0
        Q, R = np.array([2000.0, 2000.0, 0.02, 0.02]), 0.02
        start, limit = np.array([0.0, 0.5, 0.0, 0.0]), 80.0

        # The same program written for Ipopt, with costs summed at the nodes as in acados.
        opti = ca.Opti()
        X, U = opti.variable(4, n + 1), opti.variable(1, n)
        f = ca.Function("f", [x, u], [f_expl_expr])
        h, cost = T / n, 0
        for k in range(n):
            k1 = f(X[:, k], U[k])
            k2 = f(X[:, k] + h / 2 * k1, U[k])
            k3 = f(X[:, k] + h / 2 * k2, U[k])
            k4 = f(X[:, k] + h * k3, U[k])
            opti.subject_to(X[:, k + 1] == X[:, k] + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
            cost += h * 0.5 * (ca.dot(Q, X[:, k] ** 2) + R * U[k] ** 2)
        cost += 0.5 * ca.dot(Q, X[:, n] ** 2)
        opti.minimize(cost)
        opti.subject_to(opti.bounded(-limit, U, limit))
        opti.subject_to(X[:, 0] == start)
        opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "tol": 1e-10})
        expected = opti.solve().value(cost)

        swing = sl.Phase("swing", ca.Function("f", [t, x, u], [f_expl_expr]), sl.exactly(T), nx=4, nu=1)
        swing.track("state", lambda t, x: x, Q).track("force", lambda t, x, u: u, R).track_at_end("end", lambda t, x: x, Q)
        swing.bound_input(0, sl.between(-limit, limit))
        problem = sl.OptimalControlProblem("pendulum on a cart").start_at(start).then(swing).costs(sl.CostRule.nodes)
        plan = sl.solve(problem, intervals_per_phase=n, integrator=sl.runge_kutta4())
        self.assertTrue(np.isclose(plan.cost, expected, rtol=1e-8), (plan.cost, expected))


if __name__ == "__main__":
    unittest.main()
