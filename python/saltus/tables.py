"""Tables of a run: CSV files whose first line names the columns, with units."""

import csv
import math


def read_table(path):
    """Columns by name, in their order: numbers where all entries are (empty ones are NaN)."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    table = {}
    for i, name in enumerate(rows[0]):
        entries = [row[i] for row in rows[1:]]
        try:
            table[name] = [float(entry) if entry else math.nan for entry in entries]
        except ValueError:
            table[name] = entries
    return table
