"""Results as lines of JSON: a head with everything needed to repeat the run, then the lines of the tasks, each closed
by {"done": ID}."""

import json
import os

from package import whole_file

FORMAT = "saltus-bench 1"
LONGEST = 1 << 28  # longest line in characters
NAMED = 4  # longest list of differences


class RecordsError(Exception):
    """An invalid results file; the message is one sentence."""


class Records:
    """`tasks`: lines of every complete task, by its id. `cut_off`: True if incomplete lines were dropped."""

    def __init__(self, head, tasks=None, cut_off=False):
        self.head, self.tasks, self.cut_off = head, tasks or {}, cut_off

    def lines(self):
        return [line for task in self.tasks.values() for line in task]


def _is_head(head):
    matrix = head.get("matrix")
    return (isinstance(matrix, dict) and all(isinstance(matrix.get(key), list) for key in ("tasks", "solvers"))
            and all(isinstance(head.get(key), dict) for key in ("machine", "packages", "saltus")))


def _is_line(line):
    """True for a line of a solver on an instance, of a run of a campaign, or of the end of a task."""
    if not isinstance(line, dict):
        return False
    if "done" in line:
        return isinstance(line["done"], str)
    times = line.get("times", {})
    return (all(isinstance(line.get(key), str) for key in ("problem", "solver", "verdict"))
            and isinstance(line.get("instance"), int) and isinstance(times, dict)
            and all(isinstance(values, (list, float, int)) for values in times.values()))


def read(path):
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            raw = file.read(LONGEST + 1)
    except OSError as error:
        raise RecordsError(f"'{path}' cannot be read: {error.strerror}") from None
    if len(raw) > LONGEST:
        raise RecordsError(f"'{path}' has more than {LONGEST >> 20} MB, too many for results of `saltus bench`")
    lines = raw.splitlines()
    try:
        head = json.loads(lines[0])
        kind = head.get("format")
    except (IndexError, AttributeError, RecursionError, json.JSONDecodeError):
        raise RecordsError(f"'{path}' contains no results of `saltus bench run`") from None
    if kind != FORMAT:
        raise RecordsError(f"'{path}' has the format '{kind}' but this version reads "
                           f"'{FORMAT}': run it again, or use the version that wrote it")
    if not _is_head(head):
        raise RecordsError(f"'{path}' is incomplete: its first line lacks machine, matrix or packages")
    tasks, open_lines = {}, []
    for number, text in enumerate(lines[1:], 2):
        try:
            line = json.loads(text)
        except (RecursionError, json.JSONDecodeError):
            break  # the end of the file was not written completely
        if not _is_line(line):
            raise RecordsError(f"'{path}': line {number} is not a result of `saltus bench run`")
        if "done" in line:
            tasks[line["done"]] = open_lines
            open_lines = []
        else:
            open_lines.append(line)
    return Records(head, tasks, cut_off=bool(open_lines) or (bool(raw) and raw[-1] != "\n"))


MADE_BY = {None: "`bench run`", "pushes": "`bench pushes`", "robustness": "`bench robustness`", "map": "`bench map`",
           "reproduce": "`bench reproduce`"}


def read_of(path, campaign):
    """Reads results of this campaign, or of `bench run` (None), that are complete enough to report. Raises
    RecordsError."""
    found = read(path)
    matrix, kind = found.head["matrix"], found.head["matrix"].get("campaign")
    if kind != campaign:
        raise RecordsError(f"'{path}' contains results of {MADE_BY.get(kind, 'something else')}, not of {MADE_BY[campaign]}")
    if campaign is None and not (isinstance(matrix.get("tolerance"), (int, float)) and isinstance(matrix.get("horizons"), dict)
                                 and {"instances", "repetitions"} <= set(matrix)):
        raise RecordsError(f"'{path}' is incomplete: its matrix lacks instances, repetitions, horizons or tolerance")
    return found


def task_text(task, lines):
    return "".join(json.dumps(line) + "\n" for line in [*lines, {"done": task}])


def append(path, task, lines):
    """Appends at once, so an interrupted run leaves complete tasks and at most one incomplete task."""
    with open(path, "a", encoding="utf-8") as file:
        file.write(task_text(task, lines))
        file.flush()
        os.fsync(file.fileno())


def write(path, records, order):
    """Lines in the order of the matrix."""
    with whole_file(path) as partial, open(partial, "w", encoding="utf-8") as file:
        file.write(json.dumps(records.head) + "\n")
        for task in order:
            if task in records.tasks:
                file.write(task_text(task, records.tasks[task]))


def what_differs(head, other, keys):
    """Differences between two heads of results, as text: `matrix differs (tolerance)`. Empty if they are equal."""
    told = []
    for key in keys:
        a, b = head.get(key) or {}, other.get(key) or {}
        if a == b:
            continue
        parts = []
        if isinstance(a, dict) and isinstance(b, dict):
            parts = sorted(part for part in {*a, *b} if a.get(part) != b.get(part))
        if len(parts) > NAMED:
            parts[NAMED:] = [f"{len(parts) - NAMED} more"]
        told.append(f"{key} differ" + ("" if key.endswith("s") and key != "saltus" else "s")
                    + (f" ({', '.join(parts)})" if parts else ""))
    return ", its ".join(told)


def all_of(parts):
    """Combines the descriptions of several machines or programs. Values that differ are joined into one text."""
    found = {}
    for key in parts[0]:
        values = list(dict.fromkeys(str(part.get(key, "")) for part in parts))
        found[key] = parts[0][key] if len(values) == 1 else "; ".join(values)
    return found


def without_program(head):
    """Each machine may have built the program itself, so the program file of one commit may differ."""
    known = head["saltus"].get("commit", "unknown") != "unknown"
    return {**head, "saltus": {**head["saltus"], "program": ""}} if known else head


def merge(paths):
    """Merges shards of one matrix. Also returns sentences on differences. Raises RecordsError."""
    all_records = [read(path) for path in paths]
    heads = [records.head for records in all_records]
    for path, head in zip(paths, heads):
        other = what_differs(*map(without_program, (heads[0], head)), ("matrix", "saltus", "packages", "inputs"))
        if other:
            raise RecordsError(f"'{path}' does not belong to the same run as '{paths[0]}': its {other}")
    machine, saltus = (all_of([head[key] for head in heads]) for key in ("machine", "saltus"))
    merged, notes = Records({**heads[0], "machine": machine, "saltus": saltus, "shard": None}), []
    for records in all_records:
        merged.tasks.update(records.tasks)
    if machine != heads[0]["machine"]:
        notes.append(f"the shards come from different machines ({machine.get('processor')}), so their times are not "
                     "comparable")
    if saltus != heads[0]["saltus"]:
        notes.append(f"the shards come from different builds of the commit {saltus.get('commit')}: their program files "
                     "differ")
    return merged, notes
