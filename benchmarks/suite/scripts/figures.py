"""Statistics of times: medians with spread, ratios pair by pair, changes beyond noise."""

import math
import statistics

NO_RESULT = ("missing", "not applicable", "skipped", "settings")


AGREE = 0.05  # processor time that differs less from the wall time replaces it


def reported(wall, cpu):
    """The time that counts: wall time, which nothing escapes, or the processor time of the process if it agrees."""
    return cpu if abs(wall - cpu) <= AGREE * wall else wall


def repetitions(line, prefix=""):
    """Reported times of the repetitions of an answer in us, whether it is solved or not. With the prefix "default_": of
    the default setting. Counts of instructions are used in the same way."""
    times = line.get("times", {})
    if "instructions" in times:
        return times["instructions"]
    return [reported(*pair) for pair in zip(times.get(prefix + "wall_us", ()), times.get(prefix + "cpu_us", ()))]


def time_of(line, prefix=""):
    """Time of one solve in us: the median over its repetitions. None if not solved."""
    found = repetitions(line, prefix)
    return statistics.median(found) if found and line["verdict"] == "solved" else None


MANY, AT_LEAST_US = 10.0, 1e3  # ratio and time of work outside of the timed call that lead to a remark
PROCESSORS = 1.2


def remarks(line):
    """Sentences on work that the reported time of an answer does not show."""
    times = line.get("times", {})
    wall, cpu = (statistics.median(times[key]) if times.get(key) else 0.0 for key in ("wall_us", "cpu_us"))
    if not wall or "first_us" not in times:
        return []
    found = []
    for us, call, sentence in ((times.get("reading_us", 0.0), times["first_us"], "it works outside of its timed call"),
                               (times["first_us"], wall, "its first solve takes much longer than the next ones of the same program")):
        if us > max(MANY * call, call + AT_LEAST_US):
            found.append(sentence)
    if cpu > max(PROCESSORS * wall, wall + AT_LEAST_US):
        found.append("it uses several processors at a time")
    return found


def all_remarks(lines):
    """Texts `SOLVER: SENTENCE (N tasks, NAME for example)`. A sentence must hold for most answers of a task, because other
    load makes some times long."""
    answers, found = {}, {}
    for line in lines:
        if "first_us" in line.get("times", {}):
            answers.setdefault((line["solver"], line["problem"]), []).append(remarks(line))
    for (solver, problem), of in answers.items():
        for sentence in dict.fromkeys(s for sentences in of for s in sentences):
            if 2 * sum(sentence in sentences for sentences in of) > len(of):
                found.setdefault((solver, sentence), []).append(problem)
    return [f"{solver}: {sentence} ({len(of)} tasks, {of[0]} for example)" for (solver, sentence), of in found.items()]


def by_cell(records):
    """(task, solver) -> lines of its instances, without those that could not be run."""
    cells = {}
    for task, lines in records.tasks.items():
        for line in lines:
            if line["verdict"] not in NO_RESULT:
                cells.setdefault((task, line["solver"]), []).append(line)
    return cells


def quartiles(values):
    values = sorted(values)

    def at(fraction):
        place = fraction * (len(values) - 1)
        low = math.floor(place)
        high = min(low + 1, len(values) - 1)
        return values[low] + (place - low) * (values[high] - values[low])
    return at(0.25), at(0.5), at(0.75)


def ratios(lines, others):
    """Time divided by the time of another solver on the same instance, if both solved it."""
    there = {line["instance"]: time_of(line) for line in others}
    return [time_of(line) / there[line["instance"]] for line in lines
            if time_of(line) and there.get(line["instance"])]


def change(before, after, floor):
    """(median ratio after / before, noise as a factor). A change is significant if the ratio is outside [1 / noise,
    noise]."""
    found = ratios(after, before)
    if not found:
        return None
    logs = [math.log(r) for r in found]
    middle = statistics.median(logs)
    spread = 1.4826 * statistics.median(abs(x - middle) for x in logs)
    # Repetitions of an instance within one cell show the variation of times without any change.
    wander = []
    for line in (*before, *after):
        times = repetitions(line)
        if len(times) > 1:
            wander.append(math.log(max(times) / min(times)))
    noise = max(math.log1p(floor), 2.6 * 1.2533 * spread / math.sqrt(len(logs)),
                statistics.median(wander) if wander else 0.0)
    return math.exp(middle), math.exp(noise)
