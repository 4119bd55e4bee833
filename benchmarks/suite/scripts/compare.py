"""`bench compare A B`: what got better or worse from A to B beyond noise. Status 1 on a regression."""

import figures
import records

FLOOR = 0.05  # changes below are never told: clocks wander


def counts(instructions, machine, floor):
    """Records of instruction counts by task, for compare(): no clock wanders, and `floor` is what is allowed."""
    head = {"format": records.FORMAT, "machine": machine, "floor": floor,
            "matrix": {"tasks": list(instructions), "solvers": ["riccati"]}}
    return records.Records(head, {task: [{"problem": task, "solver": "riccati", "instance": 1, "verdict": "solved",
                                          "times": {"instructions": [count]}}]
                                  for task, count in instructions.items()})


def compare(before, after, out):
    old, new = figures.by_cell(before), figures.by_cell(after)
    worse = better = 0
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
        ratio, noise = found
        if ratio > noise or ratio < 1.0 / noise:
            slower = ratio > 1.0
            worse, better = worse + slower, better + (not slower)
            what = "instructions" if "instructions" in new[key][0].get("times", {}) else "time"
            print(f"{'WORSE ' if slower else 'better'} {task}, {solver}: {ratio:.2f} times the "
                  f"{what}, noise {noise:.2f}", file=out)
    only = sorted(set(old) ^ set(new))
    if only:
        print(f"{len(only)} cells are in one of the two only, {only[0][0]}, {only[0][1]} "
              "for example", file=out)
    print(f"{len(set(old) & set(new))} cells compared: {worse} worse, {better} better", file=out)
    if before.head["machine"] != after.head["machine"]:
        print("the machines differ: times say little", file=out)
    return 1 if worse else 0
