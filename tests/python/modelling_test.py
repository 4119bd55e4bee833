#!/usr/bin/env python3
"""Problems in Python: formulas, definitions, messages, solves, control loops, exports.

Usage: modelling_test.py BUILD, with the folder python of the build, or `installed` for the installed package.
"""

import copy
import math
import os
import re
import signal
import sys
import threading
import time
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
build = sys.argv.pop(1)
if build != "installed":
    sys.path[:0] = [os.path.join(ROOT, "python"), build]
import numpy as np  # noqa: E402

import saltus as sl  # noqa: E402
from saltus import Phase, exactly  # noqa: E402


def car(name="drive", duration=exactly(1.0)):
    return Phase(name, lambda t, x, u: [x[1], u[0]], duration, nx=2, nu=1)


def ride():
    """A linear-quadratic problem: the optimal cost is 6."""
    drive = car().minimise("effort", lambda t, x, u: 0.5 * u[0] * u[0])
    drive.reach("there", lambda t, x: x, exactly([1.0, 0.0]))
    return sl.OptimalControlProblem("ride").start_at([0, 0]).then(drive)


class Formulas(unittest.TestCase):
    def test_a_hessian_needs_all_weights(self):
        f = sl.make_function(lambda t, x: [x[0] * x[0], x[0]], 1)
        with self.assertRaisesRegex(ValueError, "2 outputs"):
            f.hessian(np.zeros(2), np.zeros(1))

    def test_expressions_of_another_thread_are_refused(self):
        kept = []

        def keep(t, x):
            kept.append(x[0])
            return [x[0]]

        thread = threading.Thread(target=lambda: sl.make_function(keep, 1))
        thread.start()
        thread.join()
        raised = []

        def use():
            try:
                sl.make_function(lambda t, x: [kept[0] + x[0]], 1)
            except Exception as error:
                raised.append(error)

        thread = threading.Thread(target=use)
        thread.start()
        thread.join()
        self.assertEqual(len(raised), 1)

    def assert_formula(self, formula, of_numbers, z, nx, nu=0, np_=0):
        """Compares values with those of numpy, and derivatives with differences."""
        f = sl.make_function(formula, nx, nu, np_)
        z = np.array(z, dtype=float)
        value = np.atleast_1d(np.asarray(of_numbers(z), dtype=float))
        np.testing.assert_allclose(f(z), value, rtol=1e-14, atol=1e-15)
        step = 1e-6  # balances truncation 1e-12 and rounding 1e-10
        for j in range(len(z)):
            dz = np.zeros(len(z))
            dz[j] = step
            np.testing.assert_allclose(f.jacobian(z)[:, j], (f(z + dz) - f(z - dz)) / (2 * step), atol=1e-8)
            weights = 1.0 + np.arange(f.outputs)
            np.testing.assert_allclose(
                f.hessian(z, weights)[:, j],
                weights @ ((f.jacobian(z + dz) - f.jacobian(z - dz)) / (2 * step)), atol=1e-7)

    def test_functions_of_numpy_and_of_saltus(self):
        for name in "sin cos tan sinh cosh tanh exp log sqrt".split():
            f = getattr(np, name)
            self.assert_formula(lambda t, x: f(x[0]) * x[1], lambda z: f(z[1]) * z[2], [0.0, 0.6, 0.7], 2)
            self.assert_formula(lambda t, x: getattr(sl, name)(x), lambda z: f(z[1:]), [0.0, 0.6, 0.7], 2)
        for name in "arcsin arccos arctan".split():
            f = getattr(np, name)
            self.assert_formula(lambda t, x: f(x), lambda z: f(z[1:]), [0.0, 0.6, 0.7], 2)
        for name in "arctan2 hypot minimum maximum".split():
            f = getattr(np, name)
            self.assert_formula(lambda t, x: f(x[0], x[1]), lambda z: f(z[1], z[2]), [0.0, 0.6, 0.7], 2)
            self.assert_formula(lambda t, x: f(x, 0.65), lambda z: f(z[1:], 0.65), [0.0, 0.6, 0.7], 2)

    def test_operators_and_arrays(self):
        matrix = np.array([[1.0, 2.0], [3.0, 4.0]])
        self.assert_formula(lambda t, x, u: matrix @ x + u[0] * np.ones(2), lambda z: matrix @ z[1:3] + z[3],
                            [0.1, 0.2, 0.3, 0.4], 2, 1)
        self.assert_formula(lambda t, x, u, p: [2 - x[0], 1 / x[1] - t, -u[0] ** 2 + x[0] ** 3, p[0] ** x[0], 2.0 ** x[1],
                                                abs(x[0]), x @ x, np.linalg.norm(x), np.float64(2.0) * x[0]],
                            lambda z: [2 - z[1], 1 / z[2] - z[0], -z[3] ** 2 + z[1] ** 3, z[4] ** z[1], 2.0 ** z[2],
                                       abs(z[1]), z[1:3] @ z[1:3], np.linalg.norm(z[1:3]), 2.0 * z[1]],
                            [0.1, 0.2, 0.3, 0.4, 0.5], 2, 1, 1)
        self.assert_formula(lambda t, x: np.cross(x, [1.0, 2.0, 3.0]), lambda z: np.cross(z[1:], [1.0, 2.0, 3.0]),
                            [0.1, 0.2, 0.3, 0.4], 3)
        self.assert_formula(lambda t, x: sl.select(x[0] - 0.5, x[1], sl.norm(x)), lambda z: np.hypot(z[1], z[2]),
                            [0.1, 0.2, 0.3], 2)

    def test_a_formula_is_called_once(self):
        calls = []

        def field(t, x, u):
            calls.append(None)
            return [x[1], u[0]]
        phase = Phase("drive", field, exactly(1.0), nx=2, nu=1)
        phase.minimise("effort", lambda t, x, u: u[0] * u[0]).reach("there", lambda t, x: x[0], exactly(1.0))
        self.assertTrue(sl.solve(sl.OptimalControlProblem().start_at([0, 0]).then(phase)).ok())
        self.assertEqual(len(calls), 1)

    def test_sparsity_is_exact(self):
        f = sl.make_function(lambda t, x, u: [x[1], u[0] * x[0]], 2, 1)
        np.testing.assert_array_equal(f.jacobian_pattern, [[0, 0, 1, 0], [0, 1, 0, 1]])
        self.assertEqual(f.hessian_pattern.sum(), 1)
        self.assertTrue(f.hessian_pattern[3, 1])

    def test_refused_formulas_say_why(self):
        kept = []

        def refused(formula, sentence, error=sl.DefinitionError):
            with self.assertRaisesRegex(error, re.escape(sentence)):
                car().keep("lane", formula, exactly(0.0))
        branch = "it cannot compare its numbers or branch on them"
        refused(lambda t, x: x[0] if x[0] > 0 else 0.0, branch)
        refused(lambda t, x: x[0] if x[0] else 0.0, branch)
        refused(lambda t, x: max(x[0], 0.0), branch)
        refused(lambda t, x: np.floor(x[0]), "numpy.floor", TypeError)
        refused(lambda t, x: math.sin(x[0]), "use numpy.sin or saltus.sin, not math.sin", TypeError)
        refused(lambda t, x: x[2], "phase 'drive', term 'lane': it uses x[2], but there are 2 states, x[0] to x[1]")
        refused(lambda t, x, u: u[1], "it uses u[1], but there is 1 input, u[0]")
        refused(lambda t, x, u, p: p[0], "it uses p[0], but there are no parameters")
        refused(lambda t: t, "it takes 1 arguments, but a formula is called as f(t, x), f(t, x, u) or f(t, x, u, p)")
        refused(lambda t, x: None, "it returns nothing")
        refused(lambda t, x: "x", "it returns str")
        refused(lambda t, x: np.outer(x, x), "it returns a matrix of 2 x 2")
        refused(3.0, "a formula must be callable")
        refused(sl.make_function(lambda t, x: x, 4), "the function has 5 inputs, but (t, x, u, p) has 1 + 2 + 1 + 0 = 4")
        car().keep("keeps", lambda t, x: kept.append(x[0]) or x[0], exactly(0.0))
        refused(lambda t, x: x[0] + kept[0], "a number of another formula is used")
        refused(lambda t, x: 1.0 / 0.0, "division", ZeroDivisionError)


class Definitions(unittest.TestCase):
    def refused(self, define, sentence):
        with self.assertRaisesRegex(sl.DefinitionError, re.escape(sentence)):
            define()

    def test_messages_are_those_of_cpp(self):
        self.refused(lambda: Phase("p", lambda t, x: [x[0]], exactly(1.0), nx=2),
                     "phase 'p', the dynamics: the dynamics must return one row per state; it returns 1 row")
        self.refused(lambda: car().minimise("effort", lambda t, x: x), "a cost must return a scalar")
        self.refused(lambda: car().ends_when("end", lambda t, x: x, sl.Crossing.rising),
                     "a guard must return a scalar, which is zero at the event")
        self.refused(lambda: sl.solve(sl.OptimalControlProblem().start_at([0.0]).then(car())),
                     "the start")
        self.refused(lambda: sl.solve(sl.OptimalControlProblem().start_at([0, 0]).then(
            car().bound_input(1, exactly(0.0)))), "phase 'drive': there is no input 1; the phase has 1, counted from 0")
        twice = car().keep("a", lambda t, x: x[0], sl.at_most(1.0)).keep("a", lambda t, x: x[1], sl.at_most(1.0))
        self.refused(lambda: sl.OptimalControlProblem().start_at([0, 0]).then(twice).validate(),
                     "two terms are called 'a'")
        self.refused(lambda: sl.OptimalControlProblem().then(car(), sl.jump("hit", lambda t, x: x)),
                     "jump 'hit': there is no phase before it")

    def test_unknown_options_are_named(self):
        with self.assertRaisesRegex(TypeError, "there is no option 'intervals_per_fase'; the options are intervals_per"):
            sl.solve(ride(), intervals_per_fase=3)
        with self.assertRaisesRegex(TypeError, "intervals_per_phase: 'many' has the wrong type"):
            sl.solve(ride(), intervals_per_phase="many")

    def test_algebraic_states(self):
        # x' = z, 0 = z + x - u: a linear system with one algebraic state.
        slow = Phase("slow", lambda t, x, z, u: z, exactly(1.0), nx=1, nu=1, nz=1,
                     equations=lambda t, x, z, u: z[0] + x[0] - u[0], guess=[0.0])
        slow.minimise("effort", lambda t, x, z, u: u[0] * u[0] + 0.1 * z[0] * z[0])
        slow.reach("there", lambda t, x: x[0], exactly(1.0)).bound_algebraic(0, sl.between(-5.0, 5.0))
        plan = sl.solve(sl.OptimalControlProblem().start_at([0]).then(slow))
        self.assertTrue(plan.ok(), plan.message)
        t = 0.4
        x, u, z = (f(t) for f in (plan.trajectory.state, plan.trajectory.input, plan.trajectory.algebraic))
        self.assertAlmostEqual(z[0], u[0] - x[0], places=12)
        self.assertEqual(plan.trajectory.samples()["z"].shape, (31, 1))

    def test_inner_events(self):
        # A ball that bounces inside one phase.
        fall = Phase("ball", lambda t, x: [x[1], -9.81], exactly(1.0), nx=2)
        fall.on("bounce", lambda t, x: x[0], sl.Crossing.falling, lambda t, x: [x[0], -0.8 * x[1]])
        fall.minimise_at_end("height", lambda t, x: -x[0]).guess_state(sl.Guess.simulate())
        problem = sl.OptimalControlProblem().start_at([1.0, 0.0]).then(fall)
        plan = sl.solve(problem, intervals_per_phase=10)
        bounce = math.sqrt(2.0 / 9.81)
        after = 1.0 - bounce
        self.assertAlmostEqual(plan.trajectory.final_state[0], 0.8 * 9.81 * bounce * after - 0.5 * 9.81 * after ** 2,
                               places=9)
        # The same with two fields and a surface.
        slide = Phase("slide", lambda t, x: [1.0], exactly(2.0), nx=1)
        slide.switch_at("surface", lambda t, x: x[0] - 0.5, lambda t, x: [2.0])
        slide.minimise_at_end("place", lambda t, x: x[0])
        plan = sl.solve(sl.OptimalControlProblem().start_at([0.0]).then(slide), intervals_per_phase=4)
        self.assertAlmostEqual(plan.trajectory.final_state[0], 0.5 + 2.0 * 1.5, places=9)

    def test_windows_and_schedules(self):
        drive = car().minimise("effort", lambda t, x, u: 0.5 * u[0] * u[0])
        drive.reach("there", lambda t, x: x, exactly([1.0, 0.0]))
        drive.keep("slow", lambda t, x: x[1], sl.at_most(1.0), sl.during("slow zone"))
        drive.bound_input(0, sl.between(-9.0, 9.0), sl.Window(to=sl.event("enter")))
        problem = sl.OptimalControlProblem("zones").start_at([0, 0]).then(drive)
        problem.schedule(sl.Schedule(["free", "slow zone", "free"], [("enter", 0.4), ("leave", 0.6)]))
        plan = sl.solve(problem)
        self.assertTrue(plan.ok(), plan.message)
        self.assertLess(plan.trajectory.state(np.linspace(0.4, 0.6, 21))[:, 1].max(), 1.0 + 1e-5)
        self.assertGreater(plan.cost, 6.0)
        problem.editable_schedule().retime("enter", 0.59)
        self.assertLess(sl.solve(problem).cost, plan.cost)

    def test_copies_are_independent(self):
        problem = ride()
        other = copy.copy(problem).then(car("more"))
        self.assertEqual((problem.phases, other.phases), (["drive"], ["drive", "more"]))


class Solves(unittest.TestCase):
    def setUp(self):
        # The shell may have started this test with SIGINT ignored.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))

    def test_a_known_optimum(self):
        plan = sl.solve(ride(), intervals_per_phase=100)
        self.assertTrue(plan.ok() and bool(plan), plan.message)
        self.assertAlmostEqual(plan.cost, 6.0 / (1.0 - 1e-4), places=7)  # constant inputs: 6 / (1 - 1 / n^2)
        self.assertEqual(plan.costs, {("drive", "effort"): plan.cost})
        self.assertEqual(plan.status, sl.SolveStatus.optimal)
        self.assertIsNotNone(plan.verification)

    def test_solvers_and_integrators_agree(self):
        costs = [sl.solve(ride(), integrator=integrator, solver=solver).cost
                 for integrator in (None, sl.runge_kutta8(), sl.zero_order_hold(), sl.gauss_legendre(stages=2),
                                    sl.cvodes(tolerance=1e-10))
                 for solver in (None, sl.make_native_solver(qp="riccati"), sl.make_ipopt(tolerance=1e-9))]
        np.testing.assert_allclose(costs, costs[0], rtol=1e-8)  # tolerance of the solvers

    def test_results_are_arrays(self):
        plan = sl.solve(ride())
        self.assertEqual(plan.trajectory.state(0.5).shape, (2,))
        self.assertEqual(plan.trajectory.state(np.array([0.1, 0.2, 0.3])).shape, (3, 2))
        samples = plan.trajectory.samples(2)
        self.assertEqual((samples["t"].shape, samples["x"].shape, samples["u"].shape), ((61,), (61, 2), (61, 1)))
        self.assertFalse(plan.start_multipliers.flags.owndata)  # a view of the solution, not a copy
        self.assertIs(type(plan.durations), np.ndarray)

    def test_assignments_leave_earlier_arrays_valid(self):
        point = sl.PrimalDualPoint()
        point.w = np.ones(1000000)
        before = point.w
        point.w = np.zeros(1)
        self.assertEqual(before.sum(), 1e6)

    def test_exports(self):
        plan = sl.solve(ride())
        self.assertIn("optimal", plan._repr_html_())
        self.assertIn("<svg", plan._repr_html_())
        for package, check in (("pandas", lambda: self.assertEqual(list(plan.to_pandas().columns),
                                                                   ["t", "phase", "x0", "x1", "u0"])),
                               ("xarray", lambda: self.assertEqual(plan.to_xarray()["x"].shape, (31, 2)))):
            try:
                __import__(package)
            except ImportError:
                continue
            check()

    def test_warm_starts_and_data(self):
        drive = Phase("drive", lambda t, x, u, p: [x[1], p[0] * u[0]], exactly(1.0), nx=2, nu=1, np=1)
        drive.data("gain", 1.0).minimise("effort", lambda t, x, u: 0.5 * u[0] * u[0])
        drive.reach("there", lambda t, x: x, exactly([1.0, 0.0]))
        shooting = sl.MultipleShooting(sl.OptimalControlProblem().start_at([0, 0]).then(drive))
        solver = sl.make_native_solver()
        first = sl.solve(shooting, solver)
        shooting.set_data("gain", 2.0)
        second = sl.solve(shooting, solver, first.point)
        self.assertAlmostEqual(second.cost, first.cost / 4.0, places=8)
        with self.assertRaisesRegex(sl.DefinitionError, "gain"):
            shooting.set_data("gian", 2.0)

    def test_refinement_check_and_explanation(self):
        refined = sl.solve_refined(ride(), intervals_per_phase=10)
        self.assertTrue(refined.reached, refined.message)
        page = sl.check(ride())
        self.assertTrue(page.ok(), page.text())
        self.assertEqual(page.line("derivatives").verdict, sl.ProblemCheck.Verdict.good)
        drive = car().bound_input(0, sl.between(-1.0, 1.0)).reach("there", lambda t, x: x[0], exactly(1.0))
        why = sl.explain(sl.OptimalControlProblem("far").start_at([0, 0]).then(drive))
        self.assertTrue(why.is_infeasible())
        self.assertAlmostEqual(why.shortages[0].amount, 0.5, places=5)
        self.assertIn("'there'", why.text())

    def test_multipliers(self):
        # The cost is 6 d^2 for the distance d = 1, so d cost / d d = 12; the costates are -12 and 12 t - 6.
        plan = sl.solve(ride(), intervals_per_phase=100)
        times, values = plan.multipliers["drive", "there", 0]
        self.assertEqual((list(times), values.shape), ([1.0], (1,)))
        self.assertAlmostEqual(values[0], 12.0, delta=2e-3)  # constant inputs: 1 / (1 - 1 / n^2)
        times, speed = plan.multipliers["drive", "costate", 1]
        np.testing.assert_allclose(speed, 12.0 * times - 6.0, atol=7e-2)  # h / 2 from the nodes
        np.testing.assert_allclose([plan.multipliers["drive", "costate", i][1][0] for i in range(2)], plan.start_multipliers)
        self.assertEqual(sl.multipliers_csv(plan).splitlines()[0], "t [s],costate 0,costate 1")
        # Units do not matter: the state is in mm and the input in mm/s^2.
        small = Phase("drive", lambda t, x, u: [x[1], u[0]], exactly(1.0), nx=2, nu=1).nominal([1e3, 1e3], 1e3)
        small.minimise("effort", lambda t, x, u: 0.5e-6 * u[0] * u[0]).reach("there", lambda t, x: x, exactly([1e3, 0.0]))
        scaled = sl.solve(sl.OptimalControlProblem().start_at([0, 0]).then(small), intervals_per_phase=100)
        np.testing.assert_allclose(scaled.multipliers["drive", "there", 0][1], 1e-3 * plan.multipliers["drive", "there", 0][1],
                                   rtol=1e-6)

    def test_several_starts(self):
        # The cost (x^2 - 1)^2 at the end has two minima.
        drive = Phase("drive", lambda t, x, u: [u[0]], exactly(1.0), nx=1, nu=1)
        drive.minimise_at_end("wells", lambda t, x: (x[0] ** 2 - 1.0) ** 2 + 0.1 * x[0])
        drive.minimise("effort", lambda t, x, u: 1e-3 * u[0] ** 2)
        problem = sl.OptimalControlProblem("wells").start_at([0.0]).then(drive)
        found = sl.solve_from(problem, [{"inputs": [[1.0]], "states": [sl.Guess.interpolate([0.0], [1.0])]},
                                        sl.SeveralSolutions.Start(inputs=[[-1.0]], states=[[-1.0]]),
                                        dict(inputs=[[-2.0]])], intervals_per_phase=5)
        self.assertTrue(found and found.ok())
        self.assertEqual((len(found.optima), found.optimum_of[0], found.failed), (2, 1, []))
        self.assertEqual(found.optimum_of[1], 0)
        self.assertLess(found.optima[0].cost, found.optima[1].cost)
        self.assertLess(found.optima[0].trajectory.final_state[0], 0.0)
        again = sl.solve_from(problem, [{"trajectory": found.optima[1].trajectory}], intervals_per_phase=5,
                              make_solver=lambda: sl.make_native_solver(tolerance=1e-9))
        self.assertAlmostEqual(again.optima[0].cost, found.optima[1].cost, places=7)
        shared = sl.make_native_solver()
        for make, sentence in ((lambda: shared, "the same solver twice"), (lambda: None, "no solver")):
            with self.assertRaisesRegex(sl.DefinitionError, sentence):
                sl.solve_from(problem, [{}, {}], make_solver=make, threads=1)
        with self.assertRaisesRegex(sl.DefinitionError, "start 0: 2 durations are given, but the problem has 1 phases"):
            sl.solve_from(problem, [{"durations": [1.0, 2.0]}])
        with self.assertRaisesRegex(TypeError, "there is no option 'duration'; the options are durations, states"):
            sl.solve_from(problem, [{"duration": [1.0]}])

        def interrupt():
            signal.raise_signal(signal.SIGINT)
            return sl.make_native_solver()
        with self.assertRaises(KeyboardInterrupt):
            sl.solve_from(problem, [{}] * 3, make_solver=interrupt, threads=1)

    def test_joint_schedules(self):
        legs = [sl.Schedule(["stand", "swing", "stand"], [(f"{side} lifts", lift), (f"{side} lands", lift + 0.3)])
                for side, lift in (("left", 0.1), ("right", 0.6))]
        contacts = sl.JointSchedule(legs, capacity=8)
        self.assertEqual(contacts.parts, 2)
        joint = contacts.join(0.0, 1.0)
        self.assertEqual([name for name, _ in joint.events], ["left lifts", "left lands", "right lifts", "right lands"])
        self.assertEqual([joint.mode_at(t) for t in (0.0, 0.2, 0.5, 0.7)],
                         ["stand stand", "swing stand", "stand stand", "stand swing"])
        contacts.part(0).retime("left lands", 0.35)
        self.assertAlmostEqual(contacts.join(0.0, 1.0).time_of("left lands"), 0.35)
        self.assertAlmostEqual(contacts.joined().time_of("left lands"), 0.35)
        self.assertIsInstance(contacts.during(0, "swing"), sl.Window)
        with self.assertRaisesRegex(sl.DefinitionError, "swing"):
            contacts.during(0, "swings")
        with self.assertRaises(sl.DefinitionError):
            contacts.part(2)

    def test_search_over_modes(self):
        # x' is 1 or -1 over each sample. The optimum starts at 0.5 with a step down and then alternates.
        def graph(*durations):
            modes = sl.ModeGraph("drift")
            for name, speed in (("up", 1.0), ("down", -1.0)):
                phase = Phase(name, lambda t, x, speed=speed: [speed + 0.0 * x[0]], durations[0], nx=1)
                modes.mode(phase.minimise("distance", lambda t, x: x[0] * x[0]).guess_duration(1.0))
            return modes.start_at([0.5])
        best = sl.search(graph(exactly(1.0)).all_transitions(), phases=4)
        self.assertEqual(best.guarantee, sl.SequenceResult.Guarantee.optimal, best.message)
        self.assertEqual(best.sequence, ["down", "up", "down", "up"])
        self.assertEqual(best.modes, [1, 0, 1, 0])
        self.assertAlmostEqual(best.cost, 4.0 / 12.0, places=6)  # int (0.5 - t)^2 over each sample
        self.assertTrue(best and best.found() and best.gap() < 1e-5)
        self.assertLessEqual(best.lower_bound, best.cost + 1e-9)
        self.assertEqual(sl.describe(best.guarantee), "no other sequence costs less, within the requested gap")
        dwelling = sl.search(graph(exactly(1.0)).all_transitions().dwell("down", 2), phases=3)
        self.assertGreater(dwelling.cost, 3.0 / 12.0 + 0.1)
        free = graph(sl.between(0.1, 3.0)).transition("up", "down", sl.jump("hit", lambda t, x: 0.5 * x)).transition("down", "up")
        free.begin_in(["down"]).end_in(["up"]).total_time(exactly(2.0)).enter_at_most("down", 1)
        free.minimise_at_end("place", lambda t, x: x[0] ** 2).validate()
        found = sl.search(free, at_most=2, intervals_per_phase=4)
        self.assertEqual((found.sequence, found.guarantee), (["down", "up"], sl.SequenceResult.Guarantee.enumerated))
        self.assertTrue(found.solution.ok())
        self.assertEqual(free.problem(["down", "up"]).phases, ["down 1", "up 2"])
        crossing = graph(sl.between(0.1, 3.0)).transition_when("down", "up", "floor", lambda t, x: x[0], sl.Crossing.falling)
        crossing.begin_in(["down"]).end_in(["up"]).total_time(exactly(1.0)).reach_at_end("there", lambda t, x: x[0], sl.at_most(9.0))
        down, _ = sl.search(crossing, at_most=2, intervals_per_phase=4).solution.durations
        self.assertAlmostEqual(down, 0.5, places=6)
        for wrong, sentence in ((lambda: sl.search(graph(exactly(1.0)).transition("up", "sideways"), phases=2), "sideways"),
                                (lambda: sl.ModeGraph().transition_when("a", "b", "hit", lambda t, x: x[0], sl.Crossing.falling),
                                 "add mode 'a' before it"),
                                (lambda: sl.ModeGraph().minimise_at_end("end", lambda t, x: x[0]), "add the modes before it"),
                                (lambda: graph(exactly(1.0)).minimise_at_end("end", lambda t, x: [1.0, x[0]]), "must return a scalar")):
            with self.assertRaisesRegex(sl.DefinitionError, sentence):
                wrong()

    def test_observers_and_interrupts(self):
        drive = Phase("drive", lambda t, x, u: [x[1], sl.sin(u[0]) - x[1] ** 2], exactly(1.0), nx=2, nu=1)
        drive.minimise("effort", lambda t, x, u: u[0] ** 2).reach("there", lambda t, x: x[0], exactly(0.2))
        curved, seen = sl.OptimalControlProblem("curved").start_at([0, 0]).then(drive), []
        sl.solve(curved, observer=sl.SolveObserver(report=lambda i: seen.append(i.cost)))
        self.assertGreater(len(seen), 0)
        plan = sl.solve(curved, observer=sl.SolveObserver(should_stop=lambda: True))
        self.assertEqual(plan.status, sl.SolveStatus.interrupted)

        def interrupt(iteration):
            if iteration.number == 1:
                signal.raise_signal(signal.SIGINT)
        with self.assertRaises(KeyboardInterrupt):
            sl.solve(curved, observer=sl.SolveObserver(report=interrupt))

    def test_solves_release_the_interpreter(self):
        slow = ride()
        done, ticks = threading.Event(), [0]

        def count():
            while not done.is_set():
                ticks[0] += 1
                time.sleep(1e-4)
        counter = threading.Thread(target=count)
        counter.start()
        time.sleep(0.01)
        before = ticks[0]
        sl.solve(slow, intervals_per_phase=4000, integrator=sl.runge_kutta8(steps=4))
        during = ticks[0] - before
        done.set()
        counter.join()
        self.assertGreater(during, 20)


class Loops(unittest.TestCase):
    def problem(self):
        drive = car("drive", exactly(1.0)).bound_input(0, sl.between(-20.0, 20.0))
        drive.track("rest", lambda t, x: x, [10.0, 1.0]).track("effort", lambda t, x, u: u, 0.01)
        drive.track_at_end("end", lambda t, x: x, [100.0, 10.0])
        return sl.OptimalControlProblem("brake").start_at([1.0, 0.0]).then(drive)

    def controller(self, **options):
        return sl.RecedingHorizonController(sl.MultipleShooting(self.problem(), intervals_per_phase=20), period=0.05,
                                            **options)

    def test_ticks(self):
        controller = self.controller()
        controller.prepare(0.0)
        tick = controller.feedback([1.0, 0.0])
        self.assertEqual(tick.provenance, sl.Provenance.optimal)
        self.assertLess(tick.u[0], 0.0)
        later = controller.tick(0.05, [0.9, -0.5])
        self.assertEqual((tick.time, later.time), (0.0, 0.05))
        self.assertEqual(controller.statistics.count(sl.Provenance.optimal), 2)
        self.assertTrue(controller.report().ok())

    def test_full_solves(self):
        one = self.controller().tick(0.0, [1.0, 0.0]).u
        other = self.controller(solver=sl.make_native_solver()).tick(0.0, [1.0, 0.0]).u
        np.testing.assert_allclose(one, other, rtol=1e-5)

    def test_closed_loops(self):
        log = sl.simulate_closed_loop(self.controller(), sl.nominal_plant(self.problem(), sl.runge_kutta4()),
                                      duration=2.0)
        self.assertTrue(log.ok(), log.message)
        self.assertLess(abs(log.final_state[0]), 1e-2)
        self.assertEqual(len(log.ticks), 40)
        self.assertEqual(log.recording.samples()["x"].shape[1], 2)
        noisy = sl.simulate_closed_loop(
            self.controller(), sl.nominal_plant(self.problem(), sl.runge_kutta4()), duration=2.0,
            disturbances=sl.Disturbances(measurement_noise=[0.01, 0.01], input=lambda t, x: [0.5]))
        self.assertGreater(np.abs(noisy.final_state - log.final_state).max(), 1e-4)

    def test_own_plants_and_laws(self):
        class Own(sl.LoopPlant):
            def __init__(self):
                super().__init__()
                self.t, self.x = 0.0, np.array([1.0, 0.0])

            def time(self):
                return self.t

            def state(self):
                return self.x

            def inputs(self):
                return 1

            def advance(self, input, length):
                self.x = self.x + length * np.array([self.x[1] + 0.5 * length * input[0], input[0]])
                self.t += length
                return True
        own = Own()
        log = sl.simulate_closed_loop(self.controller(), own, duration=2.0)
        self.assertLess(abs(own.x[0]), 1e-2)
        plant = sl.make_plant(lambda t, x, u: [x[1], u[0]], sl.runge_kutta4(), [1.0, 0.0], nu=1)
        log = sl.simulate_closed_loop(lambda t, x: [-10.0 * x[0] - 5.0 * x[1]], plant, duration=4.0, period=0.01)
        self.assertLess(np.abs(log.final_state).max(), 1e-2)


if __name__ == "__main__":
    unittest.main()
