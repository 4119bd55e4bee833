"""Finds the largest push in each direction from which the robot recovers on two feet, with two controllers: the whole-body
plans of task recover, and the planner of push_recovery. Both runs simulate the whole body in DART, with ideal drives and
the true state.

Usage: push_map.py SALTUS [--directions 16] [--jobs N] [--out map.csv]

SALTUS is the program. In each direction the impulse rises from 4 N s in steps of 2 N s until the robot does not recover.
One more run then tries half a step less. Prints a table with two impulses per direction and controller. Up to the first
one all runs recovered. Up to the second one no joint exceeded its speed limit either. The last row contains the areas of
the polar maps.
"""

import argparse
import concurrent.futures
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

FIRST, STEP, MOST = 4.0, 2.0, 40.0  # N s
CONTROLLERS = {
    "whole-body plans": ["whole_body", "--task", "recover"],
    "push_recovery": ["push_recovery", "--plant", "dart", "--stance", "both", "--drives", "ideal", "--sensors", "ideal"],
}
AT_REST = 0.02  # distance of the CoM from its plan at the end, m


def run(program, controller, direction, impulse):
    """(True if the robot recovered, True if no joint exceeded its speed limit)."""
    towards = f"[{math.cos(direction):.9f}, {math.sin(direction):.9f}, 0]"
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", *CONTROLLERS[controller], "--push.start", "0.3", "--push.impulse", f"{impulse}"]
        command += ["--push.direction", towards, "--pictures", "false", "--out", f"{folder}/run"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        summary = pathlib.Path(folder, "run/summary.json")
        if not summary.exists():
            sys.exit(f"push_map: {' '.join(command)} failed: {done.stderr.strip()}")
        result = json.loads(summary.read_text(encoding="utf-8"))
    if controller == "push_recovery":
        return result["recovered"], result["body"]["joint_speed_ratio_max"] <= 1.0
    tracking = result["tracking"]
    recovered = not tracking["fell"] and tracking["distance_of_com_at_end_m"] < AT_REST
    return recovered, tracking["largest_speed_over_limit"]["value"] <= 1.0


def largest(program, controller, direction):
    """The largest impulses from which the robot recovers: at any joint speed, and within the speed limits."""
    recovered_at, slow_at, slow = 0.0, 0.0, True
    impulse = FIRST
    while impulse <= MOST:
        recovered, within = run(program, controller, direction, impulse)
        if not recovered:
            break
        slow = slow and within
        recovered_at, slow_at = impulse, impulse if slow else slow_at
        impulse += STEP
    middle = recovered_at + 0.5 * STEP
    recovered, within = run(program, controller, direction, middle)
    if recovered:
        recovered_at, slow_at = middle, middle if slow and within else slow_at
    return recovered_at, slow_at


def area(radii):
    angle = 2.0 * math.pi / len(radii)
    return 0.5 * math.sin(angle) * sum(a * b for a, b in zip(radii, radii[1:] + radii[:1]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--directions", type=int, default=16)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, help="also write the table as CSV")
    arguments = parser.parse_args()
    angles = [360.0 * i / arguments.directions for i in range(arguments.directions)]
    cases = [(controller, angle) for angle in angles for controller in CONTROLLERS]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        found = pool.map(lambda case: largest(arguments.program, case[0], math.radians(case[1])), cases)
        results = dict(zip(cases, found))
    columns = [(controller, which) for controller in CONTROLLERS for which in (0, 1)]
    titles = [f"{controller}, {('recovered', 'within speeds')[which]}" for controller, which in columns]
    rows = [[f"{angle:g}", *(f"{results[c, angle][which]:g}" for c, which in columns)] for angle in angles]
    areas = [area([results[c, angle][which] for angle in angles]) for c, which in columns]
    print(f"| direction, degrees | {' | '.join(title + ', N s' for title in titles)} |\n|{' --- |' * (len(titles) + 1)}")
    for row in [*rows, ["area, (N s)^2", *(f"{value:.0f}" for value in areas)]]:
        print(f"| {' | '.join(row)} |")
    if arguments.out:
        with arguments.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([["direction [deg]", *(f"{title} [N s]" for title in titles)], *rows])


if __name__ == "__main__":
    main()
