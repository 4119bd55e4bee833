"""`bench compare A B`: what got better or worse from A to B beyond noise. Status 1 on a regression."""

import math
import statistics

import figures
import records

FLOOR = 0.05  # changes below are never told: clocks wander
OURS = ("riccati", "sparse", "ipopt")
REFERENCES = 20  # cells of others, of the same versions, from which the machine's own change is told
IN_TURNS = 2  # of them in one task, from which that of the task is


def counts(instructions, machine, floor):
    """Records of instruction counts by task, for compare(): no clock wanders, and `floor` is what is allowed."""
    head = {"format": records.FORMAT, "machine": machine, "floor": floor,
            "matrix": {"tasks": list(instructions), "solvers": ["riccati"]}}
    return records.Records(head, {task: [{"problem": task, "solver": "riccati", "instance": 1, "verdict": "solved",
                                          "times": {"instructions": [count]}}]
                                  for task, count in instructions.items()})


class Machine:
    """How much slower the machine was the second time (other work beside it, another clock), from times of solvers that are not ours and did
    not change between the runs: of a task by the others of that task, which were run in turns, else by all. Nothing is told where they are few."""

    def __init__(self, before, after, old, new):
        by_task = {}
        if before.head.get("packages", {}) == after.head.get("packages", {}):
            for key in old:
                change = figures.change(old[key], new[key], FLOOR) if key in new and key[1] not in OURS else None
                if change:
                    by_task.setdefault(key[0], []).append(math.log(change[0]))
        every = [x for logs in by_task.values() for x in logs]
        self.is_known = len(every) >= REFERENCES
        self.all = statistics.median(every) if self.is_known else 0.0
        self._of = {task: statistics.median(logs) for task, logs in by_task.items() if self.is_known and len(logs) >= IN_TURNS}
        left = [abs(x - self.of(task)) for task, logs in by_task.items() for x in logs]
        # What no solver did wanders by so much.
        self.noise = 2.6 * 1.4826 * statistics.median(left) if self.is_known else 0.0

    def of(self, task):
        return self._of.get(task, self.all)


def compare(before, after, out):
    old, new = figures.by_cell(before), figures.by_cell(after)
    machine = Machine(before, after, old, new)
    if machine.is_known:
        print(f"solvers of others took {math.exp(machine.all):.2f} times as long at the median, beside which theirs wander by "
              f"{math.exp(machine.noise):.2f}: so much is the machine's, and ratios are told without it", file=out)
    worse = better = 0
    are_times_told = False
    for key in old:
        if key not in new:
            continue
        task, solver = key
        solved = [sum(line["verdict"] == "solved" for line in cell) for cell in (old[key], new[key])]
        if solved[0] != solved[1]:
            lost = solved[1] < solved[0]
            worse, better = worse + lost, better + (not lost)
            print(f"{'WORSE ' if lost else 'better'} {task}, {solver}: {solved[0]} of "
                  f"{len(old[key])} solved, now {solved[1]} of {len(new[key])}", file=out)
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
    only = sorted(set(old) ^ set(new))
    if only:
        print(f"{len(only)} cells are in one of the two only, {only[0][0]}, {only[0][1]} "
              "for example", file=out)
    if not set(old) & set(new):
        raise records.RecordsError("the two have no problem and solver in common: nothing can be compared")
    print(f"{len(set(old) & set(new))} cells compared: {worse} worse, {better} better", file=out)
    if are_times_told and not machine.is_known:
        print("without solvers of others in both, what the machine did meanwhile is not told from what the program did: "
              "on a busy one compare two runs of the same program first", file=out)
    if before.head["machine"] != after.head["machine"]:
        print("the machines differ: times say little", file=out)
    return 1 if worse else 0
