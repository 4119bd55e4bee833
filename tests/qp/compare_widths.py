#!/usr/bin/env python3
"""Compares the optima of the structured solver with SIMD vectors of two, four and eight doubles.

Usage: compare_widths.py BUILD [PROGRAMS]. Needs the targets riccati_optima_baseline, _avx2 and _avx512. The first
computes its optima twice.
"""

import os
import statistics
import subprocess
import sys

WIDTHS = ("baseline", "avx2", "avx512")


def optima(build, width, programs):
    """Seed -> (status, iterations, objective, states)."""
    program = os.path.join(build, f"riccati_optima_{width}")
    printed = subprocess.run([program, str(programs)], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in printed.splitlines()]
    return {row[0]: (row[1], int(row[2]), float(row[3]), [float(v) for v in row[4:]]) for row in rows}


def compare(first, other):
    costs, states = [], []
    for seed, (status, _, cost, x) in first.items():
        if status != other[seed][0] or status != "0":
            continue
        costs.append(abs(cost - other[seed][2]) / max(1.0, abs(cost)))
        scale = max([1.0, *map(abs, x)])
        states.append(max(abs(a - b) for a, b in zip(x, other[seed][3])) / scale)
    return [
        sum(first[seed][0] == other[seed][0] for seed in first),
        sum(first[seed][:2] == other[seed][:2] for seed in first),
        sum(first[seed] == other[seed] for seed in first),
        f"{statistics.median(costs):.1e}",
        f"{max(costs):.1e}",
        f"{statistics.median(states):.1e}",
        f"{max(states):.1e}",
    ]


def main(build, programs=500):
    found = {width: optima(build, width, programs) for width in WIDTHS}
    again = optima(build, WIDTHS[0], programs)
    print(f"Of {len(again)} random programs, against {WIDTHS[0]}:\n")
    print("| build | same status | same iterations | all digits | cost, median | largest | states, median | largest |")
    print("|" + " --- |" * 8)
    for name, other in [(f"{WIDTHS[0]}, again", again), *list(found.items())[1:]]:
        print(f"| {name} | " + " | ".join(map(str, compare(found[WIDTHS[0]], other))) + " |")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
