"""Programs from data: random ones with stages, public ones in the folder SALTUS_REFERENCE_DATA, and files of the format
"saltus-qp 1" in the folder SALTUS_BENCH_PROGRAMS.

Public programs are files NAME.npz as qpsolvers saves them (mpc_qpbenchmark), and files NAME.mat with P, q, r, A, l, u
(Maros-Meszaros). They may be in the folder itself or in its folders mpc_qp or data. A table expected.csv next to them
may give known optima, in its sixth column."""

import glob
import json
import math
import os
import shutil

import numpy as np

PUBLIC, OWN, BOX = "public/", "own/", "box/"
SIZES = ((4, 1), (8, 3), (12, 4), (24, 12))  # states, inputs of the random programs
INTERVALS = 20


def described():
    """Descriptions in the form of the program's own problems."""
    found = [{"name": PUBLIC + name, "about": f"the public file {os.path.basename(file)}", "instances": 1, "horizon": 0,
              "warm": False} for name, (file, _) in sorted(_public().items())]
    found += [{"name": OWN + name, "about": "a file of SALTUS_BENCH_PROGRAMS", "instances": 1, **_facts(file)}
              for name, file in sorted(_own().items())]
    boxes = [{"name": f"{BOX}{nx}x{nu}", "about": "random dynamics and boxes; the instance is the seed",
              "instances": 0, "horizon": INTERVALS, "warm": False} for nx, nu in SIZES]
    return boxes + found


def _facts(file):
    """Number of intervals and presence of a warm start; an invalid file is reported by its task."""
    try:
        with open(file, encoding="utf-8") as opened:
            data = json.load(opened)
        return {"horizon": max(0, len(data.get("stages", [])) - 1), "warm": "warm" in data}
    except (OSError, ValueError, AttributeError, TypeError):
        return {"horizon": 0, "warm": False}


def is_data(problem):
    return problem.startswith((PUBLIC, OWN, BOX))


def source_of(problem):
    """The file of a problem and further facts about it, or None if the program generates it."""
    if problem.startswith(OWN):
        return (_own()[problem[len(OWN):]],)
    return _public()[problem[len(PUBLIC):]] if problem.startswith(PUBLIC) else None


def write(problem, instance, path):
    """Writes a program in the format of the program."""
    if problem.startswith(BOX):
        nx, nu = (int(word) for word in problem[len(BOX):].split("x"))
        with open(path, "w", encoding="utf-8") as file:
            json.dump(_box(problem, nx, nu, instance), file)
        return
    if problem.startswith(OWN):
        shutil.copyfile(source_of(problem)[0], path)
        return
    source, optimum = source_of(problem)
    try:
        converted = (_from_mat if source.endswith(".mat") else _convert)(problem, source, optimum)
    except KeyError as error:
        raise ValueError(f"'{source}' has no matrix or vector {error}, or only as a Python object") from None
    with open(path, "w", encoding="utf-8") as file:
        json.dump(converted, file)


def _own():
    folder = os.environ.get("SALTUS_BENCH_PROGRAMS", "")
    return {os.path.basename(path)[:-5]: path
            for path in glob.glob(os.path.join(folder, "*.json"))} if folder else {}


def _public():
    """Name -> (file, known optimum or None)."""
    folder, found = os.environ.get("SALTUS_REFERENCE_DATA", ""), {}
    for place in [os.path.join(folder, name) for name in ("", "mpc_qp", "data")] if folder else []:
        optima = _optima(os.path.join(place, "expected.csv"))
        for ending in (".npz", ".mat"):
            for file in sorted(glob.glob(os.path.join(place, "*" + ending))):
                name = os.path.basename(file).removesuffix(ending)
                found.setdefault(name, (file, optima.get(name)))
    return found


def _optima(table):
    """Known optima by name, if there is a table of them."""
    found = {}
    if os.path.exists(table):
        with open(table, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if line.strip() and not line.startswith("#"):
                    words = line.split(",")
                    try:
                        found[words[0].removesuffix(".npz")] = float(words[5])
                    except (IndexError, ValueError):
                        raise ValueError(f"'{table}', line {number}: its sixth column must be the known optimum") from None
    return found


def _entries(matrix):
    row, col = np.nonzero(matrix)
    return {"row": row.tolist(), "col": col.tolist(), "value": matrix[row, col].tolist()}


def _sides(values):
    return [None if math.isinf(v) else float(v) for v in values]


def _convert(problem, source, optimum):
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
    jacobian = np.vstack([G, A])
    absent = np.full(n, math.inf)
    return {"format": "saltus-qp 1", "problem": problem, "instance": 1, "variables": n,
            "rows": len(jacobian), "hessian": _entries(np.tril(data["P"])),
            "jacobian": _entries(jacobian), "gradient": data["q"].ravel().tolist(),
            "constant": 0.0, "lower": _sides(data.get("lb", -absent)),
            "upper": _sides(data.get("ub", absent)),
            "row_lower": [None] * len(h) + b.tolist(), "row_upper": _sides([*h, *b]), "stages": [],
            "optimum": optimum}


FAR = 1e20  # infinity in the files of Maros-Meszaros


def _from_mat(problem, source, optimum):
    """min 1/2 x'Px + q'x + r subject to l <= A x <= u, whose last rows are the bounds of the variables."""
    import scipy.io
    import scipy.sparse as sparse
    data = scipy.io.loadmat(source)
    q = np.asarray(data["q"], dtype=float).ravel()
    n, A = len(q), sparse.csc_matrix(data["A"])
    low, high = (np.where(np.abs(v) >= FAR, np.copysign(math.inf, v), v)
                 for v in (np.asarray(data[key], dtype=float).ravel() for key in "lu"))
    has_bounds = A.shape[0] >= n and (A[A.shape[0] - n:] != sparse.identity(n, format="csc")).nnz == 0
    m = A.shape[0] - n if has_bounds else A.shape[0]
    lower, upper = (low[m:], high[m:]) if has_bounds else (np.full(n, -math.inf), np.full(n, math.inf))

    def entries(matrix):
        matrix = sparse.coo_matrix(matrix)
        return {"row": matrix.row.tolist(), "col": matrix.col.tolist(), "value": matrix.data.tolist()}
    return {"format": "saltus-qp 1", "problem": problem, "instance": 1, "variables": n, "rows": m,
            "hessian": entries(sparse.tril(data["P"])), "jacobian": entries(A[:m]), "gradient": q.tolist(),
            "constant": float(np.asarray(data["r"]).ravel()[0]), "lower": _sides(lower), "upper": _sides(upper),
            "row_lower": _sides(low[:m]), "row_upper": _sides(high[:m]), "stages": [], "optimum": optimum}


def _box(problem, nx, nu, seed):
    """Dynamics near the stability limit, with a start inside the bounds. Every third state has bounds just outside the
    reach of some admissible inputs, so the program is feasible by construction. The cost has a target beyond the
    bounds."""
    random = np.random.default_rng(seed)

    def uniform(*shape):
        return random.uniform(-1.0, 1.0, shape)
    A = 0.95 * np.eye(nx) + 0.2 / math.sqrt(nx) * uniform(nx, nx)
    B, J = 0.3 * uniform(nx, nu), uniform(nx, nx)
    Q, R = 0.1 / nx * J.T @ J + 0.1 * np.eye(nx), 0.1 * np.eye(nu)
    target, start = 3.0 * uniform(nx), uniform(nx)
    x, low, high = start, np.full(nx, math.inf), np.full(nx, -math.inf)
    for _ in range(INTERVALS):
        x = A @ x + B @ (0.5 * uniform(nu))
        low, high = np.minimum(low, x), np.maximum(high, x)
    boxed = np.arange(nx) % 3 == 0
    stage = nx + nu
    n, m = INTERVALS * stage + nx, INTERVALS * nx
    hessian, jacobian = np.zeros((n, n)), np.zeros((m, n))
    gradient, lower, upper = np.zeros(n), np.full(n, -1.0), np.full(n, 1.0)
    for k in range(INTERVALS + 1):
        at = slice(k * stage, k * stage + nx)
        hessian[at, at], gradient[at] = Q, -Q @ target
        lower[at] = start if k == 0 else np.where(boxed, low - 0.05, -math.inf)
        upper[at] = start if k == 0 else np.where(boxed, high + 0.05, math.inf)
        if k == INTERVALS:
            break
        inputs, rows = slice(at.stop, at.stop + nu), slice(k * nx, (k + 1) * nx)
        hessian[inputs, inputs] = R
        jacobian[rows, at], jacobian[rows, inputs] = A, B
        jacobian[rows, inputs.stop:inputs.stop + nx] = -np.eye(nx)
    return {"format": "saltus-qp 1", "problem": problem, "instance": seed, "variables": n, "rows": m,
            "hessian": _entries(np.tril(hessian)), "jacobian": _entries(jacobian),
            "gradient": gradient.tolist(),
            "constant": float((INTERVALS + 1) * 0.5 * target @ Q @ target),
            "lower": _sides(lower), "upper": _sides(upper), "row_lower": [0.0] * m,
            "row_upper": [0.0] * m, "stages": [[nx, nu, 0]] * INTERVALS + [[nx, 0, 0]]}
