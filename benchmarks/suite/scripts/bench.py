#!/usr/bin/env python3
"""The benchmark suite: problems, solvers and settings with one common check of all answers. Run by `saltus bench`."""

import argparse
import math
import os
import platform
import subprocess
import sys

from cache import INSTALL_PEERS

OK, DIFFERENT, MISTAKE, FAILED, LOST, NO_NETWORK, INTERRUPTED = 0, 1, 2, 3, 4, 5, 130


def asked_of_program():
    from program import Program
    with Program() as program:
        return program.ask(do="describe")


def describe():
    """The description by the program, with the problems from data files."""
    import data_problems
    description = asked_of_program()
    description["problems"] += data_problems.described()
    return description


def describe_machine():
    return {"system": platform.platform(), "python": platform.python_version(),
            "processors": os.cpu_count()}


def list_all(arguments):
    import matrix
    import peers
    description = describe()
    print("problems")
    width = max(len(p["name"]) for p in description["problems"])
    for p in description["problems"]:
        count = {0: "any number of instances", 1: "one instance"}.get(p["instances"], f"{p['instances']} instances")
        print(f"  {p['name']:<{width}} {p['about'].rstrip('.')}; {count}" + ("; cold and warm" if p["warm"] else ""))
    for sentence in missing_sets():
        print(f"  ({sentence})")
    print("solvers")
    for name in description["solvers"]:
        print(f"  {name:<22} ours")
    for peer in matrix.all_peers():
        missing = peers.why_missing(peer)
        told = missing or f"{peers.named_version(peer)}{peer.about}"
        print(f"  {peer.name:<22} {told}")
    return OK


def missing_sets():
    """One sentence per public set that is not on this machine."""
    import public_sets
    return [f"missing: {name}, {s.files} files; saltus bench fetch {name}" for name, s in public_sets.SETS.items()
            if not public_sets.files_of(name)]


def fetch(arguments):
    import public_sets
    if arguments.name is None:
        for name, s in public_sets.SETS.items():
            there = len(public_sets.files_of(name))
            print(f"{name:<20} {there:>4} of {s.files} files, {s.megabytes:g} MB; {s.kind}; licence: {s.licence}; "
                  f"github.com/{s.repository} at {s.commit[:12]}")
        return OK
    if arguments.name not in public_sets.SETS:
        raise ValueError(f"there is no set '{arguments.name}'; the sets are {', '.join(public_sets.SETS)}")
    if not 0 < arguments.limit < math.inf:
        raise ValueError(f"--limit must be a number of seconds above 0, not {arguments.limit}")
    try:
        public_sets.fetch(arguments.name, arguments.source, arguments.limit, sys.stdout)
        return OK
    except public_sets.FetchError as error:
        print(f"saltus bench fetch: {error}", file=sys.stderr)
        return {public_sets.NoNetwork: NO_NETWORK, public_sets.TimeIsUp: LOST}.get(type(error), FAILED)


def check_files(arguments):
    import data_problems
    if arguments.optima is not None:
        import published
        arguments.tolerance = OPTIMA_TOLERANCE
        return OK if published.compare(describe(), arguments, sys.stdout) else DIFFERENT
    import problem_files
    import public_sets
    folders = [public_sets.folder_of(name) for name, s in public_sets.SETS.items() if not s.others]
    paths = arguments.files or [data_problems.STATEMENTS, *filter(os.path.isdir, folders)]
    invalid = problem_files.check(paths, sys.stdout, brief=arguments.brief)
    if not arguments.files:
        for sentence in missing_sets():
            print(sentence)
    return FAILED if invalid else OK


OPTIMA_TOLERANCE = 1e-6


def saltus_of(description, program):
    return {"version": description["version"], "commit": description["commit"], **description["build"],
            "lanes": description["machine"]["lanes"], "program": program}


def head_of(description, arguments, tasks):
    import inputs
    import matrix
    import peers
    import records
    import supervisor
    packages = {p.package: peers.version_of(p.package) for p in matrix.all_peers() if p.package}
    solvers = {s for t in tasks for s in t["solvers"]}
    return {"format": records.FORMAT, "saltus": saltus_of(description, inputs.of_the_suite()),
            "machine": {"processor": description["machine"]["cpu"], **describe_machine()},
            "packages": packages, "inputs": inputs.of_run(tasks),
            "matrix": {"tasks": [t["id"] for t in tasks], "horizons": {t["id"]: t["horizon"]
                                                                       for t in tasks},
                       "solvers": [s for s in (*matrix.solver_names(), *matrix.HIDDEN) if s in solvers],
                       "kinds": {t["id"]: t["kind"] for t in tasks if "kind" in t},
                       "instances": arguments.instances, "repetitions": arguments.repetitions,
                       "tolerance": arguments.tolerance, "limits": supervisor.limits()},
            "shard": arguments.shard}


def head_of_campaign(description, arguments, tasks, what):
    import campaign
    import inputs
    import records
    return {"format": records.FORMAT, "saltus": saltus_of(description, inputs.digest(campaign.program_saltus())),
            "machine": {"processor": description["machine"]["cpu"], **describe_machine()},
            "packages": {}, "inputs": inputs.of_campaign(what, getattr(arguments, "set", None)),
            "matrix": {"campaign": what, "tasks": [t["id"] for t in tasks], "commands": [t["words"] for t in tasks],
                       "solvers": ["saltus"]},
            "shard": arguments.shard}


def begin_or_resume(path, head):
    """Returns the completed tasks. Raises RecordsError if the file belongs to another run."""
    import records
    if not os.path.exists(path):
        done = records.Records(head)
    else:
        done = records.read(path)
        other = records.what_differs(done.head, head, ("saltus", "machine", "packages", "inputs", "matrix", "shard"))
        if other:
            raise records.RecordsError(f"'{path}' belongs to another run: its {other}; remove it or give another --out")
        if done.cut_off:
            print(f"'{path}' is incomplete; its last task is run again", file=sys.stderr)
    records.write(path, done, list(done.tasks))
    return done


def tell_selection(description, arguments, tasks):
    """What the run lacks: sets that are not fetched, problems that no solver of the suite supports."""
    import matrix
    problems = {p["name"]: p for p in description["problems"]}
    taken = {t["problem"] for t in tasks}
    if not arguments.problems:
        ours = sum(problems[name].get("origin", "ours") == "ours" for name in taken)
        print(f"default set: {len(taken)} problems, {ours} of them ours; not ours: {len(taken) - ours}", file=sys.stderr)
        for sentence in missing_sets():
            print(sentence, file=sys.stderr)
        return
    left = [n for n in matrix.chosen(arguments.problems, problems, "problem") if n not in taken]
    unsolved = [n for n in left if not any(matrix.suits(s, problems[n]) for s in matrix.solver_names())]
    if unsolved:
        print(f"{len(unsolved)} problems are only read, no solver of the suite takes them yet, '{unsolved[0]}' for example",
              file=sys.stderr)


def run(arguments):
    import matrix
    description = describe()
    instances, repetitions = (3, 1) if arguments.quick else (10, 3)
    arguments.instances = arguments.instances or instances
    arguments.repetitions = arguments.repetitions or repetitions
    if arguments.quick:
        there = [p["name"] for p in description["problems"]]
        arguments.problems = arguments.problems or ",".join(n for n in QUICK if n in there)
        if not arguments.solvers:
            arguments.solvers = ",".join(name for name in matrix.solver_names() if name not in NOT_QUICK)
            print(f"--quick leaves out {', '.join(NOT_QUICK)}; --solvers NAME,... runs them", file=sys.stderr)
    status, tolerances, base = OK, arguments.tolerances, arguments.out
    for tolerance in tolerances:
        arguments.tolerance = tolerance
        if len(tolerances) > 1:
            arguments.out = f"{tolerance:.0e}".join((os.path.splitext(base)[0] + "-", os.path.splitext(base)[1]))
        tasks = matrix.tasks_of(description, arguments)
        done = carry_out(tasks, head_of(description, arguments, tasks), arguments)
        if len(tolerances) > 1:
            print(arguments.out)
        status = max(status, summarise(done, sys.stdout))
    tell_selection(description, arguments, tasks)
    return status


def runs_of(arguments, campaign_name, tasks_of):
    """The runs of a campaign: those of --merged, or of its tasks, which are carried out."""
    if arguments.merged:
        import records
        return records.read_of(arguments.merged, campaign_name)
    tasks = tasks_of(arguments)
    return carry_out(tasks, head_of_campaign(asked_of_program(), arguments, tasks, campaign_name), arguments)


def pushes(arguments):
    import campaign
    import table
    done = runs_of(arguments, "pushes", campaign.push_tasks)
    table.write_rows(campaign.push_table(done), sys.stdout)
    return status_of(done)


def robustness(arguments):
    import robustness as experiments
    if arguments.list:
        width = max(map(len, experiments.EXPERIMENTS))
        for name, experiment in experiments.EXPERIMENTS.items():
            print(f"{name:<{width}}  {experiment.about}")
        return OK
    done = runs_of(arguments, "robustness", experiments.tasks_of)
    experiments.write(done, sys.stdout)
    return status_of(done)


def survival_map(arguments):
    import campaign
    done = runs_of(arguments, "map", campaign.map_tasks)
    campaign.write_map(done, arguments.folder)
    print(f"{arguments.folder}: `saltus map` with the same grid and --out {arguments.folder} draws it")
    return status_of(done)


def reproduce(arguments):
    import campaign
    tasks = campaign.table_tasks(arguments)
    done = carry_out(tasks, head_of_campaign(asked_of_program(), arguments, tasks, "reproduce"), arguments)
    for line in done.lines():
        print(f"{line['problem']}: {line['verdict']}")
        if line["verdict"] != "as printed":
            print(line["claimed"])
    return status_of(done) or (DIFFERENT if any(l["verdict"] == "differs" for l in done.lines()) else OK)


def status_of(done):
    return FAILED if any(line["verdict"] == "crashed" for line in done.lines()) else OK


def carry_out(tasks, whole, arguments):
    """Runs the tasks that the results file lacks, here or on Dask workers. Returns all known results."""
    import engine
    import forecast
    import matrix
    import records
    if arguments.shard:
        tasks = matrix.shard(tasks, arguments.shard)
    done = begin_or_resume(arguments.out, whole)
    left = [t for t in tasks if t["id"] not in done.tasks]
    if len(left) < len(tasks):
        print(f"{len(tasks) - len(left)} of {len(tasks)} tasks are already in '{arguments.out}'"
              + ("" if left else ": nothing to run"), file=sys.stderr)
    progress = forecast.Progress(forecast.expected(left, forecast.known_seconds()), len(tasks) - len(left), sys.stderr)

    def take(task, lines):
        done.tasks[task["id"]] = lines
        records.append(arguments.out, task["id"], lines)
        if not whole["matrix"].get("campaign"):
            forecast.learn(task["id"], forecast.seconds_of(task, lines))
        progress.tell(task["id"])

    if arguments.scheduler:
        engine.run_on_cluster(left, take, arguments.scheduler)
    else:
        engine.run_here(left, take, getattr(arguments, "jobs", 1))
    done.tasks = {t["id"]: done.tasks[t["id"]] for t in tasks}  # in the order of the matrix
    records.write(arguments.out, done, list(done.tasks))
    return done


NOT_QUICK = ("casadi-qpoases", "highs", "scs", "uno-filtersqp", "uno-ipopt")  # they need seconds per solve of the quick problems
QUICK = ("recipe/kI=7", "recipe/no-impact", "sequence", "box/8x3", "public/LIPMWALK0",
         "public/WHLIPBAL0", "library/brachistochrone", "library/van_der_pol", "restated/bouncing_ball",
         "restated/catalyst_mixing")


def summarise(done, out):
    import figures
    import table
    table.write_text(done, out)
    lines = done.lines()
    why = {l["solver"]: l["claimed"] for l in reversed(lines) if l["verdict"] == "missing"}
    absent = sorted(name for name in why if why[name].endswith(f"is not installed: {INSTALL_PEERS}"))
    if absent:
        print(f"not run, their packages are not installed ({INSTALL_PEERS}): {', '.join(absent)}", file=out)
    for name in sorted(set(why) - set(absent)):
        print(f"{name} was not run: {why[name]}", file=out)
    for row in table.closed_loop_costs(done):
        print(row, file=out)
    for sentence in figures.all_remarks(lines):
        print(sentence, file=out)
    bad = [l for l in lines if l["verdict"] in ("crashed", "error", "judges disagree")
           or (l["verdict"] == "missing" and "broken" in l["claimed"])]
    return FAILED if bad else OK


def compare(arguments):
    import records
    from compare import compare as compare_records
    both = [records.read(path) for path in (arguments.before, arguments.after)]
    for path, one in zip((arguments.before, arguments.after), both):
        if one.cut_off:
            print(f"'{path}' is incomplete; only its complete tasks are compared", file=sys.stderr)
    return compare_records(*both, sys.stdout)


def report(arguments):
    import pages
    import records
    import scores
    from report import write_report
    every = [records.read_of(path, None) for path in arguments.results]
    for path, one in zip(arguments.results, every):
        if one.cut_off:
            print(f"'{path}' is incomplete; only its complete tasks are shown", file=sys.stderr)
    if len({one.head["matrix"]["tolerance"] for one in every}) < len(every):
        raise ValueError("two of the files have the same tolerance; give one file per tolerance, or merge their shards")
    written = []
    for target, write in ((arguments.csv, scores.write_csv), (arguments.latex, scores.write_latex), (arguments.site, pages.write_site)):
        if target:
            write(every, target)
            written.append(target)
    if arguments.out or not written:
        written.append(arguments.out or os.path.splitext(arguments.results[0])[0] + ".html")
        write_report(every, written[-1])
    print("\n".join(written))
    return OK


def merge(arguments):
    import records
    merged, notes = records.merge(arguments.shards)
    for note in notes:
        print(note, file=sys.stderr)
    records.write(arguments.out, merged, merged.head["matrix"]["tasks"])
    absent = [t for t in merged.head["matrix"]["tasks"] if t not in merged.tasks]
    if absent:
        print(f"{len(absent)} tasks are missing, '{absent[0]}' for example", file=sys.stderr)
    return FAILED if absent else OK


def install_peers(arguments):
    """Installs the peers into a separate environment, which the product never needs, and conflicting packages into a
    folder of it."""
    folder = arguments.folder or os.environ["SALTUS_PEERS"]
    here = os.path.dirname(os.path.abspath(__file__))
    base = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
    install = [os.path.join(folder, "bin/python3"), "-m", "pip", "install", "--quiet", "--only-binary", ":all:",
               "--require-hashes"]
    for command in ([base, "-m", "venv", folder],
                    [*install, "--requirement", os.path.join(here, "peers.txt")],
                    [*install, "--no-deps", "--upgrade", "--target", os.path.join(folder, "acados"), "--requirement",
                     os.path.join(here, "peers_acados.txt")]):
        # A file pip.py in the caller's folder must not be imported.
        if subprocess.run(command, check=False, env={**os.environ, "PYTHONSAFEPATH": "1"}).returncode != 0:
            print(f"saltus bench peers: '{' '.join(command)}' failed", file=sys.stderr)
            return FAILED
    print(folder)
    return OK


def add_engine(p, out):
    p.add_argument("--out", metavar="FILE", default=out)
    p.add_argument("--scheduler", metavar="ADDRESS", help="scheduler of Dask, whose workers run the tasks")
    p.add_argument("--shard", metavar="I/N", help="run every N-th task, starting with the I-th")


def add_campaign(p, out):
    add_engine(p, out)
    p.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of parallel tasks on this machine")
    p.add_argument("--set", metavar="KEY=VALUE", action="append", help="a setting of push recovery")
    p.add_argument("--merged", metavar="FILE", help="only print these results of `bench merge`")


def parser():
    top = argparse.ArgumentParser(prog="saltus bench", description=__doc__)
    verbs = top.add_subparsers(dest="verb", required=True)
    verbs.add_parser("list", help="lists problems and solvers").set_defaults(do=list_all)
    p = verbs.add_parser("run", help="runs a matrix of problems and solvers; resumes an interrupted run")
    p.set_defaults(do=run)
    p.add_argument("--problems", metavar="NAME,...", help="NAME* selects all names with this prefix")
    p.add_argument("--solvers", metavar="NAME,...")
    p.add_argument("--start", metavar="cold,warm")
    p.add_argument("--tolerance", metavar="NUMBER,...", default="1e-8",
                   help="largest accepted KKT residual; with several, one run and file each: FILE-1e-03.jsonl")
    p.add_argument("--instances", type=int, help="maximum number per problem; default 10")
    p.add_argument("--repetitions", type=int, help="default 3")
    p.add_argument("--quick", action="store_true", help="few problems, by default with 3 instances and one repetition")
    add_engine(p, "bench.jsonl")
    p = verbs.add_parser("pushes", help="Monte Carlo of push recovery: random pushes, sensor noise, masses and friction")
    p.set_defaults(do=pushes)
    p.add_argument("--runs", type=int, default=100)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--plant", choices=("centroidal", "dart", "mujoco"), default="dart")
    p.add_argument("--impulse", metavar="LOW:HIGH", default="4:10", help="range of the impulse in N s; the direction is random")
    p.add_argument("--mass-error", metavar="LOW:HIGH", default="-0.05:0.05",
                   help="range of the relative error of the masses in the controller's model")
    p.add_argument("--friction", metavar="LOW:HIGH", default="0.4:1.0",
                   help="range of the friction coefficient of the ground (whole body)")
    add_campaign(p, "pushes.jsonl")
    p = verbs.add_parser("robustness", help="repeats named experiments of push recovery over seeds: rates with 95 %% intervals")
    p.set_defaults(do=robustness)
    p.add_argument("names", nargs="*", metavar="NAME", help="experiments; default all")
    p.add_argument("--list", action="store_true", help="lists the experiments")
    p.add_argument("--plant", choices=("dart", "mujoco"), default="dart")
    p.add_argument("--seeds", type=int, metavar="N", help="seeds 1 to N; the default depends on experiment and plant")
    p.add_argument("--quick", action="store_true", help="few seeds: all experiments in ten minutes on one core")
    p.add_argument("--conditions", metavar="NAME,...", help="only these conditions; NAME* selects all with this prefix")
    add_campaign(p, "robustness.jsonl")
    p = verbs.add_parser("map", help="runs every cell of a survival map, in shards")
    p.set_defaults(do=survival_map)
    p.add_argument("--plant", choices=("centroidal", "dart", "mujoco"), default="centroidal")
    p.add_argument("--directions", type=int, default=16)
    p.add_argument("--impulses", metavar="A,B,...", default=",".join(map(str, range(1, 17))), help="impulses in N s")
    p.add_argument("--step-times", metavar="A,B,...", default="0.3,0.45,0.6", help="step times in s")
    p.add_argument("--controllers", metavar="NAME,...", default="mpc,capture_point,none")
    p.add_argument("--folder", metavar="DIR", default="map", help="folder of map.csv")
    add_campaign(p, "map.jsonl")
    p = verbs.add_parser("reproduce", help="repeats the tables of the READMEs, from a clone of the sources")
    p.set_defaults(do=reproduce)
    p.add_argument("names", nargs="*", metavar="NAME")
    add_engine(p, "reproduce.jsonl")
    p.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of parallel tasks on this machine")
    p = verbs.add_parser("compare", help="lists improvements and regressions beyond noise; status 1 on a regression")
    p.set_defaults(do=compare)
    p.add_argument("before")
    p.add_argument("after")
    p = verbs.add_parser("report", help="writes results as an HTML page for offline use, as CSV, LaTeX or a site")
    p.set_defaults(do=report)
    p.add_argument("results", nargs="+", help="one file per tolerance")
    p.add_argument("--out", metavar="FILE", help="the page; by default next to the first file")
    p.add_argument("--csv", metavar="FILE", help="every line of the results as a table")
    p.add_argument("--latex", metavar="FILE", help="means per class as tables")
    p.add_argument("--site", metavar="FOLDER", help="the page, with a page per instance and per solver")
    p = verbs.add_parser("merge", help="merges the shards of a run into one file")
    p.set_defaults(do=merge)
    p.add_argument("shards", nargs="+")
    p.add_argument("--out", metavar="FILE", required=True)
    p = verbs.add_parser("fetch", help="copies a public set of problems into the user's cache; without a name: lists the sets")
    p.set_defaults(do=fetch)
    p.add_argument("name", nargs="?")
    p.add_argument("--from", dest="source", metavar="FOLDER", help="a local copy of the repository, or a folder with its files")
    p.add_argument("--limit", type=float, default=600.0, metavar="SECONDS", help="time limit; the same command continues")
    p = verbs.add_parser("check", help="validates problem files and counts them per class; without files: all sets on this machine")
    p.set_defaults(do=check_files)
    p.add_argument("files", nargs="*", metavar="FILE|FOLDER")
    p.add_argument("--brief", action="store_true", help="only mistakes and counts")
    p.add_argument("--optima", type=int, metavar="N", help="solve N fetched problems instead, and compare their costs with published optima")
    p.add_argument("--seed", type=int, default=1, help="seed of the choice of the N problems")
    p.add_argument("--solvers", metavar="NAME,...", default="sparse,piqp,clarabel,highs")
    p = verbs.add_parser("peers", help="installs other solvers into a separate Python environment")
    p.set_defaults(do=install_peers)
    p.add_argument("folder", nargs="?")
    return top


def tolerances_of(text):
    """Raises ValueError with one sentence."""
    try:
        found = sorted({float(word) for word in text.split(",")}, reverse=True)
        if not all(0.0 < value < math.inf for value in found):
            raise ValueError
        return found
    except ValueError:
        raise ValueError(f"--tolerance must be a number above 0, or a list like 1e-3,1e-6,1e-9, not '{text}'") from None


def main(words):
    if words[:1] == ["task"]:
        import task
        return task.main(words[1:])
    arguments, status = parser().parse_args(words), MISTAKE
    try:
        for name in ("instances", "repetitions", "runs", "seeds", "jobs", "optima"):
            given = getattr(arguments, name, None)
            if given is not None and given < 1:
                raise ValueError(f"--{name} must be at least 1")
        if hasattr(arguments, "tolerance"):
            arguments.tolerances = tolerances_of(arguments.tolerance)
        return arguments.do(arguments)
    except KeyboardInterrupt:
        print(f"saltus bench {arguments.verb}: interrupted; with --out FILE the same command resumes", file=sys.stderr)
        return INTERRUPTED
    except ModuleNotFoundError as error:
        sentence = f"{error.name} is needed: Debian's python3-{error.name}, or {INSTALL_PEERS}"
    except OSError as error:
        sentence = f"'{error.filename}': {error.strerror}" if error.filename else str(error)
    except ValueError as error:
        sentence = str(error)
    except Exception as error:  # noqa: BLE001
        if type(error).__name__ not in ("ProgramError", "RecordsError", "MatrixError", "EngineError",
                                        "CampaignError", "ProgramFileError", "TasksLost"):
            raise
        sentence = str(error)
        if type(error).__name__ == "TasksLost":
            status = LOST
    print(f"saltus bench {arguments.verb}: {sentence}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
