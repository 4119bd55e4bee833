#!/usr/bin/env python3
"""Draws cost and first input over the time of the impact, for a node at the event and for an event rounded to the grid.

Usage: python3 -m saltus.walking.plot_sweep SWEEP.CSV PICTURE.PNG, with the file that the program impact_sweep of
benchmarks/ writes.
"""

import csv
import sys

from ..drawing import plt, save_picture

GRIDS = (("10", "15"), ("50", "15"))  # dt in ms, N
QUANTITIES = (("cost", "optimal cost"), ("left_fz", "left foot, first vertical force [N]"))
STYLES = {
    "rounded": {"label": "event rounded to the grid", "color": "tab:red", "linewidth": 1.2},
    "exact": {"label": "node at the event", "color": "tab:blue", "linewidth": 2.0},
}


def select(rows, grid, impact):
    """The sweep of one grid with node-summed costs and without first differences."""
    wanted = {"dt_ms": grid[0], "intervals": grid[1], "costs": "nodes", "wrench_change": "0",
              "impact": impact}
    found = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    if not found:
        raise SystemExit(f"the file contains no sweep with {wanted}")
    return found


def main(source, target):
    with open(source, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    figure, axes = plt.subplots(2, len(GRIDS), figsize=(8.8, 5.6), sharex=True,
                                constrained_layout=True)
    for column, grid in enumerate(GRIDS):
        axes[0, column].set_title(f"dt = {grid[0]} ms, N = {grid[1]}")
        axes[-1, column].set_xlabel("landing time [ms]")
        for row, (quantity, label) in enumerate(QUANTITIES):
            panel = axes[row, column]
            for impact, style in STYLES.items():
                sweep = select(rows, grid, impact)
                panel.plot([float(point["impact_ms"]) for point in sweep],
                           [float(point[quantity]) for point in sweep], **style)
            panel.grid(alpha=0.3)
            if column == 0:
                panel.set_ylabel(label)
    axes[0, 0].set_xlim(40.0, 110.0)
    axes[0, 0].legend(fontsize="small", loc="upper left")
    save_picture(figure, target)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2])
