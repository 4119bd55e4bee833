#!/usr/bin/env python3
"""Pictures of a push recovery run, after the figures of the paper.

Usage: plot_run.py RESULTS, a folder with trajectory.csv and summary.json; writes com.png,
capture_point.png and forces.png beside them. A run on the whole body (body.csv, robot.json) also
gets measured_forces.png, feet.png and torques.png.
"""

import json
import os

import shared  # noqa: F401
from saltus.drawing import plt, save_picture
from saltus.on_folder import on_folder
from saltus.tables import read_table


SWING = {"left": ("right", "tab:orange"), "right": ("left", "tab:blue")}  # by the stance foot


def mark_events(axes, summary):
    axes.axvline(summary["push_start_s"], color="tab:red", linestyle=":", label="push")
    if summary["touchdown_s"] is not None:
        axes.axvline(summary["touchdown_s"], color="black", linestyle="--", label="impact")


def new_axes(title, ylabel):
    figure, axes = plt.subplots(figsize=(6.4, 4.0), constrained_layout=True)
    axes.set_title(title)
    axes.set_xlabel("t [s]")
    axes.set_ylabel(ylabel)
    axes.grid(alpha=0.3)
    return figure, axes


def save(figure, axes, folder, name, begin, end):
    axes.set_xlim(begin, end)
    axes.legend(fontsize="small", ncols=2)
    save_picture(figure, os.path.join(folder, name))
    plt.close(figure)


def draw_measured_forces(body, summary, folder, begin, end, what):
    figure, axes = new_axes(f"Vertical forces, {what}", "force [N]")
    for foot, color in (("left", "tab:blue"), ("right", "tab:orange")):
        axes.plot(body["t"], body[f"{foot}_measured_fz"], color=color, alpha=0.25, linewidth=0.7)
        axes.plot(body["t"], body[f"{foot}_filtered_fz"], color=color,
                  label=f"{foot}, mean over 20 ms")
        axes.step(body["t"], body[f"{foot}_planned_fz"], where="post", color=color, linestyle="--",
                  label=f"{foot}, planned")
    mark_events(axes, summary)
    # Single samples of a landing are far above everything else.
    shown = [f for foot in ("left", "right") for kind in ("filtered", "planned")
             for t, f in zip(body["t"], body[f"{foot}_{kind}_fz"]) if begin <= t <= end]
    highest = max(shown, default=1.0)
    axes.set_ylim(-0.05 * highest, 1.15 * highest)
    save(figure, axes, folder, "measured_forces.png", begin, end)


def draw_feet(body, summary, folder, begin, end, what):
    figure, panels = plt.subplots(3, 1, figsize=(6.4, 6.0), sharex=True, constrained_layout=True)
    swing, swing_color = SWING[summary["stance"]]
    for axes, label in zip(panels, (f"{swing} sole y [m]", "height [mm]", "slip [mm]")):
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        mark_events(axes, summary)
    panels[0].set_title(f"Soles, {what}")
    panels[0].plot(body["t"], body[f"{swing}_sole_y"], color=swing_color)
    for foot, color in (("left", "tab:blue"), ("right", "tab:orange")):
        for axes, quantity in ((panels[1], "sole_z"), (panels[2], "slip")):
            axes.plot(body["t"], [1e3 * v for v in body[f"{foot}_{quantity}"]], color=color,
                      label=foot)
    panels[1].legend(fontsize="small", ncols=2)
    panels[2].set_xlabel("t [s]")
    save(figure, panels[2], folder, "feet.png", begin, end)


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


def main(folder):
    table = read_table(os.path.join(folder, "trajectory.csv"))
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    t = table["t"]
    begin = max(t[0], summary["push_start_s"] - 0.4)
    landed = summary["touchdown_s"] or summary["push_start_s"] + 0.6
    end = min(t[-1], landed + 2.0)
    outcome = "recovered" if summary["recovered"] else "not recovered"
    what = f"{summary['push_impulse_ns']:g} N s, {outcome}"

    figure, axes = new_axes(f"Centre of mass, {what}", "position [m]")
    for axis in "xyz":
        axes.plot(t, table[f"com_{axis}"], label=axis)
    mark_events(axes, summary)
    save(figure, axes, folder, "com.png", begin, end)

    figure, axes = new_axes(f"Capture point, lateral, {what}", "y [m]")
    axes.plot(t, table["icp_y"], color="tab:blue", label="capture point")
    axes.plot(t, table["com_y"], color="tab:gray", linewidth=1, label="CoM")
    stance_sole = summary[summary["stance"] + "_sole"]
    sole = [p[1] for p in stance_sole]
    hull = [p[1] for p in summary.get("hull", stance_sole)]
    until = summary["touchdown_s"] or end
    axes.hlines([min(sole), max(sole)], begin, until, colors="tab:green", linestyles=":",
                label="stance sole")
    if "hull" in summary:
        axes.hlines([min(hull), max(hull)], until, end, colors="tab:green", linestyles="--",
                    label="hull of both soles")
    mark_events(axes, summary)
    shown = hull + [y for s, y in zip(t, table["icp_y"]) if begin <= s <= end]
    axes.set_ylim(max(min(shown) - 0.03, -1.0), min(max(shown) + 0.05, 1.0))
    save(figure, axes, folder, "capture_point.png", begin, end)

    figure, axes = new_axes(f"Vertical forces, {what}", "force [N]")
    axes.step(t, table["left_fz"], where="post", label="left foot")
    axes.step(t, table["right_fz"], where="post", label="right foot")
    mark_events(axes, summary)
    save(figure, axes, folder, "forces.png", begin, end)

    if "body" not in summary:  # a body.csv that lies here is of an older run
        return
    body = read_table(os.path.join(folder, "body.csv"))
    with open(os.path.join(folder, "robot.json"), encoding="utf-8") as file:
        robot = json.load(file)
    draw_measured_forces(body, summary, folder, begin, end, what)
    draw_feet(body, summary, folder, begin, end, what)
    draw_torques(body, robot, summary, folder, begin, end, what)


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS is the --out folder of a run")
