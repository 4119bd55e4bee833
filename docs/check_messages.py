#!/usr/bin/env python3
"""Does the program still print the messages that a page quotes?

Usage: check_messages.py PAGE SOURCE...

Quoted messages are in the first column of tables that have the title "Message", in code style. `...` in a quotation
stands for any text. Every other part must occur in a string of the C++ files below the folders SOURCE. The exit status
is 1 if a part does not occur.
"""

import glob
import os
import re
import sys

LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
GAP = re.compile(r'"\s*(?:\\\n\s*)?"')  # between two literals that the compiler joins


def strings(folders):
    """All string literals, with adjacent ones joined, one a line."""
    found = []
    for folder in folders:
        for path in sorted(glob.glob(os.path.join(folder, "**", "*.[hc]pp"), recursive=True)):
            with open(path, encoding="utf-8") as file:
                found += LITERAL.findall(GAP.sub("", file.read()))
    return "\n".join(found).replace('\\"', '"')


def quotations(page):
    """Of the first column of tables with the title Message."""
    is_quoted = False
    with open(page, encoding="utf-8") as file:
        for line in file:
            if not line.startswith("|"):
                is_quoted = False
            elif line.startswith("| Message |"):
                is_quoted = True
            elif is_quoted:
                match = re.match(r"\| `(.+?)` \|", line)
                if match:
                    yield match[1].replace("\\|", "|")


def main(page, folders):
    known = strings(folders)
    quoted = list(quotations(page))
    missing = [text for text in quoted
               if not all(part.strip() in known for part in re.split(r"\.\.\.|'[^' ]*'", text) if len(part.strip()) > 3)]
    for text in missing:
        print(f"{page}: no source has the message '{text}'", file=sys.stderr)
    if missing or not quoted:
        sys.exit(1)
    print(f"{len(quoted)} messages")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
