#!/usr/bin/env python3
"""Checks that every symbol in the glossary exists in the sources.

Usage: check_glossary.py docs/glossary.md SOURCE_FOLDER...

A symbol is in backticks in the last column of a table: `Name` must be declared somewhere, as a
type, an alias, a function, a value or a member; of `Owner::member`, the owner must be declared in a
header that has the member.
"""

import pathlib
import re
import sys

KINDS = r"(?:class|struct|enum class|enum|concept|namespace)\s+"


def symbols(text):
    for number, line in enumerate(text.splitlines(), 1):
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]
        if len(cells) < 5 or set(cells[1]) <= {"-", " ", ":"} or cells[1] == "Term":
            continue
        found = re.findall(r"`([^`]+)`", cells[-2])
        if not found:
            yield number, None
        for symbol in found:
            yield number, symbol.removesuffix("()")


def is_declared(name, sources):
    declaration = re.compile(
        rf"{KINDS}{name}\b|\busing {name}\s*=|[\w>&*\]]\s+{name}\s*(?:[({{=;,\[]|$)|\b{name},? *(?://|$)", re.M
    )
    return any(declaration.search(text) for text in sources)


def main(glossary, folders):
    headers = [
        file.read_text(encoding="utf-8") for folder in folders for file in sorted(pathlib.Path(folder).rglob("*.hpp"))
    ]
    mistakes = []
    checked = 0
    for number, symbol in symbols(pathlib.Path(glossary).read_text(encoding="utf-8")):
        if symbol is None:
            mistakes.append(f"{glossary}:{number}: no symbol in the last column")
            continue
        *owners, name = symbol.split("::")
        sources = headers
        for owner in owners:
            sources = [text for text in sources if re.search(rf"(?:{KINDS}|namespace (?:\w+::)*){re.escape(owner)}\b", text)]
        checked += 1
        if not is_declared(re.escape(name), sources):
            mistakes.append(f"{glossary}:{number}: no header declares {symbol}")
    if checked == 0:
        mistakes.append(f"{glossary}: no symbol was found")
    if mistakes:
        sys.exit("\n".join(mistakes))
    print(f"{checked} symbols are declared")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
