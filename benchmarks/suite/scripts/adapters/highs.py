"""HiGHS: an active-set method for convex quadratic programs, dual simplex for linear ones.

The package highspy is called through passModel and passHessian, with the lower triangle of the Hessian. Presolve is on,
one thread. Its regularisation of the Hessian (1e-7) is off, because it changes the optimum. Both feasibility tolerances
are the requested one, but at least 1e-10, the smallest that it accepts. A used solver starts at its last optimum, so its
solution is cleared before each solve. It takes no start. Its multipliers of rows and bounds are positive at lower sides,
so their signs are changed. Integer variables are relaxed, as for all solvers.
"""

import numpy as np

from peers import Adapter, Answer, Reduced

SMALLEST = 1e-10


class Highs(Adapter):
    name, package = "highs", "highspy"
    about = "HiGHS, active-set method for convex quadratic programs; no warm start, so cold in both columns"
    takes_start = False

    def __init__(self, qp, tolerance):
        import highspy
        import scipy.sparse as sparse
        r = self.reduced = Reduced(qp)
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
        self.solver = highspy.Highs()
        smallest = max(tolerance, SMALLEST)
        for option, value in (("output_flag", False), ("threads", 1), ("qp_regularization_value", 0.0), ("primal_feasibility_tolerance", smallest),
                              ("dual_feasibility_tolerance", smallest)):
            self.solver.setOptionValue(option, value)
        self.solver.passModel(model)
        self.optimal = highspy.HighsModelStatus.kOptimal

    def hand_over(self, start):
        self.solver.clearSolver()

    def run(self):
        self.solver.run()

    def read(self):
        status, found, info = self.solver.getModelStatus(), self.solver.getSolution(), self.solver.getInfo()
        iterations = max(int(info.qp_iteration_count), 0) + max(int(info.simplex_iteration_count), 0)
        n, m = len(self.reduced.gradient), self.reduced.jacobian.shape[0]
        x, rows, bounds = (np.array(v, dtype=float) if len(v) == count else np.full(count, np.nan)
                           for v, count in ((found.col_value, n), (found.row_dual, m), (found.col_dual, n)))
        return Answer(*self.reduced.expand(x, -rows, -bounds), claimed=self.solver.modelStatusToString(status),
                      solved=status == self.optimal, iterations=iterations)
