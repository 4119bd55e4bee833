"""Compares our search over mode sequences with SCIP, a global solver of mixed-integer programs.

Usage: compare_mode_search.py PROGRAM PROBLEM PHASES STARTS [--limit SECONDS] [--from FIRST]

PROGRAM is the built mode_search. PROBLEM is walls, thermostats or tanks. The models are written again from the
equations in problems/library/s0*.cpp. SCIP solves the same starts with gap 0 and feasibility 1e-9. Prints a line per
start. Exits with 1 if an optimum differs by more than 1e-6 of its size or ours lies outside SCIP's bounds. Needs the
packages pyscipopt (PyPI) and numpy. Without them it prints a message and exits with 77, which ctest counts as skipped.
"""

import argparse
import csv
import subprocess
import sys

try:
    import numpy as np
    from pyscipopt import Model, quicksum
except ImportError as error:
    print(f"skipped: {error.name} is not installed (pip install pyscipopt numpy), so there is no reference")
    sys.exit(77)

AGREEMENT = 1e-6  # relative


def held(A, B, h):
    """Exact flow of x' = A x + B u over the time h with constant u."""
    n, m = B.shape
    M = np.zeros((n + m, n + m))
    M[:n, :n], M[:n, n:] = A * h, B * h
    E, term = np.eye(n + m), np.eye(n + m)
    for k in range(1, 60):
        term = term @ M / k
        E = E + term
    return E[:n, :n], E[:n, n:]


def new_model(limit):
    model = Model()
    model.hideOutput()
    model.setParam("limits/gap", 0.0)
    model.setParam("numerics/feastol", 1e-9)
    model.setParam("numerics/dualfeastol", 1e-9)
    model.setParam("limits/time", limit)
    model.setParam("timing/clocktype", 1)  # processor time
    model.setParam("parallel/maxnthreads", 1)
    return model


def free(model, lower, upper):
    return model.addVar(lb=float(lower), ub=float(upper))


def minimise(model, squares, rest=0.0):
    """Minimises the sum of weight * expression^2 plus the linear cost `rest`. Each square has its own row, because SCIP
    then takes seconds; with one row for the whole cost it takes minutes."""
    total = rest
    for weight, expression in squares:
        t = model.addVar()
        model.addCons(t >= weight * expression * expression)
        total += t
    model.setObjective(total)


def walls(model, x0, N):
    M = m = l = 1.0
    g, d, k, c, h = 10.0, 0.5, 100.0, 5.0, 0.1
    P = np.array([[2.7759, -13.1622, 3.2139, -4.2597], [-13.1622, 319.1374, -31.5828, 84.9549],
                  [3.2139, -31.5828, 7.4944, -10.2841], [-4.2597, 84.9549, -10.2841, 23.6365]])
    top = np.array([0.5, np.pi / 10, 2.0, 2.0])
    tip = np.array([1.0, -l, 0.0, 0.0])
    rate = np.array([0.0, 0.0, 1.0, -l])
    modes = []  # A, B, b, least tip, largest tip
    for wall in (0, 1, -1):
        A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [0, m * g / M, 0, 0], [0, (M + m) * g / (M * l), 0, 0]], float)
        B = np.array([[0, 0], [0, 0], [1 / M, 0], [1 / (M * l), 0]])
        if wall:  # F = -k (y - wall d) - c y'
            A[3] += (k * tip + c * rate) / (m * l)
            B[3, 1] = -k * wall * d / (m * l)
        Ad, Bd = held(A, B, h)
        low, high = (-d, d) if wall == 0 else ((d, 2.0) if wall == 1 else (-2.0, -d))
        modes.append((Ad, Bd[:, :1], Bd[:, 1], low, high))
    # The start is given, so its possible modes are known and it has no copies.
    x = [[float(v) for v in x0]] + [[free(model, -b, b) for b in top] for _ in range(N)]
    u = [free(model, -1, 1) for _ in range(N)]
    for s in range(N):
        copies, inputs, shares = [], [], []
        for A, B, b, low, high in modes:
            share = model.addVar(vtype="B")
            ui = free(model, -1, 1)
            model.addCons(ui <= share)
            model.addCons(ui >= -1 * share)
            if s == 0:
                xi = [float(v) * share for v in x0]
                if not low <= tip @ x0 <= high:
                    model.addCons(share == 0)
            else:
                xi = [free(model, -v, v) for v in top]
                for i in range(4):
                    model.addCons(xi[i] <= top[i] * share)
                    model.addCons(xi[i] >= -top[i] * share)
                model.addCons(quicksum(tip[i] * xi[i] for i in range(4)) <= high * share)
                model.addCons(quicksum(tip[i] * xi[i] for i in range(4)) >= low * share)
            copies.append(xi), inputs.append(ui), shares.append(share)
        model.addCons(quicksum(shares) == 1)
        model.addCons(u[s] == quicksum(inputs))
        for i in range(4):
            if s > 0:
                model.addCons(x[s][i] == quicksum(xi[i] for xi in copies))
            model.addCons(x[s + 1][i] == quicksum(
                A[i, j] * xi[j] for (A, *_), xi in zip(modes, copies) for j in range(4) if A[i, j]) + quicksum(
                    B[i, 0] * ui + b[i] * share for (_, B, b, *_), ui, share in zip(modes, inputs, shares)))
    squares = [(0.5 * h, v) for state in x[1:N] for v in state] + [(0.5 * h, v) for v in u]
    for column in np.linalg.cholesky(P).T:
        y = free(model, -100, 100)
        model.addCons(y == quicksum(column[i] * x[N][i] for i in range(4)))
        squares.append((0.5, y))
    minimise(model, squares, 0.5 * h * float(x0 @ x0))


def changes(model, switches, N):
    """Variables that are 1 if a switch differs from the previous step."""
    c = [None] + [model.addVar(vtype="B") for _ in range(N - 1)]
    for k in range(1, N):
        for s in switches:
            model.addCons(c[k] >= s[k] - s[k - 1])
            model.addCons(c[k] >= s[k - 1] - s[k])
    return c


def thermostats(model, x0, N):
    h, outside, wanted, loss, exchange, heating, price = 1 / 6, 2.0, 21.0, 0.25, 0.4, 9.0, 0.6
    L = np.array([[1, -1, 0], [-1, 2, -1], [0, -1, 1]], float)
    A, B = held(-loss * np.eye(3) - exchange * L, np.hstack([heating * np.eye(3), np.full((3, 1), loss * outside)]), h)
    T = [[free(model, v, v) for v in x0]] + [[free(model, 17, 25) for _ in range(3)] for _ in range(N)]
    s = [[model.addVar(vtype="B") for _ in range(N)] for _ in range(3)]
    for k in range(N):
        model.addCons(s[0][k] + s[1][k] + s[2][k] <= 2)
        for i in range(3):
            model.addCons(T[k + 1][i] == quicksum(A[i, j] * T[k][j] + B[i, j] * s[j][k] for j in range(3)) + B[i, 3])
    c = changes(model, s, N)
    for k in range(1, min(3, N)):
        model.addCons(c[k] == 0)
    for k in range(1, N):
        for j in range(k + 1, min(k + 3, N)):
            model.addCons(c[k] + c[j] <= 1)
    squares = [(0.5 * h if k < N else 0.5, T[k][i] - wanted) for k in range(N + 1) for i in range(3)]
    minimise(model, squares, quicksum(price * h * s[i][k] for k in range(N) for i in range(3)))


def tanks(model, x0, N):
    h, section, flow, leak = 30.0, 0.0154, 1e-4, 0.0008
    q = flow / section
    A, B = held(-leak * np.eye(2), np.array([[q, -q, 0], [0, q, -q]]), h)
    x = [[free(model, v, v) for v in x0]] + [[free(model, 0.05, 0.6) for _ in range(2)] for _ in range(N)]
    s = [[model.addVar(vtype="B") for _ in range(N)] for _ in range(2)]
    v = [free(model, 0, 1) for _ in range(N)]
    for k in range(N):
        for i in range(2):
            model.addCons(x[k + 1][i] == quicksum(A[i, j] * x[k][j] + B[i, j] * s[j][k] for j in range(2)) + B[i, 2] * v[k])
    c = changes(model, s, N)
    for k in range(1, N):
        for i in range(2):
            if k == 1:
                model.addCons(c[1] + s[i][0] <= 1)
            if k + 1 < N:
                model.addCons(c[k] + c[k + 1] + s[i][k] <= 2)
    squares = []
    for i, (wanted, weight, at_end) in enumerate(((0.3, 5.0, 50.0), (0.4, 20.0, 200.0))):
        squares += [(weight if k < N else at_end, x[k][i] - wanted) for k in range(N + 1)]
    squares += [(2.0, v[k] - 0.6) for k in range(N)]
    minimise(model, squares, quicksum(0.05 * (s[0][k] + s[1][k]) for k in range(N)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("problem", choices=("walls", "thermostats", "tanks"))
    parser.add_argument("phases", type=int)
    parser.add_argument("starts", type=int)
    parser.add_argument("--limit", type=float, default=3600.0, help="seconds of processor time for SCIP per start")
    parser.add_argument("--from", type=int, default=0, dest="first", help="first start to compare")
    options = parser.parse_args()
    command = [options.program, options.problem, str(options.phases), str(options.first + options.starts)]
    ours = list(csv.DictReader(subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()))
    wrong = 0
    print("start      ours           nodes  s         SCIP           bound          nodes   s        difference")
    for line in ours[options.first:]:
        model = new_model(options.limit)
        globals()[options.problem](model, np.array([float(v) for v in line["state"].split()]), options.phases)
        model.optimize()
        cost, status = float(line["cost"]), model.getStatus()
        infeasible = status == "infeasible"
        theirs = float("inf") if infeasible or model.getNSols() == 0 else model.getObjVal()
        bound = float("inf") if infeasible else model.getDualbound()
        size = max(abs(cost), 1e-12)
        if infeasible or cost == float("inf"):
            difference = 0.0 if infeasible and cost == float("inf") else float("inf")
            good = difference == 0.0 or not (infeasible or status == "optimal")
        elif status == "optimal":
            difference = abs(cost - theirs) / size
            good = difference <= AGREEMENT
        else:
            difference = max(bound - cost, cost - theirs, 0.0) / size
            good = difference <= AGREEMENT
        wrong += not good
        print(f"{line['start']:>5}  {cost:<14.9g} {line['nodes']:>6}  {float(line['seconds']):<8.3f} {theirs:<14.9g} {bound:<14.9g} "
              f"{model.getNTotalNodes():>6}  {model.getSolvingTime():<8.2f} {difference:.1e} {status}{'' if good else '  WRONG'}", flush=True)
    print(f"{len(ours) - options.first} starts, {wrong} differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
