"""One task of a run: all solvers on the instances of one problem, alternating, with a check of every answer.

A task is a run of the program, `saltus bench task JSON`, which prints lines of JSON: {"trying": SOLVER} before the
first call of a solver (if a peer ends the process, the last such line names it), one line per solver and instance, and
{"done": ID} at the end.
"""

import contextlib
import fcntl
import json
import math
import os
import signal
import socket
import sys
import tempfile
import time

import campaign
import data_problems
import nonlinear_peers
import peers
from cache import cache_folder
from nonlinear_program import NoFile, read_nonlinear
from package import end_with_parent
from program import Program, ProgramError
from quadratic_program import kkt_residual, read_program
from toy import Endless, Toy

OURS = ("riccati", "sparse", "ipopt")  # the last on nonlinear programs only
# Both checks add the same terms in different order.
JUDGES_AGREE = 1e-10
PATIENCE = float(os.environ.get("SALTUS_BENCH_PATIENCE", "10"))  # processor seconds; a longer solve fails, and a longer repetition is not repeated
SLOW_US = 1e5  # warm caches do not matter above this time
PROBES = 3  # instances that determine the tolerance to request


def peer_named(name):
    return {p.name: p for p in [*peers.all_peers(), *nonlinear_peers.nonlinear_peers(), Toy, Endless]}[name]


@contextlib.contextmanager
def one_at_a_time():
    """A lock, so timed tasks run one at a time on a machine."""
    name = f"timing-{socket.gethostname()}.lock"  # home folders may be shared by machines
    with open(os.path.join(cache_folder(), name), "a", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@contextlib.contextmanager
def patience():
    """Limits a solve. Foreign code cannot be interrupted, so SIGPROF ends the process, which notifies the engine. The
    limit counts processor time, which hardly depends on other load."""
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def thread_us():
    return 1e-3 * time.thread_time_ns()


def process_us():
    """For multi-threaded solvers: no interrupt."""
    return 1e-3 * time.process_time_ns()


class Ours:
    """One of our solvers on one instance; the program keeps the data."""
    ladder = (1.0, 0.1, 0.01)

    def __init__(self, program, name, task, qp):
        self.program = program
        which = ({"file": qp.file} if data_problems.is_data(task["problem"])
                 else {"problem": task["problem"], "instance": qp.instance})
        self.request = {"do": "solve", **which, "solver": name, "start": task["start"]}

    def run(self, qp, tolerance, is_timed=True):
        answer = self.program.ask(**self.request, tolerance=tolerance)
        if "not_applicable" in answer:
            raise peers.NotApplicable(answer["not_applicable"])
        point = answer["point"]
        found = judged(qp, *(_array(point[key]) for key in ("w", "lambda", "z")))
        here, there = found["kkt"], answer["kkt"]
        agree = all(abs(here[key] - there[key]) <= JUDGES_AGREE * (1.0 + abs(here[key]))
                    for key in here)
        agree = agree and (abs(found["objective"] - answer["objective"])
                           <= JUDGES_AGREE * (1.0 + abs(found["objective"])))
        return {**found, "judges_agree": agree, "claimed": answer["claimed"],
                "says_solved": answer["solved"], "iterations": answer["iterations"]}, {
                    "cpu_us": answer["cpu_us"], "own_us": None, "setup_us": answer["setup_us"]}


class Peer:
    def __init__(self, adapter, task, qp):
        self.adapter, self.qp, self.ladder = adapter, qp, adapter.ladder
        self.warm = task["start"] == "warm"
        self.tolerance, self.solver, self.setup_us, self.start = None, None, None, None
        self.last_us = 0.0

    def run(self, qp, tolerance, is_timed=True):
        """The checked answer and its times. Without `is_timed`: of the first solve, with cold caches."""
        if tolerance != self.tolerance:
            begin = thread_us()
            self.solver = self.adapter(qp, tolerance)
            self.setup_us, self.tolerance = thread_us() - begin, tolerance
            if self.warm:
                whole = qp.warm["w"], qp.warm["lambda"], qp.warm["z"]
                reduced = getattr(self.solver, "reduced", None) or getattr(
                    getattr(self.solver, "rows", None), "reduced", None)
                self.start = reduced.warm() if reduced else whole
        if is_timed and self.last_us < SLOW_US:
            self.solver.solve(self.start)  # warm caches, as for ours
        clock = process_us if getattr(self.adapter, "has_threads", False) else thread_us
        with patience():
            begin = clock()
            answer = self.solver.solve(self.start)
            self.last_us = clock() - begin
        return {**self.judge(qp, answer), "claimed": answer.claimed, "says_solved": answer.solved,
                "iterations": answer.iterations}, {"cpu_us": self.last_us, "own_us": answer.own_us,
                                                   "setup_us": self.setup_us}

    def judge(self, qp, answer):
        return judged(qp, answer.w, answer.row_multipliers, answer.bound_multipliers)


class OursNonlinear(Ours):
    """For nonlinear programs the program itself checks all answers, because it has the formulas."""

    def run(self, qp, tolerance, is_timed=True):
        answer = self.program.ask(**self.request, tolerance=tolerance)
        if "not_applicable" in answer:
            raise peers.NotApplicable(answer["not_applicable"])
        return {**judged_by(answer), "claimed": answer["claimed"], "says_solved": answer["solved"],
                "iterations": answer["iterations"]}, {
                    "cpu_us": answer["cpu_us"], "own_us": None, "setup_us": answer["setup_us"]}


class NonlinearPeer(Peer):
    def __init__(self, program, adapter, task, file):
        super().__init__(adapter, task, file)
        self.program, self.problem = program, task["problem"]
        if isinstance(file, NoFile):
            raise peers.NotApplicable(file.why)

    def judge(self, qp, answer):
        point = {"w": answer.w, "lambda": answer.row_multipliers, "z": answer.bound_multipliers}
        return judged_by(self.program.ask(do="judge", problem=self.problem,
                                          **{key: list(map(float, v)) for key, v in point.items()}))


def judged_by(answer):
    """The residuals of the program, with NaN as infinity."""
    number = lambda v: math.inf if v is None else v  # noqa: E731
    return {"objective": number(answer["objective"]), "optimum": answer["optimum"],
            "margin": answer["margin"], "kkt": {k: number(v) for k, v in answer["kkt"].items()}}


def _array(values):
    import numpy
    return numpy.array([float("nan") if v is None else v for v in values], dtype=float)


def judged(qp, w, row_multipliers, bound_multipliers):
    known = {} if qp.optimum is None else {"optimum": qp.optimum}
    return {"objective": qp.objective(w), **known,
            "kkt": kkt_residual(qp, w, row_multipliers, bound_multipliers)}


def verdict(answer, accepted):
    """A wrong answer is a failure for any reported status."""
    if not answer.get("judges_agree", True):
        return "judges disagree"
    if max(answer["kkt"].values()) <= accepted:
        # The best optimum of nonlinear programs is known, and there may be others.
        if answer.get("margin") and answer["objective"] > answer["optimum"] + answer["margin"]:
            return "worse optimum"
        return "solved"
    return "wrong" if answer["says_solved"] else "gave up"


def probes(numbers):
    """The first, the last and the middle instance."""
    numbers = list(numbers)
    return sorted({numbers[i * (len(numbers) - 1) // (PROBES - 1)] for i in range(PROBES)})


def choose_tolerance(runs, programs, accepted):
    """(the loosest tolerance of a solver with which the probed instances pass the check, or the one with which most
    pass; the number that pass). Criteria of solvers differ, and none must lose because of its definition of the
    tolerance."""
    best, best_count = None, -1
    numbers = probes(runs)
    for factor in next(iter(runs.values())).ladder:
        count = 0
        for number in numbers:
            answer, _ = runs[number].run(programs[number], factor * accepted, is_timed=False)
            count += verdict(answer, accepted) == "solved"
        if count > best_count:
            best, best_count = factor * accepted, count
        if count == len(numbers):
            break
    return best, best_count


# From good to bad: the worst of several repetitions is reported.
SEVERITY = ("", "solved", "worse optimum", "gave up", "wrong", "judges disagree", "error")


def keep_worst(known, answer, found):
    """Replaces earlier repetitions by this answer, unless they were worse."""
    if SEVERITY.index(found) >= SEVERITY.index(known["verdict"]):
        known.update(answer)
        known["verdict"] = found


def say(line):
    print(json.dumps(line), flush=True)


def failure(task, solver, number, cause, sentence):
    return {"problem": task["problem"], "start": task["start"], "solver": solver,
            "instance": number, "verdict": cause, "claimed": sentence}


def measure(task, solver, runs, programs, results):
    """Adds one more answer with its times to results[number] of the solver."""
    for number, run in runs.items():
        answer, times = run.run(programs[number], results[number]["asked"])
        known = results[number]
        keep_worst(known, answer, verdict(answer, task["tolerance"]))
        known.setdefault("times", {}).setdefault("setup_us", times["setup_us"])
        for key in ("cpu_us", "own_us"):
            if times[key] is not None:
                known["times"].setdefault(key, []).append(round(times[key], 3))


def written(program, task, number, folder):
    """The program that all solvers read."""
    file = os.path.join(folder, f"{number}.json")
    if data_problems.is_data(task["problem"]):
        data_problems.write(task["problem"], number, file)
    else:
        answer = program.ask(do="export", problem=task["problem"], instance=number, file=file)
        if "not_applicable" in answer:
            return NoFile(number, answer["not_applicable"])
    read = read_nonlinear(file) if is_nonlinear(task) else read_program(file)
    read.file, read.instance = file, number
    return read


def is_nonlinear(task):
    return task.get("kind") == "nonlinear"


def solver_on(program, solver, task, qp):
    """The arguments of run()."""
    if is_nonlinear(task):
        return (OursNonlinear(program, solver, task, qp) if solver in OURS
                else NonlinearPeer(program, peer_named(solver), task, qp))
    return Ours(program, solver, task, qp) if solver in OURS else Peer(peer_named(solver), task, qp)


def run_task(task):
    with Program() as program, tempfile.TemporaryDirectory(prefix="saltus-bench-") as folder:
        programs = {number: written(program, task, number, folder) for number in task["instances"]}
        results, runs = {}, {}
        with one_at_a_time():
            for solver in task["solvers"]:
                if solver in task.get("ended", {}):
                    for number in programs:
                        say(failure(task, solver, number, *task["ended"][solver]))
                    continue
                say({"trying": solver})
                missing = "" if solver in OURS else peers.why_missing(peer_named(solver))
                if missing:
                    say(failure(task, solver, 0, "missing", missing))
                    continue
                try:
                    mine = {number: solver_on(program, solver, task, qp)
                            for number, qp in programs.items()}
                    asked, accepted = choose_tolerance(mine, programs, task["tolerance"])
                except peers.NotApplicable as why:
                    say(failure(task, solver, 0, "not applicable", str(why)))
                    continue
                except Exception as error:  # noqa: BLE001 - a peer may throw anything
                    for number in programs:
                        say(failure(task, solver, number, "error",
                                    f"{type(error).__name__}: {str(error)[:200]}"))
                    continue
                if accepted == 0:  # no probe passed with any tolerance: skip the other instances
                    mine = {number: mine[number] for number in probes(mine)}
                runs[solver] = mine
                results[solver] = {number: {**failure(task, solver, number, "", ""),
                                            "asked": asked} for number in mine}
            slow = set()
            for _ in range(task["repetitions"]):
                for solver, mine in runs.items():
                    if solver in slow:
                        continue
                    say({"trying": solver})
                    begin = time.process_time()
                    try:
                        measure(task, solver, mine, programs, results[solver])
                    except Exception as error:  # noqa: BLE001
                        for number in mine:
                            results[solver][number].update(
                                verdict="error", claimed=f"{type(error).__name__}: {error}"[:200])
                    missed_all = all(line["verdict"] != "solved" for line in results[solver].values())
                    if missed_all or time.process_time() - begin > PATIENCE:
                        slow.add(solver)
            say({"trying": None})
        for solver in runs:
            for line in results[solver].values():
                say(line)
    say({"done": task["id"]})


def main(words):
    end_with_parent()
    try:
        task = json.loads(words[0])
        if task.get("kind") == "command":
            campaign.carry_out(task, say)
            say({"done": task["id"]})
        else:
            run_task(task)
    except ProgramError as error:
        print(f"saltus bench task: {error}", file=sys.stderr)
        return 2
    return 0
