#!/usr/bin/env python3
"""Repeats tables and pictures of the READMEs from runs, and prints the differences.

Usage: reproduce.py PROGRAM [NAME...] [--quick] [--write] [--jobs N] [--keep FOLDER] [--list]

PROGRAM is saltus. Without names all tables are made, with --quick those that take seconds. A table is in its README
between the marks <!-- table: NAME --> and <!-- end of table -->. Two cells agree if their words are equal and their
numbers agree to one unit of the last printed digit (times: within a factor of three; counts, cells of a map and names
of rows: exactly). `pictures` draws the pictures of the READMEs again and prints the fraction of pixels that differ.
Status 3 if something differs, 2 for a mistake on the command line. Tables whose packages are missing are skipped with a
sentence. --write puts the tables into the READMEs, and their versions, machine and date into docs/results/made_by.md.
--keep stores the runs in a folder and reuses them.
"""

import argparse
import contextlib
import datetime
import os
import platform
import re
import shutil
import sys
import tempfile

from comparisons import COMPARISONS
from figures import FIGURES
from other_tables import OTHER_TABLES
from pictures import PICTURES
from programs import ROOT, NotHere, Programs
from rates import RATES
from tables import TABLES

from saltus.whole_file import whole_file, write_text  # programs.py has added its folder to the path

ALL = {**TABLES, **COMPARISONS, **OTHER_TABLES, **RATES, **FIGURES}
DIFFERENT = 3
INTERRUPTED = 130  # exit status of shells for SIGINT
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
SHARE = re.compile(r"(?<![\d.])\d+ of \d+(?![\d.])")  # such as 3 of 8
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
    """One unit of the last printed digit."""
    mantissa, _, exponent = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals)


def agree(there, here, timed, exact=False):
    """Measured numbers agree to one unit of the last digit. Counts must be equal: those in fractions such as 3 of 8,
    and in `exact` columns all whole numbers."""
    if there == here:
        return True
    if NUMBER.sub("#", there) != NUMBER.sub("#", here) or SHARE.findall(there) != SHARE.findall(here):
        return False
    for a, b in zip(NUMBER.findall(there), NUMBER.findall(here)):
        if exact and "." not in a + b and float(a) != float(b):
            return False
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
        return [f"{table.readme} has no table {name}; add its marks and run with --write"]
    old, new = cells(there), cells(made)
    if [len(row) for row in old] != [len(row) for row in new]:
        return [f"{table.readme}, {name}: {len(old)} rows are printed, {len(new)} were made"]
    found = []
    for old_row, new_row in zip(old[1:], new[1:]):
        for column, (title, a, b) in enumerate(zip(old[0], old_row, new_row)):
            if a != b if column == 0 else not agree(a, b, title in table.timed, title in table.exact):
                found.append(f"{table.readme}, {name}, {old_row[0]}, {title}: "
                             f"printed '{a}', made '{b}'")
    return found


def note_origin(programs, name):
    """Writes the line of the table in made_by.md."""
    path, begin = os.path.join(ROOT, "docs/results/made_by.md"), f"| {name} |"
    line = f"{begin} {programs.made_by()} | {platform.machine()}, {processor()} | {datetime.date.today().isoformat()} |"
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    is_new = not any(there.startswith(begin) for there in lines)
    lines = [line if there.startswith(begin) else there for there in lines] + ([line] if is_new else [])
    write_text(path, "\n".join(lines) + "\n")


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
    write_text(readme_of(table), before + begin + made + end + rest.split(end, 1)[1])


def make_table(name, programs, is_written):
    """The differences, one per line."""
    table = ALL[name]
    made = table.make(programs)
    found = differences(name, table, made)
    if is_written:
        note_origin(programs, name)
        put_into_readme(name, table, made)
    return found


def share_of_points(there, here):
    """Fraction of pixels that differ visibly between two pictures, 0 to 1."""
    try:
        import matplotlib.image
    except ImportError as error:
        raise NotHere(f"{sys.executable} has no matplotlib (Debian: python3-matplotlib)") from error
    # The first frame of an animation; numbers from 0 to 1 for any format.
    a, b = (image / 255.0 if image.dtype.kind == "u" else image
            for image in (matplotlib.image.imread(there), matplotlib.image.imread(here)))
    if a.shape != b.shape:
        return 1.0
    return float((abs(a - b).max(axis=-1) > 0.1).mean())


def make_each(names, make_one):
    """The differences of several pictures, and the number of skipped ones in words."""
    found, skipped = [], 0
    for name in names:
        try:
            found += make_one(name)
        except NotHere as why:
            print(f"{name}: skipped; {why}")
            skipped += 1
    if skipped == len(names):
        raise NotHere(f"all {skipped}")
    return found, f", {skipped} of {len(names)} skipped" if skipped else ""


def make_pictures(programs, is_written):
    """The pictures of maps are made with their tables."""
    return make_each(PICTURES, lambda path: compare_pictures({path: PICTURES[path](programs)}, is_written))


def compare_pictures(made, is_written):
    most = 0.005
    found = []
    for path, picture in made.items():
        there = os.path.join(ROOT, path)
        share = share_of_points(there, picture) if os.path.exists(there) else 1.0
        if share > most:
            found.append(f"{path}: {100.0 * share:.1f} % of the pixels differ")
        if is_written:
            with whole_file(there) as partial:
                shutil.copyfile(picture, partial)
    return found


def make(name, programs, is_written):
    """The differences, one per line, and the skipped pictures in words. Raises NotHere if all were skipped."""
    if name == "pictures":
        return make_pictures(programs, is_written)
    found = make_table(name, programs, is_written)
    drawn, programs.pictures = programs.pictures, {}
    return found + compare_pictures(drawn, is_written), ""


def chosen(arguments):
    known = [*ALL, "pictures"]
    unknown = [name for name in arguments.names if name not in known]
    if unknown:
        print(f"reproduce: there is no table {unknown[0]}; the tables are {', '.join(known)}", file=sys.stderr)
        sys.exit(2)
    quick = [name for name, table in ALL.items() if table.quick]
    return arguments.names or (quick if arguments.quick else known)


def folder_of_runs(kept):
    if kept is None:
        return tempfile.TemporaryDirectory(prefix="saltus-reproduce-")
    os.makedirs(kept, exist_ok=True)
    return contextlib.nullcontext(os.path.abspath(kept))


def show_list():
    for name, table in ALL.items():
        print(f"{name:<16} {table.runs():>3} runs  {table.title} ({table.readme})")
    print(f"{'pictures':<16} {len(PICTURES):>3} pictures of the READMEs")


def tell(found):
    for line in found:
        print(line)


def main():
    parser = argparse.ArgumentParser(prog="reproduce", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--keep")
    arguments = parser.parse_intermixed_args()
    found, names = [], chosen(arguments)
    if arguments.list:
        show_list()
        return 0
    try:
        with folder_of_runs(arguments.keep) as folder:
            programs = Programs(os.path.abspath(arguments.program), folder, arguments.jobs)
            for done, name in enumerate(names):
                print(f"{name} ...", flush=True)
                try:
                    new, skipped = make(name, programs, arguments.write)
                except NotHere as why:
                    print(f"{name}: skipped; {why}")
                    continue
                print(f"{name}: " + (f"{len(new)} differ" if new else "as printed") + skipped, flush=True)
                found += new
    except KeyboardInterrupt:
        tell(found)
        keeps = f"; the completed runs are in {arguments.keep}" if arguments.keep else ""
        print(f"interrupted: {done} of {len(names)} were checked{keeps}", flush=True)
        raise
    tell(found)
    return 0 if not found or arguments.write else DIFFERENT


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as cause:
        sys.exit(f"reproduce: {cause.filename}: {cause.strerror}")
