"""Statistics of several solvers per class of problems, and their export.

A solver counts on the instances of the tasks that it ran. Missing packages and problems that do not suit it do not count.
An instance that it missed, or that was skipped because it missed others, counts as a failure at the limit of a solve.
"""

import csv
import math

import numpy as np

import figures
import table
from task import OURS

SHIFT = 1e-3  # s, of the geometric mean: smaller times hardly count
RESAMPLES, SEED, BAND = 500, 1, 0.95
CURVES = 8  # of one picture


def limit_of(records):
    return records.head["matrix"].get("limits", {}).get("solve", 10.0)


def seconds(records, tasks):
    """solver -> {(task, instance): seconds, or None if missed}"""
    cells, instances, found = figures.by_cell(records), {}, {}
    for (task, _), lines in cells.items():
        instances.setdefault(task, set()).update(line["instance"] for line in lines if line["instance"])
    for (task, solver), lines in cells.items():
        if task in tasks:
            mine = {line["instance"]: figures.time_of(line) for line in lines}
            for instance in instances[task] or {0}:
                us = mine.get(instance)
                found.setdefault(solver, {})[task, instance] = us / 1e6 if us else None
    return found


def mean(values, limit):
    """Shifted geometric mean of seconds. None counts as the limit."""
    logs = [math.log(SHIFT + (limit if v is None else min(v, limit))) for v in values]
    return math.exp(sum(logs) / len(logs)) - SHIFT


def resampled(count, statistic):
    """Lower and upper end of the band of a statistic of indices 0 to count - 1, by the bootstrap over instances."""
    random = np.random.default_rng(SEED)
    samples = np.array([statistic(random.integers(0, count, count)) for _ in range(RESAMPLES)])
    return np.quantile(samples, [(1.0 - BAND) / 2.0, (1.0 + BAND) / 2.0], axis=0)


def summary(records, tasks):
    """Per solver, best first: name, instances, solved, mean in s and its band. Those that apply to fewer instances than
    others come last, because their means are not comparable."""
    limit, rows = limit_of(records), []
    for solver, of in seconds(records, tasks).items():
        times = list(of.values())
        logs = np.log(SHIFT + np.array([limit if t is None else min(t, limit) for t in times]))
        band = np.exp(resampled(len(logs), lambda i, logs=logs: logs[i].mean())) - SHIFT
        rows.append((solver, len(times), sum(t is not None for t in times), mean(times, limit), *map(float, band)))
    most = max((row[1] for row in rows), default=0)
    return sorted(rows, key=lambda row: (row[1] < most, row[3], row[0]))


def shown(rows):
    """At most CURVES solvers of a summary, the best means first. One of ours is among them."""
    names = [row[0] for row in rows]
    picked, ours = names[:CURVES], [name for name in names if name in OURS]
    if ours and not set(ours) & set(picked):
        picked[-1] = ours[0]
    return picked


def curves(records, tasks, names, is_relative):
    """(grid, solver -> (shares, lower band, upper band)): the share of a solver's instances that it solves within a
    multiple of the fastest time on the same instance, or within a time in s."""
    of, limit = seconds(records, tasks), limit_of(records)
    best = {}
    for times in of.values():
        for key, t in times.items():
            if t is not None:
                best[key] = min(t, best.get(key, math.inf))
    grid = np.geomspace(1.0, 1e3, 121) if is_relative else np.geomspace(1e-5, limit, 121)
    found = {}
    for name in names:
        values = np.array([math.inf if t is None else (t / best[key] if is_relative else t) for key, t in of[name].items()
                           if key in best or not is_relative])
        if len(values):
            within = (values[:, None] <= grid * (1.0 + 1e-12)).astype(float)
            found[name] = within.mean(axis=0), *resampled(len(values), lambda i, within=within: within[i].mean(axis=0))
    return grid, found


def behind(records):
    """Sentences on the classes in which none of ours has the smallest mean, or solves the most."""
    for name, tasks in table.groups(records):
        rows = summary(records, tasks)
        ours = [row for row in rows if row[0] in OURS]
        if not ours:
            yield f"{name}: none of our solvers ran."
            continue
        best, mine = rows[0], ours[0]
        if best[0] not in OURS:
            yield (f"{name}: {best[0]} has the smallest mean, {best[3]:.3g} s; our best is {mine[0]} with {mine[3]:.3g} s "
                   f"({best[2]} of {best[1]} and {mine[2]} of {mine[1]} solved).")
        most, share = max(rows, key=lambda row: row[2] / row[1]), max(row[2] / row[1] for row in ours)
        if most[2] / most[1] > share:
            yield f"{name}: {most[0]} solves {most[2]} of {most[1]}, more than any of ours ({100.0 * share:.0f} %)."


COLUMNS = ("class", "problem", "start", "instance", "solver", "tolerance", "verdict", "time_us", "first_us", "setup_us", "import_us",
           "iterations", "objective", "optimum", "stationarity", "feasibility", "complementarity", "integrality", "variables", "rows", "asked",
           "setting", "version", "host", "processor", "claimed")


def export_rows(all_records):
    yield COLUMNS
    for records in all_records:
        classes = {task: name for name, tasks in table.groups(records) for task in tasks}
        for task, lines in records.tasks.items():
            for line in lines:
                times, machine, kkt = (line.get(key, {}) for key in ("times", "machine", "kkt"))
                values = {**line, **times, **machine, **kkt, **dict(zip(("variables", "rows"), line.get("size", ()))),
                          "class": classes[task], "tolerance": records.head["matrix"]["tolerance"],
                          "time_us": figures.time_of(line)}
                yield ["" if values.get(key) is None else values[key] for key in COLUMNS]


def write_csv(all_records, path):
    with open(path, "w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(export_rows(all_records))


LATEX = {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}", **{c: "\\" + c for c in "_%&#${}"}}


def latex(text):
    return "".join(LATEX.get(character, character) for character in text)


def write_latex(all_records, path):
    """One table per class, without packages."""
    lines = []
    for records in all_records:
        tolerance = records.head["matrix"]["tolerance"]
        for name, tasks in table.groups(records):
            caption = (f"{name}, tolerance {tolerance:g}: shifted geometric means (shift {SHIFT:g} s, failures count "
                       f"{limit_of(records):g} s), {100.0 * BAND:g} % bootstrap intervals")
            lines += [r"\begin{table}", rf"\caption{{{latex(caption)}}}",
                      r"\begin{tabular}{lrrrr}", r"\hline", r"solver & instances & solved & mean in ms & interval \\", r"\hline"]
            lines += [f"{latex(solver)} & {count} & {solved} & {1e3 * value:.3g} & {1e3 * low:.3g} to {1e3 * high:.3g} \\\\"
                      for solver, count, solved, value, low, high in summary(records, tasks)]
            lines += [r"\hline", r"\end{tabular}", r"\end{table}", ""]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))
