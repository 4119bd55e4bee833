#!/usr/bin/env python3
"""Writes the list of library problems in the gallery, from the first comments of their source files.

Usage: gallery.py GALLERY.md [--write]

The text between `<!-- problems: LETTER -->` and `<!-- end of problems -->` lists the files of problems/library whose
names begin with LETTER: statement, equations and lines of code without comments. Without --write the exit status is 1
if the page differs from the sources.
"""

import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SECTION = re.compile(r"(<!-- problems: (\w) -->\n).*?(<!-- end of problems -->)", re.DOTALL)


def wrapped(text, width=118):
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    return "\n".join([*lines, line])


def code_lines(text):
    """Lines that are neither blank nor a comment."""
    return sum(1 for line in text.splitlines() if line.strip() and not line.strip().startswith("//"))


def entry(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    head = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        head.append(line[2:].removeprefix(" "))
    if not head:  # the header has the statement
        with open(path.replace(".cpp", ".hpp"), encoding="utf-8") as file:
            head = [line[2:].removeprefix(" ") for line in file.read().split("#pragma once")[0].splitlines()]
    blocks = re.split(r"\n\s*\n", "\n".join(head).strip("\n"))
    statement = blocks[0]
    equations = [block for block in blocks[1:] if block.startswith("  ")]
    name = os.path.basename(path).removesuffix(".cpp")
    number, _, title = name.partition("_")
    shown = [f"**{number.upper()} {title}** ([{name}.cpp](../problems/library/{name}.cpp), {code_lines(text)} lines)",
             "", wrapped(statement), ""]
    if equations:
        shown += ["```", "\n".join(line.removeprefix("  ") for line in equations[0].splitlines()), "```", ""]
    return "\n".join(shown)


def problems(letter):
    files = sorted(glob.glob(os.path.join(ROOT, "problems", "library", f"{letter}[0-9][0-9]_*.cpp")))
    return "\n" + "\n".join(entry(path) for path in files)


def main(page, write):
    with open(page, encoding="utf-8") as file:
        shown = file.read()
    made = SECTION.sub(lambda match: match[1] + problems(match[2]) + match[3], shown)
    if write:
        with open(page, "w", encoding="utf-8") as file:
            file.write(made)
    elif made != shown:
        sys.exit(f"{page} differs from the sources of the library: docs/gallery.py {page} --write updates it")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--write"]):
        sys.exit(__doc__)
    main(sys.argv[1], len(sys.argv) == 3)
