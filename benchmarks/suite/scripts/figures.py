"""Statistics of times: medians with spread, ratios pair by pair, changes beyond noise."""

import math
import statistics

NO_RESULT = ("missing", "not applicable", "skipped", "settings")


def time_of(line):
    """Time of one solve in us: the minimum over its repetitions of the smaller of the thread's CPU time and the
    solver's own timer. Calls from Python do not count against the solver, and its timer may count other processes.
    None if not solved."""
    if line["verdict"] != "solved":
        return None
    times = line["times"]
    if "instructions" in times:  # instructions instead of times
        return statistics.median(times["instructions"])
    return statistics.median(min(pair) for pair in zip(*(times[key] for key in ("cpu_us", "own_us")
                                                         if key in times)))


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
        times = line.get("times", {}).get("cpu_us", [])
        if len(times) > 1:
            wander.append(math.log(max(times) / min(times)))
    noise = max(math.log1p(floor), 2.6 * 1.2533 * spread / math.sqrt(len(logs)),
                statistics.median(wander) if wander else 0.0)
    return math.exp(middle), math.exp(noise)
