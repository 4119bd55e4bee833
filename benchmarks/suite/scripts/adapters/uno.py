"""Uno: methods for nonlinear programs, assembled from building blocks.

The package unopy is called with functions of CasADi (values, sparse Jacobian, lower triangle of the Hessian) in CasADi's
virtual machine; every evaluation passes through Python, which slows it down. Two presets: filtersqp, a trust-region SQP
method with a filter, and ipopt, an interior-point method. Primal and dual tolerance as requested, at most 1000 iterations.
It starts at the guess of the file. With MULTIPLIER_POSITIVE its multipliers have the signs of the suite.
"""

import numpy as np

from nonlinear_peers import ITERATIONS, CasadiNlp
from peers import Answer


class UnoFilterSqp(CasadiNlp):
    name, package, preset = "uno-filtersqp", "unopy", "filtersqp"
    about = "Uno with its preset filtersqp, functions of CasADi called through Python"
    needs = ("numpy", "scipy", "casadi")
    largest = 20000

    def build(self, functions, tolerance):
        import casadi
        import unopy
        file = self.file
        self.unopy = unopy
        model = unopy.Model(unopy.PROBLEM_NONLINEAR, file.n, list(file.lower), list(file.upper), unopy.ZERO_BASED_INDEXING)
        f = functions

        def entries(matrix):
            return np.array(matrix.nonzeros(), dtype=float)

        def objective(x):
            return float(f["nlp_f"](x, []))

        def gradient(x, out):
            out[:] = np.array(casadi.densify(f["nlp_grad_f"](x, [])[1])).ravel()

        def rows(x, out):
            out[:] = np.array(f["nlp_g"](x, [])).ravel()

        def jacobian(x, out):
            out[:] = entries(f["nlp_jac_g"](x, [])[1])

        def hessian(x, sigma, y, out):
            out[:] = entries(f["triangle"](x, [], sigma, y))
        model.set_objective(unopy.MINIMIZE, objective, gradient)
        J, H = f["nlp_jac_g"].sparsity_out(1), f["triangle"].sparsity_out(0)
        if file.m:
            model.set_constraints(file.m, rows, list(file.row_lower), list(file.row_upper), J.nnz(), *map(list, J.get_triplet()),
                                  jacobian)
        row, col = H.get_triplet()
        model.set_lagrangian_hessian(H.nnz(), unopy.UPPER_TRIANGLE, list(row), list(col), hessian)
        model.set_lagrangian_sign_convention(unopy.MULTIPLIER_POSITIVE)
        model.set_initial_primal_iterate(list(map(float, file.start)))
        self.model = model
        self.solver = unopy.UnoSolver()
        self.solver.set_preset(self.preset)
        for option, value in (("logger", "SILENT"), ("primal_tolerance", tolerance), ("dual_tolerance", tolerance),
                              ("max_iterations", ITERATIONS)):
            self.solver.set_option(option, value)

    def run(self):
        self.found = self.solver.optimize(self.model)

    def read(self):
        r = self.found
        bounds = np.array(r.lower_bound_dual_solution) + np.array(r.upper_bound_dual_solution)
        status = str(r.solution_status).split(".")[-1]
        return Answer(np.array(r.primal_solution, dtype=float), np.array(r.constraint_dual_solution, dtype=float), bounds,
                      claimed=status, solved=r.solution_status == self.unopy.FEASIBLE_KKT_POINT,
                      iterations=int(r.number_iterations))


class UnoIpopt(UnoFilterSqp):
    name, preset = "uno-ipopt", "ipopt"
    about = "Uno with its preset ipopt, functions of CasADi called through Python"
