#!/usr/bin/env python3
"""Draws two runs of push recovery for comparison, for example the MPC and the baseline.

Usage: python3 -m saltus.walking.compare_runs A B [PICTURE], two folders with results; writes PICTURE, or compare.png
in A.
Each run has a panel with its planned vertical forces. The band is 5 % of the weight about the mean of the
last second; the triangle marks the time from which the force stays inside (force_settling of summary.json).
The lower panels have the CoM and the capture point of both runs, y, with the hull of the soles.
"""

import json
import os
import sys

from ..drawing import plt, save_picture
from ..tables import read_by_names
from . import events, ground

NAMES = {"mpc": "MPC", "capture_point": "baseline"}
COLORS = {"left": "tab:blue", "right": "tab:orange"}
STYLES = (("tab:purple", "-"), ("tab:olive", "--"))  # colour and line of the two runs in the common panels
WITHIN = 0.05  # fraction of the weight; settling.hpp
OVER = 1.0  # s
GRAVITY = 9.81


class Run:
    def __init__(self, folder):
        with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
            self.summary = json.load(file)
        if "force_settling" not in self.summary:
            sys.exit(f"{folder}: summary.json has no force_settling; run it again")
        self.trajectory = read_by_names(os.path.join(folder, "trajectory.csv"))
        if "body" in self.summary:
            body = read_by_names(os.path.join(folder, "body.csv"))
            self.times = body["t"]
            self.planned = {foot: body[f"{foot}_planned_fz"] for foot in COLORS}
        else:
            self.times = self.trajectory["t"]
            self.planned = {foot: self.trajectory[f"{foot}_fz"] for foot in COLORS}
        self.touchdown = self.summary["touchdown_s"]
        self.settled_from = self.summary.get("icp_settling_from_s", self.touchdown)  # older runs: landing
        self.name = NAMES[self.summary["controller"]]
        engine = self.summary["plant"].split(",")[0]
        self.title = f"{self.name}, {events.impulse_in_words(self.summary)}, {engine}"


def mean_of_the_end(times, values):
    """Holds each value until the next."""
    begin = times[-1] - OVER
    total = length = 0.0
    for now, following, value in zip(times, times[1:], values):
        held = following - max(now, begin)
        if held > 0.0:
            total += held * value
            length += held
    return total / length


def draw_forces(axes, run, begin, end):
    band = WITHIN * run.summary["mass_kg"] * GRAVITY
    for foot, color in COLORS.items():
        forces = run.planned[foot]
        axes.step(run.times, forces, where="post", color=color, linewidth=1.0)
        settling = run.summary["force_settling"][f"planned_{foot}_s"]
        label = f"{foot}, settled after {settling:.2f} s" if settling is not None else \
            f"{foot}, never settled"
        if run.touchdown is not None:
            mean = mean_of_the_end(run.times, forces)
            axes.fill_between([run.settled_from, end], mean - band, mean + band, color=color,
                              alpha=0.15, linewidth=0)
        if settling is None:
            axes.plot([], [], color=color, label=label)
        else:
            at = run.settled_from + settling
            there = next(f for t, f in zip(run.times, forces) if t > at - 1e-6)
            axes.plot([at], [there], marker="v", color=color, markeredgecolor="black", markersize=8,
                      label=label, zorder=3)
    shown = [f for foot in COLORS for t, f in zip(run.times, run.planned[foot]) if begin <= t <= end]
    axes.set_ylim(-0.05 * max(shown), 1.1 * max(shown))
    axes.set_ylabel("planned force [N]")
    axes.set_title(run.title, fontsize="medium")


def draw_both(axes, runs, column, label, begin, end):
    shown, edges = [], []
    for run, (color, line) in zip(runs, STYLES):
        times, values = run.trajectory["t"], run.trajectory[column]
        axes.plot(times, values, color=color, linestyle=line, label=run.name)
        shown += [y for t, y in zip(times, values) if begin <= t <= end]
        edges += [point[1] for piece in ground.intervals(run.summary, begin, end) for point in piece[3]]
    # The CoM of a falling robot goes far beyond the support.
    axes.set_ylim(max(min(shown) - 0.01, min(edges, default=0.0) - 1.0),
                  min(max(shown) + 0.01, max(edges, default=0.0) + 1.0))
    axes.set_ylabel(label)


def draw_edges(axes, run, style, end):
    """Extent of the support: one sole, or the hull of two."""
    color, _ = style
    is_named = False
    for first, last, feet, corners in ground.intervals(run.summary, run.trajectory["t"][0], end):
        extent = [f(point[1] for point in corners) for f in (min, max)]
        if feet == 1:
            axes.hlines(extent, first, last, colors="tab:green", linestyles=":")
            continue
        axes.hlines(extent, first, last, colors=color, linestyles=":", label=None if is_named else f"hull, {run.name}")
        is_named = True
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, extent[0] - 0.01), max(high, extent[1] + 0.01))


def main(folders, picture):
    runs = [Run(folder) for folder in folders]
    pushed_at, pushed_there = ([push["start_s"] for push in events.pushes(run.summary)] for run in runs)
    if len(pushed_at) != len(pushed_there) or any(abs(a - b) > 1e-9 for a, b in zip(pushed_at, pushed_there)):
        sys.exit("the pushes of the two runs do not begin at the same time")
    begins, ends = zip(*(events.span(run.summary, before=0.2, after=2.0) for run in runs))
    begin, end = min(begins), min(max(ends), *(run.times[-1] for run in runs))

    figure, panels = plt.subplots(4, 1, figsize=(6.8, 9.0), sharex=True, constrained_layout=True)
    draw_forces(panels[0], runs[0], begin, end)
    draw_forces(panels[1], runs[1], begin, end)
    draw_both(panels[2], runs, "com_y", "CoM y [m]", begin, end)
    draw_both(panels[3], runs, "icp_y", "capture point y [m]", begin, end)
    for run, style in zip(runs, STYLES):
        draw_edges(panels[3], run, style, end)
    for axes, own in zip(panels, ([runs[0]], [runs[1]], runs, runs)):
        for start in pushed_at:
            axes.axvline(start, color="tab:red", linestyle=":")
        for run in own:
            if run.touchdown is not None:
                axes.axvline(run.touchdown, color="black", linestyle="--", linewidth=0.8)
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small", ncols=2)
    panels[-1].set_xlabel("t [s] (dotted: push, dashed: landing)")
    panels[-1].set_xlim(begin, end)
    save_picture(figure, picture, dpi=100)
    plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    beside = os.path.join(sys.argv[1], "compare.png")
    try:
        main(sys.argv[1:3], sys.argv[3] if len(sys.argv) == 4 else beside)
    except FileNotFoundError as error:
        sys.exit(f"{error.filename}: there is no such file; A and B must be --out folders of runs")
