"""Runs tasks on this machine, one after the other, or on the workers of a Dask scheduler.

In both cases a task is a run of the installed program and its results are lines of text. Tasks share only the program.
"""

import collections
import json
import queue
import sys
import time

from cache import INSTALL_PEERS
from program import path_of_program

ATTEMPTS = 3  # of a task whose worker died, or whose result was lost with it
CANNOT_START = 127  # status of a program that a machine lacks
RESULT_WAIT = 30.0  # s to fetch the result of a task
SCHEDULER_WAIT = 60.0  # s for a lost scheduler to come back
LOOK_EVERY = 1.0  # s between two looks at the list of workers


class EngineError(Exception):
    """The tasks cannot be run or continued; the message is one sentence."""


class TasksLost(EngineError):
    """Tasks have no results because workers or the scheduler died. The same command resumes."""


def run_program(program, task):
    """Runs on a worker. The function is sent by value and must not use these scripts, which a worker may not have."""
    import json as json_
    import os as os_
    import socket as socket_
    import subprocess as subprocess_
    import time as time_
    begin = time_.perf_counter()
    environment = {**os_.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    outcome = {"host": socket_.gethostname(), "worker": ""}
    try:
        from distributed import get_worker
        outcome["worker"] = get_worker().address
    except (ImportError, ValueError):  # not on a worker
        pass
    try:
        done = subprocess_.run([program, "bench", "task", json_.dumps(task)], capture_output=True,
                               text=True, check=False, env=environment)
        outcome |= {"status": done.returncode, "lines": done.stdout, "error": done.stderr[-2000:]}
    except OSError as error:  # this machine lacks the program
        outcome |= {"status": 127, "lines": "", "error": f"the program '{program}' cannot be started: {error.strerror}"}
    return {**outcome, "seconds": time_.perf_counter() - begin}


# Functions of __main__ are sent by value. Others are sent as the name of their module, which a worker would not find.
run_program.__module__ = "__main__"


class TaskDied(Exception):
    """The program of a task ended without its results; the message is one sentence."""


def results_of(task, outcome):
    """The lines of a task that ended. Raises EngineError if the task is invalid or cannot run on that machine, and
    TaskDied if its program died."""
    lines = outcome["lines"].splitlines()
    if outcome["status"] == 0 and lines and json.loads(lines[-1]).get("done") == task["id"]:
        return [json.loads(line) for line in lines[:-1]]
    told = (outcome["error"].strip().splitlines() or ["no message"])[-1]
    if outcome["status"] in (2, CANNOT_START):
        raise EngineError(told)
    raise TaskDied(f"the task ended with status {outcome['status']}: {told[-300:]}")


def results_here(task, outcome):
    """The lines of a task on this machine. A dead program is a crash of all its solvers."""
    try:
        return results_of(task, outcome)
    except TaskDied as died:
        return [{"problem": task["problem"], "start": task.get("start"), "solver": name, "instance": 0, "verdict": "crashed",
                 "claimed": str(died)} for name in task["solvers"]]


def run_here(tasks, take, jobs=1):
    """Runs this many tasks at a time and takes the results in the order of the tasks."""
    from concurrent.futures import ThreadPoolExecutor
    program = path_of_program()
    with ThreadPoolExecutor(jobs) as pool:  # threads that wait for processes
        begun = [(task, pool.submit(run_program, program, task)) for task in tasks]
        try:
            for task, outcome in begun:
                take(task, results_here(task, outcome.result()))
        except BaseException:
            for _, outcome in begun:
                outcome.cancel()
            raise


class Lost(Exception):
    """The connection to the scheduler is lost."""


class Cluster:
    """Gives the tasks to the workers of a scheduler, twice as many as there are threads.

    Workers may join and die. A task whose worker died is repeated, up to ATTEMPTS. A worker that cannot run tasks is
    quarantined with a sentence, and its task goes to another one. A task that fails everywhere is an error."""

    def __init__(self, tasks, say):
        self.left, self.say, self.program = list(tasks), say, path_of_program()
        self.running = {}  # key of a future -> (task, future, workers that may run it)
        self.quarantine, self.able = {}, set()  # address -> sentence; addresses that have completed a task
        self.losses, self.failed_on = collections.Counter(), collections.defaultdict(set)  # by task
        self.given_up, self.spent, self.done, self.most_workers = [], 0.0, 0, 0

    def run(self, client, take):
        """Returns when all tasks have ended or are given up. Raises Lost with the tasks still in `left`."""
        ended = queue.SimpleQueue()
        try:
            while self.left or self.running:
                try:
                    self._submit(client, ended)
                except (OSError, RuntimeError) as error:
                    raise Lost from error
                try:
                    future = ended.get(timeout=LOOK_EVERY)
                except queue.Empty:
                    continue
                if future.key in self.running:
                    self._end(*self.running.pop(future.key)[:2], take)
        finally:
            self.left[:0] = [task for task, _, _ in self.running.values()]
            self.running.clear()

    def _submit(self, client, ended):
        if client.status != "running":
            raise Lost
        threads = client.nthreads()
        usable = {address for address in threads if address not in self.quarantine}
        self.most_workers = max(self.most_workers, len(usable))
        if threads and not usable:
            raise EngineError("no usable worker is left: " + "; ".join(
                f"{address}: {self.quarantine[address]}" for address in threads))
        for key, (task, future, allowed) in list(self.running.items()):
            if allowed and not allowed & usable:  # it would wait forever
                del self.running[key]
                self.left.insert(0, task)
                future.cancel()
        while self.left and len(self.running) < 2 * sum(threads[address] for address in usable):
            task = self.left.pop(0)
            allowed = (usable - self.failed_on[task["id"]] or usable) if self.quarantine else set()
            future = client.submit(run_program, self.program, task, pure=False, workers=sorted(allowed) or None)
            self.running[future.key] = task, future, allowed
            future.add_done_callback(ended.put)

    def _end(self, task, future, take):
        try:
            outcome = future.result(timeout=RESULT_WAIT) if future.status == "finished" else None
        except Exception:  # noqa: BLE001 - its worker died with the result
            outcome = None
        if outcome is None:
            if future.status == "cancelled":  # by the end of the connection
                self.left.insert(0, task)
                raise Lost
            if future.status == "error" and type(future.exception()).__name__ == "KilledWorker":
                self.losses[task["id"]] = ATTEMPTS  # Dask has repeated it on other workers
            self._retry(task, "its worker died")
            return
        self.spent += outcome["seconds"]
        worker = outcome["worker"]
        try:
            lines = results_of(task, outcome)
        except TaskDied as died:
            self._retry(task, str(died))
            return
        except EngineError as error:
            if outcome["status"] == 2:
                self.failed_on[task["id"]].add(worker)
                if worker in self.able or len(self.failed_on[task["id"]]) >= ATTEMPTS:
                    raise EngineError(str(error)) from None  # the task is invalid
            if worker not in self.quarantine:
                self.quarantine[worker] = f"{error}"
                self.say(f"the worker {worker} on {outcome['host']} is not used any more: {error}; its tasks go to others")
            self.left.insert(0, task)
            return
        self.able.add(worker)
        self.done += 1
        take(task, lines)
        future.release()

    def _retry(self, task, why):
        self.losses[task["id"]] += 1
        if self.losses[task["id"]] < ATTEMPTS:
            self.left.append(task)
        else:
            self.given_up.append(task["id"])
            self.say(f"the task '{task['id']}' is given up after {ATTEMPTS} attempts: {why}")


def connected(address, patience=10.0):
    """A client of the scheduler, or None if none answers."""
    from distributed import Client
    end = time.monotonic() + patience
    while True:
        try:
            return Client(address, timeout=5, name="saltus bench")
        except ValueError:
            return None
        except (OSError, TimeoutError, RuntimeError):
            if time.monotonic() > end:
                return None
            time.sleep(LOOK_EVERY)


def run_on_cluster(tasks, take, address):
    """Runs the tasks on Dask workers. A scheduler that is lost may come back at the same address."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise EngineError("--scheduler needs Dask: Debian's python3-distributed, or the package "
                          f"distributed ({INSTALL_PEERS})") from None
    import logging
    for name in ("distributed", "distributed.client"):  # errors are reported below in one sentence
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    client = connected(address)
    if client is None:
        raise EngineError(f"no Dask scheduler answers at '{address}'; start one with `dask scheduler`, and workers with "
                          "`dask worker ADDRESS --nthreads 1`")

    def say(sentence):
        print(sentence, file=sys.stderr, flush=True)
    cluster, begin = Cluster(tasks, say), time.monotonic()
    while True:
        try:
            cluster.run(client, take)
            break
        except Lost:
            say(f"the connection to the scheduler at '{address}' was lost; waiting {SCHEDULER_WAIT:g} s for it")
        finally:
            try:
                client.close(timeout=2)
            except Exception:  # noqa: BLE001 - it may be gone
                pass
        client = connected(address, SCHEDULER_WAIT)
        if client is None:
            raise TasksLost(f"the scheduler at '{address}' is gone; the same command resumes")
    told(cluster.done, cluster.most_workers, time.monotonic() - begin, cluster.spent)
    if cluster.given_up:
        raise TasksLost(f"{len(cluster.given_up)} of {len(tasks)} tasks were given up, '{cluster.given_up[0]}' for "
                        "example; the same command tries them again")


def told(tasks, workers, elapsed, spent):
    """Prints the overhead of the engine, besides start and run of the program, on the workers that were present."""
    if tasks and workers:
        overhead = 1e3 * (elapsed * min(workers, tasks) - spent) / tasks
        print(f"{tasks} tasks on {workers} workers in {elapsed:.1f} s; the program ran for {spent:.1f} s, "
              f"the rest is {overhead:.1f} ms per task", file=sys.stderr)
