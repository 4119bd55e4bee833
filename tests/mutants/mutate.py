"""Are there tests that fail when the code is wrong? `./saltus mutate` gives the sources one small mistake at a time.

Mistakes (operators.py) are drawn by a seed. Each is made in a copy of the sources in the build folder, never in the
sources themselves; what includes the changed file is compiled again, and the layer's test programs (CMakeLists.txt of
this folder) are linked with it and run, the shortest first, up to the first failure, which has to happen twice. A
mutant that does not compile is not counted and another one takes its place; one that takes many times the processor
time of the unchanged program, or sleeps for ever, is killed. What survives is compared with explained.json, the list
of mutants that no test can or need see, with a reason each.

Results are JSON lines in BUILD/mutants; --resume goes on after the last.
"""
import argparse
import json
import os
import random
import re
import shutil
import signal
import sys
import time
from collections import Counter, defaultdict
from contextlib import nullcontext
from pathlib import Path

import operators
from relink import ROOT, Build, Failure, alone_in
from trial import Parser, Programs, processor_time, run

EXPLAINED = Path(__file__).with_name("explained.json")
REQUIRED_SHARE = 0.85  # of those that compile
MOST_OBJECTS = 4       # to be compiled for one mutant: what is included more widely is left out


# ---- mutants --------------------------------------------------------------------------------------

def sites(build, layer, rounds):
    """(file, mutation) by operator, of what the layer's programs contain."""
    inside = {member for programs in rounds for program in programs for member in program.members}
    found, wide = defaultdict(list), 0
    for folder in layer["folders"]:
        for path in sorted((ROOT / folder).rglob("*.[ch]pp")):
            name = str(path.relative_to(ROOT))
            objects = build.includers[name] & inside
            mutations = operators.mutations(path.read_text()) if objects else []
            if len(objects) > MOST_OBJECTS:
                wide += len(mutations)
                continue
            for mutation in mutations:
                found[mutation.operator].append((name, mutation))
    return found, wide


def drawn(found, seed):
    """All mutants of a layer in the order of a seed: an operator, then a place of it, each as likely as others."""
    generator = random.Random(seed)
    left = {name: generator.sample(found[name], len(found[name])) for name in operators.OPERATORS if found.get(name)}
    while left:
        name = generator.choice(sorted(left))
        yield left[name].pop()
        if not left[name]:
            del left[name]


def mistakes(places):
    """Without those that would change nothing."""
    return (place for place in places if place[1].is_a_mistake((ROOT / place[0]).read_text()))


class Mutant:
    def __init__(self, name, mutation):
        self.name = name
        self.mutation = mutation
        self.text = (ROOT / name).read_text()
        self.line = self.text.count("\n", 0, mutation.begin) + 1
        self.before = self._line_of(self.text)
        self.after = self._line_of(mutation.apply(self.text))

    def _line_of(self, text):
        return " ".join(text.split("\n")[self.line - 1].split())

    def facts(self):
        return {"file": self.name, "line": self.line, "operator": self.mutation.operator, "before": self.before,
                "after": self.after}


def judge(build, mutant, rounds, scratch, most=None):
    """(status, by which test) of one mutant; the copy is as before when it returns. Programs of the next round are
    asked only if those of the one before have found nothing, and of `most` rounds if that is given."""
    copy = build.tree / mutant.name
    inside = {member for programs in rounds for program in programs for member in program.members}
    objects = build.work / "objects"
    shutil.rmtree(objects, ignore_errors=True)
    objects.mkdir()
    replaced = {}
    copy.write_text(mutant.mutation.apply(mutant.text))
    try:
        for target in sorted(build.includers[mutant.name] & inside):
            replaced[target] = objects / f"{len(replaced)}.o"
            if not build.compile(target, replaced[target]):
                return "not compiled", ""
    finally:
        copy.write_text(mutant.text)
    for programs in rounds[:most]:
        # Times are found out before anything is made.
        parts = [part for program in programs if program.is_asked_about(mutant.name, replaced)
                 for part in program.parts()]
        made = build.made()
        for _, seconds, program, chosen in sorted(parts, key=lambda part: part[:2]):
            binary = made / program.name
            own = {target: path for target, path in replaced.items() if target in program.members}
            if not binary.exists() and not build.link(program.name, binary, own):
                return "not compiled", ""
            if test := failing_test(binary, chosen, 10.0 + 6.0 * seconds, scratch):
                return "killed", f"{program.name} {test}"
    return "survived", ""


def failing_test(binary, chosen, seconds, scratch):
    """The first that fails, or None. What fails by chance does not count: it has to happen twice."""
    words = [str(binary), f"--gtest_filter={chosen}", "--gtest_fail_fast"]
    ended, said = run(words, scratch, seconds)
    if ended == "passed":
        return None
    # After a failure the others are begun only to be skipped; a crash says nothing of its test's end.
    begun = re.findall(r"^\[  FAILED  \] ([^\s,]+)", said, re.M)[:1]
    begun = begun or re.findall(r"^\[ RUN      \] (\S+)", said, re.M)
    if ended == "too long" or not begun:
        return f"{begun[-1] if begun else 'at its start'}{' (took too long)' if ended == 'too long' else ''}"
    if run([str(binary), f"--gtest_filter={begun[-1]}"], scratch, seconds)[0] != "passed":
        return begun[-1]
    # It may need those before it: all of them once more.
    return begun[-1] if run(words, scratch, seconds)[0] != "passed" else None


# ---- the campaign ---------------------------------------------------------------------------------

def reasons():
    """Of mutants that are known to survive, by what they change."""
    return {(e["file"], e["before"], e["after"]): e["reason"] for e in json.loads(EXPLAINED.read_text())}


def share(killed, counted):
    return f"{100 * killed / counted:.1f} %" if counted else "none"


def summary(results, explained):
    """The table of a campaign, and whether it is as good as it must be."""
    lines = ["| layer | mutants | killed | of them by time | share | survived, explained | not explained | did not compile |",
             "| --- | --- | --- | --- | --- | --- | --- | --- |"]

    def row(name, of):
        status = Counter(result["status"] for result in of)
        counted = status["killed"] + status["survived"]
        known = sum(result["status"] == "survived" and key(result) in explained for result in of)
        late = sum(result["by"].endswith("too long)") for result in of)
        lines.append(f"| {name} | {counted} | {status['killed']} | {late} | {share(status['killed'], counted)} | {known} | "
                     f"{status['survived'] - known} | {status['not compiled']} |")
        return counted == 0 or status["killed"] >= REQUIRED_SHARE * counted and status["survived"] == known

    for layer in sorted({result["layer"] for result in results}):
        row(layer, [result for result in results if result["layer"] == layer])
    good = row("all", results)
    lines += ["", "| operator | mutants | killed |", "| --- | --- | --- |"]
    for name in operators.OPERATORS:
        status = Counter(result["status"] for result in results if result["operator"] == name)
        if counted := status["killed"] + status["survived"]:
            lines.append(f"| {name} | {counted} | {status['killed']} |")
    left = [result for result in results if result["status"] == "survived" and key(result) not in explained]
    if left:
        lines += ["", "survived, and nobody has said why:"]
        lines += [f"{r['file']}:{r['line']}  {r['operator']}\n  - {r['before']}\n  + {r['after']}" for r in left]
    return "\n".join(lines), good


def key(result):
    return result["file"], result["before"], result["after"]


def read_results(path, seed):
    """Complete lines of an earlier run: a kill may leave half a line at the end."""
    if not path.exists():
        raise Failure(f"there is nothing of seed {seed} to go on with ({path}); begin without --resume")
    results = []
    for line in path.read_text().splitlines():
        try:
            results.append(json.loads(line))
        except json.JSONDecodeError:
            break
    return results


def write_results(path, results):
    part = path.with_suffix(".part")
    part.write_text("".join(json.dumps(result) + "\n" for result in results))
    part.replace(path)


def scratch_of(build):
    """An empty folder that tests start in and write to."""
    scratch = build.work / "scratch"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    os.environ["TMPDIR"] = str(scratch)
    return scratch


def rounds_of(layer, programs):
    """The layer's own test programs, those of others that are asked about what survives, and at the end chosen tests
    of those that take long."""
    return [[programs[test] for test in layer[which]] for which in ("tests", "later", "last")]


def once_more(build, layers, chosen, results, path, own=False):
    """Those that survived and have no reason to, with the tests of now."""
    scratch = scratch_of(build)
    programs = Programs(build, scratch)
    explained = reasons()
    for result in results:
        if result["status"] != "survived" or result["layer"] not in chosen or key(result) in explained:
            continue
        mutant = found_again(result)
        if mutant is None:
            print(f"{result['file']}:{result['line']}  is written otherwise by now", flush=True)
            continue
        rounds = rounds_of(layers[result["layer"]], programs)
        result["status"], result["by"] = judge(build, mutant, rounds, scratch, 1 if own else None)
        print(f"{result['file']}:{result['line']}  {result['operator']}: {result['status']} {result['by']}", flush=True)
        write_results(path, results)


def found_again(result):
    """The mutant that a line of results tells of, if the line of source is still there."""
    text = (ROOT / result["file"]).read_text()
    mutants = [Mutant(result["file"], mutation) for mutation in operators.mutations(text)
               if mutation.operator == result["operator"]]
    mutants = [mutant for mutant in mutants if (mutant.before, mutant.after) == (result["before"], result["after"])]
    return min(mutants, key=lambda mutant: abs(mutant.line - result["line"]), default=None)


def campaign(build, layers, chosen, seed, count, results, path, own=False):
    scratch = scratch_of(build)
    programs = Programs(build, scratch)
    queues = {}
    for name in chosen:
        mine = rounds_of(layers[name], programs)
        found, wide = sites(build, layers[name], mine)
        print(f"{name}: {sum(map(len, found.values()))} places; {wide} more in headers of more than "
              f"{MOST_OBJECTS} objects", flush=True)
        queues[name] = (mine, mistakes(drawn(found, f"{seed} {name}")))
    explained = reasons()
    done = {name: [result for result in results if result["layer"] == name] for name in chosen}
    for name in chosen:  # those that were drawn before
        for _ in done[name]:
            next(queues[name][1], None)
    wanted = {name: count // len(chosen) + (i < count % len(chosen)) for i, name in enumerate(chosen)}
    with open(path, "a", encoding="utf-8") as file:
        while True:
            tested = {name: sum(result["status"] != "not compiled" for result in done[name]) for name in chosen}
            short = [name for name in chosen if tested[name] < wanted[name]]
            if not short:
                return
            name = min(short, key=lambda layer: tested[layer] / wanted[layer])  # all layers advance together
            mine, queue = queues[name]
            place = next(queue, None)
            if place is None:
                wanted[name] = tested[name]
                continue
            mutant, begun, before = Mutant(*place), time.monotonic(), processor_time()
            status, by = judge(build, mutant, mine, scratch, 1 if own else None)
            result = {"layer": name} | mutant.facts() | {
                "status": status, "by": by, "seconds": round(time.monotonic() - begun, 1),
                "processor": round(processor_time() - before, 1)}
            done[name].append(result)
            results.append(result)
            file.write(json.dumps(result) + "\n")
            file.flush()
            number = sum(r["status"] != "not compiled" for r in results)
            why = explained.get(key(result), "not explained") if status == "survived" else by
            print(f"{number} of {sum(wanted.values())}  {name}  {mutant.name}:{mutant.line}  {mutant.mutation.operator}: "
                  f"{status}{': ' if why else ''}{why} ({result['seconds']:.0f} s)", flush=True)


def whole_number(text):
    if not re.fullmatch(r"[1-9]\d{0,8}", text):
        raise argparse.ArgumentTypeError(f"needs a whole number of at least 1, not '{text}'")
    return int(text)


def read_arguments(words):
    parser = Parser("mutate", __doc__)
    parser.add_argument("build", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--seed", type=whole_number, default=1, help="which mutants are drawn (1)")
    parser.add_argument("--count", type=whole_number, default=300, help="how many, of all layers together (300)")
    parser.add_argument("--layer", action="append", help="of this layer only; may be given more than once")
    parser.add_argument("--own", action="store_true",
                        help="ask the layer's own programs only; --again asks all of them about what survives")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--resume", action="store_true", help="go on with what this seed has begun")
    what.add_argument("--again", action="store_true", help="those of this seed that survived and are not explained, with the tests of now")
    what.add_argument("--report", action="store_true", help="only print the table of what this seed has found")
    parser.add_argument("--only-parse", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args(words)


def main(words):
    arguments = read_arguments(words)
    if arguments.only_parse:
        return 0
    build_folder = arguments.build.resolve()
    layers = json.loads((build_folder / "mutated_layers.json").read_text())
    chosen = arguments.layer or list(layers)
    for name in chosen:
        if name not in layers:
            raise Failure(f"there is no layer '{name}' to mutate; there are {', '.join(layers)}")
    work = build_folder / "mutants"
    path = work / f"seed{arguments.seed}.jsonl"
    begins = not (arguments.resume or arguments.again or arguments.report)
    with alone_in(work) if not arguments.report else nullcontext():
        results = [] if begins else read_results(path, arguments.seed)
        if not arguments.report:
            write_results(path, results)
            print(f"seed {arguments.seed}, results in {path}", flush=True)
        if arguments.again:
            once_more(Build(build_folder, work), layers, chosen, results, path, arguments.own)
        elif not arguments.report:
            campaign(Build(build_folder, work), layers, chosen, arguments.seed, arguments.count, results, path,
                     arguments.own)
    text, good = summary(results, reasons())
    print(text)
    return 0 if good else 1


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        sys.exit(main(sys.argv[1:]))
    except Failure as failure:
        sys.exit(f"saltus: {failure}")
    except KeyboardInterrupt:
        sys.exit(130)
