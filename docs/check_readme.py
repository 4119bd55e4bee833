#!/usr/bin/env python3
"""Checks that the README shows the program that the tests compile and run, with its output, names the version of
CITATION.cff next to it, and is short.

Usage: check_readme.py README.md first_problem.cpp OUTPUT
"""

import os
import re
import sys

MOST_LINES, MOST_COLUMNS = 150, 120


def main(readme, source, output):
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    with open(source, encoding="utf-8") as file:
        program = file.read()
    if f"```cpp\n{program}```" not in text:
        sys.exit(f"{readme} does not contain {source} literally")
    if f"`{output}`" not in text:
        sys.exit(f"{readme} does not contain the output of {source}: {output}")
    with open(os.path.join(os.path.dirname(os.path.abspath(readme)), "CITATION.cff"), encoding="utf-8") as file:
        found = re.search(r"^version: (\S+)\ndate-released: (\d+)", file.read(), re.MULTILINE)
    if f"version {found[1]}, {found[2]} ([CITATION.cff]" not in text:
        sys.exit(f"{readme} does not cite version {found[1]}, {found[2]}, as CITATION.cff does")
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        sys.exit(f"{readme} has {len(lines)} lines; at most {MOST_LINES} are allowed")
    for number, line in enumerate(lines, 1):
        if len(line) > MOST_COLUMNS:
            sys.exit(f"{readme}:{number} has {len(line)} columns; at most {MOST_COLUMNS} are allowed")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
