#!/usr/bin/env python3
"""Checks that the drawings have the texts of their script and that their pages show them. Skipped (77) without matplotlib."""

import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

HERE = os.path.dirname(os.path.abspath(__file__))
try:
    import draw
except ModuleNotFoundError as error:
    print(f"skipped: no {error.name}")
    sys.exit(77)


def words(path):
    """All texts in order; their positions depend on the version of matplotlib."""
    return [text.text for text in ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}text")]


wrong = []
with tempfile.TemporaryDirectory() as folder:
    draw.main(folder)
    for name, (_, page) in draw.DRAWINGS.items():
        with open(os.path.join(HERE, "..", "..", page), encoding="utf-8") as file:
            if f"concepts/{name}.svg)" not in file.read():
                wrong.append(f"{page} does not show {name}.svg")
        if words(os.path.join(folder, f"{name}.svg")) != words(os.path.join(HERE, f"{name}.svg")):
            wrong.append(f"{name}.svg differs from the output of draw.py; run draw.py {HERE}")
if wrong:
    sys.exit("\n".join(wrong))
print(f"{len(draw.DRAWINGS)} drawings as drawn")
