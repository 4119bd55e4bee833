"""Packs a run on the whole body into one page with an animated robot.

The page is replay_template.html with three.js, replay.js, the shape of the robot and the motion: 100 frames per
second, every channel quantised to 16 bits between its smallest and largest value.
"""

import array
import base64
import csv
import html
import json
import os
import re
import sys

from . import events, replay_meshes
from ..tables import without_unit

FRAME_RATE = 100.0  # 1/s
LEVELS = 65535  # quantisation levels of a channel
THREE = "/usr/share/javascript/three"  # Debian package libjs-three
COPYRIGHT = "/usr/share/doc/libjs-three/copyright"
HERE = os.path.dirname(os.path.abspath(__file__))

WRENCH = ("fx", "fy", "fz", "tx", "ty")


def read_rows(path):
    """Names without units, and rows of numbers."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.reader(file)
        header = [without_unit(column) for column in next(reader)]
        return header, [[float(entry) for entry in row] for row in reader]


def frame_indices(times):
    """Index of the sample nearest to each frame."""
    indices, i = [], 0
    count = int((times[-1] - times[0]) * FRAME_RATE + 1e-6) + 1
    for frame in range(count):
        t = times[0] + frame / FRAME_RATE
        while i + 1 < len(times) and abs(times[i + 1] - t) <= abs(times[i] - t):
            i += 1
        indices.append(i)
    return indices


def channels_of(robot, body, trajectory):
    """Names of the channels in the page and their columns."""
    joints = [entry["joint"] for entry in robot["bodies"] if entry["joint"]]
    chosen = [(body, "base_" + e) for e in ("x", "y", "z", "qw", "qx", "qy", "qz")]
    chosen += [(body, "q_" + joint) for joint in joints]
    chosen += [(body, f"{foot}_filtered_{e}") for foot in ("left", "right") for e in WRENCH]
    chosen += [(body, f"{foot}_planned_fz") for foot in ("left", "right")]
    chosen += [(trajectory, name) for name in ("com_x", "com_y", "com_z", "icp_x", "icp_y",
                                               "push_x", "push_y", "push_z", "two_feet")]
    return [(name, [row[header.index(name)] for row in rows])
            for (header, rows), name in chosen]


def quantise(values):
    """(smallest value, step, levels); a constant channel has step zero."""
    low, high = min(values), max(values)
    step = (high - low) / LEVELS
    return low, step, [round((v - low) / step) if step > 0.0 else 0 for v in values]


def pack(channels, indices):
    """All frames, channel by channel, as little-endian uint16."""
    data, table = array.array("H"), []
    for name, column in channels:
        low, step, levels = quantise([column[i] for i in indices])
        table.append([name, low, step])
        data.extend(levels)
    if sys.byteorder == "big":
        data.byteswap()
    return table, base64.b64encode(data.tobytes()).decode("ascii")


def script(path):
    with open(path, encoding="utf-8") as file:
        return file.read().replace("</script", "<\\/script")


def licence():
    """The licence notice of three.js, which must accompany it."""
    if not os.path.exists(COPYRIGHT):
        return "three.js, copyright the three.js authors, MIT licence"
    with open(COPYRIGHT, encoding="utf-8") as file:
        found = re.search(r"^License: Expat\n(?: .*\n)+", file.read(), re.MULTILINE)
    text = found.group(0) if found else ""
    return "three.js, copyright the three.js authors, MIT licence\n" + text.replace("--", "- -")


def json_text(value):
    """JSON for a script element, with "<" escaped."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def step_plans(folder):
    """For each tick with planned steps: its time, the chosen step (foot is right, x, y, landing) or null, and the
    positions (x, y) that were considered."""
    path = os.path.join(folder, "plans.csv")
    if not os.path.exists(path):
        return []
    header, rows = read_rows(path)
    column = {name: i for i, name in enumerate(header)}
    count = sum(name.endswith("_cost") for name in header)
    plans = []
    for row in rows:
        def entry(name, row=row):
            return round(row[column[name]], 4)
        chosen = [entry(name) for name in ("right_foot", "place_x", "place_y", "landing")] if entry("steps") > 0 else None
        places = [[entry(f"alternative_{i}_place_x"), entry(f"alternative_{i}_place_y")]
                  for i in range(1, count + 1) if entry(f"alternative_{i}_steps") > 0 and
                  row[column[f"alternative_{i}_cost"]] < float("inf")]
        plans.append([entry("t"), chosen, places])
    return plans


def page(folder, summary):
    """The text of replay.html. Raises FileNotFoundError if three.js is not installed."""
    library = script(os.path.join(THREE, "three.min.js"))
    controls = script(os.path.join(THREE, "examples/js/controls/OrbitControls.js"))
    with open(os.path.join(folder, "robot.json"), encoding="utf-8") as file:
        robot = json.load(file)
    meshes, mesh_data, warning = replay_meshes.take_in(robot)
    if warning:
        print(warning, file=sys.stderr)
    body = read_rows(os.path.join(folder, "body.csv"))
    trajectory = read_rows(os.path.join(folder, "trajectory.csv"))
    times = [row[0] for row in body[1]]
    if times != [row[0] for row in trajectory[1]]:
        sys.exit(f"body.csv and trajectory.csv in {folder} do not belong to the same run")
    indices = frame_indices(times)
    table, data = pack(channels_of(robot, body, trajectory), indices)
    outcome = "recovered" if summary["recovered"] else "not recovered: " + summary["reason"]
    engine = summary["plant"].split(",")[0]
    title = f"{summary['robot']}, {events.impulse_in_words(summary)}, {engine}: {outcome}"
    scene = {key: summary.get(key) for key in ("ground", "ground_boxes", "target", "touchdown_s", "push_body", "push_point")}
    scene["unmet"] = [[entry["t_s"], entry["text"]] for entry in summary.get("unmet", []) if "text" in entry]
    scene["plans"] = step_plans(folder) if "step_plans" in summary else []
    motion = {"start": times[0], "rate": FRAME_RATE, "frames": len(indices), "channels": table}
    with open(os.path.join(HERE, "replay_template.html"), encoding="utf-8") as file:
        text = file.read()
    parts = {"TITLE": html.escape(title), "LICENCE": licence(), "THREE": library,
             "CONTROLS": controls, "PROGRAM": script(os.path.join(HERE, "replay.js")),
             "MESHES": json_text(meshes), "MESHDATA": mesh_data,
             "ROBOT": json_text(robot), "SCENE": json_text(scene),
             "MOTION": json_text(motion), "DATA": data}
    return re.sub(r"@@([A-Z]+)@@", lambda match: parts[match.group(1)], text)
