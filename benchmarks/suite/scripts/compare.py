"""`bench compare A B`: improvements and regressions from A to B beyond noise. Status 1 on a regression."""

import json
import math
import statistics

import figures
import records

FLOOR = 0.05  # smaller changes are not reported: clocks vary
OURS = ("riccati", "riccati-generic", "sparse", "ipopt")
REFERENCES = 20  # cells of other solvers, of the same versions, from which the change of the machine is estimated
GOOD = {None: ("solved",), "pushes": ("recovered",), "robustness": ("recovered",), "map": ("recovered",),
        "reproduce": ("as printed", "partly skipped")}  # good verdicts, by campaign
IN_TURNS = 2  # cells of other solvers in one task, from which the change in that task is estimated


def counts(instructions, machine, floor):
    """Records of instruction counts by task, for compare(). They have no noise; `floor` is the permitted change."""
    head = {"format": records.FORMAT, "machine": machine, "floor": floor,
            "matrix": {"tasks": list(instructions), "solvers": ["riccati"]}}
    return records.Records(head, {task: [{"problem": task, "solver": "riccati", "instance": 1, "verdict": "solved",
                                          "times": {"instructions": [count]}}]
                                  for task, count in instructions.items()})


class Machine:
    """Estimates the slowdown of the machine in the second run (other load, another clock) from solvers that are not
    ours and did not change. The estimate of a task uses the other solvers of that task, which ran alternately, or
    all of them. There is no estimate from few solvers."""

    def __init__(self, before, after, old, new):
        by_task = {}
        if not records.what_differs(before.head, after.head, ("packages", "inputs")):
            for key in old:
                change = figures.change(old[key], new[key], FLOOR) if key in new and key[1] not in OURS else None
                if change:
                    by_task.setdefault(key[0], []).append(math.log(change[0]))
        every = [x for logs in by_task.values() for x in logs]
        self.is_known = len(every) >= REFERENCES
        self.all = statistics.median(every) if self.is_known else 0.0
        self._of = {task: statistics.median(logs) for task, logs in by_task.items() if self.is_known and len(logs) >= IN_TURNS}
        left = [abs(x - self.of(task)) for task, logs in by_task.items() for x in logs]
        # This variation is not caused by a solver.
        self.noise = 2.6 * 1.4826 * statistics.median(left) if self.is_known else 0.0

    def of(self, task):
        return self._of.get(task, self.all)


def in_both(cell, other):
    """Lines of the instances that both runs have. A task that failed as a whole (instance 0) stands for all instances."""
    there = {line["instance"] for line in other}
    return [line for line in cell if line["instance"] in there or 0 in (line["instance"], *there)]


def refuse_what_cannot_be_compared(before, after, old, new):
    accepted = [records_.head["matrix"].get("tolerance") for records_ in (before, after)]
    if accepted[0] != accepted[1]:
        raise records.RecordsError(f"the two runs have different tolerances, {accepted[0]} and {accepted[1]}, so they "
                                   "cannot be compared")
    clocks = {"wall_us" in line["times"] for cells in (old, new) for lines in cells.values() for line in lines
              if "cpu_us" in line.get("times", {})}
    if len(clocks) > 1:
        raise records.RecordsError("one of the two runs has no wall times, because an older version made it; repeat it")
    for key in old:
        drawn = [{json.dumps(line["drawn"]) for line in cells.get(key, []) if "drawn" in line} for cells in (old, new)]
        if all(drawn) and drawn[0] != drawn[1]:
            raise records.RecordsError(f"'{key[0]}' has different random draws in the two runs (seed, ranges, plant), so "
                                       "they cannot be compared")
    if not any(in_both(old[key], new[key]) for key in old if key in new):
        raise records.RecordsError("the two runs have no problem and solver in common")


def compare(before, after, out):
    old, new = figures.by_cell(before), figures.by_cell(after)
    refuse_what_cannot_be_compared(before, after, old, new)
    good = GOOD.get(before.head["matrix"].get("campaign"), GOOD[None])
    machine = Machine(before, after, old, new)
    if machine.is_known:
        print(f"other solvers took {math.exp(machine.all):.2f} times as long in the median, with a spread of a factor of "
              f"{math.exp(machine.noise):.2f}; the ratios are corrected by this factor of the machine", file=out)
    worse = better = compared = 0
    only = [key for key in (*old, *new) if key not in old or key not in new]
    are_times_told = False
    for key in old:
        if key not in new:
            continue
        task, solver = key
        both = in_both(old[key], new[key]), in_both(new[key], old[key])
        if not all(both):
            only.append(key)
            continue
        compared += 1
        solved = [sum(line["verdict"] in good for line in cell) for cell in both]
        if solved[0] != solved[1]:
            lost = solved[1] < solved[0]
            worse, better = worse + lost, better + (not lost)
            print(f"{'WORSE ' if lost else 'better'} {task}, {solver}: {solved[0]} of "
                  f"{len(both[0])} {good[0]}, now {solved[1]} of {len(both[1])}", file=out)
        found = figures.change(old[key], new[key], before.head.get("floor", FLOOR))
        if found is None:
            continue
        ratio, noise = found[0] / math.exp(machine.of(task)), max(found[1], math.exp(machine.noise))
        if ratio > noise or ratio < 1.0 / noise:
            slower = ratio > 1.0
            worse, better = worse + slower, better + (not slower)
            what = "instructions" if "instructions" in new[key][0].get("times", {}) else "time"
            are_times_told = are_times_told or what == "time"
            print(f"{'WORSE ' if slower else 'better'} {task}, {solver}: {ratio:.2f} times the "
                  f"{what}, noise {noise:.2f}", file=out)
    if only:
        example = min(only)
        print(f"{len(only)} cells are in only one of the two runs, for example {example[0]}, {example[1]}", file=out)
    print(f"{compared} cells compared: {worse} worse, {better} better", file=out)
    if are_times_told and not machine.is_known:
        print("without other solvers in both runs, changes of the machine are not separated from changes of the program: "
              "on a busy machine, compare two runs of the same program first", file=out)
    other = records.what_differs(before.head, after.head, ("inputs",))
    if other:
        print(f"their {other}, so the solved programs may differ too", file=out)
    if before.head["machine"] != after.head["machine"]:
        print("the machines differ, so their times are not comparable", file=out)
    return 1 if worse else 0
