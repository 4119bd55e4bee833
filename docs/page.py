#!/usr/bin/env python3
"""Checks or updates the parts of its programs that a page shows: lines, output and pictures.

Usage: page.py PAGE PROGRAMS [--write]

PROGRAMS is the folder of the programs that PAGE names. Their sources are in the folder with the name of
PAGE without its extension. Without --write nothing is changed: the exit status is 1 if the page shows
different lines or output. With --write the page is updated and, if a program NAME_N writes tables
to step_N, its picture is drawn into the folder; pictures need matplotlib.

In the page, `<!-- code: FILE "FROM" "TO" -->` shows the lines of FILE from the first that contains FROM
to the next that contains TO (for a lone brace: the matching one), and `<!-- output: NAME -->` the
output of program NAME, or of NAME.py beside the sources, each up to `<!-- end -->`.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python")
CODE = re.compile(r'(<!-- code: (\S+) "([^"\n]*)" "([^"\n]*)" -->\n).*?(<!-- end -->)', re.S)
OUTPUT = re.compile(r"(<!-- output: (\w+) -->\n).*?(<!-- end -->)", re.S)


def lines_of(page, file, first, last):
    with open(os.path.join(os.path.splitext(page)[0], file), encoding="utf-8") as source:
        lines = source.read().splitlines()
    begin = next((i for i, line in enumerate(lines) if first in line), None)
    if begin is None:
        sys.exit(f"{page}: no line of {file} contains '{first}'")
    alone = last in ("}", "};")
    end = next((i for i in range(begin, len(lines))
                if (lines[i].strip() == last and lines[i].index(last) <=
                    len(lines[begin]) - len(lines[begin].lstrip()) if alone else last in lines[i])),
               None)
    if end is None:
        sys.exit(f"{page}: no line of {file} after '{first}' contains '{last}'")
    shown = lines[begin:end + 1]
    margin = min(len(line) - len(line.lstrip()) for line in shown if line.strip())
    return "\n".join(line[margin:] for line in shown) + "\n"


def run(page, programs, name, folder):
    program = os.path.join(os.path.abspath(programs), name)
    script = os.path.join(os.path.abspath(os.path.splitext(page)[0]), f"{name}.py")
    python = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
    command, extension = [program], os.path.join(os.path.abspath(programs), "python")
    if os.path.exists(script):
        command, program = [python, "-B", script], script
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join((PACKAGE, extension))})
    if done.returncode != 0:
        sys.exit(f"{program} ended with {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def draw(page, folder):
    python = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
    for step in sorted(os.listdir(folder)):
        subprocess.run([python, "-B", "-m", "saltus.plot_trajectory", os.path.join(folder, step)], check=True,
                       env={**os.environ, "PYTHONPATH": PACKAGE, "PYTHONSAFEPATH": "1"})
        shutil.copy(os.path.join(folder, step, "trajectory.png"),
                    os.path.join(os.path.splitext(page)[0], f"{step}.png"))


def main(page, programs, write):
    with open(page, encoding="utf-8") as file:
        shown = file.read()
    with tempfile.TemporaryDirectory() as folder:
        made = CODE.sub(lambda m: f"{m[1]}```{'python' if m[2].endswith('.py') else 'cpp'}\n{lines_of(page, m[2], m[3], m[4])}```\n{m[5]}", shown)
        made = OUTPUT.sub(lambda m: f"{m[1]}```\n{run(page, programs, m[2], folder)}```\n{m[3]}", made)
        if write:
            draw(page, folder)
    if write:
        with open(page, "w", encoding="utf-8") as file:
            file.write(made)
    elif made != shown:
        remedy = f"page.py {page} PROGRAMS --write updates it"
        for is_, was in zip(made.splitlines(), shown.splitlines()):
            if is_ != was:
                sys.exit(f"{page} shows\n  {was}\nbut it is\n  {is_}\n{remedy}")
        sys.exit(f"{page} differs from its programs; {remedy}")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--write"]):
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], len(sys.argv) == 4)
