"""The scene of a run on the whole body for the viewer: the robot of robot.json, its contacts, and what was planned."""

import json
import os
import sys

import numpy as np

from . import events, replay_meshes
from ..results import Table

BLUE, ORANGE, GREEN, RED, VIOLET = "#1565c0", "#ef6c00", "#2e7d32", "#d32f2f", "#7b1fa2"
LOADED = 5.0  # N: below this the centre of pressure is meaningless
PLAN_LASTS = 0.015  # s: a tick and a half of the planner
PANELS = ["icp", "com", "push", "vel", "body:left_measured_f", "body:right_measured_f", "h", "ticks:solve time"]


def soles(body, names):
    """Centres of pressure in the frames of the soles, and forces there; zero without load."""
    columns = {"t [s]": body.time}
    for foot in ("left", "right"):
        force = [np.array(body[f"{foot}_{names}_{e}"]) for e in ("fx", "fy", "fz", "tx", "ty")]
        loaded = force[2] > LOADED
        fz = np.where(loaded, force[2], 1.0)
        places = (np.where(loaded, -force[4] / fz, 0.0), np.where(loaded, force[3] / fz, 0.0))
        for axis, place, f in zip("xy", places, force):
            columns[f"{foot}_cop_{axis}"] = place
            columns[f"{foot}_f{axis}"] = np.where(loaded, f, 0.0)
        columns[f"{foot}_fz"] = np.where(loaded, force[2], 0.0)
    return Table(columns)


def step_plans(plans):
    """The places of the planned step and of those that were considered, NaN where there are none; and their number."""
    t, steps = plans.time, plans["steps"]
    columns, count = {"t": [], "place_x": [], "place_y": []}, sum(name.endswith("_cost") for name in plans)
    for i in range(1, count + 1):
        columns.update({f"other_{i}_x": [], f"other_{i}_y": []})
    for row, time in enumerate(t):
        columns["t"] += [time, min(time + PLAN_LASTS, t[row + 1] - 1e-9 if row + 1 < len(t) else np.inf)]
        for axis in "xy":
            columns[f"place_{axis}"] += [plans[f"place_{axis}"][row] if steps[row] > 0 else np.nan, np.nan]
            for i in range(1, count + 1):
                is_step = plans[f"alternative_{i}_steps"][row] > 0 and np.isfinite(plans[f"alternative_{i}_cost"][row])
                columns[f"other_{i}_{axis}"] += [plans[f"alternative_{i}_place_{axis}"][row] if is_step else np.nan, np.nan]
    return Table({name: np.array(values, dtype=float) for name, values in columns.items()}), count


def robot_item(folder, table):
    with open(os.path.join(folder, "robot.json"), encoding="utf-8") as file:
        robot = json.load(file)
    meshes, packed, warning = replay_meshes.take_in(robot)
    if warning:
        print(warning, file=sys.stderr)
    return {"name": "robot", "shape": "robot", "table": table, "robot": robot, "meshes": meshes, "packed": packed}


def marks(place, size, color, legend, path=None):
    """A point, its way, and a name in the legend."""
    items = [{"name": legend, "shape": "point", "at": place, "size": size, "color": color, "legend": legend}]
    return items + ([{"shape": "path", "of": legend, "color": color, **path}] if path is not None else [])


def plan_scene(run):
    """A plan of the whole body that DART follows."""
    def triple(name):
        return [f"{name} {axis}" for axis in "xyz"]

    items = [robot_item(run.folder, "tracking")]
    items += marks(triple("CoM"), 0.044, BLUE, "centre of mass", {})
    items += marks(triple("planned CoM"), 0.03, ORANGE, "planned centre of mass", {})
    items += marks(triple("left sole"), 0.02, GREEN, "left sole", {}) + marks(triple("right sole"), 0.02, VIOLET, "right sole", {})
    for side in ("left", "right"):
        items.append({"on": f"robot.{side}_sole", "shape": "arrow", "vector": [0, 0, f"{side} force"], "scale": 0.0012,
                      "width": 0.016, "color": GREEN})
    return {"table": "tracking", "ground": True, "follow": "centre of mass", "items": items}


def scene(run):
    """The scene of a run with robot.json, or None if its tables do not fit."""
    summary, body = run.summary, run.tables.get("body")
    if summary.get("name") == "whole_body" and "base_x" in run.tables.get("tracking", {}):
        return plan_scene(run)
    if body is None or "body" not in summary:  # otherwise body.csv belongs to an older run
        return None
    if not np.array_equal(body.time, run.trajectory.time):
        raise ValueError(f"body.csv and trajectory.csv in {run.folder} do not belong to the same run")
    items, tables = [robot_item(run.folder, "body")], {"soles": soles(body, "filtered")}
    for record, after in zip(summary["ground"], [*summary["ground"][1:], {}]):
        if record["corners"]:
            items.append({"shape": "polygon", "points": record["corners"], "at": [0, 0, 0.003], "from": record["from_s"],
                          "until": after.get("from_s")})
    items.append({"legend": "hull of the standing soles", "color": "#a5d6a7"})
    ground = True
    for number, box in enumerate(summary.get("ground_boxes") or []):
        color = "#e3e7ea" if number == 0 else "#bcaaa4" if box.get("soft") else "#b0bec5"
        items.append({"shape": "box", "size": box["size"], "at": box["position"], "quaternion": box["rotation"], "color": color})
        ground = "grid"
    for foot in ("left", "right"):
        items.append({"on": f"robot.{foot}_sole", "shape": "arrow", "table": "soles", "at": [f"{foot}_cop_x", f"{foot}_cop_y", 0],
                      "vector": [f"{foot}_f{axis}" for axis in "xyz"], "scale": 0.0012, "width": 0.016, "color": GREEN})
    items.append({"legend": "contact forces, measured", "color": GREEN})
    items.append({"on": f"robot.{summary.get('push_body') or 'root_link'}", "at": summary.get("push_point") or [0, 0, 0],
                  "shape": "arrow", "vector": ["push_x", "push_y", "push_z"], "scale": 0.004, "width": 0.022, "ends": True,
                  "world": True, "color": RED, "legend": "push"})
    items += marks(["com_x", "com_y", "com_z"], 0.044, BLUE, "centre of mass", {"height": 0.005})
    items.append({"shape": "line", "points": [["com_x", "com_y", "com_z"], ["com_x", "com_y", 0]], "color": BLUE})
    items += marks(["icp_x", "icp_y", 0.006], 0.032, ORANGE, "capture point", {"height": 0.006})
    if "step_plans" in summary and "plans" in run.tables:
        tables["step plans"], count = step_plans(run.tables["plans"])
        for i in range(1, count + 1):
            items.append({"shape": "point", "table": "step plans", "at": [f"other_{i}_x", f"other_{i}_y", 0.007], "size": 0.016,
                          "color": VIOLET})
        items.append({"shape": "point", "table": "step plans", "at": ["place_x", "place_y", 0.008], "size": 0.036,
                      "color": VIOLET, "legend": "planned step (small: considered)"})
    outcome = "recovered" if summary["recovered"] else "not recovered: " + summary["reason"]
    return {"title": f"{summary['robot']}, {events.impulse_in_words(summary)}, {summary['plant'].split(',')[0]}: {outcome}",
            "ground": ground, "follow": "centre of mass", "items": items, "tables": tables, "panels": PANELS,
            "events": sorted([[push["start_s"], "push"] for push in events.pushes(summary)] +
                             [[t, "landing"] for t in events.landings(summary)]),
            "notes": [[entry["t_s"], entry["text"]] for entry in summary.get("unmet", []) if "text" in entry]}
