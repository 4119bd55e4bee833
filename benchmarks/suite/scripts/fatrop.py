"""fatrop, a structured interior-point method for nonlinear programs, through casadi's nlpsol.

It needs variables x_0, u_0, x_1, ... and rows next - F(x_0, u_0), other rows of stage 0, next - F(x_1, u_1), ...,
without other couplings of stages. Quadratic programs use the same path: casadi's conic plug-in of fatrop (3.8.2) prints
its matrices and does not return the cost. Its BLASFEO is generic, as for HPIPM of that package.
"""

import math

import numpy as np

from nonlinear_peers import CasadiNlp
from peers import ITERATIONS, Adapter, Answer, NotApplicable

# It solves unscaled quadratic programs to 1e-7; scaled, and with tighter tolerances, some of them to 1e-8 (see
# measured.md).
COST_SCALE = 100.0


def options(sizes, tolerance):
    return {"structure_detection": "manual", "N": len(sizes) - 1, "nx": [s[0] for s in sizes],
            "nu": [s[1] for s in sizes], "ng": [s[2] for s in sizes], "print_time": False, "error_on_fail": False,
            "fatrop": {"print_level": 0, "tol": tolerance, "max_iter": ITERATIONS}}


class CasadiFatrop(Adapter):
    name, package = "casadi-fatrop", "casadi"
    about = "fatrop of casadi's package, a method for nonlinear programs; its BLASFEO is generic"

    def __init__(self, qp, tolerance):
        import casadi as ca
        import scipy.sparse as sparse
        if not qp.stages or len(qp.stages) < 2:
            raise NotApplicable("it has no stages")
        self.qp, self.nx = qp, qp.stages[0][0]
        first = qp.stages[1][0]
        # The fixed start as rows of stage 0, after its dynamics.
        start = sparse.identity(qp.n, format="csr")[:self.nx]
        J = qp.jacobian.csc().tocsr()
        self.place = np.concatenate([np.arange(first), first + self.nx + np.arange(qp.m - first)])  # our row indices
        A = sparse.vstack([J[:first], start, J[first:]])
        low, high = (np.concatenate([rows[:first], qp.lower[:self.nx], rows[first:]])
                     for rows in (qp.row_lower, qp.row_upper))
        sizes = [list(s) for s in qp.stages]
        sizes[0][2] += self.nx
        sign, row = np.ones(len(low)), 0
        for k in range(len(sizes) - 1):  # ours are F - next
            sign[row:row + sizes[k + 1][0]] = -1.0
            row += sizes[k + 1][0] + sizes[k][2]
        self.sign = sign
        A = sparse.csc_matrix(sparse.diags(sign) @ A)
        x = ca.MX.sym("x", qp.n)
        cost = 0.5 * ca.dot(x, ca.mtimes(ca.DM(qp.hessian.csc()), x)) + ca.dot(ca.DM(qp.gradient), x)
        self.solver = ca.nlpsol("solver", "fatrop", {"x": x, "f": COST_SCALE * cost, "g": ca.mtimes(ca.DM(A), x)},
                                options(sizes, COST_SCALE * tolerance))
        x_low, x_high = qp.lower.copy(), qp.upper.copy()
        x_low[:self.nx], x_high[:self.nx] = -math.inf, math.inf
        self.given = {"lbx": ca.DM(x_low), "ubx": ca.DM(x_high), "lbg": ca.DM(np.where(sign < 0, -high, low)),
                      "ubg": ca.DM(np.where(sign < 0, -low, high))}

    def hand_over(self, start):
        import casadi as ca
        self.given["x0"] = ca.DM(np.zeros(self.qp.n) if start is None else start[0])

    def run(self):
        self.answer = self.solver(**self.given)

    def read(self):
        answer, stats = self.answer, self.solver.stats()
        rows, bounds = (np.array(answer[key]).ravel() / COST_SCALE for key in ("lam_g", "lam_x"))
        rows *= self.sign
        w, row_multipliers = np.array(answer["x"]).ravel(), rows[self.place]
        # The fixed start has rows here, and bounds in the check.
        first = self.qp.stages[1][0]
        bounds[:self.nx] = rows[first:first + self.nx]
        w[:self.nx] = self.qp.lower[:self.nx]
        return Answer(w, row_multipliers, bounds, claimed=str(stats.get("unified_return_status", "")),
                      solved=bool(stats.get("success")), iterations=int(stats.get("iter_count", -1)))


def _patterns(file, nonlinear, linear):
    """Columns of each row, and pairs of variables in the Hessian. Programs of the library have both in their file."""
    columns = [set(touched) for touched in nonlinear]
    if "jacobian" in file.data:
        columns = [set() for _ in columns]
        for row, column in zip(file.data["jacobian"]["row"], file.data["jacobian"]["col"]):
            columns[row].add(column)
        return [sorted(of) for of in columns], list(zip(file.data["hessian"]["row"], file.data["hessian"]["col"]))
    for row, variable in linear:
        columns[row].add(variable)
    coupled = []
    for block in file.data["blocks"]:  # pairs of neighbours are enough to find a block of two stages
        touched = sorted({v for terms in block["coefficients"] for v, _ in terms})
        coupled += zip(touched, touched[1:])
    return [sorted(of) for of in columns], coupled


class Stages:
    """Order and signs of the rows that split a nonlinear program into stages. Raises NotApplicable if there are none."""

    def __init__(self, file):
        nonlinear = [set() for _ in range(file.m)]
        for block in file.data["blocks"]:
            touched = {v for terms in block["coefficients"] for v, _ in terms}
            for row, factor in block["outputs"]:
                if row >= 0 and factor != 0.0:
                    nonlinear[row] |= touched
        linear = {(row, variable): factor for row, variable, factor in file.data["linear"]}
        columns, coupled = self.columns, _ = _patterns(file, nonlinear, linear)
        # Rows that define the next state: their last variable, which is linear and does not occur in nonlinear parts.
        closing = {}
        for row in range(file.m):
            last = max(columns[row], default=-1)
            if (file.row_lower[row] == file.row_upper[row] and len(columns[row]) > 1 and last not in nonlinear[row]
                    and abs(linear.get((row, last), 0.0)) == 1.0 and last not in closing):
                closing[last] = row
        stage_of, self.sizes, gaps = np.zeros(file.n, dtype=int), [[0, 0, 0]], [[]]
        for v in range(file.n):
            if v in closing and v - 1 not in closing:
                self.sizes.append([0, 0, 0])
                gaps.append([])
            if v in closing:
                gaps[len(self.sizes) - 2].append(closing[v])
            self.sizes[-1][0 if v in closing else 1] += 1  # variables without dynamics count as inputs
            stage_of[v] = len(self.sizes) - 1
        if len(self.sizes) < 2:
            raise NotApplicable("it has no stages")
        gap_rows = {row for rows in gaps for row in rows}
        others = [[] for _ in self.sizes]
        for row in range(file.m):
            stages = {stage_of[v] for v in columns[row]}
            if row in gap_rows:
                if len(stages) != 2 or max(stages) - min(stages) != 1:
                    raise NotApplicable("its stages are coupled: parameters, free durations or links")
            elif len(stages) > 1:
                raise NotApplicable("its stages are coupled: parameters, free durations or links")
            elif stages:
                others[stages.pop()].append(row)
        if any(stage_of[i] != stage_of[j] for i, j in coupled):
            raise NotApplicable("its costs couple stages")
        self.order = [row for k in range(len(self.sizes)) for row in (*gaps[k], *others[k])]
        sign_of = {row: linear[(row, v)] for v, row in closing.items() if row in gap_rows}
        self.sign = np.array([sign_of.get(row, 1.0) for row in self.order])
        for k, rows in enumerate(others):
            self.sizes[k][2] = len(rows)


class CasadiFatropNonlinear(CasadiNlp):
    name, plugin, is_compiled = "casadi-fatrop-compiled", "fatrop", True
    about = "fatrop of casadi's package, functions as C compiled by gcc for the processor; its BLASFEO is generic"
    compiles = ("nlp", "nlp_f", "nlp_g", "nlp_grad_f", "nlp_jac_g", "nlp_hess_l", "nlp_grad")

    def options(self, tolerance):
        chosen = options(self.stages.sizes, tolerance)
        chosen["fatrop"]["max_iter"] = 1000
        chosen["no_nlp_grad"] = False  # requested at the end of a solve
        return chosen

    def prepare(self, program):
        """The functions with their rows in the order of fatrop."""
        import casadi as ca
        import scipy.sparse as sparse
        stages, file = self.stages, self.file
        count = len(stages.order)
        pick = ca.DM(sparse.csc_matrix((stages.sign, (range(count), stages.order)), shape=(count, file.m)))
        w, p, lam_f, lam_g = (ca.MX.sym("x", file.n), ca.MX.sym("p", 0), ca.MX.sym("lam_f"),
                              ca.MX.sym("lam_g", count))
        of, both, four = program.functions, ["x", "p"], ["x", "p", "lam_f", "lam_g"]
        f, g = of["nlp"](w, p)
        g1, J = of["nlp_jac_g"](w, p)
        multipliers = ca.mtimes(pick.T, lam_g)
        H = of["whole"](w, p, lam_f, multipliers)
        _, slope = of["nlp_grad_f"](w, p)
        slope_g = of["nlp_jac_g"](w, p)[1]
        gradient = lam_f * slope + ca.mtimes(slope_g.T, multipliers)
        known = {"nlp": ca.Function("nlp", [w, p], [f, ca.mtimes(pick, g)], both, ["f", "g"]),
                 "nlp_f": of["nlp_f"],
                 "nlp_g": ca.Function("nlp_g", [w, p], [ca.mtimes(pick, of["nlp_g"](w, p))], both, ["g"]),
                 "nlp_grad_f": ca.Function("nlp_grad_f", [w, p], [slope], both, ["grad_f_x"]),
                 "nlp_jac_g": ca.Function("nlp_jac_g", [w, p], [ca.mtimes(pick, g1), ca.mtimes(pick, J)], both,
                                          ["g", "jac_g_x"]),
                 "nlp_hess_l": ca.Function("nlp_hess_l", [w, p, lam_f, lam_g], [gradient, H], four,
                                           ["grad_gamma_x", "hess_gamma_x_x"])}
        known["nlp_grad"] = ca.Function("nlp_grad", [w, p, lam_f, lam_g], [f, ca.mtimes(pick, g), gradient, ca.MX(0, 1)], four,
                                        ["f", "g", "grad_gamma_x", "grad_gamma_p"])
        return known

    def __init__(self, file, tolerance):
        if file.n > self.largest:
            raise NotApplicable(f"more than {self.largest} variables")
        import casadi as ca
        self.stages = Stages(file)
        super().__init__(file, tolerance)
        order, sign = self.stages.order, self.stages.sign
        low, high = file.row_lower[order], file.row_upper[order]
        self.given.update(lbg=ca.DM(np.where(sign < 0, -high, low)), ubg=ca.DM(np.where(sign < 0, -low, high)))

    def row_multipliers(self, found):
        rows = np.zeros(self.file.m)
        rows[self.stages.order] = self.stages.sign * found
        return rows
