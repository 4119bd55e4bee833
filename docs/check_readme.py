#!/usr/bin/env python3
"""Checks that the README shows the program that the tests compile and run.

Usage: check_readme.py README.md first_problem.cpp
"""

import sys


def main(readme, source):
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    with open(source, encoding="utf-8") as file:
        program = file.read()
    if f"```cpp\n{program}```" not in text:
        sys.exit(f"{readme} does not contain {source} literally")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
