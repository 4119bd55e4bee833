"""Forecast of a run from the processor seconds that each solver took on each task in earlier runs of this user. Other load
hardly affects them. Only their ratios matter, because the progress of the run shows the speed of the machine."""

import json
import os
import statistics
import time

from cache import cache_folder
from package import write_text


def _path():
    return os.path.join(cache_folder(), "bench_processor_seconds.json")


# Seconds of `bench run --quick` on the machine of measured.md, for the first run of a user.
SHIPPED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "processor_seconds.json")


def known_seconds():
    """task -> solver -> seconds per instance and repetition, from earlier runs or else from SHIPPED."""
    return {**_read(SHIPPED), **_read(_path())}


def _read(path):
    """The contents of a file, or an empty dictionary if it cannot be read."""
    try:
        with open(path, encoding="utf-8") as file:
            known = json.load(file)
        return {task: {solver: float(s) for solver, s in of.items()} for task, of in known.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def size_of(task):
    return len(task.get("instances", (1,))) * (1 + task.get("repetitions", 0))


def seconds_of(task, lines):
    """solver -> seconds per instance and repetition, from the lines of a task that ended."""
    found = {}
    for line in lines:
        found[line["solver"]] = found.get(line["solver"], 0.0) + line.get("times", {}).get("spent_s", 0.0)
    return {solver: round(seconds / size_of(task), 6) for solver, seconds in found.items()}


def learn(task, seconds):
    """Keeps the seconds of a task for the next run. Without a cache folder they are lost."""
    try:
        known = _read(_path())
        known.setdefault(task, {}).update(seconds)
        write_text(_path(), json.dumps(known))
    except OSError:
        pass


def expected(tasks, known):
    """Expected seconds of each task. A solver without a record takes its median, or that of all."""
    every = [s for of in known.values() for s in of.values()]
    usual = statistics.median(every) if every else 1.0
    of_solver = {}
    for of in known.values():
        for solver, seconds in of.items():
            of_solver.setdefault(solver, []).append(seconds)
    typical = {solver: statistics.median(all_of) for solver, all_of in of_solver.items()}
    return {task["id"]: size_of(task) * sum(known.get(task["id"], {}).get(solver, typical.get(solver, usual))
                                            for solver in task["solvers"]) or 1e-9
            for task in tasks}


class Progress:
    """`7 of 21 (33 %), sequence warm; 2 min passed, about 4 min left` on the error stream. The percentage is that of the
    expected work. `work`: expected seconds of each task that is left; `already`: number of tasks that are not."""

    def __init__(self, work, already, stream, now=time.monotonic):
        self.work, self.stream, self.now = work, stream, now
        self.done, self.total, self.passed_work = already, already + len(work), 0.0
        self.begin = now()

    def left(self):
        """Forecast of the remaining seconds, after the first task."""
        remaining = sum(self.work.values()) - self.passed_work
        return (self.now() - self.begin) * remaining / self.passed_work

    def tell(self, task):
        self.done += 1
        self.passed_work += self.work[task]
        percent = 100.0 * self.passed_work / sum(self.work.values())
        print(f"{self.done} of {self.total} ({percent:.0f} %), {task}; {in_words(self.now() - self.begin)} passed, about "
              f"{in_words(self.left())} left", file=self.stream, flush=True)


def in_words(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
