#!/usr/bin/env python3
"""Plots the trajectory of a run: states and inputs over time, with shaded modes.

Usage: plot.py FOLDER. Reads FOLDER/trajectory.csv and writes FOLDER/trajectory.png. Needs matplotlib.
"""

import csv
import os
import sys

try:
    import matplotlib
except ModuleNotFoundError:
    sys.exit("python3 cannot find matplotlib: apt-get install python3-matplotlib, then /usr/bin/python3 plot.py FOLDER")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

SHADES = ["#dbe9f6", "#fde6cf", "#dff0d8", "#f3dcef"]


def main(folder):
    with open(os.path.join(folder, "trajectory.csv"), newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    time = [float(row["t [s]"]) for row in rows]
    modes = [row.get("mode", "") for row in rows]
    names = [name for name in rows[0] if name not in ("t [s]", "mode")]
    figure, panels = plt.subplots(len(names), squeeze=False, sharex=True, constrained_layout=True,
                                  figsize=(7, 1 + 1.6 * len(names)))
    for panel, name in zip(panels[:, 0], names):
        panel.plot(time, [float(row[name] or "nan") for row in rows])
        panel.set_ylabel(name)
        panel.grid(alpha=0.3)
        for i in range(1, len(time)):
            shade = SHADES[list(dict.fromkeys(modes)).index(modes[i])  % len(SHADES)]
            panel.axvspan(time[i - 1], time[i], color=shade, linewidth=0, zorder=0)
    panels[-1, 0].set_xlabel("t [s]")
    figure.savefig(os.path.join(folder, "trajectory.png"), dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
