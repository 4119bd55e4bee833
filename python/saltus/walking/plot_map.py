#!/usr/bin/env python3
"""Draws a survival map as a polar plot.

Usage: python3 -m saltus.walking.plot_map RESULTS, a folder with map.csv; writes map.png into it. There is one panel
per step time, or one panel if the planner decides the step time. The angle is the direction of the push, seen from
above with forward at the top; the radius is the impulse. Filled cells: the MPC recovered. Lines: the impulse up to
which each controller recovered every push; dots: further recovered pushes. Dashed: the bound of the plain pendulum. If
the planner decides the step time, the title has the fraction of the bound's area that was reached.
"""

import csv
import math
import os
import sys

from ..drawing import matplotlib, plt, save_picture
from ..on_folder import on_folder

STYLES = {
    "mpc": {"color": "tab:blue", "label": "MPC"},
    "capture_point": {"color": "tab:orange", "label": "baseline"},
    "none": {"color": "tab:green", "label": "no step"},
}
FONT = 12  # points, legible at half size
# Offset of the dots of different controllers, in fractions of a cell's width.
OFFSETS = {"mpc": -0.2, "capture_point": 0.0, "none": 0.2}


def read_cells(path):
    """{(controller, step time): {direction in rad: {impulse: (outcome, bound)}}}; uses the last line of
    each cell."""
    cells = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            ray = cells.setdefault((row["controller"], float(row["step_time_s"])), {})
            pushes = ray.setdefault(math.radians(float(row["direction_deg"])), {})
            pushes[float(row["impulse_ns"])] = (row["outcome"], float(row["bound_ns"]))
    return cells


def unbroken(pushes):
    """The largest impulse up to which everything was recovered; 0 if not even the smallest."""
    largest = 0.0
    for impulse in sorted(pushes):
        if pushes[impulse][0] != "recovered":
            break
        largest = impulse
    return largest


def area(radii):
    """Area of the polygon with these radii at equal angles."""
    pairs = zip(radii, radii[1:] + radii[:1])
    return 0.5 * math.sin(2.0 * math.pi / len(radii)) * sum(a * b for a, b in pairs)


def share_of_bound(rays, width):
    """Fraction of the bound's area that was reached; None if directions are missing."""
    if len(rays) < 3 or abs(len(rays) * width - 2.0 * math.pi) > 1e-6:
        return None
    angles = sorted(rays)
    return area([unbroken(rays[a]) for a in angles]) / area([bound_of(rays[a]) for a in angles])


def bound_of(pushes):
    return next(iter(pushes.values()))[1]


def closed(rays, value, width):
    """Angles and values around the circle, with gaps where directions are missing."""
    angles = sorted(rays)
    points = [(angle, value(rays[angle])) for angle in angles]
    points.append((angles[0] + 2.0 * math.pi, points[0][1]))
    line = []
    for angle, radius in points:
        if line and angle - line[-1][0] > 1.5 * width:
            line.append((0.5 * (angle + line[-1][0]), math.nan))
        line.append((angle, radius))
    return [p[0] for p in line], [p[1] for p in line]


def draw_panel(axes, cells, step_time, width, edges, outermost):
    below = dict(zip(edges[1:], edges[:-1]))
    shown = [("mpc", step_time), ("capture_point", step_time), ("none", 0.0)]
    for angle, pushes in cells.get(shown[0], {}).items():
        for impulse, (outcome, _) in pushes.items():
            if outcome == "recovered":
                axes.bar(angle, impulse - below[impulse], width=width, bottom=below[impulse],
                         color=STYLES["mpc"]["color"], alpha=0.18, linewidth=0)
            elif outcome == "failed":
                axes.plot(angle, impulse, "x", color="black", markersize=4)
    # Later lines are narrower, so that coinciding lines remain visible.
    for key, linewidth in zip(shown, (3.4, 2.2, 1.2)):
        rays = cells.get(key)
        if not rays:
            continue
        style = STYLES[key[0]]
        axes.plot(*closed(rays, unbroken, width), linewidth=linewidth, marker="o",
                  markersize=linewidth + 0.8, **style)
        for angle, pushes in rays.items():
            beyond = [j for j, (outcome, _) in pushes.items()
                      if outcome == "recovered" and j > unbroken(pushes)]
            axes.plot([angle + OFFSETS[key[0]] * width] * len(beyond), beyond, ".",
                      color=style["color"], markersize=5)
    for key, style in ((shown[0], "--"), (shown[2], ":")):
        rays = cells.get(key) or cells.get((shown[1] if style == "--" else key))
        if rays:
            axes.plot(*closed(rays, bound_of, width),
                      linestyle=style, color="black", linewidth=1.0,
                      label="pendulum's bound" + ("" if style == "--" else ", no step"))
    axes.set_theta_zero_location("N")  # forward is up; angles increase to the left, seen from above
    axes.set_thetagrids(range(0, 360, 45),
                        ["forward", "", "left", "", "back", "", "right", ""])
    axes.set_ylim(0.0, outermost)
    label_radii(axes)
    axes.grid(alpha=0.3)


def label_radii(axes):
    """A few labels of the impulse on the left, where few lines are, on a white background."""
    axes.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(nbins=5, steps=[1, 2, 4, 10], integer=True, prune="lower"))
    axes.set_rlabel_position(100.0)
    axes.tick_params(labelsize=FONT)
    for text in axes.get_yticklabels():
        text.set_bbox({"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.6})


def free_title(rays, width, largest):
    title = "time and place of the steps chosen by the planner"
    share = share_of_bound(rays, width)
    if share is None:
        return title
    at_least = "at least " if any(unbroken(pushes) == largest for pushes in rays.values()) else ""
    return f"{title}\nMPC: {at_least}{100.0 * share:.0f} % of the bound's area"


def main(folder):
    cells = read_cells(os.path.join(folder, "map.csv"))
    step_times = sorted({t for controller, t in cells if controller != "none"})
    has_steps = bool(step_times)
    step_times = step_times or [0.0]
    rays = [pushes for by_angle in cells.values() for pushes in by_angle.values()]
    if not rays:
        sys.exit("map.csv has no cells yet")
    impulses = sorted({impulse for pushes in rays for impulse in pushes})
    edges = [max(0.0, 2.0 * impulses[0] - impulses[1]) if len(impulses) > 1 else 0.0] + impulses
    angles = sorted({angle for by_angle in cells.values() for angle in by_angle})
    gaps = [b - a for a, b in zip(angles, angles[1:] + [angles[0] + 2.0 * math.pi])]
    width = min(gaps)

    figure, panels = plt.subplots(1, len(step_times), figsize=(max(4.0 * len(step_times), 7.2), 5.4),
                                  subplot_kw={"projection": "polar"}, squeeze=False)
    for axes, step_time in zip(panels[0], step_times):
        is_free = has_steps and step_time == 0.0  # the planner decides the step time: the whole bound is shown
        outermost = max(impulses[-1], *map(bound_of, rays)) if is_free else impulses[-1]
        draw_panel(axes, cells, step_time, width, edges, 1.08 * outermost)
        axes.set_title(free_title(cells.get(("mpc", 0.0), {}), width, impulses[-1]) if is_free
                       else f"step of {step_time:g} s" if step_time > 0.0 else "no step", pad=16, fontsize=FONT + 1)
    handles, labels = panels[0][0].get_legend_handles_labels()
    if any(controller == "mpc" for controller, _ in cells):
        handles.append(plt.Rectangle((0, 0), 1, 1, color=STYLES["mpc"]["color"], alpha=0.18, linewidth=0))
        labels.append("recovered by MPC")
    columns = 6 if len(step_times) > 2 else 3
    figure.legend(handles, labels, loc="lower center", ncols=columns, frameon=False, fontsize=FONT)
    figure.suptitle("Recovered pushes: impulse in N s, by direction", y=0.98, fontsize=FONT + 2)
    figure.tight_layout(rect=(0.0, 0.07 if len(step_times) > 2 else 0.11, 1.0, 0.99))
    save_picture(figure, os.path.join(folder, "map.png"))


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a map")
