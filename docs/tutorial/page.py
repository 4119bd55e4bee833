#!/usr/bin/env python3
"""The tutorial's page as its programs are: their lines, what they print, their pictures.

Usage: page.py PROGRAMS [--write]

PROGRAMS is the folder with tutorial_1 to tutorial_6. Without --write nothing is changed: the exit
status is 1 if the page shows other lines or another output. With it, lines, output and pictures are
put into the page; pictures need matplotlib.

In the page, `<!-- code: FILE "FROM" "TO" -->` shows the lines of FILE from the first that holds FROM
to the next that holds TO (of a lone brace: that begins with it), and `<!-- output: step_N -->` what
program N prints, each up to `<!-- end -->`.
"""

import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PAGE = HERE + ".md"
PLOT = os.path.join(HERE, "..", "..", "python", "saltus", "plot_trajectory.py")
CODE = re.compile(r'(<!-- code: (\S+) "([^"\n]*)" "([^"\n]*)" -->\n).*?(<!-- end -->)', re.S)
OUTPUT = re.compile(r"(<!-- output: step_(\d) -->\n).*?(<!-- end -->)", re.S)


def lines_of(file, first, last):
    with open(os.path.join(HERE, file), encoding="utf-8") as source:
        lines = source.read().splitlines()
    begin = next((i for i, line in enumerate(lines) if first in line), None)
    if begin is None:
        sys.exit(f"{PAGE}: no line of {file} holds '{first}'")
    alone = last in ("}", "};")
    end = next((i for i in range(begin, len(lines))
                if (lines[i].strip() == last and lines[i].index(last) <=
                    len(lines[begin]) - len(lines[begin].lstrip()) if alone else last in lines[i])),
               None)
    if end is None:
        sys.exit(f"{PAGE}: no line of {file} behind '{first}' holds '{last}'")
    shown = lines[begin:end + 1]
    margin = min(len(line) - len(line.lstrip()) for line in shown if line.strip())
    return "\n".join(line[margin:] for line in shown) + "\n"


def run(programs, step, folder):
    program = os.path.join(os.path.abspath(programs), f"tutorial_{step}")
    done = subprocess.run([program], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{program} ended with {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def draw(folder, step):
    python = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
    subprocess.run([python, "-B", PLOT, os.path.join(folder, f"step_{step}")], check=True)
    os.replace(os.path.join(folder, f"step_{step}", "trajectory.png"),
               os.path.join(HERE, f"step_{step}.png"))


def main(programs, write):
    with open(PAGE, encoding="utf-8") as file:
        page = file.read()
    with tempfile.TemporaryDirectory() as folder:
        made = CODE.sub(lambda m: f"{m[1]}```cpp\n{lines_of(m[2], m[3], m[4])}```\n{m[5]}", page)
        made = OUTPUT.sub(lambda m: f"{m[1]}```\n{run(programs, m[2], folder)}```\n{m[3]}", made)
        if write:
            for step in range(1, 7):
                draw(folder, step)
    if write:
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(made)
    elif made != page:
        for is_, was in zip(made.splitlines(), page.splitlines()):
            if is_ != was:
                sys.exit(f"{PAGE} shows\n  {was}\nbut it is\n  {is_}\n(page.py PROGRAMS --write)")
        sys.exit(f"{PAGE} is not as its programs are (page.py PROGRAMS --write)")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--write"]):
        sys.exit(__doc__)
    main(sys.argv[1], len(sys.argv) == 3)
