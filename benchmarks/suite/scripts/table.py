"""The results as one table: a row per problem and start, a column per solver."""

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


def is_nonlinear(task):
    return task.startswith("library/")


def class_of(task):
    return "nonlinear problems" if is_nonlinear(task) else (
        "quadratic programs, warm" if task.endswith(" warm") else "quadratic programs, cold")


def groups(records):
    """(class, its tasks), of the classes that exist. They are never mixed: solvers and meaning of the times differ."""
    found = {}
    for task in records.tasks:
        found.setdefault(class_of(task), []).append(task)
    return sorted(found.items(), key=lambda one: ("cold", "warm", "problems").index(one[0].split()[-1]))


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


def write_rows(all_rows, out):
    lines = list(all_rows)
    widths = [max(len(row[i]) for row in lines) for i in range(len(lines[0]))]
    for row in lines:
        print("  ".join(text.ljust(width) if i == 0 else text.rjust(width)
                        for i, (text, width) in enumerate(zip(row, widths))), file=out)
