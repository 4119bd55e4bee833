"""SCS: a splitting method (ADMM) for quadratic cone programs.

Equality rows go to the zero cone, sides of other rows and of variables to the nonnegative cone. Direct linear solver,
absolute tolerance as requested, relative 0, at most 20,000 iterations. Warm starts take the primal and dual point. The
step size adapts during a solve, so the solver is built again before each one.
"""

import numpy as np

from peers import FIRST_ORDER_ITERATIONS, Adapter, Answer, Cones


class Scs(Adapter):
    name, package = "scs", "scs"
    about = "splitting method (ADMM) for cones, direct linear solver"

    def __init__(self, qp, tolerance):
        import scipy.sparse as sparse
        import scs
        c = self.cones = Cones(qp)
        data = {"P": sparse.triu(c.P, format="csc"), "A": sparse.vstack([c.A, c.G], format="csc"), "b": np.concatenate([c.b, c.h]),
                "c": c.c}
        self.new_solver = lambda: scs.SCS(data, {"z": len(c.b), "l": len(c.h)}, eps_abs=tolerance, eps_rel=0.0,
                                          max_iters=FIRST_ORDER_ITERATIONS, verbose=False)
        self.data, self.reduced = data, c.reduced

    def hand_over(self, start):
        self.solver, self.given = self.new_solver(), {"warm_start": False}
        if start is not None:
            y = np.concatenate(self.cones.duals(start[1], start[2]))
            self.given = {"warm_start": True, "x": start[0], "y": y, "s": self.data["b"] - self.data["A"] @ start[0]}

    def run(self):
        self.result = self.solver.solve(**self.given)

    def read(self):
        r, info = self.result, self.result["info"]
        y = np.array(r["y"], dtype=float)
        equalities = len(self.cones.b)
        return Answer(*self.cones.expand(np.array(r["x"], dtype=float), y[:equalities], y[equalities:]), claimed=info["status"],
                      solved=info["status"] == "solved", iterations=int(info["iter"]), own_us=1e3 * float(info["solve_time"]))
