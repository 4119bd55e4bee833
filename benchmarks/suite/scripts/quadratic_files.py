"""Quadratic programs of other formats as files of the format `saltus-qp 1`: .npz as qpsolvers saves them, .mat as in
maros_meszaros_qpbenchmark, and .QPS or .SIF in the format QPS."""

import math
import os

import numpy as np

FAR = 9e19  # infinity in the files of Maros-Meszaros is 1e20, sometimes less a rounding error


def program(name, variables, rows, hessian, jacobian, gradient, sides, row_sides, constant=0.0):
    """A file's contents. Matrices are triples (row, col, value) of lists; sides are pairs of lists with infinities."""
    def entries(matrix):
        return dict(zip(("row", "col", "value"), (np.asarray(part).tolist() for part in matrix)))
    return {"format": "saltus-qp 1", "problem": name, "instance": 1, "variables": variables, "rows": rows,
            "hessian": entries(hessian), "jacobian": entries(jacobian),
            "gradient": np.asarray(gradient, dtype=float).ravel().tolist(), "constant": constant,
            "lower": _nullable(sides[0]), "upper": _nullable(sides[1]), "row_lower": _nullable(row_sides[0]),
            "row_upper": _nullable(row_sides[1]), "stages": []}


def _nullable(values):
    return [None if math.isinf(v) else float(v) for v in values]


def _nonzeros(matrix):
    row, col = np.nonzero(matrix)
    return row, col, matrix[row, col]


def from_npz(name, source):
    """min 1/2 x'Px + q'x subject to G x <= h, A x = b, lb <= x <= ub; absent parts are None or missing."""
    with np.load(source, allow_pickle=False) as archive:
        data = {}
        for key in archive.files:
            try:
                data[key] = archive[key]
            except ValueError:
                pass  # an object, None
    n = len(data["q"])
    G, A = data.get("G", np.zeros((0, n))), data.get("A", np.zeros((0, n)))
    h, b = data.get("h", np.zeros(0)).ravel(), data.get("b", np.zeros(0)).ravel()
    jacobian, absent = np.vstack([G, A]), np.full(n, math.inf)
    return program(name, n, len(jacobian), _nonzeros(np.tril(data["P"])), _nonzeros(jacobian), data["q"],
                   (data.get("lb", -absent), data.get("ub", absent)), ([-math.inf] * len(h) + b.tolist(), [*h, *b]))


def from_mat(name, source):
    """min 1/2 x'Px + q'x + r subject to l <= A x <= u, whose last rows may be the bounds of the variables."""
    import scipy.io
    import scipy.sparse as sparse
    data = scipy.io.loadmat(source)
    q = np.asarray(data["q"], dtype=float).ravel()
    n, A = len(q), sparse.csc_matrix(data["A"])
    low, high = (np.where(np.abs(v) >= FAR, np.copysign(math.inf, v), v)
                 for v in (np.asarray(data[key], dtype=float).ravel() for key in "lu"))
    has_bounds = A.shape[0] >= n and (A[A.shape[0] - n:] != sparse.identity(n, format="csc")).nnz == 0
    m = A.shape[0] - n if has_bounds else A.shape[0]
    sides = (low[m:], high[m:]) if has_bounds else (np.full(n, -math.inf), np.full(n, math.inf))

    def entries(matrix):
        matrix = sparse.coo_matrix(matrix)
        return matrix.row, matrix.col, matrix.data
    return program(name, n, m, entries(sparse.tril(data["P"])), entries(A[:m]), q, sides, (low[:m], high[:m]),
                   float(np.asarray(data["r"]).ravel()[0]))


class _Qps:
    """The sections of a QPS file. The first row of type N is the objective."""

    def __init__(self, source):
        self.source, self.kinds, self.rows, self.columns = source, {}, {}, {}
        self.objective, self.section = None, ""
        self.gradient, self.entries, self.right, self.ranges = {}, {}, {}, {}
        self.lower, self.upper, self.hessian, self.integer = {}, {}, {}, set()
        self.in_integers, self.has_spaces = False, False
        with open(source, encoding="latin-1") as file:
            for self.number, line in enumerate(file, 1):
                if line[:1] == "*" or not line.strip():
                    continue
                if line[0] not in " \t":
                    self.section = line.split()[0].upper()
                    if self.section == "ENDATA":
                        return
                    if self.section not in ("NAME", "ROWS", "COLUMNS", "RHS", "RANGES", "BOUNDS", "QUADOBJ", "QMATRIX", "OBJSENSE"):
                        raise self.mistake(f"the section {self.section} is not supported")
                    continue
                try:
                    self._take(self._words(line.rstrip()))
                except (KeyError, IndexError, ValueError) as error:
                    raise self.mistake(f"the section {self.section} has an invalid entry: {error}") from None
        raise self.mistake("it ends without ENDATA")

    def mistake(self, sentence):
        return ValueError(f"'{self.source}', line {self.number}: {sentence}")

    def _words(self, line):
        """Names with spaces are read by their columns."""
        words = line.split()
        self.has_spaces = self.has_spaces or (self.section == "ROWS" and len(words) > 2)
        if not self.has_spaces:
            return words
        fields = [line[a:b].strip() for a, b in ((1, 3), (4, 12), (14, 22), (24, 36), (39, 47), (49, 61))]
        return [word for word in fields if word]

    def _take(self, words):
        if self.section == "ROWS":
            kind, name = words
            if kind == "N":
                self.objective = self.objective or name
            else:
                self.rows[name] = len(self.kinds)
                self.kinds[len(self.kinds)] = kind
        elif self.section == "COLUMNS":
            if len(words) > 2 and words[1] == "'MARKER'":
                self.in_integers = words[2] == "'INTORG'"
                return
            column = self.columns.setdefault(words[0], len(self.columns))
            if self.in_integers:
                self.integer.add(column)
            for name, value in self._pairs(words[1:]):
                if name == self.objective:
                    self.gradient[column] = value
                elif name in self.rows:
                    self.entries[self.rows[name], column] = value
        elif self.section in ("RHS", "RANGES"):
            target = self.right if self.section == "RHS" else self.ranges
            for name, value in self._pairs(words[len(words) % 2:]):
                target[self.rows.get(name, -1) if name == self.objective else self.rows[name]] = value
        elif self.section == "BOUNDS":
            self._bound(words)
        elif self.section in ("QUADOBJ", "QMATRIX"):
            a = self.columns[words[0]]
            for name, value in self._pairs(words[1:]):
                b = self.columns[name]
                self.hessian[max(a, b), min(a, b)] = value
        elif self.section == "OBJSENSE" and words[0].upper().startswith("MAX"):
            raise ValueError("programs with a maximum are not supported")

    @staticmethod
    def _pairs(words):
        return [(words[i], float(words[i + 1])) for i in range(0, len(words), 2)]

    def _bound(self, words):
        kind, with_value = words[0], words[0] not in ("FR", "MI", "PL", "BV")
        column = self.columns[words[-2] if with_value else words[-1]]
        value = float(words[-1]) if with_value else math.nan
        if kind in ("LO", "LI", "FX"):
            self.lower[column] = value
        if kind in ("UP", "UI", "FX"):
            self.upper[column] = value
            if value < 0 and kind != "FX":
                self.lower.setdefault(column, -math.inf)
        if kind in ("FR", "MI"):
            self.lower[column] = -math.inf
        if kind == "BV":
            self.upper[column] = 1.0
        if kind in ("LI", "UI", "BV"):
            self.integer.add(column)


def from_qps(name, source):
    data = _Qps(source)
    n, m = len(data.columns), len(data.rows)
    low, high = np.full(m, -math.inf), np.full(m, math.inf)
    for row, kind in data.kinds.items():
        right, width = data.right.get(row, 0.0), data.ranges.get(row)
        if kind in "GE":
            low[row] = right
        if kind in "LE":
            high[row] = right
        if width is not None:
            if kind == "G" or (kind == "E" and width >= 0):
                high[row] = right + abs(width)
            else:
                low[row] = right - abs(width)
    gradient = np.zeros(n)
    gradient[list(data.gradient)] = list(data.gradient.values())

    def triples(entries):
        keys = sorted(entries)
        return [i for i, _ in keys], [j for _, j in keys], [entries[key] for key in keys]
    found = program(name, n, m, triples(data.hessian), triples(data.entries), gradient,
                    ([data.lower.get(i, 0.0) for i in range(n)], [data.upper.get(i, math.inf) for i in range(n)]),
                    (low, high), -data.right.get(-1, 0.0))
    return {**found, "integer": sorted(data.integer)} if data.integer else found


READERS = {".npz": from_npz, ".mat": from_mat, ".qps": from_qps, ".sif": from_qps}


def read(name, source):
    """Raises ValueError with one sentence."""
    try:
        return READERS[os.path.splitext(source)[1].lower()](name, source)
    except KeyError as error:
        raise ValueError(f"'{source}' has no matrix or vector {error}, or only as a Python object") from None


# The table prints ten times this value. An exact active-set method, at violations below 1e-14, finds it, and the printed
# optima of LISWET7 and LISWET9 to LISWET12.
CORRECTED = {"liswet8": 714.47006}


def published_optima(table):
    """Optima of the table of Maros and Meszaros (name, sizes, optimum), by normalised name, with CORRECTED."""
    found = {}
    with open(table, encoding="latin-1") as file:
        for line in file:
            words = line.split()
            if len(words) == 7 and all(word.isdigit() for word in words[1:6]):
                found[normalised(words[0])] = float(words[6])
    return {name: CORRECTED.get(name, optimum) for name, optimum in found.items()}


def normalised(name):
    return name.lower().replace("_", "").replace("-", "")
