"""The READMEs' pictures: which runs they show, and how they are drawn."""

import os
import sys

from programs import SCRIPTS, call
from tables import PAPER

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


def impact_sweep(programs):
    return programs.drawn("impact_sweep", "plot_sweep.py")[1]


PICTURES = {
    "docs/com.png": of_the_demo("com.png"),
    "docs/capture_point.png": of_the_demo("capture_point.png"),
    "docs/forces.png": of_the_demo("forces.png"),
    "docs/mpc_and_baseline.png": both_controllers,
    "problems/push_recovery/impact_sweep.png": impact_sweep,
}
