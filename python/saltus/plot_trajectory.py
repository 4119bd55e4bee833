#!/usr/bin/env python3
"""Draws a run of any problem: states and inputs over time, modes shaded, events marked.

Usage: python3 -m saltus.plot_trajectory RESULTS, a folder with trajectory.csv ("t [s]", optionally "mode", states,
inputs) and optionally events.csv and summary.json; writes trajectory.png into it. For a case with several motions,
each trajectory_NAME.csv gives a picture. For a closed loop, ticks.csv adds the provenance of the inputs and the
computing times, and plans.csv adds the plans as thin lines.
"""

import glob
import json
import math
import os

from .drawing import plt, save_picture
from .on_folder import on_folder
from .tables import read_table

SHADES = ["#dbe9f6", "#fde6cf", "#dff0d8", "#f3dcef", "#fff3bf", "#e2e2e2", "#d5f0f0", "#f6d8d8"]
INPUT = "#d9661f"  # as in docs/gallery.py
PROVENANCES = {"optimal": "tab:green", "step": "tab:blue", "feasible": "tab:olive",
               "shifted": "tab:orange", "fallback": "tab:red"}
MOST_LABELS = 6  # largest number of modes or events with a label


def mode_spans(times, modes):
    """[(begin, end, mode)] of consecutive samples of one mode."""
    spans = []
    for t, mode in zip(times, modes):
        if spans and spans[-1][2] == mode:
            spans[-1][1] = t
        else:
            if spans:
                spans[-1][1] = t
            spans.append([t, t, mode])
    return spans


def shade(axes, spans, names):
    for begin, end, mode in spans:
        if end > begin:
            axes.axvspan(begin, end, color=SHADES[names.index(mode) % len(SHADES)], linewidth=0,
                         zorder=0)


def mark(axes, events):
    for t in events.get("t [s]", []):
        axes.axvline(t, color="0.25", linestyle="--", linewidth=0.8, zorder=1)


def split_columns(table, summary):
    """Names of states and of inputs; summary.json has the number of states."""
    names = [name for name in table if name not in ("t [s]", "mode")]
    states = summary.get("states")
    if states is None:
        states = [name for name in names if not name.startswith("u")]
    return states, [name for name in names if name not in states]


def jumps_at(times, values):
    """Interrupts a line at a jump, so that jumps are not drawn as ramps."""
    t, v = [], []
    for i, time in enumerate(times):
        if i > 0 and time == times[i - 1] and values[i] != values[i - 1]:
            t.append(time)
            v.append(math.nan)
        t.append(time)
        v.append(values[i])
    return t, v


def draw_ticks(axes, ticks):
    seconds = [1e3 * s for s in ticks["solve time [s]"]]
    sources = ticks["provenance"]
    for source in dict.fromkeys(sources):
        chosen = [i for i, name in enumerate(sources) if name == source]
        axes.plot([ticks["t [s]"][i] for i in chosen], [seconds[i] for i in chosen], ".",
                  color=PROVENANCES.get(source, "tab:gray"), markersize=4, label=source)
    axes.set_ylabel("solve time [ms]")
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize="x-small", ncols=4)


def draw_plans(axes, plans, name):
    """Every stored plan, from its tick to its end."""
    if name not in plans:
        return
    for made_at in dict.fromkeys(plans["made at [s]"]):
        chosen = [i for i, t in enumerate(plans["made at [s]"]) if t == made_at]
        axes.plot(*jumps_at([plans["t [s]"][i] for i in chosen], [plans[name][i] for i in chosen]),
                  color="0.45", linewidth=0.6, alpha=0.6)


def legend_of(figure, spans, names, events):
    handles = []
    shown = [name for name in names if any(s[2] == name and s[1] > s[0] for s in spans)]
    for name in shown[:MOST_LABELS]:
        color = SHADES[names.index(name) % len(SHADES)]
        handles.append(plt.Rectangle((0, 0), 1, 1, color=color, label=name))
    if len(shown) > MOST_LABELS:
        more = len(shown) - MOST_LABELS
        handles.append(plt.Rectangle((0, 0), 1, 1, color="white", label=f"and {more} more"))
    labels = list(dict.fromkeys(events.get("event", [])))
    if labels:
        text = ", ".join(labels[:MOST_LABELS]) + (", ..." if len(labels) > MOST_LABELS else "")
        handles.append(plt.Line2D([], [], color="0.25", linestyle="--", linewidth=0.8, label=text))
    if not handles:
        return
    columns = max(1, min(len(handles), 4, int(80 / max(len(h.get_label()) + 6 for h in handles))))
    lines = math.ceil(len(handles) / columns)
    strip = (0.12 + 0.19 * lines) / figure.get_size_inches()[1]  # below the panels, for the legend
    figure.get_layout_engine().set(rect=(0.0, strip, 1.0, 1.0 - strip))
    figure.legend(handles=handles, loc="lower center", ncols=columns, fontsize="small",
                  frameon=False)


def title_of(folder, summary, motion):
    title = summary.get("name") or os.path.basename(os.path.abspath(folder)).replace("_", " ")
    if motion:
        title += f", {motion}"
    if "cost" in summary and summary["cost"] is not None:
        title += f": cost {summary['cost']:.6g}"
    if summary.get("completed", summary.get("ok")) is False:
        title += " (not completed)"
    elif summary.get("misses"):
        title += " (misses constraints)"
    return title


def draw_motion(folder, table_file, summary):
    table = read_table(table_file)
    motion = os.path.basename(table_file)[len("trajectory"):-len(".csv")].lstrip("_")
    suffix = f"_{motion}" if motion else ""
    events_file = os.path.join(folder, f"events{suffix}.csv")
    events = read_table(events_file) if os.path.exists(events_file) else {}
    ticks_file = os.path.join(folder, "ticks.csv")
    ticks = read_table(ticks_file) if os.path.exists(ticks_file) else None

    plans_file = os.path.join(folder, "plans.csv")
    plans = read_table(plans_file) if ticks and os.path.exists(plans_file) else {}

    t = table["t [s]"]
    spans = mode_spans(t, table["mode"]) if "mode" in table else []
    names = list(dict.fromkeys(span[2] for span in spans))
    states, inputs = split_columns(table, summary)
    states = [name for name in states if name in table]
    plane = summary.get("plane") or []
    panels = [("state", name) for name in states] + [("input", name) for name in inputs]
    panels += [("ticks", "")] if ticks else []
    panels += [("plane", "")] if len(plane) == 2 else []
    columns = 1 if len(panels) <= 3 else 2 if len(panels) <= 10 else 3
    rows = math.ceil(len(panels) / columns)
    figure, grid = plt.subplots(rows, columns, squeeze=False, constrained_layout=True,
                                figsize=(6.4 * (1 + 0.6 * (columns - 1)), 1.2 + 1.7 * rows))
    figure.suptitle(title_of(folder, summary, motion))
    flat = list(grid.flat)
    for axes in flat[len(panels):]:
        axes.set_visible(False)
    for (kind, name), axes in zip(panels, flat):
        axes.grid(alpha=0.3)
        if kind == "plane":
            axes.plot(table[plane[0]], table[plane[1]], linewidth=1.0)
            axes.set_xlabel(plane[0])
            axes.set_ylabel(plane[1])
            axes.set_aspect("equal", adjustable="datalim")
            continue
        shade(axes, spans, names)
        mark(axes, events)
        if kind == "ticks":
            draw_ticks(axes, ticks)
        else:
            color = "tab:blue" if kind == "state" else INPUT
            held = kind == "input" and ticks  # constant between samples; plans have their own nodes
            draw_plans(axes, plans, name)
            axes.plot(*jumps_at(t, table[name]), color=color, linewidth=1.2,
                      drawstyle="steps-post" if held else "default")
            axes.set_ylabel(name)
            axes.ticklabel_format(axis="y", useOffset=False)
            known = [value for value in table[name] if not math.isnan(value)]
            if known and max(known) - min(known) <= 1e-9 * max(1.0, abs(known[0])):
                axes.set_ylim(known[0] - 1.0, known[0] + 1.0)  # constant up to rounding
        if summary.get("logarithmic_time"):
            axes.set_xscale("log")
        else:
            axes.set_xlim(min(t), max(t))
    for axes in flat[max(0, len(panels) - columns):len(panels)]:
        if not axes.get_xlabel():
            axes.set_xlabel("t [s]")
    legend_of(figure, spans, names, events)
    save_picture(figure, os.path.join(folder, f"trajectory{suffix}.png"))
    plt.close(figure)


def main(folder):
    summary = {}
    summary_file = os.path.join(folder, "summary.json")
    if os.path.exists(summary_file):
        with open(summary_file, encoding="utf-8") as file:
            summary = json.load(file)
    single = os.path.join(folder, "trajectory.csv")
    files = [os.path.join(folder, name) for name in summary.get("tables", [])]
    if not files:
        files = [single] if os.path.exists(single) else sorted(
            glob.glob(os.path.join(folder, "trajectory_*.csv"))) or [single]
    for file in files:
        draw_motion(folder, file, summary)


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a run")
