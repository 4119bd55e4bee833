"""Closed loops: predictive controllers whose quadratic program is solved at each tick, on a plant that differs from the
model. The result is the closed-loop cost. The time is the mean per solve.

    loop/masses     four masses between springs, three forces; the plant has softer springs and disturbances
    loop/pendulum   a pendulum on a cart, linearised; the plant is nonlinear, with disturbances

The instance is the seed of start and disturbances. Only inputs have bounds, so each program has a solution. At each tick a
solver is set up again. It is offered the previous solution with its multipliers, shifted by one stage.
"""

import json
import math
import os

import numpy as np

from quadratic_program import FORMAT, QuadraticProgram

PREFIX = "loop/"
TICKS, INSTANCES = 25, 5


def _masses(stiffness):
    """Continuous matrices of four unit masses in a row, between walls."""
    K = stiffness * (2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1))
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-K, -0.05 * np.eye(4)]])
    pulls = np.array([[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, -1.0]])
    return A, np.vstack([np.zeros((4, 3)), pulls])


def _pendulum(x, u):
    """Rates of position, angle and their speeds: cart of 1 kg, bob of 0.3 kg at 0.5 m; the angle 0 is upright."""
    _, angle, speed, rate = x
    m, M, length, g, s, c = 0.3, 1.0, 0.5, 9.81, np.sin(angle), np.cos(angle)
    push = (u[0] + m * length * rate * rate * s - m * g * s * c) / (M + m * s * s)
    return np.array([speed, rate, push, (g * s - push * c) / length])


def _runge_kutta(rate, x, h):
    a = rate(x)
    b = rate(x + 0.5 * h * a)
    c = rate(x + 0.5 * h * b)
    return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + h * c))


def _discrete(rate, nx, nu, h):
    """Linear model of one interval at the origin, by central differences: exact for linear rates."""
    def step(z):
        return _runge_kutta(lambda x: rate(x, z[nx:]), z[:nx], h)
    small = 1e-5
    J = np.array([(step(small * unit) - step(-small * unit)) / (2.0 * small) for unit in np.eye(nx + nu)]).T
    return J[:, :nx], J[:, nx:]


class Loop:
    """A controller and its plant. `program(x, warm)` is the program of a tick. `following(x, u, tick)` is the next state of
    the plant. `folder` contains the files of programs."""

    def __init__(self, problem, seed, folder):
        random = np.random.default_rng(seed)
        if problem == PREFIX + "masses":
            nx, nu, self.N, h, bound = 8, 3, 20, 0.5, 0.4
            model, true = (lambda x, u, m=_masses(k): m[0] @ x + m[1] @ u for k in (1.0, 0.9))
            self.Q, self.R, start, noise = np.eye(nx), 0.1 * np.eye(nu), 1.5, 0.05
        else:
            nx, nu, self.N, h, bound = 4, 1, 30, 0.05, 6.0
            model = true = _pendulum
            self.Q, self.R, start, noise = np.diag([1.0, 4.0, 0.1, 0.1]), 0.01 * np.eye(nu), 0.25, 0.01
        self.nx, self.nu, self.bound = nx, nu, bound
        self.A, self.B = _discrete(model, nx, nu, h)
        self.start, self.noise = start * random.uniform(-1.0, 1.0, nx), noise * random.uniform(-1.0, 1.0, (TICKS, nx))
        self.plant = lambda x, u: _runge_kutta(lambda y: true(y, u), x, h)
        self.end = self.Q  # cost to go without bounds
        for _ in range(1000):
            gain = np.linalg.solve(self.R + self.B.T @ self.end @ self.B, self.B.T @ self.end @ self.A)
            self.end = self.Q + self.A.T @ self.end @ (self.A - self.B @ gain)
        self.problem, self.seed, self.folder = problem, seed, folder
        self.data = self._data()

    def _data(self):
        nx, nu, N = self.nx, self.nu, self.N
        stage, n, m = nx + nu, N * (nx + nu) + nx, N * nx
        H, J = np.zeros((n, n)), np.zeros((m, n))
        lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
        for k in range(N + 1):
            x, u = slice(k * stage, k * stage + nx), slice(k * stage + nx, (k + 1) * stage)
            H[x, x] = self.Q if k < N else self.end
            if k < N:
                H[u, u], lower[u], upper[u] = self.R, -self.bound, self.bound
                rows = slice(k * nx, (k + 1) * nx)
                J[rows, x], J[rows, u], J[rows, (k + 1) * stage:(k + 1) * stage + nx] = self.A, self.B, -np.eye(nx)

        def entries(matrix):
            row, col = np.nonzero(matrix)
            return {"row": row.tolist(), "col": col.tolist(), "value": matrix[row, col].tolist()}
        return {"format": FORMAT, "problem": self.problem, "instance": self.seed, "variables": n, "rows": m,
                "hessian": entries(np.tril(H)), "jacobian": entries(J), "gradient": [0.0] * n, "constant": 0.0,
                "lower": lower, "upper": upper, "row_lower": [0.0] * m, "row_upper": [0.0] * m,
                "stages": [[nx, nu, 0]] * N + [[nx, 0, 0]]}

    def program(self, x, warm):
        """The contents of a file of the format `saltus-qp 1`."""
        lower, upper = self.data["lower"].copy(), self.data["upper"].copy()
        lower[:self.nx] = upper[:self.nx] = x
        sides = {key: [None if np.isinf(v) else float(v) for v in values] for key, values in (("lower", lower), ("upper", upper))}
        return {**self.data, **sides, "warm": {key: part.tolist() for key, part in zip(("w", "lambda", "z"), warm)}}

    def shifted(self, point):
        """A point (w, lambda, z) shifted by one stage. It repeats the last input."""
        w, rows, bounds = point
        stage, nx = self.nx + self.nu, self.nx
        last = slice(-nx - self.nu, -nx)  # the last input
        return (np.concatenate([w[stage:], w[last], self.A @ w[-nx:] + self.B @ w[last]]), np.concatenate([rows[nx:], rows[-nx:]]),
                np.concatenate([bounds[stage:], bounds[last], np.zeros(nx)]))

    def following(self, x, u, tick):
        return self.plant(x, np.clip(u, -self.bound, self.bound)) + self.noise[tick]

    def cost(self, x, u):
        return float(0.5 * (x @ self.Q @ x + u @ self.R @ u))


def described():
    about = {"masses": "closed loop: masses between springs", "pendulum": "closed loop: a pendulum on a cart"}
    return [{"name": PREFIX + name, "about": text, "instances": INSTANCES, "horizon": {"masses": 20, "pendulum": 30}[name],
             "warm": False, "kind": "loop", "on_request": True} for name, text in about.items()]


class LoopRun:
    """One solver in one closed loop, with the interface of task.Peer. `solver_of(own, qp)` is the solver of one tick, and
    `begin_loop()` is a context manager that returns `own`."""

    def __init__(self, loop, begin_loop, solver_of):
        self.loop, self.begin_loop, self.solver_of = loop, begin_loop, solver_of
        self.zeros = np.zeros(loop.data["variables"]), np.zeros(loop.data["rows"]), np.zeros(loop.data["variables"])
        with begin_loop() as own:
            one = self._at_tick(own, 0, loop.start, self.zeros)
        self.qp, self.settings, self.ladder = one.qp, one.settings, one.ladder

    def _at_tick(self, own, tick, x, warm):
        data = self.loop.program(x, warm)
        qp = QuadraticProgram(data)
        qp.file, qp.instance = os.path.join(self.loop.folder, f"tick-{tick}.json"), self.loop.seed
        with open(qp.file, "w", encoding="utf-8") as file:
            json.dump(data, file)
        return self.solver_of(own, qp)

    def begin(self, tolerance, setting):
        with self.begin_loop() as own:
            return self._at_tick(own, 0, self.loop.start, self.zeros).begin(tolerance, setting)

    def run(self, tolerance, setting, is_timed=True):
        """The closed-loop cost with the worst residuals of all ticks, and the mean time per solve."""
        loop, x, warm, cost = self.loop, self.loop.start, self.zeros, 0.0
        worst, iterations, solved, spent = {}, 0, True, {"wall_us": 0.0, "cpu_us": 0.0}
        with self.begin_loop() as own:
            for tick in range(TICKS):
                one = self._at_tick(own, tick, x, warm)
                answer, times = one.run(tolerance, setting, is_timed)
                worst = {key: max(value, worst.get(key, 0.0)) for key, value in answer["kkt"].items()}
                iterations, solved = iterations + answer["iterations"], solved and answer["says_solved"]
                spent = {key: spent[key] + times[key] / TICKS for key in spent}
                u = one.point[0][loop.nx:loop.nx + loop.nu]
                cost += loop.cost(x, u)
                x, warm = loop.following(x, u, tick), loop.shifted(one.point)
                if not np.isfinite(cost) or not all(np.isfinite(part).all() for part in (x, *warm)):
                    worst, cost = {**worst, "feasibility": math.inf}, math.inf
                    break
        return {"objective": cost, "kkt": worst, "claimed": answer["claimed"], "says_solved": solved,
                "iterations": iterations}, {**spent, "own_us": None}
