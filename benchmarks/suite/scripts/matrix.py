"""The tasks of a run: problems x starts x solvers, with instances and repetitions."""

import difflib

import nonlinear_peers
import peers
import supervisor
from task import OURS
from toy import Endless, Toy

HIDDEN = ("toy", "endless")


class MatrixError(Exception):
    """A request for something that does not exist; the message is one sentence."""


def solver_names():
    return [*OURS, *(peer.name for peer in all_peers())]


def all_peers():
    return [*peers.all_peers(), *nonlinear_peers.nonlinear_peers()]


def suits(solver, problem):
    """True if the solver supports programs of this kind."""
    kind, theirs = problem.get("kind"), {p.name: p for p in nonlinear_peers.nonlinear_peers()}
    if kind in (None, "integer", "loop"):
        mine = {p.name: p for p in (*peers.all_peers(), Toy, Endless)}
        if kind == "integer":
            return getattr(mine.get(solver), "takes_integers", False)
        return solver != "ipopt" and solver not in theirs and (kind, solver) != ("loop", "riccati") and getattr(mine.get(solver), "takes_continuous", True)
    if solver in OURS:  # they compile no sizes in, and files have no stages
        return solver != "riccati-generic" and (solver != "riccati" or not problem.get("origin"))
    wanted = "takes_pairs" if kind == "complementarity" else "takes_files"
    return solver in theirs and (not problem.get("origin") or getattr(theirs[solver], wanted, False))


def chosen(wanted, names, what, hidden=()):
    """The requested names in canonical order. A pattern that ends in * selects all names with this prefix."""
    if not wanted:
        return list(names)
    picked = set()
    for word in wanted.split(","):
        found = [n for n in (*names, *hidden)
                 if n == word or (word.endswith("*") and n.startswith(word[:-1]))]
        if not found:
            near = difflib.get_close_matches(word, names, 1, 0.4)
            raise MatrixError(f"there is no {what} '{word}'; "
                              + (f"did you mean '{near[0]}'?" if near
                                 else f"the {what}s are {', '.join(names)}"))
        picked.update(found)
    return [n for n in (*names, *hidden) if n in picked]


def default_names(problems):
    """Our problems and a sample, evenly spread, of the published ones: two for each of ours, as far as they are there."""
    usual = [n for n, p in problems.items() if not p.get("on_request")]
    ours = [n for n in usual if problems[n].get("origin", "ours") in ("ours", "own file")]
    others = [n for n in usual if n not in ours and any(suits(s, problems[n]) for s in solver_names())]
    count = min(len(others), 2 * len(ours))
    picked = {others[i * len(others) // count] for i in range(count)}
    return [n for n in usual if n in picked or n in ours]


def tasks_of(description, arguments):
    """The list of tasks, in the order of the results."""
    problems = {p["name"]: p for p in description["problems"]}
    names = chosen(arguments.problems, problems, "problem")
    if not arguments.problems:
        names = default_names(problems)
    solvers = chosen(arguments.solvers, solver_names(), "solver", HIDDEN)
    starts = chosen(arguments.start, ("cold", "warm"), "start")
    tasks, limits = [], supervisor.limits()
    for name in names:
        problem = problems[name]
        count = min(arguments.instances, problem["instances"] or arguments.instances)
        # A sequence is sampled over its whole length.
        every = max(1, (problem["instances"] or count) // count)
        instances = [1 + every * i for i in range(count)]
        for start in starts:
            if start == "warm" and not problem["warm"]:
                continue
            mine = [s for s in solvers if suits(s, problem)]
            if not mine:
                continue
            kind = {"kind": problem["kind"]} if "kind" in problem else {}
            tasks.append({"id": f"{name} {start}", "problem": name, "start": start, **kind,
                          "horizon": problem["horizon"], "instances": instances,
                          "repetitions": arguments.repetitions, "tolerance": arguments.tolerance,
                          "limits": limits,
                          "solvers": mine})
    return tasks


def shard(tasks, text):
    """Part I of N, from 1: every N-th task."""
    try:
        part, count = (int(word) for word in text.split("/"))
        if not 1 <= part <= count:
            raise ValueError
    except ValueError:
        raise MatrixError(f"a shard must be I/N with 1 <= I <= N, as in 2/5, not '{text}'") from None
    return tasks[part - 1::count]
