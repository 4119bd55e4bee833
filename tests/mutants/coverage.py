"""Which lines and branches of a layer do its tests reach? `./saltus coverage [LAYER ...]`

Only the layer's objects are compiled again, with counters (gcc --coverage); the test programs of mutants are linked
with them and run, and gcovr reads the counters. Branches that only an exception or an unreachable end would take are
left out.
"""
import argparse
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from relink import Build, Failure, alone_in
from trial import Parser, parts_of, run


def measure(build, layer, with_later, jobs):
    """(lines, reached, branches, reached) by file of a layer."""
    folder = build.made()
    asked = [parts_of(words)[:2] for words in layer["tests"] + (layer["later"] if with_later else [])]
    members = {name: build.members(name) for name, _ in asked}
    targets = [target for target in sorted(set().union(*members.values()))
               if any(target.startswith(f"{source}/") for source in layer["folders"])]
    made = {target: folder / f"{i}.o" for i, target in enumerate(targets)}
    with ThreadPoolExecutor(jobs) as pool:
        compiled = pool.map(lambda target: build.compile(target, made[target], "--coverage"), targets)
        if bad := [target for target, good in zip(targets, compiled) if not good]:
            raise Failure(f"{bad[0]} does not compile with --coverage")
    for name, chosen in asked:
        own = {target: path for target, path in made.items() if target in members[name]}
        if own and not build.link(name, folder / name, own, "--coverage"):
            raise Failure(f"{name} does not link with --coverage")
        if own:
            ended, said = run([str(folder / name), f"--gtest_filter={chosen}"], folder, 3600)
            if ended != "passed":
                raise Failure(f"{name} fails with counters\n{said[-2000:]}")
    report = folder / "summary.json"
    subprocess.run(["gcovr", "--root", str(build.work), "--json-summary", str(report), "--exclude-throw-branches",
                    "--exclude-unreachable-branches", "--gcov-ignore-parse-errors", str(folder)],
                   cwd=build.folder, check=True, capture_output=True)
    found = {}
    for entry in json.loads(report.read_text())["files"]:
        name = os.path.relpath(os.path.realpath(build.work / entry["filename"]), os.path.realpath(build.tree))
        if any(name.startswith(f"{source}/") for source in layer["folders"]):
            found[name] = tuple(entry[kind] for kind in ("line_total", "line_covered", "branch_total", "branch_covered"))
    return found


def percent(part, whole):
    return f"{100 * part / whole:.1f} %" if whole else "none"


def row(name, figures):
    lines, lines_reached, branches, branches_reached = figures
    return (f"| {name} | {lines} | {percent(lines_reached, lines)} | {branches} | "
            f"{percent(branches_reached, branches)} |")


def main(words):
    parser = Parser("coverage", __doc__)
    parser.add_argument("build", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("layers", nargs="*", metavar="LAYER")
    parser.add_argument("--sample", type=int, metavar="N", help="one layer, chosen by the number")
    parser.add_argument("--files", action="store_true", help="also file by file")
    parser.add_argument("--later", action="store_true", help="also with the test programs of other layers")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers at once (one per processor)")
    parser.add_argument("--only-parse", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_intermixed_args(words)  # layers may stand behind options
    if arguments.only_parse:
        return 0
    folder = arguments.build.resolve()
    layers = json.loads((folder / "mutated_layers.json").read_text())
    names = arguments.layers or list(layers)
    if arguments.sample is not None:
        names = [names[arguments.sample % len(names)]]
    for name in names:
        if name not in layers:
            raise Failure(f"there is no layer '{name}' to measure; there are {', '.join(layers)}")
    work = folder / "coverage"
    with alone_in(work):
        build = Build(folder, work)
        print("| layer | lines | reached | branches | reached |\n| --- | --- | --- | --- | --- |", flush=True)
        for name in names:
            files = measure(build, layers[name], arguments.later, arguments.jobs)
            if arguments.files:
                for file, figures in sorted(files.items()):
                    print(row(file, figures))
            print(row(name, [sum(column) for column in zip(*files.values())]), flush=True)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Failure as failure:
        sys.exit(f"saltus: {failure}")
