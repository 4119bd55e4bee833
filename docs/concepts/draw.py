#!/usr/bin/env python3
"""Draws the figures of docs/concepts.md and of the theory pages as SVG files. Every run writes identical files.

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
            (1.55, "constraints on\nstates alone", GREEN, 0.0, 3.6, "oo", "also at the left limit of `to`: they hold\nwhen the event is reached"),
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
    label(axes, 0.85, "as detected")
    for y, name, at in ((1.15, "planned", 5.0), (0.45, "detected", 4.1)):
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
    axes.text(6.6, 1.9, "rotation: from the frame to the world\nquaternion (w, x, y, z), unit, w first", va="center")
    return figure


def shooting():
    """Multiple shooting: nodes, intervals integrated from them, defects, and an event with its own node."""
    figure, axes = new_axes(3.9, 10.6, 5.6)
    nodes = [0.0, 1.7, 3.4, 4.6, 5.1, 6.8, 8.5, 10.0]
    starts = [2.5, 3.15, 3.75, 3.6, 3.05, 2.75, 2.35]
    ends = [3.35, 3.55, 3.92, 3.2, 2.95, 2.2, 2.1]
    label(axes, 4.3, "states")
    for k, (begin, end) in enumerate(zip(nodes, nodes[1:])):
        times = [begin + (end - begin) * i / 20 for i in range(21)]
        bend = 0.12 * (end - begin)
        axes.plot(times, [starts[k] + (ends[k] - starts[k]) * i / 20 + bend * math.sin(math.pi * i / 20) for i in range(21)],
                  color=BLUE, linewidth=1.5)
        axes.plot(begin, starts[k], "o", color="black", markersize=5)
        if k + 1 < len(starts):
            axes.plot([end, end], [ends[k], starts[k + 1]], color=RED, linewidth=1.5)
    axes.plot(nodes[-1], ends[-1], "o", color="black", markersize=5)
    axes.text(0.1, 2.15, "node: state $x_k$ is a variable", va="top")
    axes.annotate("defect, zero\nat the solution", (3.4, 3.65), (0.2, 4.9), va="center",
                  color=RED, arrowprops={"arrowstyle": "-|>", "color": RED, "linewidth": 0.9})
    label(axes, 1.1, "inputs")
    for k, (begin, end, value) in enumerate(zip(nodes, nodes[1:], [1.5, 1.35, 1.0, 0.7, 0.85, 1.05, 1.2])):
        axes.plot([begin, end], [value, value], color=ORANGE, linewidth=2.2)
        axes.text(0.5 * (begin + end), value + 0.07, f"$u_{k}$", ha="center", va="bottom", color=ORANGE)
    for t in nodes:
        axes.plot([t, t], [0.25, 0.4], color=GREY, linewidth=0.8)
    event(axes, 4.6, 0.3, 4.85, "event: a node and a control break\nare exactly here", 0.05)
    axes.text(6.6, 4.5, "each interval is integrated\nfrom its node, with derivatives\nin $x_k$, $u_k$, $p$, $t_0$ and $h$", va="center",
              color=GREY)
    time_axis(axes, 10.4, 0.3)
    return figure


def free_duration():
    """The nodes of a phase of free duration: the part up to the last limit of a window keeps its length."""
    figure, axes = new_axes(2.6, 10.6, 3.6)
    for y, name, duration, above in ((2.4, "guess of $T$", 7.0, 0.15), (1.0, "longer $T$", 9.6, -0.15)):
        nodes = [0.0, 1.0, 2.0, 3.0, *(3.0 + (duration - 3.0) * i / 4 for i in range(1, 5))]
        label(axes, y, name)
        axes.plot([0.0, 3.0], [y, y], color=GREEN, linewidth=4, solid_capstyle="butt")
        axes.plot([3.0, duration], [y, y], color=BLUE, linewidth=4, solid_capstyle="butt")
        axes.plot(nodes, [y] * len(nodes), "o", color="black", markersize=5)
        axes.text(duration, y + above, "end of the phase", ha="center", va="bottom" if above > 0 else "top")
    for a, b in zip([3.0 + 1.0 * i for i in range(1, 5)], [3.0 + 1.65 * i for i in range(1, 5)]):
        arrow(axes, (a, 2.28), (b, 1.12), GREY)
    event(axes, 3.0, 0.3, 3.05, "last limit of a window, in phase time", 0.05)
    axes.text(1.5, 0.75, "keeps its length", ha="center", va="top", color=GREEN)
    axes.text(6.4, 0.75, "stretches: $h_k = c_k + d_k\\,T$", ha="center", va="top", color=BLUE)
    time_axis(axes, 10.3, 0.3)
    return figure


def sweeps():
    """The recursion over the stages: factorisation and backward sweep, then forward sweep."""
    figure, axes = new_axes(3.5, 10.6, 4.9)
    places = [(0.0, "stage 0"), (2.3, "stage 1"), (4.9, "..."), (6.4, "stage N-1"), (9.0, "stage N")]
    width = 1.4
    for x, name in places:
        if name == "...":
            axes.text(x + 0.1, 2.3, "...", ha="center", va="center", fontsize=14)
            continue
        k = {"stage 0": "0", "stage 1": "1", "stage N-1": "{N-1}", "stage N": "N"}[name]
        text = f"$H_{k}, F_{k}$\n$W_{k}$" if name != "stage N" else "$H_N$\n$W_N$"
        bar(axes, x, x + width, 1.85, "push off", 0.9, text)
        axes.text(x + 0.5 * width, 1.72, name, ha="center", va="top", color=GREY)
    label(axes, 3.75, "backward")
    label(axes, 2.3, "stages")
    label(axes, 0.75, "forward")
    links = [(9.3, 7.5, "$P_N, p_N$"), (6.7, 5.1, "$P_{N-1}, p_{N-1}$"), (4.9, 3.4, "$P_2, p_2$"), (2.6, 1.1, "$P_1, p_1$")]
    for begin, end, text in links:
        arrow(axes, (begin, 3.5), (end, 3.5), RED)
        axes.text(0.5 * (begin + end), 3.58, text, ha="center", va="bottom", color=RED)
    axes.text(5.3, 4.35, "eliminate $u_k$ from $M = H_k + G_k^T W_k G_k + F_k^T P_{k+1} F_k$; what remains is $P_k$",
              ha="center", va="center")
    for (end, begin, _), text in zip(links, ["$x_N$", "$x_{N-1}$", "$x_2$", "$x_1$"]):
        arrow(axes, (begin, 1.0), (end, 1.0), GREEN)
        axes.text(0.5 * (begin + end), 0.92, text, ha="center", va="top", color=GREEN)
    axes.text(5.3, 0.2, "$u_k$ from $x_k$, then $x_{k+1} = F_k v_k + d_k$ and the costate $P_{k+1} x_{k+1} + p_{k+1}$",
              ha="center", va="center")
    return figure


def event_derivatives():
    """Two neighbouring trajectories through an event: the shift of the event time and of the state."""
    figure, axes = new_axes(3.6, 10.6, 5.6, bottom=0.0, left=0.0)
    axes.plot([0.6, 10.0], [1.3, 1.3], color="black", linewidth=1.0)
    axes.text(10.0, 1.22, "guard g = 0", ha="right", va="top")

    def before(s, shift):
        return 4.1 + shift - 0.62 * s - 0.02 * s * s

    def crossing(shift):
        return (-0.62 + math.sqrt(0.62 ** 2 + 0.08 * (2.8 + shift))) / 0.04

    for shift, color, name in ((0.0, BLUE, "nominal"), (0.55, GREEN, "with $w + dw$")):
        at = crossing(shift)
        times = [at * i / 40 for i in range(41)]
        axes.plot([0.6 + s for s in times], [before(s, shift) for s in times], color=color, linewidth=1.6)
        axes.text(0.75 if shift else 0.3, before(0.0, shift) + (0.1 if shift else -0.55), name,
                  va="bottom" if shift else "top", color=color)
        rest = [i * (9.4 - at) / 20 for i in range(21)]
        axes.plot([0.6 + at + s for s in rest], [2.1 + 0.2 * shift + 0.62 * s - 0.02 * s * s for s in rest], color=color,
                  linewidth=1.6)
        axes.plot([0.6 + at] * 2, [1.3, 2.1 + 0.2 * shift], color=color, linestyle=":", linewidth=1.1)
        axes.plot(0.6 + at, 1.3, "o", color=color, markersize=5)
    first, second = 0.6 + crossing(0.0), 0.6 + crossing(0.55)
    arrow(axes, (first, 0.75), (second, 0.75), RED, "<|-|>")
    axes.text(0.5 * (first + second), 0.66, "$ds^*$", ha="center", va="top", color=RED)
    axes.plot([first, first], [0.65, 1.3], color=GREY, linewidth=0.6)
    axes.plot([second, second], [0.65, 1.3], color=GREY, linewidth=0.6)
    arrow(axes, (first, 1.3), (first, before(first - 0.6, 0.55)), RED)
    axes.text(first - 0.08, 1.62, "$A$", ha="right", va="center", color=RED)
    late = 9.0

    def after(shift):
        s = late - 0.6 - crossing(shift)
        return 2.1 + 0.2 * shift + 0.62 * s - 0.02 * s * s

    arrow(axes, (late, after(0.0)), (late, after(0.55)), RED)
    axes.text(late + 0.08, after(0.55) - 0.1, "flow of $A^+$", ha="left", va="top", color=RED)
    axes.text(second + 0.1, 1.75, "reset R", va="center", color=GREY)
    time_axis(axes, 10.3, 0.3)
    return figure


def control_timing():
    """The parts of two ticks of a controller in real time."""
    figure, axes = new_axes(2.9, 10.6, 4.0)
    period, now, solve = 4.6, 1.6, 1.2
    label(axes, 2.6, "controller")
    label(axes, 1.15, "robot")
    for k in (0, 1):
        t = now + k * period
        bar(axes, t - 1.4, t - 0.1, 2.35, "flight", text="prepare")
        bar(axes, t, t + solve, 2.35, "stance", text="feedback")
        bar(axes, t + solve, t + solve + 1.1, 2.35, "", text="check")
        arrow(axes, (t, 1.45), (t, 2.33), GREEN)
        axes.text(t - 0.06, 1.85, "state", ha="right", va="center", color=GREEN)
        arrow(axes, (t + solve, 2.33), (t + solve, 1.45), RED)
        axes.text(t + solve + 0.06, 1.85, "input", ha="left", va="center", color=RED)
    bar(axes, 0.0, now + solve, 0.9, "", text="input of tick k-1")
    bar(axes, now + solve, now + solve + period, 0.9, "stance", text="input of tick k")
    bar(axes, now + solve + period, 10.0, 0.9, "flight", text="input of tick k+1")
    for y, begin, end, name in ((3.15, now, now + period, "period"), (3.15, now + period, now + period + 2.4, "deadline")):
        arrow(axes, (begin, y), (end, y), GREY, "<|-|>")
        axes.text(0.5 * (begin + end), y + 0.05, name, ha="center", va="bottom", color=GREY)
    axes.text(0.0, 0.72, "prepare: needs no measurement; feedback: one quadratic program; then the plan is checked",
              va="top", color=GREY)
    time_axis(axes, 10.3, 0.1)
    return figure


def search_tree():
    """Branch and bound over prefixes of mode sequences."""
    figure, axes = new_axes(3.3, 10.6, 4.6, left=0.0)
    boxes = {"all": (4.4, 3.7, "all phases: hull", "bound 10"), "A": (1.7, 2.4, "A, then hull", "bound 11"),
             "B": (7.1, 2.4, "B, then hull", "bound 16"), "AA": (0.3, 1.1, "A A, then hull", "bound 14"),
             "AB": (3.1, 1.1, "A B", "cost 12"), "BA": (7.1, 1.1, "not continued:", "16 > 12")}
    for name, (x, y, first, second) in boxes.items():
        bar(axes, x, x + 2.2, y, "both" if name == "AB" else "" if name == "BA" else "push off", 0.75, f"{first}\n{second}")
    for a, b in (("all", "A"), ("all", "B"), ("A", "AA"), ("A", "AB"), ("B", "BA")):
        arrow(axes, (boxes[a][0] + 1.1, boxes[a][1]), (boxes[b][0] + 1.1, boxes[b][1] + 0.75))
    axes.text(0.3, 0.6, "A bound holds for every sequence with this prefix. The search solves the node with the lowest bound\n"
              "next. It ends when no bound is below the cost of the best sequence, up to the gap.", va="top", color=GREY)
    return figure


THEORY = "framework/design/"
# Name of the drawing: its function and the page that shows it.
DRAWINGS = {
    "modes": (modes, "docs/concepts.md"),
    "windows": (windows, "docs/concepts.md"),
    "events": (events, "docs/concepts.md"),
    "conventions": (conventions, "docs/concepts.md"),
    "shooting": (shooting, THEORY + "conventions.md"),
    "free_duration": (free_duration, THEORY + "switch_times.md"),
    "sweeps": (sweeps, THEORY + "riccati.md"),
    "event_derivatives": (event_derivatives, THEORY + "events.md"),
    "search_tree": (search_tree, THEORY + "sequences.md"),
    "control_timing": (control_timing, "docs/howto.md"),
}


def main(folder):
    for name, (draw, _) in DRAWINGS.items():
        figure = draw()
        figure.savefig(os.path.join(folder, f"{name}.svg"), metadata={"Date": None, "Creator": None}, facecolor="white")
        plt.close(figure)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
