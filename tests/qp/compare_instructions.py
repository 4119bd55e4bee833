#!/usr/bin/env python3
"""Counts instructions, by default of the solves of the structured solver, and compares them with the record.

Usage: compare_instructions.py PROGRAM FILE [--write] [--of FUNCTION]

Times depend on the machine and its load; instructions depend only on compiler and sources. As in `saltus bench
compare`, more instructions than the record and its tolerance are a failure (exit status 1). Fewer are reported, so that
--write can update the record. A batch also fails if it exceeds a multiple of another one that the record limits
(at_most). Without valgrind, or with another compiler than that of the record, nothing is compared (exit status 77).
"""

import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "benchmarks/suite/scripts"))
from compare import compare, counts  # noqa: E402


def skip(why):
    print(f"instructions: not compared, {why}")
    sys.exit(77)


def count(program, batch, function):
    """Instructions of a batch inside this function, and the compiler named by the program."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={function}", program,
               batch]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "unhandled instruction" in done.stderr or "cannot be executed" in done.stderr:
        skip("valgrind cannot run the vectors of the program here")
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found or int(found[1]) == 0:
        sys.exit(f"instructions: '{' '.join(command)}' failed:\n{done.stdout}{done.stderr}")
    return int(found[1]), done.stdout.splitlines()[0]


def dearer(bounds, found):
    """True if a batch exceeds its limit relative to another one."""
    above = False
    for batch, (most, other) in bounds.items():
        ratio = found[batch] / found[other]
        print(f"{batch}: {ratio:.2f} times the instructions of {other}, at most {most}")
        above = above or ratio > most
    return above


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("--write", action="store_true", help="store the counts as the record")
    parser.add_argument("--of", default="*RiccatiSolver::solve*", help="the counted function, as a pattern of valgrind")
    arguments = parser.parse_args()
    if not shutil.which("valgrind"):
        skip("there is no valgrind")
    record = json.loads(arguments.file.read_text())
    known, found = record["instructions"], {}
    for batch in known:
        counted, compiler = count(arguments.program, batch, arguments.of)
        if not arguments.write and compiler != record["compiler"]:
            skip(f"the record is of {record['compiler']}, this program of {compiler}")
        change = f" ({counted / known[batch] - 1.0:+.1%})" if known[batch] else ""
        print(f"{batch}: {counted / 1e6:.3f} M, on record {known[batch] / 1e6:.3f} M{change}")
        found[batch] = counted
    if arguments.write:
        arguments.file.write_text(json.dumps({**record, "compiler": compiler, "instructions": found}, indent=2) + "\n")
        return
    above = dearer(record.get("at_most", {}), found)
    worse = compare(counts(known, compiler, record["tolerance"]), counts(found, compiler, record["tolerance"]), sys.stdout)
    sys.exit(1 if above else worse)


if __name__ == "__main__":
    main()
