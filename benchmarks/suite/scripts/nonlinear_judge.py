"""The judge of points of nonlinear programs in files (format `saltus-nlp 1`): evaluates the steps with numpy and computes
the KKT residual by reverse differentiation, from the file alone and without CasADi.

Lagrangian: f + lambda' g + z' w; multipliers are positive at upper sides, negative at lower ones. Stationarity and
complementarity are divided by max(100, mean |multiplier|) / 100, as interior-point methods do.

Complementarity pairs, rows a and b with 0 <= g_a perp g_b >= 0: the smaller of both values counts as violation. The
multipliers of both rows have any sign, but each must vanish where its row does not (weak stationarity). Signs where both
rows are 0 are not judged, because multipliers of such programs are rarely unique; costs show which stationary point is better.
"""

import math

import numpy as np

UNUSUAL = 100.0  # multipliers up to this mean are not scaled


def _sides(values, absent):
    return np.array([absent if v is None else v for v in values], dtype=float)


def _divided(a, b):
    """a / b, and 0 where b is 0: derivatives that do not exist count as 0."""
    return np.divide(a, b, out=np.zeros(np.broadcast(a, b).shape), where=b != 0.0)


def _power_slopes(a, b, y):
    exponent_matters = a > 0.0
    slope_a = np.where((a == 0.0) & (b < 1.0) | (b == 0.0), 0.0, b * np.power(a, b - 1.0))
    return slope_a, np.where(exponent_matters, y * np.log(np.where(exponent_matters, a, 1.0)), 0.0)


def _of_both(a, b, is_first, is_second):
    half = 0.5 * (a == b)
    return is_first + half, is_second + half


# Operation -> (value, partial derivatives as a function of the arguments and the value)
RULES = {
    "add": (np.add, lambda a, b, y: (1.0, 1.0)), "subtract": (np.subtract, lambda a, b, y: (1.0, -1.0)),
    "multiply": (np.multiply, lambda a, b, y: (b, a)), "divide": (np.divide, lambda a, b, y: (1.0 / b, -y / b)),
    "negate": (np.negative, lambda a, y: (-1.0,)), "sin": (np.sin, lambda a, y: (np.cos(a),)),
    "cos": (np.cos, lambda a, y: (-np.sin(a),)), "tan": (np.tan, lambda a, y: (1.0 + y * y,)),
    "asin": (np.arcsin, lambda a, y: (_divided(1.0, np.sqrt(1.0 - a * a)),)),
    "acos": (np.arccos, lambda a, y: (_divided(-1.0, np.sqrt(1.0 - a * a)),)),
    "atan": (np.arctan, lambda a, y: (1.0 / (1.0 + a * a),)), "sinh": (np.sinh, lambda a, y: (np.cosh(a),)),
    "cosh": (np.cosh, lambda a, y: (np.sinh(a),)), "tanh": (np.tanh, lambda a, y: (1.0 - y * y,)),
    "exp": (np.exp, lambda a, y: (y,)), "log": (np.log, lambda a, y: (1.0 / a,)),
    "sqrt": (np.sqrt, lambda a, y: (_divided(0.5, y),)), "abs": (np.abs, lambda a, y: (np.sign(a),)),
    "min": (np.minimum, lambda a, b, y: _of_both(a, b, a < b, b < a)),
    "max": (np.maximum, lambda a, b, y: _of_both(a, b, a > b, b > a)),
    "atan2": (np.arctan2, lambda a, b, y: (_divided(b, a * a + b * b), -_divided(a, a * a + b * b))),
    "hypot": (np.hypot, lambda a, b, y: (_divided(a, y), _divided(b, y))),
    "pow": (np.power, _power_slopes),
    "select": (lambda a, b, c: np.where(a >= 0.0, b, c), lambda a, b, c, y: (0.0, a >= 0.0, a < 0.0)),
}


class _Blocks:
    """All blocks of one function, evaluated together: one column per block."""

    def __init__(self, function, blocks):
        self.function, count = function, len(blocks)
        self.constants = np.array([b["constants"] for b in blocks], dtype=float).reshape(count, function["inputs"]).T
        entries = [(i, k, variable, factor) for k, b in enumerate(blocks) for i, pairs in enumerate(b["coefficients"])
                   for variable, factor in pairs]
        self.input, self.block, self.variable = (np.array([e[p] for e in entries], dtype=int) for p in range(3))
        self.factor = np.array([e[3] for e in entries], dtype=float)
        outputs = len(function["outputs"])
        self.row = np.array([[o[0] for o in b["outputs"]] for b in blocks], dtype=int).reshape(count, outputs).T
        self.weight = np.array([[o[1] for o in b["outputs"]] for b in blocks], dtype=float).reshape(count, outputs).T

    def values(self, w):
        z = self.constants.copy()
        np.add.at(z, (self.input, self.block), self.factor * w[self.variable])
        found, like = [], np.zeros(self.constants.shape[1])
        for operation, *rest in self.function["steps"]:
            if operation == "input":
                found.append(z[rest[0]])
            elif operation == "constant":
                found.append(like + rest[0])
            else:
                found.append(RULES[operation][0](*(found[i] for i in rest)))
        return found

    def add_slope(self, values, multipliers, slope):
        """Adds the derivative of the weighted outputs. `multipliers`: of the rows, then of the objective."""
        steps, like = self.function["steps"], np.zeros(self.constants.shape[1])
        adjoint = [None] * len(steps)
        for o, step in enumerate(self.function["outputs"]):
            adjoint[step] = (like if adjoint[step] is None else adjoint[step]) + self.weight[o] * multipliers[self.row[o]]
        inputs = np.zeros(self.constants.shape)
        for s in range(len(steps) - 1, -1, -1):
            if adjoint[s] is None:
                continue
            operation, *rest = steps[s]
            if operation == "input":
                inputs[rest[0]] += adjoint[s]
            elif operation != "constant":
                for i, partial in zip(rest, RULES[operation][1](*(values[i] for i in rest), values[s])):
                    part = np.where(adjoint[s] == 0.0, 0.0, adjoint[s] * partial)
                    adjoint[i] = part if adjoint[i] is None else adjoint[i] + part
        np.add.at(slope, self.variable, self.factor * inputs[self.input, self.block])


class NonlinearJudge:
    def __init__(self, data):
        self.n, self.m = data["variables"], data["rows"]
        self.lower, self.upper = _sides(data["lower"], -math.inf), _sides(data["upper"], math.inf)
        self.row_lower, self.row_upper = _sides(data["row_lower"], -math.inf), _sides(data["row_upper"], math.inf)
        self.start = np.array(data["start"], dtype=float)
        by_function = {}
        for block in data["blocks"]:
            by_function.setdefault(block["function"], []).append(block)
        self.groups = [_Blocks(data["functions"][i], blocks) for i, blocks in by_function.items()]
        linear = data["linear"]
        self.row, self.variable = (np.array([e[p] for e in linear], dtype=int) for p in range(2))
        self.coefficient = np.array([e[2] for e in linear], dtype=float)
        self.a, self.b = np.zeros(self.n), np.zeros(self.n)
        for variable, a, b in data["variable_costs"]:
            self.a[variable] += a
            self.b[variable] += b
        self.pairs = np.array(data.get("complementarity", []), dtype=int).reshape(-1, 2)
        optimum = data.get("optimum")
        self.known = {} if optimum is None else {
            "optimum": optimum, "margin": data.get("optimum_tolerance", 1e-4) * (1.0 + abs(optimum))}

    def evaluate(self, w, multipliers):
        """(cost, rows, derivative of the Lagrangian without bounds)"""
        w = np.asarray(w, dtype=float)
        rows, slope = np.zeros(self.m + 1), self.a + self.b * w  # the last row is the cost
        rows[-1] = self.a @ w + 0.5 * self.b @ (w * w)
        np.add.at(rows, self.row, self.coefficient * w[self.variable])
        weights = np.append(multipliers, 1.0)
        np.add.at(slope, self.variable, self.coefficient * weights[self.row])
        with np.errstate(all="ignore"):
            for group in self.groups:
                values = group.values(w)
                for o, step in enumerate(group.function["outputs"]):
                    np.add.at(rows, group.row[o], group.weight[o] * values[step])
                group.add_slope(values, weights, slope)
        return float(rows[-1]), rows[:-1], slope

    def judged(self, w, row_multipliers, bound_multipliers):
        """The answer in the form of the other judges."""
        parts = [np.asarray(p, dtype=float) for p in (w, row_multipliers, bound_multipliers)]
        w, lam, z = parts
        never = {**self.known, "objective": math.inf, "kkt": dict.fromkeys(("stationarity", "feasibility", "complementarity"),
                                                                          math.inf)}
        if [p.shape for p in parts] != [(self.n,), (self.m,), (self.n,)] or not all(np.isfinite(p).all() for p in parts):
            return never
        cost, rows, slope = self.evaluate(w, lam)
        if not (math.isfinite(cost) and np.isfinite(rows).all() and np.isfinite(slope).all()):
            return never
        free, first, second = self.lower != self.upper, self.pairs[:, 0], self.pairs[:, 1]
        scale = max(UNUSUAL, (np.abs(lam).sum() + np.abs(z[free]).sum()) / max(1, self.m + free.sum())) / UNUSUAL
        paired = np.zeros(self.m, dtype=bool)
        paired[self.pairs.ravel()] = True
        moving = (self.row_lower != self.row_upper) & ~paired
        products = [_products(w[free], self.lower[free], self.upper[free], z[free]),
                    _products(rows[moving], self.row_lower[moving], self.row_upper[moving], lam[moving]),
                    np.abs(lam[paired]) * np.maximum(rows[paired], 0.0)]
        violations = [self.lower - w, w - self.upper, self.row_lower - rows, rows - self.row_upper,
                      np.minimum(rows[first], rows[second])]
        return {**self.known, "objective": cost,
                "kkt": {"stationarity": _largest(slope[free] + z[free]) / scale,
                        "feasibility": max(0.0, *(float(np.max(v, initial=0.0)) for v in violations)),
                        "complementarity": max(map(_largest, products)) / scale}}


def _largest(values):
    return float(np.max(np.abs(values), initial=0.0))


def _products(value, lower, upper, multiplier):
    """multiplier x distance to its side; without a side the multiplier itself counts."""
    distance = np.where(multiplier > 0.0, upper - value, value - lower)
    there = np.isfinite(distance)
    return np.where(there, multiplier * np.maximum(np.where(there, distance, 0.0), 0.0), multiplier)


def lifted(data):
    """The program with complementarity as one that solvers of nonlinear programs take. A variable at least 0 replaces
    each row of a pair. Rows bound the products of both variables. `pairs` contains their numbers; solvers reduce the
    bound of the products step by step and then fix the smaller variable of each pair at 0. Variables and rows of the
    original program keep their numbers, so a point of the lifted program contains a point with its multipliers."""
    judge = NonlinearJudge(data)
    rows = judge.evaluate(judge.start, np.zeros(judge.m))[1]
    out = {key: list(value) if isinstance(value, list) else value for key, value in data.items() if key != "complementarity"}
    slack = {}

    def slack_of(row):
        if row not in slack:
            slack[row] = out["variables"]
            out["variables"] += 1
            value = rows[row] if math.isfinite(rows[row]) else 0.0
            for key, entry in (("lower", 0.0), ("upper", out["row_upper"][row]), ("start", max(0.0, float(value)))):
                out[key].append(entry)
            out["row_lower"][row] = out["row_upper"][row] = 0.0
            out["linear"].append([row, slack[row], -1.0])
        return slack[row]
    out["functions"].append({"inputs": 2, "steps": [["input", 0], ["input", 1], ["multiply", 0, 1]], "outputs": [2]})
    out["pairs"] = []
    for first, second in data["complementarity"]:
        a, b = slack_of(first), slack_of(second)
        out["row_lower"].append(None)
        out["row_upper"].append(1.0)
        out["blocks"].append({"function": len(out["functions"]) - 1, "constants": [0.0, 0.0],
                              "coefficients": [[[a, 1.0]], [[b, 1.0]]], "outputs": [[out["rows"], 1.0]]})
        out["pairs"].append([a, b, out["rows"]])
        out["rows"] += 1
    return out
