"""The results as one table: a row per problem and start, a column per solver."""

import math
import statistics

import figures


def solvers_of(records):
    return records.head["matrix"]["solvers"]


def cell_text(lines):
    if not lines:
        return "-"
    times = [t for t in map(figures.time_of, lines) if t]
    missed = sum(line["verdict"] != "solved" for line in lines)
    text = f"{figures.quartiles(times)[1]:.0f}" if times else "-"
    return text + (f" ({missed} missed)" if missed else "")


# Kinds of problems, in the order of the report. Quadratic programs have a class per start.
CLASSES = {"cold": "quadratic programs, cold", "warm": "quadratic programs, warm", "nonlinear": "nonlinear problems",
           "file": "optimal control and nonlinear programs as data", "complementarity": "programs with complementarity",
           "integer": "mixed-integer programs", "loop": "closed loops"}


def class_of(task, kinds):
    if task.startswith("library/"):
        return CLASSES["nonlinear"]
    return CLASSES.get({"nonlinear": "file"}.get(kinds.get(task), kinds.get(task)), CLASSES[
        "warm" if task.endswith(" warm") else "cold"])


def groups(records):
    """(class, its tasks), of the classes that exist. They are never mixed: solvers and meaning of the times differ."""
    found, kinds = {}, records.head["matrix"].get("kinds", {})
    for task in records.tasks:
        found.setdefault(class_of(task, kinds), []).append(task)
    return [(name, found[name]) for name in CLASSES.values() if name in found]


# Two columns of the same solver.
LABELS = {"riccati": "riccati (sizes compiled in)", "riccati-generic": "riccati-generic (as a user gets it)"}


def labels(names):
    return [LABELS.get(name, name) for name in names]


def rows(records, tasks):
    cells = figures.by_cell(records)
    names = [s for s in solvers_of(records) if any((task, s) in cells for task in tasks)]
    yield ["us per solve, medians", *labels(names)]
    for task in tasks:
        yield [task, *(cell_text(cells.get((task, name))) for name in names)]


def write_text(records, out):
    for _, tasks in groups(records):
        write_rows(rows(records, tasks), out)


def closed_loop_costs(records):
    """`loop/masses cold: closed-loop cost 19.5 (piqp), largest 19.6 (osqp)`, for the solvers that finished the loop."""
    cells = figures.by_cell(records)
    for name, tasks in groups(records):
        for task in tasks if name == CLASSES["loop"] else ():
            costs = {solver: statistics.median(line.get("objective", math.inf) for line in lines)
                     for (of, solver), lines in cells.items() if of == task}
            known = {solver: cost for solver, cost in costs.items() if cost < math.inf}
            if known:
                low, high = min(known, key=known.get), max(known, key=known.get)
                yield f"{task}: closed-loop cost {known[low]:.8g} ({low}), largest {known[high]:.8g} ({high})"


def write_rows(all_rows, out):
    lines = list(all_rows)
    widths = [max(len(row[i]) for row in lines) for i in range(len(lines[0]))]
    for row in lines:
        print("  ".join(text.ljust(width) if i == 0 else text.rjust(width)
                        for i, (text, width) in enumerate(zip(row, widths))), file=out)
