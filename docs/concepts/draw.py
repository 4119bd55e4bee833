#!/usr/bin/env python3
"""Draws the figures of docs/concepts.md as SVG files, which are the same each time.

Usage: draw.py FOLDER
"""

import math
import os
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "saltus", "svg.fonttype": "none", "font.size": 9,
                            "font.family": "sans-serif"})
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patches import FancyArrowPatch, Rectangle  # noqa: E402

BLUE, ORANGE, GREEN, GREY, RED = "#1f77b4", "#e08214", "#2ca02c", "#666666", "#d62728"
SHADES = {"push off": "#dbe9f6", "flight": "#fde6cf", "stance": "#dbe9f6", "both": "#dff0d8", "left": "#dbe9f6",
          "right": "#fde6cf"}


def new_axes(height, right, top, bottom=-0.4, left=-2.1):
    figure, axes = plt.subplots(figsize=(7.2, height))
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.axis("off")
    figure.subplots_adjust(0.0, 0.0, 1.0, 1.0)
    return figure, axes


def bar(axes, begin, end, low, name, height=0.5, text=None):
    axes.add_patch(Rectangle((begin, low), end - begin, height, facecolor=SHADES.get(name, "#eeeeee"), edgecolor=GREY,
                             linewidth=0.8))
    axes.text(0.5 * (begin + end), low + 0.5 * height, name if text is None else text, ha="center", va="center")


def arrow(axes, begin, end, color=GREY, style="-|>", **how):
    axes.add_patch(FancyArrowPatch(begin, end, arrowstyle=style, mutation_scale=10, color=color, linewidth=1.1,
                                   shrinkA=0, shrinkB=0, **how))


def label(axes, y, text):
    axes.text(-2.05, y, text, ha="left", va="center", color=GREY)


def event(axes, t, low, high, name, above=0.08):
    axes.plot([t, t], [low, high], color="black", linestyle="--", linewidth=0.9)
    axes.text(t, high + above, name, ha="center", va="bottom")


def time_axis(axes, end, y=0.0):
    arrow(axes, (0.0, y), (end, y))
    axes.text(end, y - 0.12, "t", ha="center", va="top")


# ---- the drawings --------------------------------------------------------------------------------


def modes():
    """Consecutive phases, and a schedule of modes inside a phase."""
    figure, axes = new_axes(2.9, 10.6, 3.9)
    label(axes, 2.95, "phases")
    bar(axes, 0.0, 3.6, 2.7, "push off", text="push off\nx in R2, u in R1")
    bar(axes, 3.6, 7.4, 2.7, "flight", text="flight\nx in R2, no u")
    bar(axes, 7.4, 10.0, 2.7, "stance", text="stance\nx in R2, u in R1")
    for t, name in ((3.6, "jump: x+ = x-"), (7.4, "jump: x+ = g(t, x-, p)")):
        axes.plot([t, t], [2.6, 3.3], color="black", linewidth=1.2)
        axes.text(t, 3.38, name, ha="center", va="bottom")
    label(axes, 1.25, "modes of a\nschedule, in\none phase")
    bar(axes, 0.0, 2.6, 1.0, "left")
    bar(axes, 2.6, 4.4, 1.0, "both")
    bar(axes, 4.4, 7.6, 1.0, "right")
    bar(axes, 7.6, 10.0, 1.0, "both")
    for t, name in ((2.6, "landing"), (4.4, "lift-off"), (7.6, "landing 2")):
        event(axes, t, 0.9, 1.62, name, 0.04)
    axes.text(0.0, 0.72, "the same states and inputs throughout; windows select the active terms", va="top", color=GREY)
    time_axis(axes, 10.3, 0.3)
    return figure


def windows():
    """Half-open windows and their ends."""
    figure, axes = new_axes(3.2, 10.6, 4.6)
    nodes = [0.0, 1.4, 2.8, 3.6, 4.2, 5.6, 7.0, 8.4, 9.8]
    axes.plot([0.0, 9.8], [3.5, 3.5], color="black", linewidth=1.0)
    for t in nodes:
        axes.plot(t, 3.5, "o", color="black" if t != 3.6 else RED, markersize=5)
    label(axes, 3.5, "nodes")
    event(axes, 3.6, -0.05, 4.05, "event: a node and a control break are exactly here")
    rows = [(2.6, "inputs and\nrunning costs", BLUE, 0.0, 3.6, "o--", "[from, to): the interval before the event is the last"),
            (1.55, "constraints on\nstates alone", GREEN, 0.0, 3.6, "oo", "also at the left limit of `to`: what was promised holds\nwhen the event is reached"),
            (0.5, "the next window", ORANGE, 3.6, 9.8, "oo", "without `to`: the end of the horizon is part of it")]
    for y, name, color, begin, end, ends, text in rows:
        label(axes, y, name)
        axes.plot([begin, end], [y, y], color=color, linewidth=4, solid_capstyle="butt")
        axes.plot(begin, y, "o", color=color, markersize=8)
        axes.plot(end, y, "o", markersize=8, color=color, markerfacecolor=color if ends == "oo" else "white")
        axes.text(3.85, y + (0.24 if begin > 0.0 else 0.0), text, va="bottom" if begin > 0.0 else "center", color=GREY)
    time_axis(axes, 10.3, -0.05)
    return figure


def events():
    """Events from the schedule, from the state, and early or late ones."""
    figure, axes = new_axes(3.6, 10.6, 5.2)
    label(axes, 4.3, "in the schedule")
    bar(axes, 0.0, 5.0, 4.05, "left")
    bar(axes, 5.0, 10.0, 4.05, "both")
    event(axes, 5.0, 3.95, 4.65, "at a given time: retime(\"landing\", 0.6)", 0.05)
    label(axes, 2.65, "by the state:\na guard")
    times = [0.05 * i for i in range(201)]
    axes.plot(times, [2.6 + 0.7 * math.cos(0.105 * math.pi * t) for t in times], color=BLUE, linewidth=1.4)
    axes.plot([0.0, 10.0], [2.6, 2.6], color=GREY, linewidth=0.7)
    t = 0.5 / 0.105
    axes.plot(t, 2.6, "o", color=RED, markersize=6)
    axes.text(t + 0.2, 2.7, "g(t, x) = 0, falling: its time has a derivative", va="bottom")
    axes.text(0.1, 3.4, "g > 0", color=GREY)
    label(axes, 0.85, "as it happens")
    for y, name, at in ((1.15, "planned", 5.0), (0.45, "happened", 4.1)):
        bar(axes, 0.0, at, y, "left", 0.4, name)
        bar(axes, at, at + 2.0, y, "both", 0.4, "both")
        bar(axes, at + 2.0, 10.0, y, "right", 0.4, "right")
    arrow(axes, (5.0, 1.15), (4.1, 0.87), RED)
    arrow(axes, (7.0, 1.15), (6.1, 0.87), RED)
    axes.text(5.0, 0.33, "confirm(\"landing\", t): early or late, later events move along", ha="center", va="top", color=GREY)
    time_axis(axes, 10.3, -0.1)
    return figure


def conventions():
    """The axes of world, foot and robot, and the entries of a wrench."""
    figure, axes = new_axes(3.3, 10.6, 4.8, bottom=0.0, left=0.0)

    def frame(x, y, name, turn=(0.95, 0.0, -0.45, -0.32)):
        arrow(axes, (x, y), (x + turn[0], y + turn[1]), RED)
        arrow(axes, (x, y), (x + turn[2], y + turn[3]), GREEN)
        arrow(axes, (x, y), (x, y + 0.9), BLUE)
        axes.text(x + turn[0] + 0.05, y + turn[1], "x forward", color=RED, va="center")
        axes.text(x + turn[2] - 0.05, y + turn[3], "y left", color=GREEN, va="center", ha="right")
        axes.text(x, y + 0.95, "z", color=BLUE, ha="center", va="bottom")
        axes.text(x + 0.12, y + 0.72, name, va="center")

    frame(1.3, 0.8, "world, z up")
    frame(5.4, 0.8, "")
    axes.text(5.4, 0.3, "contact frame of a foot: origin in the contact plane", ha="left", va="center")
    axes.add_patch(Rectangle((4.6, 0.68), 1.5, 0.12, facecolor="#dddddd", edgecolor=GREY, linewidth=0.8))
    axes.plot(2.9, 3.6, "o", color="black", markersize=9)
    axes.text(2.7, 3.85, "CoM x (m), v (m/s)\nH about it (Nms), world axes", ha="center", va="bottom")
    arrow(axes, (2.9, 3.6), (4.0, 3.6), BLUE)
    axes.text(4.05, 3.6, "v", color=BLUE, va="center")
    arrow(axes, (5.4, 0.9), (5.1, 3.0), ORANGE)
    axes.text(5.2, 3.1, "wrench (f N | tau Nm), tau about the frame's origin,\nin the axes of the sole", color=ORANGE, va="bottom", ha="left")
    axes.text(6.6, 1.9, "rotation: axes of the frame -> world\nquaternion (w, x, y, z), unit, w first", va="center")
    return figure


DRAWINGS = {"modes": modes, "windows": windows, "events": events, "conventions": conventions}


def main(folder):
    for name, draw in DRAWINGS.items():
        figure = draw()
        figure.savefig(os.path.join(folder, f"{name}.svg"), metadata={"Date": None, "Creator": None}, facecolor="white")
        plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
