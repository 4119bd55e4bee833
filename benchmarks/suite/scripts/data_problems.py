"""Problems from data: random ones with stages; published ones in our words (suite/problems); public sets that `bench fetch`
copied, and files in the folder SALTUS_REFERENCE_DATA; files in the folder SALTUS_BENCH_PROGRAMS.

Files have any format of problem_files.py. A table expected.csv next to the files of SALTUS_REFERENCE_DATA, of its folder
mpc_qp or of its folder data may give known optima, in its sixth column."""

import glob
import json
import math
import os

import numpy as np

import control_problem
import integer_problems
import loops
import nosbench
import problem_files
import public_sets
import quadratic_files

PUBLIC, OWN, BOX, RESTATED, INTEGER = "public/", "own/", "box/", "restated/", integer_problems.PREFIX
LOOP, SHOOTING = loops.PREFIX, "shooting/"
SIZES = ((4, 1), (8, 3), (12, 4), (24, 12))  # states, inputs of the random programs
INTERVALS, LONG = 20, (1000, 10000)
LARGE = 1_000_000  # bytes of a file above which a problem is not in the default set
STATEMENTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../problems")
QPS_TABLE = "00README.QP"


def described():
    """Descriptions in the form of the program's own problems. `origin` is "ours" unless the problem is published;
    `on_request` problems are not in the default set."""
    boxes = [_box_description(f"{BOX}{nx}x{nu}", INTERVALS) for nx, nu in SIZES]
    boxes += [{**_box_description(f"{BOX}8x3x{n}", n), "instances": 1, "on_request": True} for n in LONG]
    found = [_description(RESTATED + name, file, "restated") for name, file in sorted(_restated().items())]
    found += [{**_description(SHOOTING + name, file, "restated"), "on_request": True} for name, file in _for_shooting().items()]
    found += [_description(PUBLIC + name, file, "public") for name, (file, _) in sorted(_public().items())]
    found += [_description(OWN + name, file, "own file") for name, file in sorted(_own().items())]
    return boxes + integer_problems.described() + loops.described() + found


def _box_description(name, intervals):
    return {"name": name, "about": "random dynamics and boxes; the instance is the seed", "instances": 0,
            "horizon": intervals, "warm": False}


def _description(name, file, origin):
    about = {"own file": "a file of SALTUS_BENCH_PROGRAMS", "public": f"the public file {os.path.basename(file)}"}.get(origin, "")
    common = {"name": name, "instances": 1, "origin": origin, "on_request": os.path.getsize(file) > LARGE}
    if name.startswith(PUBLIC):
        return {**common, "about": about, "horizon": 0, "warm": False,
                **({"kind": "complementarity"} if name.startswith(PUBLIC + "nosbench/") else {})}
    return {**common, "about": about, **_facts(file)}


def _facts(file):
    """Kind, number of intervals, presence of a warm start; an invalid file is reported by its task."""
    facts = {"horizon": 0, "warm": False}
    if not file.endswith(".json"):
        return facts
    try:
        with open(file, encoding="utf-8") as opened:
            data = json.load(opened)
        facts |= {key: data[key] for key in ("about",) if isinstance(data.get(key), str)}
        if nosbench.is_nosbench(data):
            return {**facts, "kind": "complementarity"}
        if data.get("format") == problem_files.QP:
            return {**facts, "horizon": max(0, len(data.get("stages", [])) - 1), "warm": "warm" in data,
                    **({"kind": "integer"} if is_mixed_integer(data) else {})}
        facts["kind"] = "complementarity" if "complementarity" in problem_files.kind_of(data) else "nonlinear"
        return {**facts, "horizon": sum(int(phase.get("intervals", 0)) for phase in data.get("phases", []))}
    except (OSError, ValueError, AttributeError, TypeError, KeyError):
        return facts


def is_data(problem):
    return problem.startswith((PUBLIC, OWN, BOX, RESTATED, INTEGER, LOOP, SHOOTING))


def is_mixed_integer(data):
    """True for quadratic programs whose integer variables are not relaxed."""
    return bool(data.get("format") == problem_files.QP and data.get("integer") and data.get("optimum_of") != "relaxation")


def source_of(problem):
    """The file of a problem and further facts about it, or None if the program generates it."""
    if problem.startswith(OWN):
        return (_own()[problem[len(OWN):]],)
    for prefix in (RESTATED, SHOOTING):
        if problem.startswith(prefix):
            return (_restated()[problem[len(prefix):]],)
    return _public()[problem[len(PUBLIC):]] if problem.startswith(PUBLIC) else None


def write(problem, instance, path):
    """Writes a program in a format that solvers read. Raises ValueError with one sentence."""
    if problem.startswith(BOX):
        nx, nu, *intervals = (int(word) for word in problem[len(BOX):].split("x"))
        program = _box(problem, nx, nu, instance, *intervals)
    elif problem.startswith(INTEGER):
        program = integer_problems.program(problem, instance)
    else:
        source, *optimum = source_of(problem)
        data = problem_files.read(source, problem)
        problem_files.validate(data, source)
        program = {**problem_files.program_of(data, is_shooting=problem.startswith(SHOOTING)), "problem": problem, "instance": instance}
        if program.get("integer") and not is_mixed_integer(data):  # solvers solve the relaxation
            del program["integer"]
            if data.get("optimum_of") != "relaxation":
                program["optimum"] = None
        if optimum:
            program["optimum"] = optimum[0]
    with open(path, "w", encoding="utf-8") as file:
        json.dump(program, file)


def _own():
    folder = os.environ.get("SALTUS_BENCH_PROGRAMS", "")
    return _files_of(folder) if folder else {}


def _restated():
    return _files_of(STATEMENTS)


def _for_shooting():
    """Restated problems that are also offered with explicit steps between their stages, for solvers that need them."""
    found = {}
    for name, path in _restated().items():
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        if data.get("format") == problem_files.OCP and control_problem.ControlProblem(data).is_for_shooting():
            found[name] = path
    return found


def _files_of(folder):
    return {os.path.splitext(os.path.basename(path))[0]: path for path in sorted(glob.glob(os.path.join(folder, "*")))
            if os.path.splitext(path)[1].lower() in problem_files.ENDINGS}


def _public():
    """Name -> (file, known optimum or None)."""
    folder, found = os.environ.get("SALTUS_REFERENCE_DATA", ""), {}
    for place in [os.path.join(folder, name) for name in ("", "mpc_qp", "data")] if folder else []:
        optima = _optima(os.path.join(place, "expected.csv"))
        for name, file in _files_of(place).items():
            if not file.endswith(".json"):
                found.setdefault(name, (file, optima.get(name)))
    table = os.path.join(public_sets.folder_of("maros-meszaros-qps"), QPS_TABLE)
    published = quadratic_files.published_optima(table) if os.path.exists(table) else {}
    for name in public_sets.SETS:
        known = published if name.startswith("maros-meszaros") else {}
        for problem, file in public_sets.files_of(name).items():
            found[f"{name}/{problem}"] = (file, known.get(quadratic_files.normalised(problem)))
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


def _box(problem, nx, nu, seed, intervals=INTERVALS):
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
    for _ in range(intervals):
        x = A @ x + B @ (0.5 * uniform(nu))
        low, high = np.minimum(low, x), np.maximum(high, x)
    boxed = np.arange(nx) % 3 == 0
    stage = nx + nu
    n, m = intervals * stage + nx, intervals * nx

    def tile(matrix, row, col, down, right, count):
        """The nonzeros of a matrix at (row, col), repeated `count` times."""
        i, j = np.nonzero(matrix)
        k = np.arange(count)[:, None]
        return (row + i + k * down).ravel(), (col + j + k * right).ravel(), np.tile(matrix[i, j], count)

    def joined(*tiles):
        """Triples in the order of rows, then columns."""
        row, col, value = (np.concatenate(parts) for parts in zip(*tiles))
        order = np.lexsort((col, row))
        return row[order], col[order], value[order]
    hessian = joined(tile(np.tril(Q), 0, 0, stage, stage, intervals + 1), tile(R, nx, nx, stage, stage, intervals))
    jacobian = joined(tile(A, 0, 0, nx, stage, intervals), tile(B, 0, nx, nx, stage, intervals),
                      tile(-np.eye(nx), 0, stage, nx, stage, intervals))
    gradient, lower, upper = np.zeros(n), np.full(n, -1.0), np.full(n, 1.0)
    for k in range(intervals + 1):
        at = slice(k * stage, k * stage + nx)
        gradient[at] = -Q @ target
        lower[at] = start if k == 0 else np.where(boxed, low - 0.05, -math.inf)
        upper[at] = start if k == 0 else np.where(boxed, high + 0.05, math.inf)
    program = quadratic_files.program(problem, n, m, hessian, jacobian, gradient, (lower, upper), (np.zeros(m), np.zeros(m)),
                                      float((intervals + 1) * 0.5 * target @ Q @ target))
    return {**program, "instance": seed, "stages": [[nx, nu, 0]] * intervals + [[nx, 0, 0]]}
