#!/usr/bin/env python3
"""Draws a run of push recovery, with the figures of the paper.

Usage: python3 -m saltus.walking.plot_run RESULTS, a folder with trajectory.csv and summary.json; writes com.png,
capture_point.png, from_above.png and forces.png into it, and step_plans.png if steps were planned (plans.csv).
A run on the whole body (body.csv, robot.json) also has measured_forces.png, feet.png and torques.png, and with
measured sensors estimate.png.
"""

import json
import os

from ..drawing import plt, save_picture
from ..on_folder import on_folder
from ..tables import read_by_names
from . import events, ground

FEET = (("left", "tab:blue"), ("right", "tab:orange"))
CAPTURE_POINT, COM = "tab:orange", "tab:blue"  # as in the replay
STANDING = {1: ("stance sole", ":"), 2: ("hull of both soles", "--")}  # by number of stance feet


def mark_events(axes, summary):
    for number, push in enumerate(events.pushes(summary)):
        axes.axvline(push["start_s"], color="tab:red", linestyle=":", label="push" if number == 0 else None)
    for number, landing in enumerate(events.landings(summary)):
        axes.axvline(landing, color="black", linestyle="--", linewidth=1.5 if number == 0 else 0.8,
                     label="landing" if number == 0 else None)


def new_axes(title, ylabel):
    figure, axes = plt.subplots(figsize=(6.4, 4.0), constrained_layout=True)
    axes.set_title(title)
    axes.set_xlabel("t [s]")
    axes.set_ylabel(ylabel)
    axes.grid(alpha=0.3)
    return figure, axes


def save(figure, axes, folder, name, begin, end):
    axes.set_xlim(begin, end)
    axes.legend(fontsize="medium", ncols=2)
    save_picture(figure, os.path.join(folder, name))
    plt.close(figure)


def draw_measured_forces(body, summary, folder, begin, end, what):
    figure, axes = new_axes(f"Vertical forces, {what}", "force [N]")
    for foot, color in FEET:
        axes.plot(body["t"], body[f"{foot}_measured_fz"], color=color, alpha=0.25, linewidth=0.7)
        axes.plot(body["t"], body[f"{foot}_filtered_fz"], color=color,
                  label=f"{foot}, mean over 20 ms")
        axes.step(body["t"], body[f"{foot}_planned_fz"], where="post", color=color, linestyle="--",
                  label=f"{foot}, planned")
    mark_events(axes, summary)
    # Single samples at a landing are far above all others.
    shown = [f for foot in ("left", "right") for kind in ("filtered", "planned")
             for t, f in zip(body["t"], body[f"{foot}_{kind}_fz"]) if begin <= t <= end]
    highest = max(shown, default=1.0)
    axes.set_ylim(-0.05 * highest, 1.15 * highest)
    save(figure, axes, folder, "measured_forces.png", begin, end)


def draw_feet(body, summary, folder, begin, end, what):
    figure, panels = plt.subplots(4, 1, figsize=(6.4, 7.4), sharex=True, constrained_layout=True)
    stepped = {step["foot"] for step in summary["steps"]} or {"left", "right"}
    one = f"{min(stepped)} sole" if len(stepped) == 1 else "sole"
    labels = (f"{one} y [m]", f"{one} x [m]", "height [mm]", "slip [mm]")
    for axes, label in zip(panels, labels):
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        mark_events(axes, summary)
    panels[0].set_title(f"Soles, {what}")
    for foot, color in FEET:
        for axes, axis in ((panels[0], "y"), (panels[1], "x")):
            if foot in stepped:
                axes.plot(body["t"], body[f"{foot}_sole_{axis}"], color=color)
        for axes, quantity in ((panels[2], "sole_z"), (panels[3], "slip")):
            axes.plot(body["t"], [1e3 * v for v in body[f"{foot}_{quantity}"]], color=color,
                      label=foot)
    panels[2].legend(fontsize="medium", ncols=2)
    panels[3].set_xlabel("t [s]")
    save(figure, panels[3], folder, "feet.png", begin, end)


def draw_torques(body, robot, summary, folder, begin, end, what):
    figure, axes = new_axes(f"Joint torques, {what}", "fraction of the limit")
    fractions = {}
    for entry in robot["bodies"]:
        joint, limit = entry["joint"], entry["effort"]
        if joint and limit:
            fractions[joint] = [tau / limit for tau in body["tau_" + joint]]
    largest = sorted(fractions, key=lambda joint: max(abs(s) for s in fractions[joint]), reverse=True)
    for joint in reversed(largest[6:]):
        axes.plot(body["t"], fractions[joint], color="0.8", linewidth=0.6)
    for joint in largest[:6]:
        axes.plot(body["t"], fractions[joint], linewidth=1.0, label=joint)
    axes.axhline(1.0, color="tab:red", linewidth=0.8)
    axes.axhline(-1.0, color="tab:red", linewidth=0.8)
    axes.set_ylim(-1.05, 1.05)
    mark_events(axes, summary)
    save(figure, axes, folder, "torques.png", begin, end)


def draw_estimate(table, body, summary, folder, begin, end, what):
    figure, axes = new_axes(f"Error of the estimated CoM, {what}", "relative to the stance sole [mm]")
    is_left = body["estimate_stance_is_left"]
    shown = [i for i, t in enumerate(body["t"]) if begin <= t <= end]
    for axis in "xyz":
        estimated, below = body[f"estimate_com_{axis}"], body[f"estimate_stance_{axis}"]
        com, left, right = table[f"com_{axis}"], body[f"left_sole_{axis}"], body[f"right_sole_{axis}"]
        foot = [a if chosen else b for chosen, a, b in zip(is_left, left, right)]
        axes.plot([body["t"][i] for i in shown],
                  [1e3 * ((estimated[i] - below[i]) - (com[i] - foot[i])) for i in shown], label=axis)
    mark_events(axes, summary)
    save(figure, axes, folder, "estimate.png", begin, end)


def draw_capture_point(table, summary, folder, begin, end, what):
    """Lateral and forward motion, with the extent of the support in that direction."""
    t = table["t"]
    standing = list(ground.intervals(summary, begin, end))
    figure, panels = plt.subplots(2, 1, figsize=(6.4, 6.4), sharex=True, constrained_layout=True)
    panels[0].set_title(f"Capture point, {what}")
    panels[1].set_xlabel("t [s]")
    for axes, axis, label, entry in ((panels[0], "y", "to the left, y [m]", 1),
                                     (panels[1], "x", "forward, x [m]", 0)):
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        axes.plot(t, table["icp_" + axis], color=CAPTURE_POINT, label="capture point")
        axes.plot(t, table["com_" + axis], color=COM, linewidth=1, label="CoM")
        edges, named = [], set()
        for first, last, feet, corners in standing:
            extent = [f(p[entry] for p in corners) for f in (min, max)]
            name, line = STANDING[feet]
            axes.hlines(extent, first, last, colors="tab:green", linestyles=line, label=None if name in named else name)
            named.add(name)
            edges += extent
        mark_events(axes, summary)
        shown = edges + [v for s, v in zip(t, table["icp_" + axis]) if begin <= s <= end]
        # The CoM of a falling robot goes far beyond the support.
        axes.set_ylim(max(min(shown) - 0.03, min(edges, default=0.0) - 1.0),
                      min(max(shown) + 0.05, max(edges, default=0.0) + 1.0))
    save(figure, panels[0], folder, "capture_point.png", begin, end)


def closed(corners):
    """x and y of the closed outline of a polygon."""
    return [[p[entry] for p in corners + corners[:1]] for entry in (0, 1)]


def draw_from_above(table, summary, folder, begin, end, what):
    """View from above: feet, hull, paths of CoM and capture point; y to the left, as seen by the robot."""
    figure, axes = plt.subplots(figsize=(5.6, 6.0), constrained_layout=True)
    axes.set_title(f"From above, {what}")
    axes.set_xlabel("y [m]")
    axes.set_ylabel("x, forward [m]")
    axes.grid(alpha=0.3)
    for number, (x, y) in enumerate(ground.outlines(summary)):
        axes.plot(y, x, color="0.6", linewidth=0.8, label=None if number else "unknown ground")
    for foot, color in FEET:
        corners = summary.get(foot + "_sole")
        if corners:
            x, y = closed(corners)
            axes.fill(y, x, color=color, alpha=0.25, label=f"{foot} sole")
    if "hull" in summary:
        x, y = closed(summary["hull"])
        axes.plot(y, x, color="tab:green", linestyle="--", label="hull of both soles")
    steps = [s for s in summary.get("steps", []) if s["touchdown_s"] is not None]
    if len(steps) > 1:  # labels of the landings
        for number, step in enumerate(steps, start=1):
            x, y = step["landed_at_m"][:2]
            axes.annotate(str(number), (y, x), color="tab:" + ("blue" if step["foot"] == "left" else "orange"))
    shown = [i for i, s in enumerate(table["t"]) if begin <= s <= end]
    for name, color, label in (("icp", CAPTURE_POINT, "capture point"), ("com", COM, "CoM")):
        x, y = ([table[f"{name}_{axis}"][i] for i in shown] for axis in "xy")
        axes.plot(y, x, color=color, linewidth=1.2, label=label)
        axes.plot(y[0], x[0], "o", color=color, markersize=4)
        axes.plot(y[-1], x[-1], "s", color=color, markersize=5)
    corners = [p for foot in ("left", "right") for p in summary.get(foot + "_sole", [])]
    if len(steps) > 1:
        corners += [[v + beside for v in step["landed_at_m"][:2]] for step in steps
                    if step["touchdown_s"] >= begin for beside in (-0.08, 0.08)]
    middle = [0.5 * (min(p[entry] for p in corners) + max(p[entry] for p in corners))
              for entry in (0, 1)] if len(steps) > 1 else [
                  sum(p[entry] for p in corners) / len(corners) for entry in (0, 1)]
    reach = max(0.25, *(abs(p[entry] - middle[entry]) + 0.05 for p in corners for entry in (0, 1)))
    is_named = False
    for push in events.pushes(summary):  # an arrow to the CoM, projected on the ground
        length = sum(v * v for v in push["direction"][:2]) ** 0.5 if push["direction"] else 0.0
        if length == 0.0:
            continue
        at = min(shown, key=lambda i, start=push["start_s"]: abs(table["t"][i] - start))
        com = [table["com_" + axis][at] for axis in "xy"]
        tail = [c - 0.3 * reach * v / length for c, v in zip(com, push["direction"])]
        axes.annotate("", xy=(com[1], com[0]), xytext=(tail[1], tail[0]),
                      arrowprops={"arrowstyle": "->", "color": "tab:red", "linewidth": 1.5})
        if not is_named:
            axes.plot([], [], color="tab:red", marker=r"$\rightarrow$", linestyle="", label="push")
        is_named = True
    axes.plot([], [], "o", color="0.5", markersize=4, label="begin")
    axes.plot([], [], "s", color="0.5", markersize=5, label="end")
    axes.set_aspect("equal")
    axes.set_xlim(middle[1] + reach, middle[1] - reach)
    axes.set_ylim(middle[0] - reach, middle[0] + reach)
    axes.legend(fontsize="medium", ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.13))
    save_picture(figure, os.path.join(folder, "from_above.png"))
    plt.close(figure)


def step_alternatives(plans):
    """One list per tick of the considered plans (steps, foot, cost, x, y, landing)."""
    names = ("steps", "right_foot", "cost", "place_x", "place_y", "landing")
    count = sum(name.endswith("_cost") for name in plans)
    columns = [[plans[f"alternative_{i + 1}_{name}"] for name in names] for i in range(count)]
    return [[tuple(column[tick] for column in alternative) for alternative in columns
             if alternative[0][tick] == alternative[0][tick]] for tick in range(len(plans["t"]))]


def draw_step_plans(plans, summary, folder, begin, end, what):
    """Alternatives of the step planner: positions, costs, and time to the landing."""
    shown = [i for i, t in enumerate(plans["t"]) if begin <= t <= end]
    considered = step_alternatives(plans)
    figure, (above, cost, landing) = plt.subplots(3, 1, figsize=(6.4, 9.0), constrained_layout=True,
                                                  height_ratios=(2, 1, 1))
    above.set_title(f"Step plans, {what}")
    above.set_xlabel("y [m]")
    above.set_ylabel("x, forward [m]")
    for foot, color in FEET:
        is_right = 1.0 if foot == "right" else 0.0
        corners = summary.get(foot + "_sole")
        if corners:
            x, y = closed(corners)
            above.fill(y, x, color=color, alpha=0.15)
        places = [(a[4], a[3]) for i in shown for a in considered[i] if a[0] > 0 and a[1] == is_right]
        above.plot([p[0] for p in places], [p[1] for p in places], ".", color=color, alpha=0.25,
                   markersize=4, label=f"{foot} foot, considered")
        chosen = [i for i in shown if plans["steps"][i] > 0 and plans["right_foot"][i] == is_right]
        above.plot([plans["place_y"][i] for i in chosen], [plans["place_x"][i] for i in chosen], "o",
                   color=color, markersize=4, markeredgecolor="black", label=f"{foot} foot, chosen")
        landing.plot([plans["t"][i] for i in chosen],
                     [plans["landing"][i] - plans["t"][i] for i in chosen], ".", color=color,
                     label=f"{foot} foot")
    for step in summary.get("steps", []):
        if step["touchdown_s"] is not None:
            above.plot(step["landed_at_m"][1], step["landed_at_m"][0], "x", color="black")
    above.plot([], [], "x", color="black", label="landed")
    above.set_aspect("equal", adjustable="datalim")
    above.invert_xaxis()
    kinds = sorted({(a[0], a[1] if a[0] > 0 else 0.0) for i in shown for a in considered[i]})
    for steps, is_right in kinds:
        points = [(plans["t"][i], a[2]) for i in shown for a in considered[i]
                  if a[0] == steps and (steps == 0 or a[1] == is_right) and a[2] < float("inf")]
        foot = "right" if is_right else "left"
        label = "stand" if steps == 0 else f"{steps:.0f} step{'s' if steps > 1 else ''}, {foot} first"
        cost.plot([p[0] for p in points], [p[1] for p in points], ".", markersize=4, label=label)
    cost.set_ylabel("cost of an alternative")
    cost.set_yscale("symlog", linthresh=1.0)
    none = [plans["t"][i] for i in shown if plans.get("feasible", [1.0] * len(plans["t"]))[i] == 0.0]
    if none:
        cost.plot(none, [0.0] * len(none), "x", color="tab:red", label="no feasible alternative")
    landing.set_ylabel("time to the landing [s]")
    landing.set_xlabel("t [s]")
    for axes in (above, cost, landing):
        axes.grid(alpha=0.3)
    for axes in (cost, landing):
        mark_events(axes, summary)
        axes.set_xlim(begin, end)
        axes.legend(fontsize="small", ncols=2)
    above.legend(fontsize="small", ncols=2)
    save_picture(figure, os.path.join(folder, "step_plans.png"))
    plt.close(figure)


def main(folder):
    table = read_by_names(os.path.join(folder, "trajectory.csv"))
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    t = table["t"]
    begin, end = events.span(summary, before=0.4, after=2.0)
    outcome = "recovered" if summary["recovered"] else "not recovered"
    what = f"{events.impulse_in_words(summary)}, {outcome}"

    figure, axes = new_axes(f"Centre of mass, {what}", "position [m]")
    for axis in "xyz":
        axes.plot(t, table[f"com_{axis}"], label=axis)
    mark_events(axes, summary)
    save(figure, axes, folder, "com.png", begin, end)

    draw_capture_point(table, summary, folder, begin, end, what)
    draw_from_above(table, summary, folder, begin, end, what)

    figure, axes = new_axes(f"Vertical forces, {what}", "force [N]")
    axes.step(t, table["left_fz"], where="post", label="left foot")
    axes.step(t, table["right_fz"], where="post", label="right foot")
    mark_events(axes, summary)
    save(figure, axes, folder, "forces.png", begin, end)

    if "step_plans" in summary:
        plans = read_by_names(os.path.join(folder, "plans.csv"))
        if any(step_alternatives(plans)):  # the formula has no alternatives
            draw_step_plans(plans, summary, folder, begin, end, what)

    if "body" not in summary:  # body.csv belongs to an older run
        return
    body = read_by_names(os.path.join(folder, "body.csv"))
    with open(os.path.join(folder, "robot.json"), encoding="utf-8") as file:
        robot = json.load(file)
    draw_measured_forces(body, summary, folder, begin, end, what)
    draw_feet(body, summary, folder, begin, end, what)
    draw_torques(body, robot, summary, folder, begin, end, what)
    if "estimate_com_error_m" in summary["body"]:
        draw_estimate(table, body, summary, folder, begin, end, what)


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a run")
