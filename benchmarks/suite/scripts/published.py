"""`bench check --optima N`: solves N published problems, drawn at random, and compares the costs with the published optima."""

import random

import data_problems
import engine
import matrix
import public_sets
import table

AGREE = 1e-5  # relative; published optima have about eight digits


def drawn(count, seed):
    """Names of fetched problems with a published optimum, up to the size of the default set."""
    usual = {p["name"] for p in data_problems.described() if p.get("origin") == "public" and not p["on_request"]}
    twice = tuple(f"{data_problems.PUBLIC}{name}/" for name, s in public_sets.SETS.items() if s.others)
    known = sorted(name for name in usual if not name.startswith(twice) and data_problems.source_of(name)[1] is not None)
    if len(known) < count:
        raise ValueError(f"only {len(known)} problems have a published optimum; `bench fetch maros-meszaros` and "
                         "`bench fetch maros-meszaros-qps` copy 138 and the table of their optima")
    return sorted(random.Random(seed).sample(known, count))


def rows(names, lines, solvers):
    """A row per problem: the published optimum, and each solver's relative difference from it or its verdict."""
    yield ["problem", "variables", "rows", "published", *solvers]
    for name in names:
        mine = {line["solver"]: line for line in lines if line["problem"] == name}
        size = next((line["size"] for line in mine.values() if "size" in line), ("-", "-"))
        yield [name, *map(str, size), f"{data_problems.source_of(name)[1]:.7e}", *(told(mine[s]) if s in mine else "-" for s in solvers)]


def difference(line):
    """Relative difference of an accepted cost from the published optimum, or None."""
    if line["verdict"] != "solved":
        return None
    return abs(line["objective"] - line["optimum"]) / max(1.0, abs(line["optimum"]))


def told(line):
    found = difference(line)
    return line["verdict"] if found is None else f"{found:.1e}"


def compare(description, arguments, out):
    """True if for each problem a solver finds the published optimum, and none finds another one."""
    names = drawn(arguments.optima, arguments.seed)
    arguments.problems, arguments.start, arguments.instances, arguments.repetitions = ",".join(names), "cold", 1, 1
    tasks, lines = matrix.tasks_of(description, arguments), []
    engine.run_here(tasks, lambda _, found: lines.extend(found))
    solvers = [s for s in tasks[0]["solvers"] if any(line["solver"] == s and line["verdict"] != "missing" for line in lines)]
    table.write_rows(rows(names, lines, solvers), out)
    errors = {name: [e for e in (difference(line) for line in lines if line["problem"] == name) if e is not None] for name in names}
    agree = [name for name in names if errors[name] and max(errors[name]) <= AGREE]
    print(f"{len(agree)} of {len(names)} costs agree with the published optima to {AGREE:g}", file=out)
    return len(agree) == len(names)
