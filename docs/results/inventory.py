#!/usr/bin/env python3
"""Which number of the READMEs is made by what?

Usage: inventory.py [README...]

A number is made if it stands in a table between marks or in a sentence of sentences.py; it is given if it stands in
code (a command, a setting, a formula) or in a phrase of given.py, which says what kind of number it is. This prints a
line for every number, and ends with status 3 if one is neither. What is written as a word (eight seeds) is not looked at.
"""

import collections
import os
import re
import sys

import reproduce
from given import GIVEN

NUMBER = re.compile(r"(?<![\w.#+])\d+(?:[.,]\d+)*(?:e[-+]?\d+)?")
CODE = re.compile(r"^```.*?^```$|`[^`\n]*(?:\n[^`\n]*)?`", re.DOTALL | re.MULTILINE)
LINK_TARGET = re.compile(r"\]\([^)]*\)")
TABLE = re.compile(r"<!-- table: (\w+) -->\n.*?<!-- end of table -->", re.DOTALL)

Number = collections.namedtuple("Number", "readme line text maker")  # maker: None if there is none


def phrase_pattern(phrase):
    """However its lines are broken; a title row with its table."""
    words = r"\s+".join(re.escape(word) for word in phrase.split())
    return re.compile(words + r"(?:\n\|.*)*" if phrase.startswith("|") else words)


def makers(readme, text):
    """Spans of the text with what makes the numbers in them, and what is declared but does not stand there."""
    spans, absent = [], []
    for match in TABLE.finditer(text):
        name = match.group(1)
        if name in reproduce.ALL and reproduce.ALL[name].readme == readme:
            spans.append((match.span(), f"table {name}"))
        else:
            absent.append(f"{readme}: nothing makes the table {name}")
    spans += [(match.span(), "code") for pattern in (CODE, LINK_TARGET) for match in pattern.finditer(text)]
    for name, sentence in reproduce.SENTENCES.items():
        if sentence.readme == readme:
            match = sentence.look_up(text)
            if match:
                spans.append((match.span(), f"sentence {name}"))
            else:
                absent.append(f"{readme} does not say ({name}): {sentence.words}")
    for kind, phrases in GIVEN.get(readme, {}).items():
        for phrase in phrases:
            found = [(match.span(), kind) for match in phrase_pattern(phrase).finditer(text)]
            spans += found
            if not found:
                absent.append(f"{readme} has no longer the {kind}: {phrase}")
    return spans, absent


def look(readme, text):
    """Every number of a README's text, and what is declared for it but does not stand there."""
    spans, absent = makers(readme, text)
    found = []
    for match in NUMBER.finditer(text):
        maker = next((who for (begin, end), who in spans if begin <= match.start() and match.end() <= end), None)
        line = text.count("\n", 0, match.start()) + 1
        found.append(Number(readme, line, match.group(), maker))
    return found, absent


def numbers(readme):
    with open(os.path.join(reproduce.ROOT, readme), encoding="utf-8") as file:
        return look(readme, file.read())


def readmes():
    """The READMEs of the project, without those in build folders, and the other pages with checked numbers."""
    found = ["docs/formulation.md", "problems/push_recovery/experiments.md"]
    for folder, inner, files in os.walk(reproduce.ROOT):
        inner[:] = sorted(name for name in inner if not name.startswith((".", "build")))
        found += [os.path.relpath(os.path.join(folder, name), reproduce.ROOT) for name in files if name == "README.md"]
    return found


def main(wanted):
    missing = 0
    for readme in wanted or readmes():
        found, absent = numbers(readme)
        for number in found:
            print(f"{number.readme}:{number.line}: {number.text}: {number.maker or 'NOTHING MAKES IT'}")
        for line in absent:
            print(line)
        missing += len(absent) + sum(number.maker is None for number in found)
    return reproduce.DIFFERENT if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
