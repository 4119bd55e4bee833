"""crocoddyl and mim-solvers: solvers of trajectories on action models, here linear with quadratic costs.

Both keep penalties and regularisation between solves, so each solve uses a new solver. It is constructed outside of the
measured time, from models that are constructed once.
"""


import numpy as np

from peers import Adapter, Answer, NotApplicable
from trajectories import Trajectory

ITERATIONS = 20  # programs of a sequence; of a quadratic program the first suffices
PROGRAM_ITERATIONS = 4000


class _Crocoddyl(Adapter):
    constrains_inputs_only = False

    def __init__(self, qp, tolerance):
        import crocoddyl
        t = self.trajectory = Trajectory(qp)
        self.tolerance = tolerance
        if self.constrains_inputs_only and any(len(low) > len(s.bounded_u) for s, (_, _, low, _) in zip(t.stages, t.rows)):
            raise NotApplicable("it has constraints other than bounds of inputs")
        models = [self._model(crocoddyl, s, *rows) for s, rows in zip(t.stages, t.rows)]
        self.problem = crocoddyl.ShootingProblem(t.start, models[:-1], models[-1])
        self.problem.nthreads = 1  # more threads wait for each other by spinning

    def _model(self, crocoddyl, s, C, D, low, high):
        nx, nu = int(s.nx), int(s.nu)
        is_last = len(s.A) == 0
        if self.constrains_inputs_only:
            C, D = C[:0], D[:0]
        A, B, b = (np.eye(nx), np.zeros((nx, nu)), np.zeros(nx)) if is_last else (s.A, s.B, s.b)
        model = crocoddyl.ActionModelLQR(A, B, s.Q, s.R, s.S.T.copy(), np.hstack([C, D]), np.zeros((0, nx + nu)), b, s.q, s.r,
                                         np.zeros(len(C)), np.zeros(0))
        if len(C):
            model.g_lb, model.g_ub = low, high
        elif len(low):
            sides = np.full(nu, -np.inf), np.full(nu, np.inf)
            sides[0][s.bounded_u], sides[1][s.bounded_u] = low, high
            model.u_lb, model.u_ub = sides
        return model

    def hand_over(self, start):
        self.solver = self.new_solver()
        self.start = self.trajectory.split(None if start is None else start[0])

    def run(self):
        self.found = self.solver.solve(*self.start, ITERATIONS, False)


class MimCsqp(_Crocoddyl):
    name, package = "mim-csqp", "mim-solvers"
    about = "sequential programs by ADMM in stages on crocoddyl's linear-quadratic action models; warm from states and inputs"
    module = "crocoddyl"  # first, because mim_solvers finds its libraries only next to it
    needs = ("scipy.sparse", "mim_solvers")

    def new_solver(self):
        import mim_solvers
        solver = mim_solvers.SolverCSQP(self.problem)
        solver.termination_tolerance = self.tolerance
        solver.eps_abs, solver.eps_rel, solver.max_qp_iters = 0.1 * self.tolerance, 0.0, PROGRAM_ITERATIONS
        # With its defaults (1e-6, kept, every 25) it ends at 1e-7 to 1e-6 (see measured.md).
        solver.sigma, solver.remove_reg, solver.rho_update_interval = 1e-10, True, 100
        return solver

    def read(self):
        t, solver = self.trajectory, self.solver
        w = t.joined(solver.xs.tolist(), solver.us.tolist())
        return Answer(w, *t.joined_multipliers(w, solver.lag_mul.tolist(), solver.y.tolist()),
                      claimed=f"KKT {solver.KKT:.1e}", solved=bool(self.found), iterations=int(solver.qp_iters))


class CrocoddylBoxFddp(_Crocoddyl):
    name, package = "crocoddyl-boxfddp", "crocoddyl"
    about = ("BoxFDDP; it supports only bounds of inputs and returns no multipliers, so they are computed from its "
             "point, in its favour; "
             "warm from states and inputs")
    ladder = (1.0, 1e-4, 1e-8)  # its criterion is the square of a gradient
    constrains_inputs_only = True
    near = 1e-9  # distance to a bound that counts as active

    def new_solver(self):
        import crocoddyl
        solver = crocoddyl.SolverBoxFDDP(self.problem)
        solver.th_stop = self.tolerance
        return solver

    def read(self):
        t, solver = self.trajectory, self.solver
        w = t.joined(solver.xs.tolist(), solver.us.tolist())
        return Answer(w, *self.multipliers(w), claimed=f"stop {solver.stop:.1e}", solved=bool(self.found), iterations=int(solver.iter))

    def multipliers(self, w):
        """Multipliers of a point. Costates follow backwards from zero slopes along the states; input bounds receive the
        remaining slope."""
        t, qp = self.trajectory, self.trajectory.qp
        slope = qp.hessian.times(w) + qp.gradient
        rows, bounds = np.zeros(qp.m), np.zeros(qp.n)
        after = t.stages[-1]
        costate = slope[after.x]
        for s in reversed(t.stages[:-1]):
            rows[s.dynamics] = costate
            places = s.u.start + s.bounded_u
            left = slope[places] + s.B.T[s.bounded_u] @ costate
            distance = np.where(left < 0.0, s.u_high - w[places], w[places] - s.u_low)
            bounds[places] = np.where(distance <= self.near, -left, 0.0)
            costate = slope[s.x] + s.A.T @ costate
        bounds[:t.nx] = -costate
        return rows, bounds
