"""QOCO: a primal-dual interior-point method for quadratic programs with second-order cones.

Equality rows go to A, sides of other rows and of variables to the nonnegative cone. Absolute tolerance as requested,
relative 0. It takes no start. Its multipliers have the signs of the suite.
"""

import numpy as np

from peers import ITERATIONS, Adapter, Answer, Cones


class Qoco(Adapter):
    name, package = "qoco", "qoco"
    about = "interior point for second-order cones; no warm start, so cold in both columns"
    takes_start = False

    def __init__(self, qp, tolerance):
        import qoco
        import scipy.sparse as sparse
        c = self.cones = Cones(qp)
        equalities, inequalities = len(c.b), len(c.h)
        self.solver = qoco.QOCO()
        self.solver.setup(len(c.c), inequalities, equalities, sparse.triu(c.P, format="csc"), c.c, c.A if equalities else None,
                          c.b if equalities else None, c.G if inequalities else None, c.h if inequalities else None, inequalities,
                          0, np.zeros(0, dtype=int), abstol=tolerance, reltol=0.0, max_iters=ITERATIONS, verbose=False)

    def run(self):
        self.result = self.solver.solve()

    def read(self):
        c, r = self.cones, self.result
        y, z = (np.array(v, dtype=float).ravel() if count else np.zeros(0) for v, count in ((r.y, len(c.b)), (r.z, len(c.h))))
        return Answer(*c.expand(np.array(r.x, dtype=float).ravel(), y, z), claimed=str(r.status),
                      solved=str(r.status) == "QOCO_SOLVED", iterations=int(r.iters), own_us=1e6 * float(r.solve_time_sec))
