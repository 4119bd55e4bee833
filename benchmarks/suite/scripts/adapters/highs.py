"""HiGHS: an active-set method for convex quadratic programs, dual simplex for linear ones.

The package highspy is called through passModel and passHessian, with the lower triangle of the Hessian. Presolve is on,
one thread. Its regularisation of the Hessian (1e-7) is off, because it changes the optimum. Both feasibility tolerances
are the requested one, but at least 1e-10, the smallest that it accepts. A used solver starts at its last optimum, so its
solution is cleared before each solve. It takes no start. Its multipliers of rows and bounds are positive at lower sides,
so their signs are changed. Mixed-integer programs with linear costs are solved by branch and cut with both gaps 0, so that
HiGHS proves the optimum; it has no method for quadratic ones.
"""

import numpy as np

from peers import Adapter, Answer, NotApplicable, Reduced
from quadratic_program import Whole

SMALLEST = 1e-10


class Highs(Adapter):
    name, package = "highs", "highspy"
    about = "HiGHS, active-set method for convex quadratic programs; no warm start, so cold in both columns"
    takes_start, takes_integers = False, True

    def __init__(self, qp, tolerance):
        import highspy
        import scipy.sparse as sparse
        self.qp, self.is_integer = qp, len(qp.integer) > 0
        if self.is_integer and np.any(qp.hessian.value):
            raise NotApplicable("it has no method for mixed-integer programs with quadratic costs")
        r = Whole(qp) if self.is_integer else Reduced(qp)
        if not self.is_integer:
            self.reduced = r
        n, m = len(r.gradient), r.jacobian.shape[0]
        J, H = sparse.csc_matrix(r.jacobian), sparse.tril(r.hessian, format="csc")
        model = highspy.HighsModel()
        lp = model.lp_
        lp.num_col_, lp.num_row_ = n, m
        lp.col_cost_, lp.col_lower_, lp.col_upper_ = r.gradient, r.lower, r.upper
        lp.row_lower_, lp.row_upper_ = r.row_lower, r.row_upper
        lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = J.indptr, J.indices, J.data
        if H.nnz:
            model.hessian_.dim_, model.hessian_.format_ = n, highspy.HessianFormat.kTriangular
            model.hessian_.start_, model.hessian_.index_, model.hessian_.value_ = H.indptr, H.indices, H.data
        if self.is_integer:
            lp.integrality_ = [highspy.HighsVarType.kInteger if i in set(qp.integer.tolist()) else highspy.HighsVarType.kContinuous
                               for i in range(n)]
        self.solver = highspy.Highs()
        smallest = max(tolerance, SMALLEST)
        for option, value in (("output_flag", False), ("threads", 1), ("qp_regularization_value", 0.0), ("mip_rel_gap", 0.0),
                              ("mip_abs_gap", 0.0), *((f"{kind}_feasibility_tolerance", smallest) for kind in ("primal", "dual", "mip"))):
            self.solver.setOptionValue(option, value)
        self.solver.passModel(model)
        self.optimal = highspy.HighsModelStatus.kOptimal

    def hand_over(self, start):
        self.solver.clearSolver()

    def run(self):
        self.solver.run()

    def read(self):
        status, found, info = self.solver.getModelStatus(), self.solver.getSolution(), self.solver.getInfo()
        if self.is_integer:
            w = np.array(found.col_value, dtype=float) if len(found.col_value) == self.qp.n else np.full(self.qp.n, np.nan)
            return Answer(w, np.zeros(self.qp.m), np.zeros(self.qp.n), claimed=self.solver.modelStatusToString(status),
                          solved=status == self.optimal, iterations=max(int(info.mip_node_count), 0))
        iterations = max(int(info.qp_iteration_count), 0) + max(int(info.simplex_iteration_count), 0)
        n, m = len(self.reduced.gradient), self.reduced.jacobian.shape[0]
        x, rows, bounds = (np.array(v, dtype=float) if len(v) == count else np.full(count, np.nan)
                           for v, count in ((found.col_value, n), (found.row_dual, m), (found.col_dual, n)))
        return Answer(*self.reduced.expand(x, -rows, -bounds), claimed=self.solver.modelStatusToString(status),
                      solved=status == self.optimal, iterations=iterations)
