#!/usr/bin/env python3
"""Draws a run of the quadruped: path over the ground, contacts, body, solve times.

Usage: python3 -m saltus.plot_quadruped RESULTS, a folder with trajectory.csv, feet.csv, ticks.csv and summary.json;
writes quadruped.png into it. For a campaign, campaign.csv is drawn as campaign.png.
"""

import json
import math
import os

from .drawing import plt, save_picture
from .on_folder import on_folder
from .tables import read_table

LEGS = {"FL": "tab:blue", "FR": "tab:orange", "RL": "tab:green", "RR": "tab:red"}
WINDOW = 1.6  # s, length of the gait that is shown


def spans(times, flags):
    """[(begin, length)] of the times in which the flag is set."""
    found, begin = [], None
    for t, flag in zip(times, flags):
        if flag and begin is None:
            begin = t
        if not flag and begin is not None:
            found.append((begin, t - begin))
            begin = None
    if begin is not None:
        found.append((begin, times[-1] - begin))
    return found


def draw_way(axes, body, feet):
    way = [z - h for z, h in zip(body["z [m]"], body["height [m]"])]
    axes.fill_between(body["x [m]"], [min(way) - 0.05] * len(way), way, color="0.9", linewidth=0,
                      label="ground below the body")
    for leg, color in LEGS.items():
        axes.plot(feet[f"{leg} x [m]"], feet[f"{leg} z [m]"], color=color, linewidth=0.6, label=leg)
    axes.plot(body["x [m]"], body["z [m]"], color="black", linewidth=1.2, label="centre of mass")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
    axes.legend(fontsize="small", ncol=3, loc="upper center")
    axes.margins(x=0.01)
    axes.set_ylim(top=0.75)  # room for the legend


def draw_gait(axes, feet, push):
    begin = max(push - 0.4 * WINDOW, 0.0)
    for row, (leg, color) in enumerate(reversed(LEGS.items())):
        planned = spans(feet["t [s]"], feet[f"{leg} planned"])
        touching = spans(feet["t [s]"], feet[f"{leg} touches"])
        axes.broken_barh(planned, (row - 0.38, 0.36), color=color, alpha=0.35, linewidth=0)
        axes.broken_barh(touching, (row + 0.02, 0.36), color=color, linewidth=0)
    axes.set_yticks(range(len(LEGS)), list(reversed(LEGS)))
    axes.set_xlim(begin, begin + WINDOW)
    axes.axvline(push, color="black", linestyle=":")
    axes.set_xlabel("t [s]")
    axes.set_title("ground contact: actual (top, dark), scheduled (bottom, light)", fontsize="medium")


def draw_body(axes, body, push):
    for name, color in (("vx [m/s]", "tab:blue"), ("vy [m/s]", "tab:orange")):
        axes.plot(body["t [s]"], body[name], color=color, linewidth=0.8, label=name)
    axes.plot(body["t [s]"], [10.0 * h for h in body["tilt [rad]"]], color="tab:red", linewidth=0.8,
              label="tilt [0.1 rad]")
    axes.axvline(push, color="black", linestyle=":", label="push")
    axes.set_xlabel("t [s]")
    axes.legend(fontsize="small", ncol=2)
    axes.grid(alpha=0.3)


def draw_ticks(axes, ticks, period):
    axes.semilogy(ticks["t [s]"], [1e3 * s for s in ticks["solve time [s]"]], ".", markersize=2)
    axes.axhline(1e3 * period, color="black", linestyle="--", linewidth=0.8, label="period")
    axes.set_xlabel("t [s]")
    axes.set_ylabel("tick [ms]")
    axes.legend(fontsize="small")


def draw_run(folder, summary):
    feet, ticks = (read_table(os.path.join(folder, name)) for name in ("feet.csv", "ticks.csv"))
    body = {name.removeprefix("measured "): values for name, values in ticks.items()}
    body["height [m]"], body["tilt [rad]"] = feet["height [m]"], feet["tilt [rad]"]
    figure, axes = plt.subplot_mosaic([["way", "way"], ["gait", "gait"], ["body", "ticks"]],
                                      figsize=(8.0, 8.0), constrained_layout=True)
    end = "recovered" if summary["recovered"] else "fell"
    sensing = "without contact sensing" if summary["blind"] else (
        f"{summary['early_landings']} landings early, {summary['late_landings']} late")
    figure.suptitle(f"{summary['gait']}: {end} ({sensing})")
    draw_way(axes["way"], body, feet)
    draw_gait(axes["gait"], feet, summary["push_start_s"])
    draw_body(axes["body"], body, summary["push_start_s"])
    draw_ticks(axes["ticks"], ticks, summary["period_s"])
    save_picture(figure, os.path.join(folder, "quadruped.png"))
    plt.close(figure)


def draw_campaign(folder, summary):
    runs = read_table(os.path.join(folder, "campaign.csv"))
    figure, axes = plt.subplots(figsize=(6.4, 4.0), constrained_layout=True)
    order = sorted(range(len(runs["seed"])), key=lambda i: runs["blind end [s]"][i])
    for who, color in (("seeing", "tab:blue"), ("blind", "tab:red")):
        tilts = [math.degrees(runs[f"{who} largest tilt [rad]"][i]) for i in order]
        falls = [runs[f"{who} recovered"][i] == 0.0 for i in order]
        axes.plot(range(len(order)), tilts, "o", color=color, markersize=4,
                  label=f"{who}: {len(order) - sum(falls)} of {len(order)} recovered")
        axes.plot([i for i, fell in enumerate(falls) if fell],
                  [tilts[i] for i, fell in enumerate(falls) if fell], "x", color="black", markersize=8)
    axes.set_xlabel("runs, ordered by the time at which the blind run falls (x)")
    axes.set_ylabel("largest tilt [degrees]")
    axes.set_title(f"ground within {100 * summary['roughness_m']:.0f} cm, "
                   f"push of {summary['impulse_N_s']:.0f} N s", fontsize="medium")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    save_picture(figure, os.path.join(folder, "campaign.png"))
    plt.close(figure)


def main(folder):
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    (draw_campaign if summary["kind"] == "campaign" else draw_run)(folder, summary)


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a run")
