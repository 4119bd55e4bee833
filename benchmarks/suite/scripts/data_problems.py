"""Programs from data: random ones with stages, the public ones of mpc_qpbenchmark (SALTUS_REFERENCE_DATA names the
folder above mpc_qp), and files of the format "saltus-qp 1" in the folder SALTUS_BENCH_PROGRAMS."""

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
    found = [(PUBLIC + name, "a quadratic program of a walking robot, from mpc_qpbenchmark")
             for name in sorted(_public())]
    found += [(OWN + name, "a file of SALTUS_BENCH_PROGRAMS") for name in sorted(_own())]
    boxes = [{"name": f"{BOX}{nx}x{nu}", "about": "random dynamics and boxes; the instance is the seed",
              "instances": 0, "horizon": INTERVALS, "warm": False} for nx, nu in SIZES]
    return boxes + [{"name": name, "about": about, "instances": 1, "horizon": 0, "warm": False}
                    for name, about in found]


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
    with open(path, "w", encoding="utf-8") as file:
        json.dump(_convert(problem, source, optimum), file)


def _own():
    folder = os.environ.get("SALTUS_BENCH_PROGRAMS", "")
    return {os.path.basename(path)[:-5]: path
            for path in glob.glob(os.path.join(folder, "*.json"))} if folder else {}


def _public():
    """Name -> (file, known optimum)."""
    folder = os.environ.get("SALTUS_REFERENCE_DATA", "")
    table = os.path.join(folder, "mpc_qp", "expected.csv")
    if not folder or not os.path.exists(table):
        return {}
    found = {}
    with open(table, encoding="utf-8") as file:
        for line in file:
            if line.strip() and not line.startswith("#"):
                words = line.split(",")
                found[words[0].removesuffix(".npz")] = (
                    os.path.join(folder, "mpc_qp", words[0]), float(words[5]))
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
