"""The READMEs' pictures: which runs they show, and how they are drawn."""

import os
import sys

from programs import NotHere, call
from tables import PAPER

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = os.path.join(ROOT, "robots/report/scripts")
DEMO = {"plant": "dart", "pictures": "true"}
SIX = {**PAPER, "plant": "dart", "push.impulse": 6}


def of_the_demo(name):
    def draw(programs):
        return os.path.join(programs.run_folder({"plant": "dart"}, pictures=True), name)
    return draw


def both_controllers(programs):
    mpc = programs.run_folder(SIX)
    baseline = programs.run_folder({**SIX, "controller": "capture_point"})
    out = os.path.join(programs.folder, "mpc_and_baseline.png")
    call([sys.executable, "-B", os.path.join(SCRIPTS, "compare_runs.py"), mpc, baseline, out])
    return out


def impact_table(programs):
    program = os.path.join(os.path.dirname(programs.program), "impact_sweep")
    table = os.path.join(programs.folder, "impact_sweep.csv")
    if not os.path.exists(table):
        if not os.path.exists(program):
            raise NotHere("the program impact_sweep is not built (a target of the build)")
        printed = call([program], good=(0,)).stdout
        with open(table, "w", encoding="utf-8") as file:
            file.write(printed)
    return table


def impact_sweep(programs):
    out = os.path.join(programs.folder, "impact_sweep.png")
    call([sys.executable, "-B", os.path.join(SCRIPTS, "plot_sweep.py"), impact_table(programs), out])
    return out


PICTURES = {
    "docs/com.png": of_the_demo("com.png"),
    "docs/capture_point.png": of_the_demo("capture_point.png"),
    "docs/forces.png": of_the_demo("forces.png"),
    "docs/mpc_and_baseline.png": both_controllers,
    "problems/push_recovery/impact_sweep.png": impact_sweep,
}
