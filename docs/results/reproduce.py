#!/usr/bin/env python3
"""Makes the tables of the READMEs again from runs, and says what differs from what is printed.

Usage: reproduce.py PROGRAM [NAME...] [--quick] [--sample N] [--write] [--jobs N] [--list]

PROGRAM is saltus. Without names all tables are made, with --quick those that take seconds, with --sample
N the one whose turn it is (N modulo their number). A table stands in its README between the marks
<!-- table: NAME --> and <!-- end of table -->; what was made goes to docs/results/NAME.md, with
machine, versions and date. Two cells agree if their words do and their numbers do to one unit of the last printed digit
(times: within a factor of three). Status 3 if something differs, 2 for a mistake on the command
line. --write puts what was made into the READMEs.
"""

import argparse
import concurrent.futures
import datetime
import json
import os
import platform
import re
import subprocess
import sys
import tempfile

from tables import TABLES

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DIFFERENT = 3
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
TIMED_FACTOR = 3.0


def marks(name):
    return f"<!-- table: {name} -->\n", "<!-- end of table -->"


def readme_of(table):
    return os.path.join(ROOT, table.readme)


def printed(name, table):
    """The text between the marks; None if the README has no such table."""
    with open(readme_of(table), encoding="utf-8") as file:
        text = file.read()
    begin, end = marks(name)
    if begin not in text:
        return None
    rest = text.split(begin, 1)[1]
    return rest.split(end, 1)[0]


def cells(text):
    """Rows of a Markdown table without its rule."""
    rows = [line.strip().strip("|").split("|") for line in text.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in row] for row in rows]
    return [row for row in rows if not all(set(cell) <= set("-: ") for cell in row)]


def unit_of(number):
    """One in the last printed digit."""
    mantissa, _, exponent = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals)


def agree(there, here, timed):
    if there == here:
        return True
    if NUMBER.sub("#", there) != NUMBER.sub("#", here):
        return False
    for a, b in zip(NUMBER.findall(there), NUMBER.findall(here)):
        if timed:
            low, high = sorted((abs(float(a)), abs(float(b))))
            if high > TIMED_FACTOR * low + unit_of(a):
                return False
        elif abs(float(a) - float(b)) > 1.001 * unit_of(a):
            return False
    return True


def differences(name, table, made):
    there = printed(name, table)
    if there is None:
        return [f"{table.readme} has no table {name}; run with --write after adding its marks"]
    old, new = cells(there), cells(made)
    if [len(row) for row in old] != [len(row) for row in new]:
        return [f"{table.readme}, {name}: {len(old)} rows are printed, {len(new)} were made"]
    found = []
    for old_row, new_row in zip(old[1:], new[1:]):
        for title, a, b in zip(old[0], old_row, new_row):
            if not agree(a, b, title in table.timed):
                found.append(f"{table.readme}, {name}, {old_row[0]}, {title}: "
                             f"printed '{a}', made '{b}'")
    return found


def run(program, settings, folder):
    """summary.json of one run of push recovery."""
    command = [program, "run", "push_recovery", "--out", folder, "--pictures", "false"]
    for key, value in settings.items():
        command += ["--" + key, str(value)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(command)}: status {done.returncode}\n{done.stderr}")
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        return json.load(file)


def make(program, table, jobs):
    """The table as Markdown."""
    with tempfile.TemporaryDirectory(prefix="saltus-reproduce-") as folder:
        def one(index):
            row = table.rows[index]
            return [run(program, settings, os.path.join(folder, f"{index}-{i}"))
                    for i, settings in enumerate(row.runs)]
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            summaries = list(pool.map(one, range(len(table.rows))))
    lines = ["| " + " | ".join(title for title, _ in table.columns) + " |",
             "| " + " | ".join("---" for _ in table.columns) + " |"]
    for row, found in zip(table.rows, summaries):
        lines.append("| " + " | ".join(cell(row, found) for _, cell in table.columns) + " |")
    return "\n".join(lines) + "\n"


def write(path, text):
    partial = path + ".partial"
    with open(partial, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(partial, path)


def save_result(program, name, table, made):
    version = subprocess.run([program, "--version"], capture_output=True, text=True,
                             check=False).stdout.strip()
    write(os.path.join(ROOT, "docs/results", name + ".md"),
          f"# {table.title}\n\n{made}\n{version}; {platform.machine()}, {processor()}; "
          f"{datetime.date.today().isoformat()}\n")


def processor():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            return re.search(r"model name\s*:\s*(.+)", file.read()).group(1)
    except (OSError, AttributeError):
        return platform.processor() or "unknown processor"


def put_into_readme(name, table, made):
    with open(readme_of(table), encoding="utf-8") as file:
        text = file.read()
    begin, end = marks(name)
    before, rest = text.split(begin, 1)
    write(readme_of(table), before + begin + made + end + rest.split(end, 1)[1])


def chosen(arguments):
    unknown = [name for name in arguments.names if name not in TABLES]
    if unknown:
        print(f"reproduce: there is no table {unknown[0]}; there are {', '.join(TABLES)}",
              file=sys.stderr)
        sys.exit(2)
    names = arguments.names or [n for n, t in TABLES.items() if t.quick or not arguments.quick]
    if arguments.sample is not None:
        names = [names[arguments.sample % len(names)]]
    return names


def main():
    parser = argparse.ArgumentParser(prog="reproduce", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_intermixed_args()
    if arguments.list:
        for name, table in TABLES.items():
            runs = sum(len(row.runs) for row in table.rows)
            print(f"{name:<16} {runs:>3} runs  {table.title} ({table.readme})")
        return 0
    found = []
    for name in chosen(arguments):
        table = TABLES[name]
        print(f"{name}: {sum(len(row.runs) for row in table.rows)} runs ...", flush=True)
        made = make(arguments.program, table, arguments.jobs)
        save_result(arguments.program, name, table, made)
        new = differences(name, table, made)
        if arguments.write:
            put_into_readme(name, table, made)
        print(f"{name}: " + ("as printed" if not new else f"{len(new)} cells differ"))
        found += new
    for line in found:
        print(line)
    return 0 if not found or arguments.write else DIFFERENT


if __name__ == "__main__":
    sys.exit(main())
