#!/usr/bin/env python3
"""Draws a plan of the whole body as DART follows it: CoM and soles from the side and from above, forces, torques.

Usage: python3 -m saltus.plot_whole_body RESULTS, a folder with tracking.csv and summary.json; writes whole_body.png
and view.html into it.
"""

import json
import os

from . import viewer
from .drawing import plt, save_picture
from .on_folder import on_folder
from .tables import read_table

CURVES = (("planned CoM", "black", "--"), ("CoM", "tab:red", "-"), ("left sole", "tab:blue", "-"),
          ("right sole", "tab:orange", "-"))


def draw_paths(axes, motion, across, label):
    for name, color, style in CURVES:
        axes.plot(motion[f"{name} x [m]"], motion[f"{name} {across} [m]"], style, color=color, linewidth=1.0, label=name)
    axes.set_xlabel("x [m]")
    axes.set_ylabel(label)
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.3)


def draw_times(axes, motion, changes, unit):
    for time in changes:
        axes.axvline(time, color="0.7", linewidth=0.6)
    axes.set_xlabel("t [s]")
    axes.set_ylabel(unit)
    axes.margins(x=0.01)
    axes.grid(alpha=0.3)


def main(folder):
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    motion = read_table(os.path.join(folder, "tracking.csv"))
    changes = summary["tracking"]["modes_begin_s"]
    figure, axes = plt.subplot_mosaic([["side", "top"], ["forces", "torques"]], figsize=(9.0, 6.5),
                                      constrained_layout=True)
    end = "fell" if summary["tracking"]["fell"] else "tracked"
    figure.suptitle(f"{summary['task']}: {end} in DART")
    draw_paths(axes["side"], motion, "z", "z [m]")
    draw_paths(axes["top"], motion, "y", "y [m]")
    axes["top"].legend(fontsize="small")
    for side, color in (("left", "tab:blue"), ("right", "tab:orange")):
        axes["forces"].plot(motion["t [s]"], motion[f"{side} force [N]"], color=color, linewidth=0.8, label=side)
    axes["forces"].legend(fontsize="small")
    draw_times(axes["forces"], motion, changes, "vertical force [N]")
    for name, values in motion.items():
        if name.endswith("torque [Nm]"):
            axes["torques"].plot(motion["t [s]"], values, linewidth=0.6)
    draw_times(axes["torques"], motion, changes, "torques of all joints [Nm]")
    save_picture(figure, os.path.join(folder, "whole_body.png"))
    plt.close(figure)
    viewer.write(folder)


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a run")
