"""A nonlinear program in elementary steps, and its conversion to functions of CasADi.

The file, format `saltus-nlp 1`, holds
    min f(w)   lower <= w <= upper,   row_lower <= g(w) <= row_upper          (null: no side)
as small functions of few arguments. functions: {inputs, steps, outputs}, a step being ["input", NUMBER],
["constant", VALUE] or [OPERATION, STEP, ...], an output the number of a step. blocks: a function, its arguments
    z_i = constants[i] + sum FACTOR * w[VARIABLE] over coefficients[i],
and where its outputs are added, [ROW, FACTOR], ROW -1 being the objective. linear: [ROW, VARIABLE, COEFFICIENT].
variable_costs: [VARIABLE, a, b] for (a + b/2 w) w. checks: our values and derivatives at some points, patterns as
jacobian and hessian (lower triangle; at sigma = 1 and the check's lambda).

CasADi receives the form that suits it best: one expression graph for each small function, with the Jacobian and Hessian
of CasADi, mapped over all blocks that share the function. Sparse constant matrices place the entries.
"""

import json
import math
import os
import subprocess

import numpy as np

from nonlinear_judge import NonlinearJudge

FORMAT = "saltus-nlp 1"


class ProgramFileError(Exception):
    """An invalid file; the message is one sentence."""


class NonlinearFile:
    """The contents of the file, with bounds as arrays with infinities."""

    def __init__(self, data):
        if data.get("format") != FORMAT:
            raise ProgramFileError(f"a nonlinear program has the format '{FORMAT}', not '{data.get('format')}'")
        self.data = data
        self.n, self.m = data["variables"], data["rows"]
        self.start = np.array(data["start"])
        self.lower, self.upper = _sides(data["lower"], -math.inf), _sides(data["upper"], math.inf)
        self.row_lower = _sides(data["row_lower"], -math.inf)
        self.row_upper = _sides(data["row_upper"], math.inf)
        self.pairs = data.get("pairs", [])  # see nonlinear_judge.lifted()
        self.judge = None  # of a program that is data

    def original(self, w, row_multipliers, bound_multipliers):
        """The point of the program as stated, without the variables and rows of lifted()."""
        n, m = (self.judge.n, self.judge.m) if self.pairs else (self.n, self.m)
        return w[:n], row_multipliers[:m], bound_multipliers[:n]


class NoFile:
    """A program that has no elementary steps, and the reason: only our solvers run it."""

    def __init__(self, instance, why):
        self.instance, self.why, self.judge = instance, why, None


def _sides(values, absent):
    return np.array([absent if v is None else v for v in values], dtype=float)


def read_nonlinear(path):
    with open(path, encoding="utf-8") as file:
        return NonlinearFile(json.load(file))


def expression(function, z, is_safe=False):
    """The outputs of a function of steps for arguments z of CasADi's SX. At 0, where sqrt has no derivative, our value
    is 0 (the length of a velocity at rest), and that of CasADi is NaN unless `is_safe`."""
    import casadi as ca
    known = {"add": lambda a, b: a + b, "subtract": lambda a, b: a - b,
             "multiply": lambda a, b: a * b, "divide": lambda a, b: a / b, "negate": lambda a: -a,
             "abs": ca.fabs, "min": ca.fmin, "max": ca.fmax, "hypot": lambda a, b: ca.sqrt(a * a + b * b),
             "pow": ca.power, "atan2": ca.atan2,
             "select": lambda a, b, c: ca.if_else(a >= 0, b, c)}
    if is_safe:
        known["sqrt"] = lambda a: ca.sqrt(a + 1e-100 * (a == 0))
    values = []
    for operation, *rest in function["steps"]:
        if operation == "input":
            values.append(z[rest[0]])
        elif operation == "constant":
            values.append(ca.SX(rest[0]))
        else:
            arguments = [values[i] for i in rest]
            call = known.get(operation) or getattr(ca, operation)
            values.append(call(*arguments))
    return [values[i] for i in function["outputs"]]


class _Group:
    """All blocks of one function: variable arguments as V = A w + b, one column per block, and the others as numbers."""

    def __init__(self, function, blocks, n, is_safe):
        import casadi as ca
        self.count = len(blocks)
        inputs = function["inputs"]
        self.varies = [i for i in range(inputs) if any(b["coefficients"][i] for b in blocks)]
        fixed = [i for i in range(inputs) if i not in self.varies]
        outputs = [o for o in range(len(function["outputs"]))
                   if any(b["outputs"][o][1] != 0.0 for b in blocks)]
        nv = len(self.varies)
        z = ca.SX.sym("v", nv), ca.SX.sym("p", len(fixed))
        argument = {i: z[0][k] for k, i in enumerate(self.varies)}
        argument.update({i: z[1][k] for k, i in enumerate(fixed)})
        every = expression(function, argument, is_safe)
        y = ca.vertcat(*(every[o] for o in outputs))
        mu = ca.SX.sym("mu", len(outputs))
        J = ca.jacobian(y, z[0])
        H = ca.tril(ca.hessian(ca.dot(mu, y), z[0])[0])
        self.value = ca.Function("value", [*z], [y], {"cse": True})
        self.first = ca.Function("first", [*z], [y, ca.vertcat(*J.nonzeros())], {"cse": True})
        self.second = ca.Function("second", [*z, mu], [ca.vertcat(*H.nonzeros())], {"cse": True})
        self.numbers = ca.DM([[b["constants"][i] for b in blocks] for i in fixed]) if fixed else ca.DM(0, self.count)
        A, b = _Triplets(nv * self.count, n), np.zeros(nv * self.count)
        for k, block in enumerate(blocks):
            for r, i in enumerate(self.varies):
                b[k * nv + r] = block["constants"][i]
                for variable, factor in block["coefficients"][i]:
                    A.add(k * nv + r, variable, factor)
        self.A, self.b, self.nv = A.matrix(), ca.DM(b), nv
        self.outputs, self.blocks = outputs, blocks
        self.J_pairs = list(zip(*J.sparsity().get_triplet()))
        self.H_pairs = list(zip(*H.sparsity().get_triplet()))

    def arguments(self, w):
        import casadi as ca
        return ca.reshape(ca.mtimes(self.A, w) + self.b, self.nv, self.count)

    def mapped(self, function):
        return function if self.count == 1 else function.map(self.count)


class _Triplets:
    def __init__(self, rows, cols):
        self.shape, self.row, self.col, self.value = (rows, cols), [], [], []

    def add(self, row, col, value):
        self.row.append(row)
        self.col.append(col)
        self.value.append(value)

    def matrix(self):
        import casadi as ca
        import scipy.sparse as sparse
        m = sparse.csc_matrix((self.value, (self.row, self.col)), shape=self.shape)
        m.sum_duplicates()
        return ca.DM(m)


class CasadiProgram:
    """nlp_f, nlp_g and their derivatives under the names that CasADi's plug-ins expect."""

    def __init__(self, file, is_safe=False):
        import casadi as ca
        self.file, self.is_safe = file, is_safe
        data, n, m = file.data, file.n, file.m
        by_function = {}
        for block in data["blocks"]:
            by_function.setdefault(block["function"], []).append(block)
        groups = [_Group(data["functions"][i], blocks, n, is_safe) for i, blocks in by_function.items()]
        L = _Triplets(m, n)
        for row, variable, coefficient in data["linear"]:
            L.add(row, variable, coefficient)
        L = L.matrix()
        a, b = np.zeros(n), np.zeros(n)
        for variable, linear, quadratic in data["variable_costs"]:
            a[variable] += linear
            b[variable] += quadratic
        a, b = ca.DM(a), ca.DM(b)

        w, p = ca.MX.sym("x", n), ca.MX.sym("p", 0)
        sigma, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", m)
        multipliers = ca.vertcat(sigma, lam)

        def scattered(entries, pairs_of_entry, shape):
            """Sparse matrix whose entries are sums of factors times `entries`: pairs_of_entry gives (row, col, factor)."""
            where = {}
            for k, targets in enumerate(pairs_of_entry):
                for row, col, factor in targets:
                    where.setdefault((col, row), []).append((k, factor))
            keys = sorted(where)
            S = _Triplets(len(keys), len(pairs_of_entry))
            for position, key in enumerate(keys):
                for k, factor in where[key]:
                    S.add(position, k, factor)
            pattern = ca.Sparsity.triplet(*shape, [r for _, r in keys], [c for c, _ in keys])
            return ca.MX(pattern, ca.mtimes(S.matrix(), entries)) if keys else ca.MX(*shape)

        f0 = ca.dot(a, w) + 0.5 * ca.dot(b, w * w)
        g0 = ca.mtimes(L, w)
        parts_f, parts_g, first_f, first_g = [f0], [g0], [f0], [g0]
        J_entries, J_targets, H_entries, H_targets = [], [], [], []
        J_entries.append(ca.DM([v for *_, v in data["linear"]]) if data["linear"] else ca.DM(0, 1))
        J_targets += [[(r, v, 1.0)] for r, v, _ in data["linear"]]
        gradient_entries, gradient_targets = [], []
        for group in groups:
            V = group.arguments(w)
            numbers = ca.MX(group.numbers)
            ny = len(group.outputs)
            F, G = _Triplets(1, ny * group.count), _Triplets(m, ny * group.count)
            M = _Triplets(ny * group.count, 1 + m)
            for k, block in enumerate(group.blocks):
                for r, o in enumerate(group.outputs):
                    row, factor = block["outputs"][o]
                    if factor == 0.0:
                        continue
                    (F.add(0, k * ny + r, factor) if row < 0 else G.add(row, k * ny + r, factor))
                    M.add(k * ny + r, 1 + row, factor)
            F, G, M = F.matrix(), G.matrix(), M.matrix()
            y = ca.vec(group.mapped(group.value)(V, numbers))
            parts_f.append(ca.mtimes(F, y))
            parts_g.append(ca.mtimes(G, y))
            y, entries = group.mapped(group.first)(V, numbers)
            y = ca.vec(y)
            first_f.append(ca.mtimes(F, y))
            first_g.append(ca.mtimes(G, y))
            for target, all_entries, objective in ((J_targets, J_entries, False),
                                                   (gradient_targets, gradient_entries, True)):
                all_entries.append(ca.vec(entries))
                for block in group.blocks:
                    for r, c in group.J_pairs:
                        row, factor = block["outputs"][group.outputs[r]]
                        counts = factor != 0.0 and (row < 0) == objective
                        target.append([(max(row, 0), v, factor * s) for v, s in
                                       block["coefficients"][group.varies[c]]] if counts else [])
            if group.H_pairs:
                mu = ca.reshape(ca.mtimes(M, multipliers), ny, group.count)
                H_entries.append(ca.vec(group.mapped(group.second)(V, numbers, mu)))
                for block in group.blocks:
                    for r, c in group.H_pairs:
                        H_targets.append(_curvature(block["coefficients"][group.varies[r]],
                                                    block["coefficients"][group.varies[c]], r == c))
        quadratic = [(v, q) for v, _, q in data["variable_costs"] if q != 0.0]
        if quadratic:
            H_entries.append(sigma * ca.DM([q for _, q in quadratic]))
            H_targets += [[(v, v, 1.0)] for v, _ in quadratic]

        f, g, f1, g1 = (ca.densify(sum(parts)) for parts in (parts_f, parts_g, first_f, first_g))
        J = scattered(ca.vertcat(*J_entries), J_targets, (m, n))
        slope = scattered(ca.vertcat(*gradient_entries), gradient_targets, (1, n)) if gradient_entries else ca.MX(1, n)
        gradient = ca.densify(slope.T + a + b * w)
        # Upper triangle: the transposed targets of the lower one.
        upper = [[(c, r, s) for r, c, s in targets] for targets in H_targets]
        H = scattered(ca.vertcat(*H_entries), upper, (n, n)) if H_entries else ca.MX(n, n)
        both = [w, p]

        def function(name, ins, outs, names_in, names_out):
            return ca.Function(name, ins, outs, names_in, names_out)

        xp, xpl = ["x", "p"], ["x", "p", "lam_f", "lam_g"]
        # The Hessian as a whole (sqpmethod) or as upper triangle (ipopt).
        self.functions = {
            "nlp": function("nlp", both, [f, g], xp, ["f", "g"]),
            "nlp_f": function("nlp_f", both, [f], xp, ["f"]),
            "nlp_g": function("nlp_g", both, [g], xp, ["g"]),
            "nlp_fg": function("nlp_fg", both, [f, g], xp, ["f", "g"]),
            "nlp_grad_f": function("nlp_grad_f", both, [f1, gradient], xp, ["f", "grad_f_x"]),
            "nlp_jac_g": function("nlp_jac_g", both, [g1, J], xp, ["g", "jac_g_x"]),
            "nlp_jac_fg": function("nlp_jac_fg", both, [f1, gradient, g1, J], xp,
                                   ["f", "grad_f_x", "g", "jac_g_x"]),
            "triangle": function("nlp_hess_l", [w, p, sigma, lam], [H], xpl, ["triu_hess_gamma_x_x"]),
            "whole": function("nlp_hess_l", [w, p, sigma, lam], [ca.triu2symm(H)], xpl,
                              ["hess_gamma_x_x"]),
        }

    def disagreement(self):
        """The largest difference of values and derivatives from ours, relative to 1 + |entry| and to the largest entry
        of a matrix, with the name of the quantity."""
        import casadi as ca
        worst, what = 0.0, "nothing"
        data = self.file.data
        f = self.functions
        if "checks" not in data:
            return self._disagreement_with_judge()
        for number, check in enumerate(data["checks"]):
            w, lam = check["w"], check["lambda"]
            objective, gradient, rows, J = f["nlp_jac_fg"](w, [])
            found = [("objective", objective, check["objective"]), ("gradient", gradient, check["gradient"]),
                     ("rows", rows, check["rows"]),
                     ("jacobian", J, _dense(data["jacobian"], check["jacobian"], J.shape))]
            # The first point is the guess, which may have no second derivative.
            if "hessian" in check and not (self.is_safe and number == 0):
                H = f["triangle"](w, [], 1.0, lam)
                found.append(("hessian", H, _dense(data["hessian"], check["hessian"], H.shape).T))
            worst, what = _worst(found, worst, what)
        return worst, what

    def _disagreement_with_judge(self):
        """The same for a file without checks, near its start, without second derivatives."""
        import casadi as ca
        judge, random = NonlinearJudge(self.file.data), np.random.default_rng(1)
        worst, what = 0.0, "nothing"
        for radius in (0.0, 1e-3, 1e-3):
            w = self.file.start + radius * random.uniform(-1.0, 1.0, self.file.n)
            lam = random.uniform(-1.0, 1.0, self.file.m)
            cost, rows, slope = judge.evaluate(w, lam)
            if math.isfinite(cost) and np.isfinite(rows).all() and np.isfinite(slope).all():
                objective, gradient, values, J = self.functions["nlp_jac_fg"](w, [])
                worst, what = _worst([("objective", objective, cost), ("rows", values, rows),
                                      ("slope", gradient + ca.mtimes(J.T, ca.DM(lam)), slope)], worst, what)
        return worst, what

    def write_source(self, folder, names, functions=None):
        """Writes these functions as C, of this program or as given. Returns the path of the file."""
        import casadi as ca
        generator = ca.CodeGenerator("nlp.c")
        for name in names:
            generator.add((functions or self.functions)[name])
        return generator.generate(folder + os.sep)

    @staticmethod
    def compile(source, library, flags):
        subprocess.run(["gcc", *flags, "-fPIC", "-shared", "-w", source, "-o", library, "-lm"], check=True)


def _worst(found, worst, what):
    """The largest difference of quantities (name, values, expected values), if it is above `worst`, with its name."""
    import casadi as ca
    for name, ours, theirs in found:
        ours, theirs = np.array(ca.DM(ours)).ravel(order="F"), np.array(theirs, dtype=float).ravel(order="F")
        scale = 1.0 + (np.abs(theirs).max() if theirs.size else 0.0)
        difference = np.abs(ours - theirs).max() / scale if theirs.size else 0.0
        if not difference <= worst:
            worst, what = (difference if np.isfinite(difference) else math.inf), name
    return worst, what


def _curvature(left, right, diagonal):
    """Entries (row >= col) to which a local second derivative at a pair of arguments contributes."""
    targets = []
    for i, a in left:
        for j, b in right:
            if diagonal:
                if i >= j:
                    targets.append((i, j, a * b))
                continue
            # the pair and its mirror image
            targets.append((max(i, j), min(i, j), a * b * (2.0 if i == j else 1.0)))
    return targets


def _dense(pattern, values, shape):
    import scipy.sparse as sparse
    return sparse.csc_matrix((values, (pattern["row"], pattern["col"])), shape=shape).toarray()
