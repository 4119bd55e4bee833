"""One task of a run: all solvers on the instances of one problem, alternating, with a check of every answer.

A task is a run of the program, `saltus bench task JSON`, which prints one line of JSON per solver and instance, then
{"done": ID}. The solvers run in a second process, `saltus bench task --solvers`, which supervisor.py watches.
"""

import contextlib
import copy
import json
import math
import os
import sys
import tempfile
import time
from time import perf_counter_ns, process_time_ns

import campaign
import data_problems
import loops
import nonlinear_peers
import peers
import supervisor
from nonlinear_judge import NonlinearJudge, lifted
from nonlinear_program import NoFile, NonlinearFile, read_nonlinear
from package import end_with_parent
from program import Program, ProgramDied, ProgramError
from quadratic_program import integer_residual, kkt_residual, largest_sum, points_of, read_program
from toy import Endless, Toy

OURS = ("riccati", "riccati-generic", "sparse", "ipopt")  # the last on nonlinear programs only
# Both checks add the same terms in different order.
JUDGES_AGREE = 1e-10
OF_TERMS = 2e-15  # the same, relative to the largest sum of absolute terms
SLOW_US = 1e5  # warm caches do not matter above this time
PROBES = 3  # instances that determine the tolerance and the setting
LADDER = (1.0, 0.1, 0.01, 1e-3, 1e-4)  # requested tolerances of every solver, as factors of the judged one
MARGIN = 0.5  # the probes must pass with this fraction of the judged tolerance


def peer_named(name):
    return {p.name: p for p in [*peers.all_peers(), *nonlinear_peers.nonlinear_peers(), Toy, Endless]}[name]


class Clock:
    """Wall time and processor time of this process, with all its threads, in microseconds."""

    def __enter__(self):
        self._cpu, self._wall = process_time_ns(), perf_counter_ns()
        return self

    def __exit__(self, *_):
        self.wall_us = 1e-3 * (perf_counter_ns() - self._wall)
        self.cpu_us = 1e-3 * (process_time_ns() - self._cpu)


class Ours:
    """One of our solvers on one instance; the program keeps the data."""

    def __init__(self, program, name, task, qp, step):
        self.program, self.qp, self.step, self.ladder = program, qp, step, LADDER
        which = {"problem": task["problem"], "instance": qp.instance}
        if data_problems.is_data(task["problem"]):
            which = {"file": qp.file, **({"kind": "nonlinear file"} if is_nonlinear(task) else {})}
        self.request = {"do": "solve", **which, "solver": name}
        self.settings = (["warm", "own start"] if task["start"] == "warm" else
                         ["own start"] if is_nonlinear(task) else ["own start", *points_of(qp)])

    def begin(self, tolerance, setting):
        """Times of the set-up and of the first solve."""
        times = self._ask(tolerance, setting)["times"]
        return {"setup_us": times["setup_us"], "first_us": times["first_us"]}

    def run(self, tolerance, setting, is_timed=True):
        answer = self._ask(tolerance, setting)
        self.found = answer.get("point")
        times = {key: answer["times"][key] for key in ("wall_us", "cpu_us")}
        return {**self.judge(answer), "claimed": answer["claimed"], "says_solved": answer["solved"],
                "iterations": answer["iterations"]}, times

    @property
    def point(self):
        """The last answer as (w, lambda, z)."""
        return tuple(_array(self.found[key]) for key in ("w", "lambda", "z"))

    def _ask(self, tolerance, setting):
        self.step("solve")
        answer = self.program.ask(**self.request, start=setting, tolerance=tolerance)
        self.step("check")
        if "not_applicable" in answer:
            raise peers.NotApplicable(answer["not_applicable"])
        return answer

    def judge(self, answer):
        point = answer["point"]
        found = judged(self.qp, *(_array(point[key]) for key in ("w", "lambda", "z")))
        terms = largest_sum(self.qp, *(_array(point[key]) for key in ("w", "lambda", "z")))
        return {**found, "judges_agree": agree(found, answer, terms)}


def offered(qp):
    """A copy for a solver, so that it cannot change what the judge reads. It contains starts, but not the optimum."""
    given = copy.deepcopy(qp)
    given.guess = given.warm = given.optimum = None
    return given


def fix(answer, program):
    """Converts the parts of an answer to arrays of the right sizes. A lazy array computes its values here, within the timed
    call."""
    import numpy
    for part, count in (("w", program.n), ("row_multipliers", program.m), ("bound_multipliers", program.n)):
        values = numpy.array(getattr(answer, part), dtype=float)
        if values.shape != (count,):
            raise ValueError(f"its {part} has the shape {values.shape}, not {(count,)}")
        setattr(answer, part, values)


class Peer:
    def __init__(self, adapter, task, qp, step):
        self.adapter, self.qp, self.step = adapter, qp, step
        self.ladder = getattr(adapter, "ladder", LADDER)
        self.given = qp if is_nonlinear(task) else offered(qp)
        self.tolerance, self.solver, self.last_us = None, None, 0.0
        self.starts, levels = {"own start": None}, {}
        if task["start"] == "warm":
            warm = qp.warm["w"], qp.warm["lambda"], qp.warm["z"]
            levels = {f"level {level}": level for level in getattr(adapter, "warm_levels", tuple)()}
            self.starts = {**{name: warm for name in levels or ("warm",)}, **self.starts}
        elif not is_nonlinear(task):
            self.starts |= points_of(qp)
        if not getattr(adapter, "takes_start", True):
            self.starts = {"own start": None}
        self.levels, self.settings = levels, list(self.starts)

    def begin(self, tolerance, setting):
        """Times of a new set-up and of its first solve."""
        self.step("set-up")
        with Clock() as setup:
            self.solver = self.adapter(self.given, tolerance)
        self.tolerance = tolerance
        _, first, reading_us = self._solve(setting)
        return {"setup_us": setup.wall_us, "first_us": first.wall_us, "reading_us": reading_us}

    def run(self, tolerance, setting, is_timed=True):
        """The checked answer and its times. Without `is_timed`: of the first solve, with cold caches."""
        if tolerance != self.tolerance:
            self.step("set-up")
            self.solver = self.adapter(self.given, tolerance)
            self.tolerance = tolerance
        if is_timed and self.last_us < SLOW_US:
            self._solve(setting)  # warm caches, as for ours
        answer, clock, _ = self._solve(setting)
        self.last_us, self.point = clock.wall_us, (answer.w, answer.row_multipliers, answer.bound_multipliers)
        self.step("check")
        return {**self.judge(answer), "claimed": answer.claimed, "says_solved": bool(answer.solved),
                "iterations": int(answer.iterations)}, {"wall_us": clock.wall_us, "cpu_us": clock.cpu_us,
                                                        "own_us": answer.own_us}

    def _solve(self, setting):
        """(answer, clock of the solve, wall us around it)."""
        solver, start = self.solver, self.starts[setting]
        if start is not None:
            start = tuple(part.copy() for part in start)
            reduced = getattr(solver, "reduced", None) or getattr(getattr(solver, "rows", None), "reduced", None)
            start = reduced.restrict(start) if reduced else start
        if setting in self.levels:
            solver.level = self.levels[setting]
        self.step("solve")
        with Clock() as around:
            if not isinstance(solver, peers.Adapter) or type(solver).solve is not peers.Adapter.solve:
                with Clock() as clock:
                    answer = solver.solve(start)
            else:
                solver.hand_over(start)
                with Clock() as clock:
                    solver.run()
                answer = solver.read()
            fix(answer, self.given)
        return answer, clock, around.wall_us - clock.wall_us

    def judge(self, answer):
        return judged(self.qp, answer.w, answer.row_multipliers, answer.bound_multipliers)


class OursNonlinear(Ours):
    """For problems of the library the program itself checks all answers, because it has the formulas. Files are judged
    here, and the program must agree."""

    def judge(self, answer):
        if self.qp.judge is None:
            return judged_by(answer)
        point = answer["point"]
        found = self.qp.judge.judged(*self.qp.original(*(_array(point[key]) for key in ("w", "lambda", "z"))))
        return {**found, "judges_agree": bool(self.qp.pairs) or agree(found, judged_by(answer))}


class NonlinearPeer(Peer):
    def __init__(self, program, adapter, task, file, step):
        super().__init__(adapter, task, file, step)
        self.program, self.problem = program, task["problem"]
        if isinstance(file, NoFile):
            raise peers.NotApplicable(file.why)

    def judge(self, answer):
        if self.qp.judge is not None:
            return self.qp.judge.judged(*self.qp.original(answer.w, answer.row_multipliers, answer.bound_multipliers))
        point = {"w": answer.w, "lambda": answer.row_multipliers, "z": answer.bound_multipliers}
        return judged_by(self.program.ask(do="judge", problem=self.problem,
                                          **{key: list(map(float, v)) for key, v in point.items()}))


def judged_by(answer):
    """The residuals of the program, with NaN as infinity."""
    number = lambda v: math.inf if v is None else v  # noqa: E731
    return {"objective": number(answer["objective"]), **{key: answer[key] for key in ("optimum", "margin") if key in answer},
            "kkt": {k: number(v) for k, v in answer["kkt"].items()}}


def agree(found, answer, terms=0.0):
    """True if both judges find the same cost and residuals. `terms`: the largest sum of absolute terms in them."""
    pairs = [(found["objective"], answer["objective"]), *((found["kkt"][key], answer["kkt"][key]) for key in found["kkt"])]
    return all(a == b or abs(a - b) <= JUDGES_AGREE * (1.0 + abs(a)) + OF_TERMS * terms for a, b in pairs)


def _array(values):
    import numpy
    return numpy.array([float("nan") if v is None else v for v in values], dtype=float)


def judged(qp, w, row_multipliers, bound_multipliers):
    """Cost and residuals of an answer. For mixed-integer programs the best known cost replaces the multipliers."""
    known = {} if qp.optimum is None else {"optimum": qp.optimum}
    if not len(qp.integer):
        return {"objective": qp.objective(w), **known, "kkt": kkt_residual(qp, w, row_multipliers, bound_multipliers)}
    rounded, residual = integer_residual(qp, w)
    margin = {"margin": qp.margin * (1.0 + abs(qp.optimum))} if known else {}
    return {"objective": qp.objective(rounded), **known, **margin, "kkt": residual}


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


class Choice:
    """The requested tolerance and the setting of a solver: of its settings the one with the fewest iterations, each with
    the loosest tolerance with which all instances pass. Criteria of solvers differ, and none must lose because of its
    definition of the tolerance. The rule is the same for all solvers, ours too.

    The probes try the ladder with a margin. Then all instances run once, untimed, and a miss tightens the tolerance."""

    def __init__(self, runs, accepted):
        self.accepted = accepted
        one = next(iter(runs.values()))
        numbers, ladder = probes(runs), [factor * accepted for factor in one.ladder]
        found = {setting: self._climb(runs, numbers, ladder, setting) for setting in one.settings}
        self.default, self.setting = one.settings[0], max(found, key=lambda setting: found[setting][:3])
        _, count, _, rung = found[self.setting]
        self.asked, self.is_hopeless = ladder[rung], count == 0
        self.swept = {setting: [count, -fewer] for setting, (_, count, fewer, _) in found.items()}
        if not self.is_hopeless and len(runs) > len(numbers):
            self._tighten(runs, ladder[rung:])

    def _climb(self, runs, numbers, ladder, setting):
        """(probes that pass with the margin, that pass, -iterations, rung) at the loosest tolerance with most of them."""
        best = (-1, -1, 0, 0)
        for rung, asked in enumerate(ladder):
            safe, count, iterations = self._try(runs, numbers, asked, setting)
            if (safe, count) > best[:2]:
                best = safe, count, -iterations, rung
            if safe == len(numbers):
                break
        return best

    def _try(self, runs, numbers, asked, setting):
        """(instances that pass with the margin, that pass, iterations) at a tolerance."""
        safe = count = iterations = 0
        for number in numbers:
            answer, _ = runs[number].run(asked, setting, is_timed=False)
            count += verdict(answer, self.accepted) == "solved"
            safe += verdict(answer, MARGIN * self.accepted) == "solved"
            iterations += answer["iterations"]
        return safe, count, iterations

    def _tighten(self, runs, ladder):
        best = -1
        for asked in ladder:
            count = self._try(runs, list(runs), asked, self.setting)[1]
            if count > best:
                best, self.asked = count, asked
            if count == len(runs):
                break


# From good to bad: the worst of several repetitions is reported.
SEVERITY = ("", "solved", "worse optimum", "gave up", "wrong", "judges disagree", "error")


def keep_worst(known, answer, found):
    """Replaces earlier repetitions by this answer, unless they were worse."""
    if SEVERITY.index(found) >= SEVERITY.index(known["verdict"]):
        known.update(answer)
        known["verdict"] = found


def failure(task, solver, number, cause, sentence):
    return {"problem": task["problem"], "start": task["start"], "solver": solver,
            "instance": number, "verdict": cause, "claimed": sentence}


def measure(task, runs, results, choice):
    """Adds one more answer with its times to results[number] of the solver. If a setting was chosen, the times of the
    default setting are measured too."""
    for number, run in runs.items():
        known = results[number]
        times = known.setdefault("times", {})
        if "setup_us" not in times:
            times.update(run.begin(choice.asked, choice.setting))
        answer, measured = run.run(choice.asked, choice.setting)
        keep_worst(known, answer, verdict(answer, task["tolerance"]))
        if choice.setting != choice.default:
            measured |= {f"default_{key}": value
                         for key, value in run.run(choice.asked, choice.default)[1].items() if key != "own_us"}
        for key, value in measured.items():
            if value is not None:
                times.setdefault(key, []).append(round(float(value), 3))


def written(program, task, number, folder):
    """The program that all solvers read."""
    if task.get("kind") == "loop":
        return loops.Loop(task["problem"], number, folder)
    file = os.path.join(folder, f"{number}.json")
    if data_problems.is_data(task["problem"]):
        try:
            data_problems.write(task["problem"], number, file)
            return _nonlinear_file(file, number) if is_nonlinear(task) else _placed(read_program(file), file, number)
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ProgramError(f"the problem '{task['problem']}' cannot be read: {error}") from None
    answer = program.ask(do="export", problem=task["problem"], instance=number, file=file)
    if "not_applicable" in answer:
        return NoFile(number, answer["not_applicable"])
    return _placed(read_nonlinear(file) if is_nonlinear(task) else read_program(file), file, number)


def size_of(qp):
    """Variables and rows of the program as stated."""
    stated = getattr(qp, "judge", None) or qp
    return {} if isinstance(qp, NoFile) else {"size": [stated.n, stated.m]}


def _placed(qp, file, instance):
    qp.file, qp.instance = file, instance
    return qp


def _nonlinear_file(path, number):
    """What solvers read, with a judge that has its own copy. A program with complementarity is lifted for solvers."""
    with open(path, encoding="utf-8") as file:
        data = json.load(file)
    judge = NonlinearJudge(data)
    if data.get("complementarity"):
        data, path = lifted(data), path + ".lifted.json"
        with open(path, "w", encoding="utf-8") as file:
            json.dump(data, file)
    program = _placed(NonlinearFile(data), path, number)
    program.judge = judge
    return program


def is_nonlinear(task):
    return task.get("kind") in ("nonlinear", "complementarity")


def solver_on(program, solver, task, qp, step):
    """One solver on one instance."""
    if task.get("kind") == "loop":
        tick = {**task, "kind": None, "start": "warm"}
        # Our program caches files by name, so each loop starts a separate program.
        return loops.LoopRun(qp, Program if solver in OURS else lambda: contextlib.nullcontext(program),
                             lambda own, one: solver_on(own, solver, tick, one, step))
    if is_nonlinear(task):
        return (OursNonlinear(program, solver, task, qp, step) if solver in OURS
                else NonlinearPeer(program, peer_named(solver), task, qp, step))
    return Ours(program, solver, task, qp, step) if solver in OURS else Peer(peer_named(solver), task, qp, step)


def version_of(solver, program):
    """Version of the solver for the lines of the result: `piqp 0.7.0`."""
    if solver in OURS:
        return "saltus {version} ({commit})".format(**program.ask(do="version"))
    return peers.named_version(peer_named(solver)).rstrip(": ")


def prepare(program, solver, task, programs, say, step):
    """(runs by instance, choice, import_us) of a solver, or None after lines that say why there are none."""
    if solver in task["ended"]:
        for number in programs:
            say(failure(task, solver, number, *task["ended"][solver]))
        return None
    step("import")
    with Clock() as importing:
        missing = "" if solver in OURS else peers.why_missing(peer_named(solver))
    if missing:
        say(failure(task, solver, 0, "missing", missing))
        return None
    step("set-up")
    try:
        mine = {number: solver_on(program, solver, task, qp, step) for number, qp in programs.items()}
        choice = Choice(mine, task["tolerance"])
    except peers.NotApplicable as why:
        say(failure(task, solver, 0, "not applicable", str(why)))
        return None
    except ProgramError:
        raise
    except Exception as error:  # noqa: BLE001 - a peer may throw anything
        for number in programs:
            say(failure(task, solver, number, "error", f"{type(error).__name__}: {str(error)[:200]}"))
        return None
    if choice.is_hopeless:  # no probe passed with any tolerance: skip the other instances
        mine = {number: mine[number] for number in probes(mine)}
    return mine, choice, importing.wall_us


def run_task(task, channel):
    channel.step(None, "task")
    with Program() as program, tempfile.TemporaryDirectory(prefix="saltus-bench-") as folder:
        programs = {number: written(program, task, number, folder) for number in task["instances"]}
        results, runs = {}, {}
        for solver in task["solvers"]:
            version = version_of(solver, program)

            def say(line):
                channel.say({**line, "machine": {"version": version}})
            prepared = prepare(program, solver, task, programs, say, lambda step: channel.step(solver, step))
            if prepared is None:
                continue
            mine, choice, import_us = runs[solver] = prepared
            told = {"asked": choice.asked, "setting": choice.setting, "swept": choice.swept}
            results[solver] = {number: {**failure(task, solver, number, "", ""), **told, **size_of(mine[number].qp),
                                        "machine": {"version": version}, "times": {"import_us": round(import_us, 3)}}
                               for number in mine}
        slow = set()
        for _ in range(task["repetitions"]):
            for solver, (mine, choice, _) in runs.items():
                if solver in slow:
                    continue
                channel.step(solver, "check")
                begin = time.monotonic()
                try:
                    measure(task, mine, results[solver], choice)
                except ProgramError:
                    raise
                except Exception as error:  # noqa: BLE001
                    for number in mine:
                        results[solver][number].update(
                            verdict="error", claimed=f"{type(error).__name__}: {error}"[:200])
                missed_all = all(line["verdict"] != "solved" for line in results[solver].values())
                if missed_all or time.monotonic() - begin > task["limits"]["solve"]:
                    slow.add(solver)
        channel.step(None, "task")
        for solver in runs:
            for line in results[solver].values():
                channel.say(line)
    channel.say({"done": task["id"]})


def main(words):
    end_with_parent()
    if words == ["--solvers"]:
        task, channel = supervisor.receive()
        try:
            run_task(task, channel)
        except ProgramDied:  # a failure of the solver that was tried last
            return 1
        except ProgramError as error:
            channel.say({"error": str(error)})
        return 0
    try:
        task = json.loads(words[0])
        lines = campaign.carry_out(task) if task.get("kind") == "command" else supervisor.carry_out(task)
    except ProgramError as error:
        print(f"saltus bench task: {error}", file=sys.stderr)
        return 2
    for line in [*lines, {"done": task["id"]}]:
        print(json.dumps(line))
    return 0
