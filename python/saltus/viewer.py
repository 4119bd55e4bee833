"""Writes one page about a run: plots over time, and a scene that moves with them.

Usage: python3 -m saltus.viewer FOLDER [--with=FOLDER]... [--scene=FILE] [--open] [--live]; writes FOLDER/view.html,
which opens without a network or a server. With --live the page follows a run that continues: it reads
FOLDER/view_live.js again, which this program rewrites until the run writes its summary or is interrupted.

docs/viewer.md describes the page and the scene.
"""

import argparse
import base64
import csv
import html
import importlib.util
import json
import os
import re
import sys
import tempfile
import time
import webbrowser

from .on_folder import NOT_WRITTEN, SAID

try:
    import numpy as np
except ModuleNotFoundError:
    print("no page: this python3 has no numpy; install python3-numpy, or set SALTUS_PYTHON to another python3",
          file=sys.stderr)
    sys.exit(SAID)

from .results import load  # noqa: E402
from .whole_file import write_text  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
SHARE = os.path.dirname(os.path.dirname(HERE))  # share/saltus, or the sources
THREE = next((place for place in (os.path.join(HERE, "three"), "/usr/share/javascript/three")  # a wheel; libjs-three
              if os.path.isdir(place)), "")
COPYRIGHT = next((path for path in (os.path.join(THREE, "copyright"), "/usr/share/doc/libjs-three/copyright")
                  if os.path.isfile(path)), "")
FEW = 50000  # values: a table of at most so many keeps 32 bits per value, a larger one has 16
MANY = 400000  # values: a larger table is thinned
PANELS = 12  # shown at first
LIVE_PAUSE = 0.5  # s
NO_MULTIPLIER = 1e-7  # multipliers up to this size mean that a constraint is inactive
# Columns that share a panel: what comes before, the part that differs, what comes after.
GROUPS = (re.compile(r"(.*?)([wxyz])()"), re.compile(r"(.*?)(roll|pitch|yaw)(.*)"), re.compile(r"()(left|right)([_ ].*)"))
LEAST = ({"x", "y"}, {"roll", "pitch"}, {"left", "right"})  # parts that a group must have
PLANNED = re.compile(r"(?:^|(?<=[_ ]))planned[_ ]")


class ViewError(ValueError):
    """Why there is no page, with a remedy."""


# ---- tables ------------------------------------------------------------------------------------------


def _text(data):
    return base64.b64encode(data.tobytes()).decode("ascii")


def pack(values, fine):
    """A column for the page: texts as indices, numbers with 32 bits (fine) or in 65534 steps of its range."""
    if values.dtype.kind != "f":
        names, codes = np.unique(values.astype(str), return_inverse=True)
        return {"names": names.tolist(), "u": _text(codes.reshape(-1).astype("<u2")), "low": 0, "step": 1}
    if fine:
        return {"f": _text(values.astype("<f4"))}
    known = values[np.isfinite(values)]
    low = float(known.min()) if len(known) else 0.0
    step = (float(known.max()) - low) / 65534 if len(known) else 0.0
    levels = np.full(len(values), 65535)
    levels[np.isfinite(values)] = np.round((known - low) / (step or 1.0))
    return {"u": _text(levels.astype("<u2")), "low": low, "step": step}


def _increasing(times):
    """Separates equal times, which occur at jumps, by a millionth of a millionth of the range or more."""
    times = np.array(times, dtype=float)
    least = 1e-12 * max(1.0, float(np.ptp(times)), float(np.abs(times).max()))
    for i in range(1, len(times)):
        if times[i] <= times[i - 1]:
            times[i] = times[i - 1] + least
    return times


def spans(times, names):
    """[begin, end, name] of consecutive equal names."""
    begins = [i for i, name in enumerate(names) if i == 0 or name != names[i - 1]]
    ends = [float(times[i]) for i in begins[1:]] + [float(times[-1])]
    return [[float(times[i]), end, str(names[i])] for i, end in zip(begins, ends)]


def pack_table(table, hold=False):
    every = max(1, -(-len(table) * len(table.time) // MANY))
    rows = slice(None, None, every)
    fine = len(table) * len(table.time) <= FEW
    packed = {"time": _text(_increasing(table.time[rows]).astype("<f8")), "every": every, "hold": hold, "columns": {
        name: pack(table[name][rows], fine) for name in table if name not in ("t", "made at")}}
    for name in ("mode", "phase"):
        if name in table:
            is_number = table[name].dtype.kind == "f"
            packed["modes"] = spans(table.time, [f"{name} {x:g}" if is_number else x for x in table[name]])
            break
    return packed


def pack_plans(table):
    """Each plan of a closed loop, in order: its first row, its number of rows and the time of its tick."""
    starts = [i for i, made in enumerate(table["made at"]) if i == 0 or made != table["made at"][i - 1]]
    ends = [*starts[1:], len(table.time)]
    return {"time": _text(table.time.astype("<f8")),
            "columns": {name: pack(table[name], True) for name in table.numbers() if name != "made at"},
            "plans": [[float(table["made at"][i]), i, end - i] for i, end in zip(starts, ends)]}


def _bare(name):
    return re.sub(r" \[.*\]$", "", name)


def panels_of(table_name, table):
    """Panels of a table: those with x, y, z, with roll, pitch, yaw and with left, right hold several columns, and a
    planned column is drawn with its real one."""
    names = [name for name in table if name not in ("t", "mode", "phase", "made at")]
    planned = {}  # by the name of the real column
    for name in names:
        short = PLANNED.sub("", name)
        if short != name:
            real = [other for other in (short, PLANNED.sub("measured_", name), PLANNED.sub("filtered_", name))
                    if other in table and other != name]
            if real:
                planned[real[0]] = name
    names = [name for name in names if name not in planned.values()]
    panels, of_group = [], {}
    for name in names:
        unit, place = table.units[name], None
        for pattern, least in zip(GROUPS, LEAST):
            match = pattern.fullmatch(name)
            if not match:
                continue
            before, part, after = match.groups()
            if all(table.units.get(before + other + after) == unit for other in least):
                place = (pattern, before, after, unit)
                break
        if place is None or place not in of_group:
            title = _bare(name) if place is None else f"{before.strip('_ ')} {after.strip('_ ')}".strip()
            panel = {"table": table_name, "title": title, "unit": unit, "series": []}
            panels.append(panel)
            if place:
                of_group[place] = panel
        else:
            panel = of_group[place]
        label = part if place else ""
        panel["series"].append({"column": name, "label": label})
        if name in planned:
            panel["series"].append({"column": planned[name], "label": f"{label} planned".strip(), "dash": True})
    for panel in panels:
        panel["title"] = panel["title"] or ", ".join(series["label"] for series in panel["series"])
    return panels


def main_table(tables):
    """The table whose curves are shown first."""
    names = ["trajectory", "tracking", *(name for name in tables if not name.startswith("events"))]
    return next((name for name in names if name in tables), None)


def choose(panels, summary, tables, wanted):
    """Marks the panels that are shown at first: `wanted` titles, or states and inputs, then solve times."""
    main = main_table(tables)
    states, inputs = ([_bare(name) for name in summary[key]] if isinstance(summary.get(key), list) else []
                      for key in ("states", "inputs"))
    left = PANELS
    for panel in panels:
        columns = [_bare(series["column"]) for series in panel["series"]]
        panel["stepped"] = "ticks" in tables and panel["table"] == main and all(c in inputs for c in columns)
        if wanted:
            shown = f"{panel['table']}:{panel['title']}" in wanted or panel["title"] in wanted
        elif panel["table"] == main or panel["table"].startswith("trajectory"):
            shown = left > 0 and (not states or any(c in states + inputs for c in columns))
        else:
            shown = left > 0 and panel["table"] == "ticks" and panel["title"] == "solve time"
        panel["shown"] = shown
        left -= shown
    order = {title: i for i, title in enumerate(wanted)}
    panels.sort(key=lambda p: (order.get(p["title"], order.get(f"{p['table']}:{p['title']}", len(order))), p["table"] != main))


# ---- what a run says about itself -----------------------------------------------------------------------


def events_of(run):
    """[time, text] of the events of a run."""
    for name, table in run.tables.items():
        if name.startswith("events") and "event" in table:
            return [[float(t), str(text)] for t, text in zip(table.time, table["event"])]
    begins = (run.summary.get("tracking") or {}).get("modes_begin_s")
    if begins is not None:
        return [[float(time), f"mode {i} begins"] for i, time in enumerate(begins, 2)]
    durations = run.summary.get("durations_s") or []
    return [[float(sum(durations[:i])), f"end of phase {i}"] for i in range(1, len(durations))]


def _shown(value):
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _scalars(value, prefix=""):
    """Texts and numbers in nested objects, by their path."""
    found = {}
    for key, entry in value.items():
        if isinstance(entry, dict):
            found.update(_scalars(entry, f"{prefix}{key}."))
        elif not isinstance(entry, list):
            found[prefix + key] = _shown(entry)
        elif 0 < len(entry) <= 12 and all(isinstance(x, (int, float, str)) for x in entry):
            found[prefix + key] = ", ".join(map(_shown, entry))
    return found


VIOLATIONS = ("misses", "missed_at_ends", "missed_on_the_way", "plan_missed_at_ends", "violations", "soft_violations",
              "shortages", "remedies", "checked")


def _multipliers(entries):
    """The active constraints with the derivatives of the cost."""
    active, texts = [e for e in entries if max(abs(e.get(side) or 0.0) for side in ("lower", "upper")) > NO_MULTIPLIER], {}
    rows = {(entry.get("phase"), entry["term"]) for entry in entries if entry.get("row")}  # terms with several rows
    for entry in active:
        name = ": ".join(entry[key] for key in ("phase", "term") if entry.get(key))
        name += f" {entry['row']}" if (entry.get("phase"), entry["term"]) in rows else ""
        texts[name] = f"{_shown(entry['lower'])}, {_shown(entry['upper'])}"
    return {"derivative of the cost with respect to": "the lower, the upper bound", **texts} if texts else {}


def notes_of(runs):
    """Tables for the page: cost terms, violations and the summary; a column for each run."""
    sections = []

    def section(title, maps):
        keys = list(dict.fromkeys(key for entries in maps for key in entries))
        if keys:
            sections.append({"title": title, "rows": [[key, *(entries.get(key, "") for entries in maps)] for key in keys]})

    section("Cost terms", [{f"{c.get('phase', '')}: {c.get('term', '')}": _shown(c.get("value"))
                            for c in run.summary.get("costs") or []} for run in runs])
    section("Multipliers", [_multipliers(run.summary.get("multipliers") or []) for run in runs])
    violated = []
    for run in runs:
        entries = {}
        unmet = run.summary.get("unmet")
        explained = run.summary.get("explanation") or (unmet.get("explanation") if isinstance(unmet, dict) else None) or {}
        found = {**run.summary, "shortages": explained.get("missing"), "remedies": explained.get("remedies")}
        for kind in VIOLATIONS:
            for entry in found.get(kind) or []:
                if isinstance(entry, dict):
                    name = ": ".join(str(entry[k]) for k in ("phase", "term", "name", "kind") if entry.get(k))
                    said = entry.get("text") or ", ".join(
                        f"{k} {_shown(entry[k])}" for k in ("t_s", "amount", "value", "reference", "error", "tolerance")
                        if entry.get(k) is not None)
                    key = f"{kind.replace('_', ' ')}: {name}".rstrip(": ")
                    same = sum(other == key or other.startswith(key + " (") for other in entries)
                    entries[f"{key} ({same + 1})" if same else key] = said
        violated.append(entries)
    section("Violations and checks", violated)
    section("Summary", [_scalars(run.summary) for run in runs])
    return sections


# ---- the scene --------------------------------------------------------------------------------------------


def find_scene(folder, problem):
    """The scene of a run: scene.json in its folder or in the two above, or that of a problem of Saltus; or None."""
    places = [folder, os.path.dirname(folder), os.path.dirname(os.path.dirname(folder))]
    paths = [os.path.join(place, "scene.json") for place in places]
    if problem and re.fullmatch(r"\w+", problem):
        paths += [os.path.join(SHARE, "problems", "library", "scenes", problem + ".json"),
                  os.path.join(SHARE, "problems", problem, "scene.json")]
    return next((path for path in paths if os.path.isfile(path)), None)


SHAPES = {"point", "sphere", "box", "cylinder", "line", "polygon", "arrow", "path", "robot", "frame"}
VALUES = ("at", "vector", "quaternion", "rpy", "angle")


def check_scene(scene, tables):
    """Raises ViewError for an unknown shape, item or column."""
    if not isinstance(scene, dict) or not isinstance(scene.get("items"), list):
        raise ViewError('the scene must be an object with a list "items"')
    names = [item.get("name") for item in scene["items"] if isinstance(item, dict)]
    for number, item in enumerate(scene["items"], 1):
        if not isinstance(item, dict):
            raise ViewError(f"item {number} of the scene is not an object")
        what = f"item {item.get('name', number)!r} of the scene"
        if item.get("shape", "frame") not in SHAPES:
            raise ViewError(f"{what} has the unknown shape {item['shape']!r}; the shapes are {', '.join(sorted(SHAPES))}")
        for key, known, kind in (("on", names[: number - 1], "earlier item"), ("of", names, "item")):
            if key in item and item[key] not in known and "." not in str(item[key]):
                raise ViewError(f"{what} refers to {item[key]!r}, which is no {kind} of the scene; add the item or "
                                "correct the name")
        points = item.get("points", [])
        for point in points:
            if isinstance(point, str) and point not in names:
                raise ViewError(f"{what} has a point at {point!r}, which is no item of the scene; name an item or "
                                "give three values")
        values = [item[key] for key in VALUES if key in item] + [point for point in points if isinstance(point, list)]
        for column in _columns(values):
            table, _, name = column.rpartition(":")
            table = table or item.get("table") or scene.get("table") or "trajectory"
            if table not in tables or name not in tables[table]:
                raise ViewError(f"{what} needs column {name!r} of table {table!r}, which the run does not have; the "
                                f"first line of {table}.csv lists its columns")


def _columns(value):
    if isinstance(value, str):
        yield value.lstrip("-")
    elif isinstance(value, list):
        for entry in value:
            yield from _columns(entry)
    elif isinstance(value, dict):
        yield from _columns(value.get("column", []))


# ---- the page ---------------------------------------------------------------------------------------------


def _plots_folder():
    """The folder with uPlot: of the package uplot-python, or of the set-up."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    places = [os.path.join(place, "uplot") for place in (HERE, SHARE, os.path.join(cache, "saltus"))]
    found = importlib.util.find_spec("uplot")
    if found and found.submodule_search_locations:
        places += [os.path.join(place, "static") for place in found.submodule_search_locations]
    for place in places:
        if os.path.isfile(os.path.join(place, "uPlot.iife.js")):
            return place
    command = f"bash {os.path.join(HERE, 'fetch_uplot')} {os.path.join(cache, 'saltus')}"
    raise ViewError(f"uPlot is not installed; run: {command}")


def _read(*parts):
    with open(os.path.join(*parts), encoding="utf-8") as file:
        return file.read()


def _script(*parts):
    return _read(*parts).replace("</script", "<\\/script")


def _licence():
    """The text of the MIT licence, which must accompany the libraries."""
    if not COPYRIGHT:
        return ""
    found = re.search(r"^License: Expat\n(?: .*\n)+", _read(COPYRIGHT), re.MULTILINE)
    return found.group(0).replace("--", "- -") if found else ""


def json_text(value):
    """JSON for a script element. NaN becomes null."""
    text = json.dumps(value, separators=(",", ":"))
    return re.sub(r"\b(NaN|-?Infinity)\b(?=[,\]}])", "null", text).replace("<", "\\u003c")


def _data(runs, scene):
    """Everything that the page shows."""
    shown, panels, wanted = [], {}, scene.get("panels", [])
    for run in runs:
        tables = {**run.timed_tables(), **scene.get("tables", {})}
        plans = tables.pop("plans", None) if "made at" in tables.get("plans", {}) else None
        tables = {name: table for name, table in tables.items() if not name.startswith("events")}
        own = [panel for name, table in tables.items() if name not in scene.get("tables", {})
               for panel in panels_of(name, table)]
        choose(own, run.summary, tables, wanted)
        for panel in own:
            panels.setdefault((panel["table"], panel["title"], panel["unit"]), panel)
        shown.append({"name": os.path.basename(run.folder),
                      "tables": {name: pack_table(table, name in scene.get("tables", {})) for name, table in tables.items()},
                      "events": scene.get("events") or events_of(run)})
        if plans is not None:
            shown[-1]["plans"] = pack_plans(plans)
    return {"runs": shown, "panels": list(panels.values()), "notes": notes_of(runs), "main": main_table(runs[0].timed_tables()),
            "logarithmic": bool(runs[0].summary.get("logarithmic_time"))}


def _scene_of(run, path):
    """The scene of a run as data, with the robot that it names."""
    if path is None and os.path.exists(os.path.join(run.folder, "robot.json")):
        from .walking import replay
        scene = replay.scene(run)
        if scene is not None:
            return scene
    path = path or find_scene(run.folder, _problem(run))
    if path is None:
        return {}
    try:
        scene = json.loads(_read(path))
        check_scene(scene, run.timed_tables())
    except ValueError as error:
        raise ViewError(f"{path}: {error}") from None
    return scene


def _problem(run):
    path = os.path.join(run.folder, "run.json")
    return json.loads(_read(path)).get("problem") if os.path.exists(path) else None


def _title(run):
    summary = run.summary
    title = summary.get("name") or _problem(run) or os.path.basename(run.folder)
    for key in ("task", "gait"):
        title += f", {summary[key]}" if summary.get(key) else ""
    if isinstance(summary.get("cost"), float):
        title += f": cost {summary['cost']:.6g}"
    return str(title).replace("_", " ")


def page(runs, scene=None, live=False):
    """The text of the page about these runs. `scene` is the path of a scene file, see docs/viewer.md. Raises ViewError
    if the scene is wrong or a library is missing."""
    for run in runs:
        if not main_table(run.timed_tables()):
            raise ViewError(f"{run.folder} has no table with a column t and rows; name the folder that "
                            "contains trajectory.csv")
    described = _scene_of(runs[0], scene)
    libraries = [_script(_plots_folder(), "uPlot.iife.js")]
    licences = ["uPlot, copyright Leon Sorokin"]
    if described:
        if not os.path.exists(os.path.join(THREE, "three.min.js")):
            raise ViewError("three.js is not installed; run: apt-get install libjs-three")
        libraries += [_script(THREE, "three.min.js"), _script(THREE, "examples/js/controls/OrbitControls.js")]
        licences.append("three.js, copyright the three.js authors")
    data = _data(runs, described)
    data["live"] = live
    drawn = {key: value for key, value in described.items() if key not in ("tables", "events", "panels")}
    title = described.get("title") or " and ".join(_title(run) for run in runs)
    parts = {"TITLE": html.escape(title), "LICENCES": "; ".join(licences) + "; MIT licence\n" + _licence(),
             "STYLE": _read(_plots_folder(), "uPlot.min.css"),
             "LIBRARIES": "\n".join(f"<script>{text}</script>" for text in libraries),
             "DATA": json_text(data), "SCENE": json_text(drawn),
             "PROGRAM": _script(HERE, "viewer.js") + "\n" + (_script(HERE, "scene.js") if described else "")}
    return re.sub(r"@@([A-Z]+)@@", lambda match: parts[match.group(1)], _read(HERE, "viewer.html"))


class View:
    """A page about runs: `save(path)` writes it, and notebooks show it."""

    def __init__(self, runs, scene=None):
        self._text = page(runs, scene)

    def save(self, path):
        write_text(path, self._text)

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self._text)}" style="width: 100%; height: 640px; border: 0" '
                'title="view of a run"></iframe>')


def _loaded(run, folder):
    """Loads a run from its folder. The result of a solve or of a closed loop is first written into `folder`."""
    if isinstance(run, (str, os.PathLike)):
        return load(run)
    if hasattr(run, "tables"):  # load(), run()
        return run
    if hasattr(run, "solution"):  # solve_refined(), search()
        run = run.solution
    if hasattr(run, "recording"):
        run.write(os.path.join(folder, "closed loop"))
        return load(os.path.join(folder, "closed loop"))
    if not hasattr(run, "trajectory"):
        raise ViewError(f"{type(run).__name__} is not a run; give a folder, a result of load() or run(), a solution or a closed loop")
    from . import _core
    if run.trajectory.empty:
        raise ViewError(f"the plan has no trajectory: {run.message}")
    folder = os.path.join(folder, "plan")
    os.makedirs(folder)
    samples = run.trajectory.samples(8)
    names = run.trajectory.phases
    columns = {"t [s]": samples["t"], "phase": [names[i] for i in samples["phase"]]}
    for letter in ("x", "u", "z"):
        columns.update({f"{letter}{i}": values for i, values in enumerate(np.transpose(samples.get(letter, [])))})
    with open(os.path.join(folder, "trajectory.csv"), "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([columns, *zip(*columns.values())])
    write_text(os.path.join(folder, "multipliers.csv"), _core.multipliers_csv(run))
    write_text(os.path.join(folder, "summary.json"), _core.summary_json("plan", run))
    return load(folder)


def view(run, *others, scene=None):
    """A page about a run, or a comparison of several. A run is a folder, a result of load() or run(), a solution, or the
    log of a closed loop. In a notebook the page appears inline; `save(path)` writes it as one file."""
    with tempfile.TemporaryDirectory(prefix="saltus-view-") as folder:
        return View([_loaded(entry, os.path.join(folder, str(i), "run")) for i, entry in enumerate((run, *others))], scene)


def write(folder):
    """Writes view.html of the run in the folder. False: it cannot, and the reason is printed."""
    try:
        View([load(folder)]).save(os.path.join(folder, "view.html"))
    except ViewError as error:
        print(f"no view: {error}", file=sys.stderr)
        return False
    return True


# ---- the command line ---------------------------------------------------------------------------------------


def follow(folder, write):
    """Calls `write` whenever a table of the folder changes, until the run writes its summary."""
    begin = time.time()
    last = None
    while True:
        names = [name for name in os.listdir(folder) if name.endswith(".csv") or name == "summary.json"] \
            if os.path.isdir(folder) else []
        stamps = {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in names}
        if stamps != last and "trajectory.csv" in stamps and stamps["trajectory.csv"] > 1e9 * (begin - 60):
            is_over = stamps.get("summary.json", 0) >= stamps["trajectory.csv"]
            write(is_over)
            last = stamps
            if is_over:
                return
        time.sleep(LIVE_PAUSE)


def main(words):
    parser = argparse.ArgumentParser(prog="saltus view")
    parser.add_argument("folder")
    parser.add_argument("--with", action="append", default=[], dest="others")
    parser.add_argument("--scene")
    parser.add_argument("--open", action="store_true")
    parser.add_argument("--live", action="store_true")
    given = parser.parse_args(words)
    path = os.path.join(given.folder, "view.html")
    is_open = False

    def write(is_over=True):
        nonlocal is_open
        runs = [load(folder) for folder in (given.folder, *given.others)]
        if given.live:  # before the page, which reads it
            news = json_text(_data(runs, {}))
            write_text(os.path.join(given.folder, "view_live.js"), f"saltus_live({news}, {json_text(is_over)});\n")
        if is_over or not is_open:
            write_text(path, page(runs, given.scene, live=not is_over))
        if not is_open:
            print(path, flush=True)
            if given.open:
                webbrowser.open("file://" + os.path.abspath(path))
        is_open = True

    try:
        if given.live:
            follow(given.folder, write)
        else:
            write()
    except KeyboardInterrupt:
        return 0
    except (ViewError, FileNotFoundError) as error:
        print(f"no page: {error}", file=sys.stderr)
        return SAID
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError) as error:
        print(f"{given.folder}: its tables cannot be read: {error}; repeat the run", file=sys.stderr)
        return SAID
    except OSError as error:
        print(f"{error.filename or path}: {error.strerror}", file=sys.stderr)
        return NOT_WRITTEN
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
