#!/usr/bin/env python3
"""Draws the pushes that a pendulum survives by direction, for different freedoms of its planner.

Usage: python3 -m saltus.walking.plot_step_map MAP.CSV PICTURE.PNG, with the output of the program step_map of
benchmarks/.
"""

import csv
import math
import sys

from ..drawing import plt, save_picture

VARIANTS = {
    "fixed": ("time and place fixed", "tab:gray"),
    "place": ("place free", "tab:green"),
    "time": ("time free", "tab:orange"),
    "both": ("both free", "tab:blue"),
    "steps": ("several steps", "tab:red"),
}
BOUNDS = {"bound_0": ("bound, no step", ":"), "bound_1": ("bound, one step", "--"),
          "bound_3": ("bound, three steps", "-.")}


def main(source, target):
    with open(source, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    area = next((row for row in rows if row["direction"] == "area"), None)
    if area is None:
        raise SystemExit(f"{source} has no line with the areas, so it is not the complete output of step_map")
    rows.remove(area)
    rows.append(rows[0])
    angles = [math.radians(float(row["direction"])) for row in rows]
    figure, axes = plt.subplots(figsize=(9.0, 6.0), subplot_kw={"projection": "polar"},
                                constrained_layout=True)
    for key, (label, style) in BOUNDS.items():
        axes.plot(angles, [float(row[key]) for row in rows], style, color="black", linewidth=1.0,
                  label=f"{label} ({float(area[key]):.0f} (N s)²)")
    for key, (label, colour) in VARIANTS.items():
        axes.plot(angles, [float(row[key]) for row in rows], color=colour, linewidth=2.0,
                  label=f"{label} ({float(area[key]):.0f} (N s)²)")
    axes.set_theta_zero_location("N")  # forward is up, the side of the left foot is left
    axes.set_title("largest survived impulse, N s; forward is up")
    axes.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1.08, 1.0))
    save_picture(figure, target)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2])
