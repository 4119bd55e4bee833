"""acados: sequential quadratic programming with HPIPM, from code that acados generates for the problem.

The Python interface of the package comma-deps-acados is used, with the casadi of the other peers. Dynamics are DISCRETE: the
steps of the program, so acados solves the same program as the others. Costs are EXTERNAL with a time step of 1, because
acados multiplies costs by the time step. Settings: exact Hessian, convexified (CONVEXIFY), merit function with line search,
partial condensing with HPIPM, at most 1000 iterations. A given start and given end values become bounds. Code is
generated and compiled once per problem, at set-up. Each solve starts from the guess of the file and zero multipliers. The
libraries are built for Haswell, so they are slower than acados built for the processor.
"""

import ctypes
import os
import sys
import tempfile

import numpy as np

from front_ends import Intervals
from nonlinear_peers import ITERATIONS
from peers import Adapter, Answer, NotApplicable

FOLDER = os.path.join(sys.prefix, "acados")  # see bench.install_peers()
BIG = 1e6  # the missing bound of a variable with one bound; HPIPM does not converge with larger values


def interface():
    """The module acados_template. The casadi in its folder is for another version of Python and is never imported."""
    home = os.path.join(FOLDER, "acados", "install")
    os.environ.update(ACADOS_SOURCE_DIR=home, TERA_PATH=os.path.join(home, "bin", "t_renderer"),
                      ACADOS_PYTHON_INTERFACE_PATH=os.path.join(FOLDER, "acados", "acados_template"))
    import casadi  # noqa: F401
    if FOLDER not in sys.path:
        sys.path.append(FOLDER)
    from acados import acados_template
    for name in ("libblasfeo.so", "libhpipm.so", "libqpOASES_e.so.3.1"):  # found by name afterwards
        ctypes.CDLL(os.path.join(home, "lib", name), ctypes.RTLD_GLOBAL)
    return acados_template


class AcadosSqp(Adapter):
    name, package = "acados-sqp", "comma-deps-acados"
    about = "acados' SQP with HPIPM, generated C code; its libraries are built for Haswell"
    module, needs, takes_files = "casadi", ("numpy", "scipy", "casadi"), True
    largest, regularisation, globalisation = 20000, "CONVEXIFY", "MERIT_BACKTRACKING"

    def __init__(self, file, tolerance):
        if file.n > self.largest:
            raise NotApplicable(f"more than {self.largest} variables")
        if file.pairs:
            raise NotApplicable("it does not reduce the products of complementarity pairs")
        if getattr(file, "acados", None) is None:
            file.acados = self._generated(file)
        self.file, (self.intervals, self.solver) = file, file.acados
        for option in ("tol_stat", "tol_eq", "tol_ineq", "tol_comp"):
            self.solver.options_set(option, tolerance)
        self.solver.options_set("qp_tol_stat", 0.1 * tolerance)
        for option in ("qp_tol_eq", "qp_tol_ineq", "qp_tol_comp"):
            self.solver.options_set(option, 0.1 * tolerance)

    def _generated(self, file):
        import casadi as ca
        it, template = Intervals(file, more=True), interface()
        nx, nu, N = it.nx, it.nu, it.N
        x, u, p = ca.SX.sym("x", nx), ca.SX.sym("u", nu), ca.SX.sym("p", len(it.varies))
        ocp, model = template.AcadosOcp(), template.AcadosModel()
        model.name, model.x, model.u, model.p = "problem", x, u, p
        model.disc_dyn_expr, model.cost_expr_ext_cost = it.step(x, u, p)
        model.cost_expr_ext_cost_e = it.end_cost(x) if it.end_cost else ca.SX(0)
        ocp.model, ocp.dims.N, ocp.parameter_values = model, N, np.zeros(len(it.varies))
        ocp.cost.cost_type = ocp.cost.cost_type_e = "EXTERNAL"
        c = ocp.constraints
        self._bounds(it, file)
        c.x0 = it.start
        c.idxbu, c.lbu, c.ubu = it.of_inputs
        c.idxbx, c.lbx, c.ubx = it.of_states
        c.idxbx_e, c.lbx_e, c.ubx_e = it.of_end
        o = ocp.solver_options
        o.tf, o.integrator_type, o.nlp_solver_type, o.qp_solver = float(N), "DISCRETE", "SQP", "PARTIAL_CONDENSING_HPIPM"
        o.hessian_approx, o.regularize_method, o.globalization = "EXACT", self.regularisation, self.globalisation
        o.nlp_solver_max_iter, o.qp_solver_iter_max, o.print_level = ITERATIONS, 200, 0
        folder = it.folder = tempfile.TemporaryDirectory(prefix="saltus-acados-")
        ocp.code_export_directory = os.path.join(folder.name, "code")
        here = os.getcwd()
        try:
            solver = template.AcadosOcpSolver(ocp, json_file=os.path.join(folder.name, "ocp.json"), verbose=False)
        finally:
            os.chdir(here)
        for k in range(N):
            if len(it.varies):
                solver.set(k, "p", it.numbers[k])
        return it, solver

    @staticmethod
    def _bounds(it, file):
        states, last = slice(it.states[1, 0], it.states[1, 0] + it.nx), it.states[-1]
        for k in range(1, it.N):
            if (file.lower[it.states[k]] != file.lower[states]).any() or (file.upper[it.states[k]] != file.upper[states]).any():
                raise NotApplicable("bounds of states vary between stages")
        end = [file.lower[last].copy(), file.upper[last].copy()]
        for _, i, value, _ in it.end_rows:
            end[0][i] = end[1][i] = value

        def bounded(low, high):
            """(indices, lower, upper) of the variables with a bound."""
            some = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
            return some, np.maximum(low[some], -BIG), np.minimum(high[some], BIG)
        it.of_inputs, it.of_states, it.of_end = (bounded(*sides) for sides in (
            (it.low, it.high), (file.lower[states], file.upper[states]), end))

    def hand_over(self, start):
        it, w = self.intervals, self.file.start
        self.solver.reset()
        for k in range(it.N + 1):
            self.solver.set(k, "x", w[it.states[k]])
            if k < it.N:
                self.solver.set(k, "u", w[it.inputs[k]])

    def run(self):
        self.status = self.solver.solve()

    def read(self):
        it, file, get = self.intervals, self.file, self.solver.get
        w, rows, bounds = np.zeros(file.n), np.zeros(file.m), np.zeros(file.n)
        for k in range(it.N + 1):
            w[it.states[k]] = get(k, "x")
            if k < it.N:
                w[it.inputs[k]] = get(k, "u")
                for i, pi in enumerate(get(k, "pi")):
                    row, factor = it.row_of[int(it.states[k + 1, i])]
                    rows[row] = -pi * factor  # its Lagrangian has pi (F - next)
            lam = get(k, "lam")
            both = lam[len(lam) // 2:] - lam[:len(lam) // 2]  # multipliers of upper minus lower bounds, inputs first
            places = it.states[k][it.of_end[0]]
            if k < it.N:
                places = [*it.inputs[k][it.of_inputs[0]], *it.states[k][it.of_states[0] if k else np.arange(it.nx)]]
            bounds[places] = both
        # Given values are rows in the file and bounds in acados.
        for row, i, factor in it.start_rows:
            rows[row], bounds[i] = bounds[i] / factor, 0.0
        for row, i, _, factor in it.end_rows:
            v = it.states[-1, i]
            rows[row], bounds[v] = bounds[v] / factor, 0.0
        stats = self.solver.get_stats
        return Answer(w, rows, bounds, claimed=f"status {self.status}", solved=self.status == 0,
                      iterations=int(np.ravel(stats("sqp_iter"))[0]), own_us=1e6 * float(np.ravel(stats("time_tot"))[0]))
