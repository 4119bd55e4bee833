#!/usr/bin/env python3
"""Writes a report of a push recovery run, and the view of runs on the whole body.

Usage: python3 -m saltus.walking.report RESULTS, a folder with summary.json and the pictures of plot_run.py; writes
report.html and, for a run on the whole body (body.csv, robot.json), view.html. Both open without a network.
"""

import base64
import html
import json
import os

from . import events, ground
from .. import viewer
from ..on_folder import on_folder
from ..whole_file import write_text

PICTURES = [  # file, caption
    ("capture_point.png", "Capture point and hull"),
    ("from_above.png", "Feet, hull, centre of mass and capture point, from above"),
    ("step_plans.png", "Step plans: considered and chosen places, costs, time to landing"),
    ("com.png", "Centre of mass"),
    ("forces.png", "Commanded vertical forces"),
]
BODY_PICTURES = [
    ("measured_forces.png", "Vertical forces, planned and measured"),
    ("feet.png", "Soles: position, height and slip"),
    ("torques.png", "Joint torques as a fraction of their limits"),
]
ESTIMATE_PICTURES = [("estimate.png", "Error of the estimate")]

# Title, then key of summary.json ("body." of its section), text, unit, factor, decimals.
FIGURES = [
    ("The run", [
        ("stood_on", "Stance at the start", "", 1, 0),
        ("touchdown_s", "Touch-down", "s", 1, 3),
        ("end_s", "Length of the run", "s", 1, 2),
        ("com_height_min_m", "Lowest CoM", "m", 1, 3),
        ("com_height_max_m", "Highest CoM", "m", 1, 3),
        ("angular_momentum_max", "Largest angular momentum", "Nms", 1, 2),
        ("final_com_error_m", "Final CoM error", "mm", 1e3, 1),
        ("body.standing", "Balanced without a step, almost upright", "", 1, 0),
        ("body.base_tilt_max_rad", "Largest tilt of the base against the start", "rad", 1, 3),
        ("body.base_tilt_end_rad", "Tilt at the end", "rad", 1, 3),
    ]),
    ("Settling after the last landing or push", [
        ("icp_settling_from_s", "Start of the interval", "s", 1, 3),
        ("icp_settling_s", "Capture point within 1 cm of its final place", "s", 1, 2),
        ("force_settling.planned_left_s", "Planned vertical force, left foot", "s", 1, 2),
        ("force_settling.planned_right_s", "Planned vertical force, right foot", "s", 1, 2),
        ("force_settling.measured_left_s", "Measured vertical force, left foot", "s", 1, 2),
        ("force_settling.measured_right_s", "Measured vertical force, right foot", "s", 1, 2),
    ]),
    ("Feet", [
        ("body.left_force_peak_n", "Peak force of the left foot (mean over 20 ms)", "N", 1, 0),
        ("body.right_force_peak_n", "Peak force of the right foot (mean over 20 ms)", "N", 1, 0),
        ("body.friction_max", "Largest ratio of tangential to vertical force of a foot", "", 1, 2),
        ("body.left_slip_max_m", "Largest slip of the left sole", "mm", 1e3, 2),
        ("body.right_slip_max_m", "Largest slip of the right sole", "mm", 1e3, 2),
        ("body.feet_moved_max_m", "Largest distance of a sole from its start", "mm", 1e3, 1),
    ]),
    ("Step planner", [
        ("step_plans.ticks", "Planning ticks", "", 1, 0),
        ("step_plans.ticks_with_three_alternatives", "of these with three or more alternatives", "", 1, 0),
        ("step_plans.ticks_without_feasible_alternative", "of these without a feasible alternative",
         "", 1, 0),
        ("step_plans.first_without_s", "time of the first", "s", 1, 2),
        ("step_plans.processor_us.median", "Median processor time of a tick", "ms", 1e-3, 2),
        ("step_plans.processor_us.p99", "99th percentile of the processor time of a tick", "ms", 1e-3, 2),
    ]),
    ("Error of the estimate, from 0.25 s on", [
        ("body.estimate_com_error_m", "Largest error of the CoM from the stance sole", "mm", 1e3, 1),
        ("body.estimate_velocity_error_m_s", "Error of its velocity, rms", "mm/s", 1e3, 0),
    ]),
    ("Joints", [
        ("body.torque_share_max", "Largest torque, fraction of its limit", "%", 100, 0),
        ("body.torque_share_joint", "at the joint", "", 1, 0),
        ("body.torque_limit_share", "Time with a torque at its limit", "%", 100, 1),
        ("body.joint_limit_margin_rad", "Smallest distance of a joint from its limit", "mrad", 1e3, 1),
        ("body.joint_limit_joint", "at the joint", "", 1, 0),
        ("body.joint_limit_time_s", "at the time", "s", 1, 2),
        ("body.joint_speed_ratio_max", "Largest speed, fraction of its limit", "%", 100, 0),
        ("body.joint_speed_joint", "at the joint", "", 1, 0),
        ("body.joint_speed_time_s", "at the time", "s", 1, 2),
        ("body.landing_speed_m_s", "Largest speed of landing", "m/s", 1, 2),
        ("body.landing_force_n", "Largest force on a foot (mean of 2 ms)", "N", 1, 0),
        ("body.joint_speed_over_s", "Longest time above a speed limit", "ms", 1e3, 0),
    ]),
    ("Limbs", [
        ("body.clearance_min_m", "Smallest distance (negative: overlap)", "mm", 1e3, 1),
        ("body.clearance_pair", "of the links", "", 1, 0),
        ("body.clearance_time_s", "at the time", "s", 1, 2),
    ]),
    ("Controllers", [
        ("solves", "Solves of the planner", "", 1, 0),
        ("failures", "Solves that failed", "", 1, 0),
        ("deadline_misses", "Solves cut off by the deadline", "", 1, 0),
        ("icp_slack_max_m", "Largest violation of the hull by the plans", "mm", 1e3, 2),
        ("kkt_max", "Largest KKT residual", "", 1, None),
        ("solve_us.median", "Median time of a solve", "ms", 1e-3, 3),
        ("solve_us.p99", "99th percentile of the time of a solve", "ms", 1e-3, 3),
        ("body.control_steps", "Whole-body control steps", "", 1, 0),
        ("body.control_failures", "of these not solved", "", 1, 0),
        ("body.control_cuts", "of these with torques cut to their limits", "", 1, 0),
        ("body.whole_body_solve_us.median", "Median time of a whole-body solve", "ms", 1e-3, 3),
        ("body.whole_body_solve_us.p99", "99th percentile of the time of a whole-body solve", "ms", 1e-3, 3),
    ]),
    ("Time on one core, per simulated second", [
        ("body.planner_s_per_s", "Planner", "s", 1, 3),
        ("body.whole_body_control_s_per_s", "Whole-body control", "s", 1, 3),
        ("body.plant_s_per_s", "Simulator", "s", 1, 3),
    ]),
]
NULL_MEANS = {  # meaning of null; other rows are omitted if null
    "icp_settling_s": "never",
    "force_settling.planned_left_s": "never",
    "force_settling.planned_right_s": "never",
    "force_settling.measured_left_s": "never",
    "force_settling.measured_right_s": "never",
}

STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 62em; padding: 0 1em;
       color: #222; background: #fff; }
.verdict { padding: .6em 1em; border-radius: 6px; color: #fff; font-size: 1.25em; }
.good { background: #2e7d32; } .bad { background: #b3261e; }
table { border-collapse: collapse; } td, th { padding: .15em .9em .15em 0; text-align: left; }
.opening { display: flex; flex-wrap: wrap; gap: 0 2em; } .opening section { flex: 1 1 20em; }
.groups { columns: 2 27em; column-gap: 2.5em; } section { break-inside: avoid; }
h3 { margin: 0 0 .2em; padding-top: .9em; } section table { width: 100%; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
figure { display: inline-block; margin: 0 .8em 1em 0; width: 29em; max-width: 100%; }
pre { white-space: pre-wrap; font-size: .95em; }
img { width: 100%; } figcaption { color: #555; } code { font-size: .95em; }
"""


def look_up(summary, key):
    value = summary
    for part in key.split("."):
        if not isinstance(value, dict) or value.get(part) is None:
            return None
        value = value[part]
    return value


def figure_row(summary, key, text, unit, factor, decimals):
    value = look_up(summary, key)
    if value is None and not (key in NULL_MEANS and summary["touchdown_s"] is not None):
        return ""
    if value is None and "measured" in key and "body" not in summary:
        return ""
    if value is None:
        shown, unit = NULL_MEANS[key], ""
    elif isinstance(value, bool):
        shown = "yes" if value else "no"
    elif isinstance(value, str):
        shown = html.escape(value)
    elif decimals is None:
        shown = f"{value * factor:.1e}"
    else:
        shown = f"{value * factor:.{decimals}f}"
    return (f'<tr><td>{html.escape(text)}</td><td class="number">{shown}</td>'
            f"<td>{unit}</td></tr>\n")


def figure_group(summary, title, figures):
    rows = "".join(figure_row(summary, *figure) for figure in figures)
    return f"<section><h3>{html.escape(title)}</h3><table>{rows}</table></section>\n" if rows else ""


def settings_table(summary):
    changed = summary.get("changed_settings", [])
    if not changed:
        return "<p>All settings have their defaults.</p>"
    rows = "".join(
        "<tr>" + "".join(f"<td><code>{html.escape(str(entry[part]))}</code></td>"
                         for part in ("key", "value", "default", "unit")) + "</tr>\n"
        for entry in changed)
    return ("<table><tr><th>setting</th><th>value</th><th>default</th><th>unit</th></tr>\n"
            f"{rows}</table>")


def unmet(summary):
    """Violated requirements of the planners, and possible changes."""
    told = [entry["text"] for entry in summary.get("unmet", []) if "text" in entry]
    if not told:
        return ""
    rows = "".join(f"<pre>{html.escape(text)}</pre>\n" for text in told)
    return f"<h2>Limits that the plans violate</h2>\n{rows}"


def picture(folder, name, caption):
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return ""
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return (f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}">'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>\n")


def pushes(summary):
    """Size, time, direction and link of the push."""
    told = []
    for push in events.pushes(summary):
        text = f"push of {push['impulse_ns']:g} N s in {push['duration_s']:g} s at {push['start_s']:g} s"
        if push["direction"]:
            text += " towards (" + ", ".join(f"{round(v, 3) + 0.0:g}" for v in push["direction"]) + ")"
        told.append(text)
    if told and "push_link" in summary:
        told[-1] += f" on {html.escape(summary['push_link'])}"
    return "; ".join(told) or "no push"


def provenance(summary):
    """Versions and command of this run, to repeat it with config.yaml."""
    made = summary.get("saltus")
    if not made:
        return ""
    seed = f", seed {summary['seed']}" if "seed" in summary else ""
    return f"Saltus {made['version']}, commit {made['commit']}{seed}; config.yaml repeats it."


def banner(is_good, good, bad):
    """A verdict on a green or red ground."""
    return f'<p class="verdict {"good" if is_good else "bad"}">{html.escape(good if is_good else bad)}</p>'


def report(folder, summary, with_view):
    summary = summary | {"stood_on": ground.stood_at_first(summary)}
    verdicts = banner(summary["recovered"], "Recovered", "Not recovered: " + summary["reason"])
    if summary.get("hardware_safe") is not None:
        unsafe = "Not hardware-safe: " + summary["hardware_reason"]
        verdicts += banner(summary["hardware_safe"], "Hardware-safe", unsafe)
    title = f"Push recovery: {events.impulse_in_words(summary)}"
    link = '<p><a href="view.html">Watch the robot move</a></p>' if with_view else ""
    first, *others = FIGURES
    details = "".join(figure_group(summary, *group) for group in others)
    drawn = PICTURES + (BODY_PICTURES if "body" in summary else [])
    if "estimate_com_error_m" in summary.get("body", {}):
        drawn = drawn + ESTIMATE_PICTURES
    opening, *pictures = (picture(folder, *entry) for entry in drawn)
    pictures = "".join(pictures)
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>
<style>{STYLE}</style></head><body>
<h1>{html.escape(title)}</h1>
{verdicts}
<p>{html.escape(summary['robot'])}, {summary['mass_kg']:.2f} kg, in
{html.escape(summary['plant'])}; {pushes(summary)}; controller
{html.escape(summary['controller'])}, solver {html.escape(summary['solver_name'])}, stepping
{'allowed' if summary['stepping'] else 'not allowed'}.</p>
{link}
<div class="opening">{opening}{figure_group(summary, *first)}</div>
{unmet(summary)}<h2>Details</h2>
<div class="groups">{details}</div>
<h2>Pictures</h2>
{pictures or '<p>None were drawn.</p>'}
<h2>Settings that differ from their defaults</h2>
{settings_table(summary)}
<p>{html.escape(provenance(summary))}</p>
</body></html>
"""


def main(folder):
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    has_view = "body" in summary and viewer.write(folder)  # otherwise body.csv belongs to an older run
    write_text(os.path.join(folder, "report.html"), report(folder, summary, has_view))


if __name__ == "__main__":
    on_folder(main, __doc__, "RESULTS must be the --out folder of a run")
