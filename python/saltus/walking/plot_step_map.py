#!/usr/bin/env python3
"""Draws the pushes that a pendulum survives by direction, for different freedoms of its planner.

Usage: python3 -m saltus.walking.plot_step_map MAP.CSV PICTURE.PNG, with the output of the program step_map of
benchmarks/.
"""

import csv
import math
import sys

from ..drawing import plt, save_picture
from .plot_map import FONT, label_radii

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
    figure, axes = plt.subplots(figsize=(10.0, 5.4), subplot_kw={"projection": "polar"},
                                constrained_layout=True)
    for key, (label, style) in BOUNDS.items():
        axes.plot(angles, [float(row[key]) for row in rows], style, color="black", linewidth=1.2,
                  label=f"{label} ({float(area[key]):.0f})")
    # Later lines are narrower, so that coinciding lines remain visible.
    for linewidth, (key, (label, colour)) in zip((5.0, 4.0, 3.0, 4.0, 1.6), VARIANTS.items()):
        axes.plot(angles, [float(row[key]) for row in rows], color=colour, linewidth=linewidth,
                  label=f"{label} ({float(area[key]):.0f})")
    axes.set_theta_zero_location("N")  # forward is up, the side of the left foot is left
    axes.set_thetagrids(range(0, 360, 45), ["forward", "", "left", "", "back", "", "right", ""])
    label_radii(axes)
    axes.grid(alpha=0.3)
    axes.set_title("Largest survived impulse in N s, by direction", fontsize=FONT + 2)
    axes.legend(fontsize=FONT, loc="upper left", bbox_to_anchor=(1.12, 1.0), frameon=False, title="(area of the map in (N s)²)",
                title_fontsize=FONT)
    save_picture(figure, target)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2])
