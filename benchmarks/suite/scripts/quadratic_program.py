"""A quadratic program as `saltus bench answer` writes it, and the one judge of all answers.

    min 1/2 w'Hw + q'w + c   subject to   lower <= w <= upper,  row_lower <= J w <= row_upper

Lagrangian: cost + lambda' J w + z' w; multipliers are positive at upper sides, negative at lower ones.
"""

import json
import math

import numpy as np

FORMAT = "saltus-qp 1"
MARGIN = 1e-6  # relative, of the costs of mixed-integer programs


class Matrix:
    """Entries (row, col, value) of a sparse matrix."""

    def __init__(self, entries, shape):
        self.row = np.array(entries["row"], dtype=int)
        self.col = np.array(entries["col"], dtype=int)
        self.value = np.array(entries["value"], dtype=float)
        self.shape = shape

    def times(self, vector):
        return np.bincount(self.row, self.value * vector[self.col], self.shape[0])

    def transposed_times(self, vector):
        return np.bincount(self.col, self.value * vector[self.row], self.shape[1])

    def csc(self):
        import scipy.sparse  # in the peers' environment
        return scipy.sparse.csc_matrix((self.value, (self.row, self.col)), self.shape)


def sides(values, absent):
    return np.array([absent if value is None else value for value in values], dtype=float)


class QuadraticProgram:
    def __init__(self, data):
        self.name, self.instance = data["problem"], data["instance"]
        self.n, self.m = data["variables"], data["rows"]
        low = data["hessian"]
        off = [e for e, (i, j) in enumerate(zip(low["row"], low["col"])) if i != j]
        self.hessian = Matrix({"row": low["row"] + [low["col"][e] for e in off],
                               "col": low["col"] + [low["row"][e] for e in off],
                               "value": low["value"] + [low["value"][e] for e in off]},
                              (self.n, self.n))
        self.jacobian = Matrix(data["jacobian"], (self.m, self.n))
        self.gradient = np.array(data["gradient"], dtype=float)
        self.constant = data["constant"]
        self.lower, self.upper = sides(data["lower"], -math.inf), sides(data["upper"], math.inf)
        self.row_lower = sides(data["row_lower"], -math.inf)
        self.row_upper = sides(data["row_upper"], math.inf)
        self.stages = data["stages"]  # per stage (states, inputs, rows besides the dynamics)
        self.guess = np.array(data["guess"]) if "guess" in data else None
        self.warm = ({key: np.array(value) for key, value in data["warm"].items()}
                     if "warm" in data else None)
        self.optimum = data.get("optimum")
        self.integer = np.array(data.get("integer", []), dtype=int)
        self.margin = data.get("optimum_tolerance", MARGIN)

    def objective(self, w):
        return float(0.5 * w @ self.hessian.times(w) + self.gradient @ w + self.constant)


def read_program(path):
    """Raises ValueError with one sentence."""
    with open(path, encoding="utf-8") as file:
        try:
            data = json.load(file)
        except json.JSONDecodeError as error:
            raise ValueError(f"'{path}' is not JSON: {error}") from None
    if data.get("format") != FORMAT:
        raise ValueError(f"'{path}' has the format {data.get('format')}, not '{FORMAT}'")
    return QuadraticProgram(data)


def _largest(values):
    """NaN counts as infinite, so it never hides a residual."""
    values = np.abs(values)
    return float(np.max(np.where(np.isnan(values), math.inf, values), initial=0.0))


def _missed(value, lower, upper):
    return _largest(np.fmax(np.maximum(lower - value, value - upper), 0.0)
                    + np.where(np.isnan(value), math.inf, 0.0))


def _not_complementary(value, lower, upper, multiplier):
    """multiplier x distance to its bound; without a bound the multiplier itself counts."""
    distance = np.where(multiplier > 0.0, upper - value, value - lower)
    product = np.where(np.isfinite(distance), multiplier * np.maximum(np.where(
        np.isfinite(distance), distance, 0.0), 0.0), multiplier)
    return _largest(np.where((lower == upper) | (multiplier == 0.0), 0.0, product))


def kkt_residual(qp, w, row_multipliers, bound_multipliers):
    """Stationarity, feasibility, complementarity: the largest absolute entry of each, from the data of the program
    alone, as kkt_residual(SparseQp) of the framework computes it."""
    slope = (qp.hessian.times(w) + qp.gradient + qp.jacobian.transposed_times(row_multipliers)
             + bound_multipliers)
    rows = qp.jacobian.times(w)
    return {"stationarity": _largest(slope),
            "feasibility": max(_missed(w, qp.lower, qp.upper),
                               _missed(rows, qp.row_lower, qp.row_upper)),
            "complementarity": max(
                _not_complementary(w, qp.lower, qp.upper, bound_multipliers),
                _not_complementary(rows, qp.row_lower, qp.row_upper, row_multipliers))}


def largest_sum(qp, w, row_multipliers, bound_multipliers):
    """The largest sum of absolute terms in the residuals, which determines their rounding."""
    def times(matrix, vector, is_transposed=False):
        of, by, count = (matrix.col, matrix.row, 1) if is_transposed else (matrix.row, matrix.col, 0)
        return np.bincount(of, np.abs(matrix.value * vector[by]), matrix.shape[count])
    slope = (times(qp.hessian, w) + np.abs(qp.gradient) + times(qp.jacobian, row_multipliers, is_transposed=True)
             + np.abs(bound_multipliers))
    rows = np.maximum(1.0, np.abs(row_multipliers)) * times(qp.jacobian, w)
    return max(_largest(slope), _largest(rows), _largest(np.maximum(1.0, np.abs(bound_multipliers)) * np.abs(w)))


def integer_residual(qp, w):
    """(the point with rounded integer variables, {its violation, and the largest distance to an integer}). Mixed-integer
    programs have no multipliers."""
    rounded = w.copy()
    rounded[qp.integer] = np.round(w[qp.integer])
    return rounded, {"feasibility": max(_missed(rounded, qp.lower, qp.upper),
                                        _missed(qp.jacobian.times(rounded), qp.row_lower, qp.row_upper)),
                     "integrality": _largest(w[qp.integer] - rounded[qp.integer])}


def _rolled_out(qp, guess):
    """The guess with its states replaced by a roll-out of its inputs."""
    w, J, order = guess.copy(), qp.jacobian, np.argsort(qp.jacobian.row, kind="stable")
    rows, first, row = J.row[order], 0, 0
    for (nx, nu, count), (next_nx, _, _) in zip(qp.stages, qp.stages[1:]):
        if first == 0:
            w[:nx] = np.where(qp.lower[:nx] == qp.upper[:nx], qp.lower[:nx], w[:nx])
        following = slice(first + nx + nu, first + nx + nu + next_nx)
        entries = order[np.searchsorted(rows, row):np.searchsorted(rows, row + next_nx)]
        w[following] = 0.0
        w[following] = (np.bincount(J.row[entries] - row, J.value[entries] * w[J.col[entries]], next_nx)
                        - qp.row_lower[row:row + next_nx])
        first, row = following.start, row + next_nx + count
    return w


def points_of(qp):
    """The starting points that every solver is offered in a cold task, by name, as (w, lambda, z)."""
    if qp.guess is None:
        return {}
    points = {"guess": qp.guess}
    if len(qp.stages) > 1:
        points["guess rolled out"] = _rolled_out(qp, qp.guess)
    return {name: (w, np.zeros(qp.m), np.zeros(qp.n)) for name, w in points.items()}


class Whole:
    """The program with its fixed variables, under the names of Reduced."""

    def __init__(self, qp):
        self.free = np.arange(qp.n)
        self.hessian, self.jacobian, self.gradient = qp.hessian.csc(), qp.jacobian.csc(), qp.gradient
        self.row_lower, self.row_upper = qp.row_lower, qp.row_upper
        self.lower, self.upper = qp.lower, qp.upper


class Reduced:
    """The program without its fixed variables, for solvers that would treat them as two bounds."""

    def __init__(self, qp):
        self.qp = qp
        self.free = np.flatnonzero(qp.lower < qp.upper)
        fixed = np.where(qp.lower < qp.upper, 0.0, qp.lower)
        self.hessian = qp.hessian.csc()[self.free][:, self.free].tocsc()
        self.jacobian = qp.jacobian.csc()[:, self.free].tocsc()
        self.gradient = (qp.gradient + qp.hessian.times(fixed))[self.free]
        shift = qp.jacobian.times(fixed)
        self.row_lower, self.row_upper = qp.row_lower - shift, qp.row_upper - shift
        self.lower, self.upper = qp.lower[self.free], qp.upper[self.free]
        self._fixed = fixed
        self.equal = np.flatnonzero(self.row_lower == self.row_upper)
        self.unequal = np.flatnonzero(self.row_lower < self.row_upper)

    def expand(self, w, row_multipliers, bound_multipliers):
        """(w, lambda, z) of the whole program. The multiplier of a fixed variable makes its slope zero."""
        whole, z = self._fixed.copy(), np.zeros(self.qp.n)
        whole[self.free] = w
        slope = (self.qp.hessian.times(whole) + self.qp.gradient
                 + self.qp.jacobian.transposed_times(row_multipliers))
        z -= slope
        z[self.free] = bound_multipliers
        return whole, row_multipliers, z

    def restrict(self, start):
        """A point (w, lambda, z) of the whole program, restricted to the free variables."""
        return start[0][self.free], start[1], start[2][self.free]
