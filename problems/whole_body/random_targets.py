"""Plans for random targets: how many are solved, and how many the simulated robot follows without a fall.

Usage: random_targets.py SALTUS [--seed N] [--number N] [--solver NAME] [--track] [TASK...]

SALTUS is the program. Prints a table with Wilson intervals (95 %). The status is 1 if fewer than 95 % of a task are
solved, or if the robot falls.
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "benchmarks/suite/scripts"))
import campaign  # noqa: E402

# Ranges of the targets of each task, in the units of the settings.
TARGETS = {
    "step": {"step.length_m": (-0.1, 0.3), "step.width_m": (0.14, 0.2)},
    "walk": {"step.length_m": (0.05, 0.2), "step.width_m": (0.14, 0.2)},
    "step_up": {"stair.height_m": (0.0, 0.12), "step.width_m": (0.14, 0.2)},
    "ramp": {"ramp.slope_deg": (-8.0, 10.0), "step.width_m": (0.14, 0.2)},
    "turn": {"turn.angle_deg": (-45.0, 45.0), "step.width_m": (0.14, 0.2)},
    "hop": {"step.width_m": (0.14, 0.22)},
}


def solved(program, task, target, arguments, folder):
    settings = [text for name, value in target.items() for text in (f"--{name}", f"{value:.4f}")]
    command = [program, "run", "whole_body", "--task", task, *settings, "--solver", arguments.solver]
    command += ["--track", str(arguments.track).lower(), "--pictures", "false", "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    summary = folder / "summary.json"
    if not summary.exists():
        return {"ok": False, "message": (done.stderr.strip().splitlines() or ["no summary"])[-1]}
    return json.loads(summary.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("tasks", nargs="*", default=list(TARGETS), metavar="TASK")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--number", type=int, default=20)
    parser.add_argument("--solver", default="riccati")
    parser.add_argument("--track", action="store_true", help="simulate the plans in DART")
    arguments = parser.parse_args()
    failed = 0
    print("| task | solved | rate, 95 % | tracked | iterations, median and largest |\n| --- | --- | --- | --- | --- |")
    for task in arguments.tasks:
        draw = random.Random(f"{arguments.seed} {task}")
        results = []
        for _ in range(arguments.number):
            target = {name: draw.uniform(*range_) for name, range_ in TARGETS[task].items()}
            with tempfile.TemporaryDirectory() as folder:
                result = solved(arguments.program, task, target, arguments, pathlib.Path(folder) / "run")
            results.append(result)
            if not result["ok"] or result.get("tracking", {}).get("fell"):
                print(f"{task} {target}: {result['message']}", file=sys.stderr)
        good = [r for r in results if r["ok"]]
        tracked = sum(not r["tracking"]["fell"] for r in good if "tracking" in r)
        low, high = campaign.wilson(len(good), len(results))
        steps = sorted(r["iterations"] for r in good) or [0]
        standing = f"{tracked} of {len(good)}" if arguments.track else "-"
        print(
            f"| {task} | {len(good)} of {len(results)} | {100 * low:.0f} to {100 * high:.0f} % | {standing} "
            f"| {steps[len(steps) // 2]}, {steps[-1]} |",
            flush=True,
        )
        failed += len(good) < 0.95 * len(results) or (arguments.track and tracked < len(good))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
