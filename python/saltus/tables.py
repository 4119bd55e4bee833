"""Tables of a run: CSV files whose first line names the columns, with units."""

import csv
import math
import os
import re

_UNIT = re.compile(r"(.*\S) \[.*\]$")


def without_unit(column):
    """ "height" of "height [m]"."""
    match = _UNIT.match(column)
    return match.group(1) if match else column


def read_table(path):
    """Columns by name, in order; numeric if all entries are (empty ones are NaN)."""
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{path} is not a file")  # a device has no end of file
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ValueError(f"{path} is empty")
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path}:{number} has {len(row)} entries for {len(rows[0])} columns")
    table = {}
    for i, name in enumerate(rows[0]):
        entries = [row[i] for row in rows[1:]]
        try:
            table[name] = [float(entry) if entry else math.nan for entry in entries]
        except ValueError:
            table[name] = entries
    return table


def read_by_names(path):
    """The columns by names without units."""
    return {without_unit(column): entries for column, entries in read_table(path).items()}
