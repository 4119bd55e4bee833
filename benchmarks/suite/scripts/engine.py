"""Runs tasks on this machine, one after the other, or on the workers of a Dask scheduler.

In both cases a task is a run of the installed program and its results are lines of text. Tasks share only the program.
"""

import json
import signal
import sys
import time

from cache import INSTALL_PEERS
from program import path_of_program


class EngineError(Exception):
    """The tasks cannot be run or continued; the message is one sentence."""


def run_program(program, task):
    """Runs on a worker. The function is sent by value and must not use these scripts, which a worker may not have."""
    import json as json_
    import os as os_
    import subprocess as subprocess_
    import time as time_
    begin = time_.perf_counter()
    environment = {**os_.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess_.run([program, "bench", "task", json_.dumps(task)], capture_output=True,
                           text=True, check=False, env=environment)
    return {"status": done.returncode, "lines": done.stdout, "error": done.stderr[-2000:],
            "seconds": time_.perf_counter() - begin}


# Functions of __main__ are sent by value. Others are sent as the name of their module, which a worker would not find.
run_program.__module__ = "__main__"


def lines_of(outcome):
    """(lines without marks, whether the task ended, the solver that was tried last)."""
    lines, ended, trying = [], False, None
    for text in outcome["lines"].splitlines():
        try:
            line = json.loads(text)
        except json.JSONDecodeError:
            continue  # output of a peer that ignores its verbosity option
        if not isinstance(line, dict):
            continue
        if "trying" in line:
            trying = line["trying"]
        elif "done" in line:
            ended = True
        else:
            lines.append(line)
    return lines, ended, trying


def sorted_lines(lines, task):
    order = {name: i for i, name in enumerate(task["solvers"])}
    return sorted(lines, key=lambda line: (line["instance"], order[line["solver"]]))


def end_of(status):
    """(verdict, sentence) of the peer that ended the process."""
    if status == -signal.SIGPROF:
        return "too slow", "a solve exceeded its limit of processor time"
    return "crashed", "it ended its process"


def settle(task, outcome, again):
    """The lines of the task. A peer that ended the process, or was stopped, is left out, and the task is run again."""
    while True:
        lines, ended, trying = lines_of(outcome)
        if ended:
            return sorted_lines(lines, task)
        if outcome["status"] == 2:
            raise EngineError(outcome["error"].strip())
        before = task.get("ended", {})
        if trying is None or trying in before:
            return sorted_lines([{"problem": task["problem"], "start": task.get("start"),
                                  "solver": name, "instance": 0, "verdict": "crashed",
                                  "claimed": "the task ended with status "
                                             f"{outcome['status']}: {outcome['error'][-300:]}"}
                                 for name in task["solvers"]], task)
        task = {**task, "ended": {**before, trying: end_of(outcome["status"])}}
        outcome = again(task)


def run_here(tasks, take, jobs=1):
    """Runs this many tasks at a time and takes the results in the order of the tasks."""
    from concurrent.futures import ThreadPoolExecutor
    program = path_of_program()
    with ThreadPoolExecutor(jobs) as pool:  # threads that wait for processes
        begun = [(task, pool.submit(run_program, program, task)) for task in tasks]
        try:
            for task, outcome in begun:
                take(task, settle(task, outcome.result(), lambda t: run_program(program, t)))
        except BaseException:
            for _, outcome in begun:
                outcome.cancel()
            raise


def run_on_cluster(tasks, take, address):
    """Runs the tasks on Dask workers, which may join or die: Dask reassigns their tasks. If the scheduler is lost,
    pending results are lost and the error reports this."""
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise EngineError("--scheduler needs Dask: Debian's python3-distributed, or the package "
                          f"distributed ({INSTALL_PEERS})") from None
    import logging
    for name in ("distributed", "distributed.client"):  # errors are reported below in one sentence
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(address, timeout=10, name="saltus bench")
    except (OSError, ValueError, TimeoutError):
        raise EngineError(f"no Dask scheduler answers at '{address}'; start one with `dask scheduler`, and workers with "
                          "`dask worker ADDRESS --nthreads 1`") from None
    program = path_of_program()
    begin, spent, workers = time.monotonic(), 0.0, len(client.scheduler_info()["workers"])
    try:
        futures = {client.submit(run_program, program, task, pure=False): task for task in tasks}
        for future in as_completed(futures):
            task = futures[future]
            if future.status != "finished":
                raise EngineError(f"the task '{task['id']}' was abandoned: {future.exception()}"
                                  if future.status == "error" else
                                  f"the connection to the scheduler at '{address}' was lost; the same command resumes")
            outcome = future.result()
            spent += outcome["seconds"]
            take(task, settle(task, outcome, lambda t: client.submit(
                run_program, program, t, pure=False).result()))
            future.release()
        told(len(tasks), workers, time.monotonic() - begin, spent)
    except (OSError, RuntimeError, TimeoutError) as error:
        raise EngineError(f"the connection to the scheduler at '{address}' was lost ({type(error).__name__}); the same "
                          "command resumes") from None
    finally:
        try:
            client.close(timeout=2)
        except Exception:  # noqa: BLE001 - it may be gone
            pass


def told(tasks, workers, elapsed, spent):
    """Prints the overhead of the engine, besides start and run of the program, on the workers that were present at the
    start."""
    if tasks and workers:
        overhead = 1e3 * (elapsed * min(workers, tasks) - spent) / tasks
        print(f"{tasks} tasks on {workers} workers in {elapsed:.1f} s; the program ran for {spent:.1f} s, "
              f"the rest is {overhead:.1f} ms per task", file=sys.stderr)


class Progress:
    """`7 of 21 (33 %), sequence warm; 2 min passed, about 4 min left` on the error stream."""

    def __init__(self, total, already, stream):
        self.total, self.done, self.already, self.stream = total, already, already, stream
        self.begin = time.monotonic()

    def tell(self, what):
        self.done += 1
        passed = time.monotonic() - self.begin
        left = passed * (self.total - self.done) / max(1, self.done - self.already)
        print(f"{self.done} of {self.total} ({100 * self.done // self.total} %), {what}; "
              f"{in_words(passed)} passed, about {in_words(left)} left", file=self.stream,
              flush=True)


def in_words(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
