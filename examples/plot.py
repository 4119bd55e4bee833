#!/usr/bin/env python3
"""Draws a table of Saltus: states above, inputs below, a shade for every other mode.

Usage: plot.py trajectory.csv picture.png [--inputs N] [--time LABEL] [--shade FROM TO ...] [--path X Y]
The first column is time, the second the mode or phase if its title says so. --path draws column Y over column X in place of time.
"""

import argparse
import csv

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def number(text):
    return float(text) if text else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("table")
    parser.add_argument("picture")
    parser.add_argument("--path", nargs=2, metavar=("X", "Y"))
    parser.add_argument("--inputs", type=int, default=0, help="number of inputs (the last columns)")
    parser.add_argument("--time", help="label of the time axis, in place of the first column's name")
    parser.add_argument("--shade", nargs=2, type=float, action="append", default=[], metavar=("FROM", "TO"))
    arguments = parser.parse_args()
    with open(arguments.table, encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    has_modes = header[1] in ("mode", "phase")
    names = header[2:] if has_modes else header[1:]
    columns = {name: [number(row[i]) for row in rows] for i, name in enumerate(header) if name in (header[0], *names)}
    time, modes = columns[header[0]], [row[1] if has_modes else "" for row in rows]

    if arguments.path:
        figure, axes = plt.subplots(figsize=(7, 3.2))
        x, y = arguments.path
        axes.plot(columns[x], columns[y], lw=1.6)
        axes.plot(columns[x][0], columns[y][0], "o", columns[x][-1], columns[y][-1], "s", color="black", ms=5)
        axes.axhline(0.0, color="black", lw=0.8)
        axes.set(xlabel=x, ylabel=y, aspect="equal")
    else:
        panels = [names[: len(names) - arguments.inputs], names[len(names) - arguments.inputs :]]
        figure, axes = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True, squeeze=True)
        for panel, of_panel in zip(axes, panels):
            for name in of_panel:
                panel.plot(time, columns[name], lw=1.6, label=name,
                           drawstyle="steps-post" if of_panel is panels[1] else "default")
            starts = [0] + [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]] + [len(modes) - 1]
            for start, end in arguments.shade:
                panel.axvspan(start, end, color="0.9", lw=0)
            for k in range(1, len(starts) - 1, 2):
                panel.axvspan(time[starts[k]], time[starts[k + 1]], color="0.9", lw=0)
            for k, (start, end) in enumerate(zip(starts, starts[1:])):
                if panel is axes[0] and len(starts) > 2:
                    panel.annotate(modes[start], ((time[start] + time[end]) / 2, 1.04), ha="center", fontsize=8,
                                   xycoords=("data", "axes fraction"))
            panel.legend(fontsize=8)
            panel.margins(x=0)
        axes[1].set_xlabel(arguments.time or header[0])
    figure.tight_layout()
    figure.savefig(arguments.picture, dpi=110)


if __name__ == "__main__":
    main()
