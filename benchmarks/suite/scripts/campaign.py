"""Campaigns: lists of independent runs of `saltus` for all engines of `bench run`. They compute survival maps in
shards, the Monte Carlo study of push recovery, and the tables of the READMEs. A task is a command line and its
results are lines of text. Tasks share only the program (for `reproduce`: the clone of the sources, at the same path
everywhere)."""

import csv
import difflib
import fcntl
import glob
import io
import json
import math
import os
import random
import re
import resource
import statistics
import subprocess
import tempfile

import supervisor
from package import end_with_parent, write_text
from program import ProgramError, path_of_program

# entries of summary.json that do not depend on the machine
MEASURES = ("recovered", "reason", "fell", "final_com_error_m", "icp_settling_s", "angular_momentum_max",
            "touchdown_s", "mass_kg", "hardware_safe", "hardware_reason")
MAP_ROWS, TABLE = "map.csv", "table"  # result of a task, besides summary.json


class CampaignError(Exception):
    """An invalid request; the message is one sentence."""


def program_saltus():
    """The program next to saltus-bench."""
    path = os.path.join(os.path.dirname(path_of_program()), "saltus")
    if not os.access(path, os.X_OK):
        raise ProgramError(f"there is no program saltus next to saltus-bench, at '{path}'")
    return path


def reproduce_script():
    """docs/results/reproduce.py of the clone that contains these scripts."""
    root = os.path.realpath(__file__)
    for _ in range(4):  # benchmarks/suite/scripts/campaign.py
        root = os.path.dirname(root)
    script = os.path.join(root, "docs/results/reproduce.py")
    if not os.path.exists(script):
        raise CampaignError("the tables of the READMEs need a clone of the sources, not installed scripts")
    return script


def verdict_on_table(name, status, told):
    """The verdict from the exit status and the last line of reproduce.py on this table."""
    if status == 0:
        last = next((line for line in reversed(told.splitlines()) if line.startswith(name + ": ")), "")
        is_all, is_part = last.startswith(name + ": skipped;"), last.endswith(" skipped")
        return "skipped" if is_all else "partly skipped" if is_part else "as printed"
    return "differs" if status == 3 else "crashed"


def measures_of(summary):
    """MEASURES, and of a run on the whole body the landing force and the exceeded limits of the hardware."""
    body = summary.get("body") or {}
    return {**{key: summary.get(key) for key in MEASURES}, "landing_force_n": body.get("landing_force_n"),
            "hardware_excesses": [excess["what"] for excess in body.get("hardware_excesses", ())]}


def processor_seconds():
    """Processor time of the ended child processes."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def carry_out(task):
    """The lines of one command of `saltus`."""
    lines, here = [], supervisor.machine()
    _run(task, lambda line: lines.append({**line, "machine": here}))
    return lines


def _run(task, say):
    """Runs the command; `say` receives its lines."""
    if task["result"] == TABLE:
        done = subprocess.run(["/usr/bin/python3", "-B", reproduce_script(), program_saltus(), *task["words"],
                               "--jobs", "1"], capture_output=True, text=True, check=False, preexec_fn=end_with_parent)
        verdict = verdict_on_table(task["problem"], done.returncode, done.stdout)
        say({"problem": task["problem"], "instance": 1, "solver": "saltus", "verdict": verdict,
             "claimed": (done.stdout + (done.stderr if verdict == "crashed" else ""))[-2000:]})
        return
    with tempfile.TemporaryDirectory(prefix="saltus-campaign-") as folder:
        words = [program_saltus(), *task["words"], "--out", folder]
        before = processor_seconds()
        done = subprocess.run(words, capture_output=True, text=True, check=False, preexec_fn=end_with_parent)
        base = {"problem": task["problem"], "instance": 1, "solver": "saltus"}
        if task["result"] == MAP_ROWS:
            if not os.path.exists(os.path.join(folder, MAP_ROWS)):
                raise ProgramError(done.stderr.strip() or f"saltus ended with status {done.returncode}")
            with open(os.path.join(folder, MAP_ROWS), encoding="utf-8", newline="") as file:
                reader = csv.DictReader(file)
                rows, columns = list(reader), reader.fieldnames
            with open(os.path.join(folder, "config.yaml"), encoding="utf-8") as file:
                settings = file.read()
            for number, row in enumerate(rows, 1):
                times = {"seconds": float(row.pop("seconds"))} if "seconds" in row else {}
                say({**base, "instance": number, "verdict": row.get("outcome", ""), "row": row, "times": times})
            say({**base, "instance": len(rows) + 1, "verdict": "settings", "settings": settings,
                 "columns": columns})
            return
        summary = {}
        path = os.path.join(folder, "summary.json")
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                summary = json.load(file)
        told = done.stderr.strip() or f"saltus ended with status {done.returncode}"
        if not summary and done.returncode == 2:  # an invalid command is not a result
            raise ProgramError(told)
        times = {"cpu_s": round(processor_seconds() - before, 2)}
        if not summary:
            say({**base, "verdict": "crashed", "claimed": told[-300:], "drawn": task["drawn"], "times": times})
            return
        say({**base, "verdict": "recovered" if summary["recovered"] else "not recovered",
             "drawn": task["drawn"], **measures_of(summary), "times": times})


def task_of(name, words, result, drawn=None):
    return {"id": name, "kind": "command", "problem": name, "solvers": ["saltus"], "words": words,
            "result": result, "drawn": drawn or {}}


def interval(text, what):
    """Parses LOW:HIGH."""
    try:
        low, high = (float(word) for word in text.split(":"))
        if not low <= high:
            raise ValueError
    except ValueError:
        raise CampaignError(f"{what} must be LOW:HIGH, as in 4:10, not '{text}'") from None
    return low, high


def push_tasks(arguments):
    """Random pushes, sensor noise, masses and friction. Run k does not depend on the worker or on the number of runs."""
    impulse = interval(arguments.impulse, "--impulse")
    mass = interval(arguments.mass_error, "--mass-error")
    friction = interval(arguments.friction, "--friction")
    fixed = [word for text in arguments.set or () for word in ("--set", text)]
    tasks = []
    for k in range(1, arguments.runs + 1):
        draw = random.Random(f"{arguments.seed}/{k}")
        angle = draw.uniform(0.0, 2.0 * math.pi)
        drawn = {"push.impulse": round(draw.uniform(*impulse), 3),
                 "push.direction": f"[{math.cos(angle):.6f}, {math.sin(angle):.6f}, 0]",
                 "model.mass_error": round(draw.uniform(*mass), 4)}
        whole_body = arguments.plant != "centroidal"
        if whole_body:
            drawn |= {"simulator.friction": round(draw.uniform(*friction), 4),
                      "sensor.seed": draw.randrange(1, 2 ** 31)}
        words = ["run", "push_recovery", "--plant", arguments.plant, "--pictures", "false", *fixed]
        for key, value in drawn.items():
            words += ["--set", f"{key}={value}"]
        tasks.append(task_of(f"push {k}", words, "summary.json",
                             {**drawn, "direction_deg": round(math.degrees(angle), 2)}))
    return tasks


def map_tasks(arguments):
    """All cells of a survival map. A task has all directions of one impulse, step time and controller."""
    tasks = []
    fixed = [word for text in arguments.set or () for word in ("--set", text)]
    all_times = arguments.step_times.split(",")
    for controller in arguments.controllers.split(","):
        takes_no_step = controller == "none"  # its cells do not depend on the step time
        for step_time in all_times[:1] if takes_no_step else all_times:
            for impulse in arguments.impulses.split(","):
                tasks.append(task_of(
                    f"none {impulse} N s" if takes_no_step else f"{controller} {step_time} s {impulse} N s",
                    ["map", "--all", "--jobs", "1", "--plant", arguments.plant, "--directions",
                     str(arguments.directions), "--impulses", impulse, "--step-times", step_time,
                     "--controllers", controller, "--set", "pictures=false", *fixed], MAP_ROWS))
    return tasks


def listed_tables():
    """The lines that begin with a name and end with the page of the table."""
    listed = subprocess.run(["/usr/bin/python3", "-B", reproduce_script(), program_saltus(), "--list"],
                            capture_output=True, text=True, check=False)
    return listed.stdout.splitlines()


def files_of_tables():
    """Dependencies of the tables besides `saltus`, by name."""
    folder = os.path.dirname(reproduce_script())
    root = os.path.dirname(os.path.dirname(folder))
    pages = set(re.findall(r"\((\S+\.md)\)$", "\n".join(listed_tables()), re.MULTILINE))
    scripts = {os.path.relpath(path, root) for path in glob.glob(os.path.join(folder, "*.py"))}
    beside = {name: os.path.join(os.path.dirname(program_saltus()), name) for name in ("impact_sweep", "step_map")}
    return {**{name: os.path.join(root, name) for name in pages | scripts}, **beside}


def no_such(what, name, names):
    """One sentence on an unknown name."""
    near = difflib.get_close_matches(name, names, 1, 0.4)
    return (f"there is no {what} '{name}'; "
            + (f"did you mean '{near[0]}'?" if near else f"the {what}s are {', '.join(names)}"))


def table_tasks(arguments):
    """One table, or all pictures, of the READMEs per task."""
    names = [line.split()[0] for line in listed_tables()]
    for name in arguments.names:
        if name not in names:
            raise CampaignError(no_such("table", name, names))
    return [task_of(name, [name], TABLE) for name in arguments.names or names]


def wilson(successes, count, z=1.96):
    """Bounds of a proportion at 95 % (Wilson)."""
    p = successes / count
    centre, scale = p + z * z / (2 * count), 1 + z * z / count
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    return max(0.0, (centre - half) / scale), min(1.0, (centre + half) / scale)


def push_table(records):
    """Rows: proportion of recoveries by impulse, with bounds at 95 %, and errors of the recovered runs."""
    lines = [line for line in records.lines() if line["verdict"] != "crashed"]
    if not all("push.impulse" in line.get("drawn", {}) for line in lines):
        raise CampaignError("a run has no push.impulse")
    if not lines:
        raise CampaignError("there are no runs")
    yield ["push, N s", "runs", "recovered", "share", "at 95 %", "CoM error, mm, median", "settling, s, median"]
    groups = {}
    for line in lines:
        groups.setdefault(math.floor(line["drawn"]["push.impulse"]), []).append(line)
    for size in [*sorted(groups), None]:
        of = lines if size is None else groups[size]
        good = [line for line in of if line["verdict"] == "recovered"]
        low, high = wilson(len(good), len(of))

        def median(key, scale, digits):
            values = [line[key] for line in good if line.get(key) is not None]
            return f"{scale * statistics.median(values):.{digits}f}" if values else "-"
        yield ["all" if size is None else f"{size} to {size + 1}", str(len(of)), str(len(good)),
               f"{len(good) / len(of):.3f}", f"{low:.3f} to {high:.3f}",
               median("final_com_error_m", 1e3, 2), median("icp_settling_s", 1.0, 2)]


def write_map(records, folder):
    """Writes map.csv and config.yaml as `saltus map` does. The same command then finds every cell and draws."""
    rows, settings, columns = [], None, None
    for line in records.lines():
        if "row" in line:
            row = dict(line["row"])
            if "seconds" in line.get("times", {}):
                row["seconds"] = line["times"]["seconds"]
            rows.append(row)
        settings, columns = line.get("settings", settings), line.get("columns", columns)
    if not rows or columns is None or settings is None:
        raise CampaignError("there are no cells of the map")
    os.makedirs(folder, exist_ok=True)
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    table, kept = os.path.join(folder, MAP_ROWS), os.path.join(folder, "config.yaml")
    with open(table, "a", encoding="utf-8") as held:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)  # as a running map does
        except OSError:
            raise CampaignError(f"another process is writing the map in '{folder}'; give another --folder") from None
        if os.path.exists(kept):
            with open(kept, encoding="utf-8") as file:
                if file.read() != settings:
                    raise CampaignError(f"'{folder}' contains a map with different settings; give another --folder")
        write_text(kept, settings)
        write_text(table, text.getvalue())
