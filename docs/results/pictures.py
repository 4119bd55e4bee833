"""The READMEs' pictures: which runs they show, and how they are drawn."""

import os
import sys

from programs import ROOT, NotHere, call
from programs import draw as draw_module
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
    draw_module("compare_runs", mpc, baseline, out)
    return out


def impact_sweep(programs):
    return programs.drawn("impact_sweep", "plot_sweep")[1]


def of_an_example(name, table, *arguments):
    """As examples/README.md says it."""
    def draw(programs):
        built = os.environ.get("SALTUS_EXAMPLES", os.path.join(ROOT, "examples/build"))
        program = os.path.join(built, f"example_{name}")
        if not os.path.exists(program):
            raise NotHere(f"{program} is not built (examples/README.md says how; SALTUS_EXAMPLES names another folder)")
        out = os.path.join(programs.folder, "examples")
        os.makedirs(out, exist_ok=True)
        call([program], good=(0,), folder=out)
        picture = os.path.join(out, f"{name}.png")
        call([sys.executable, "-B", os.path.join(ROOT, "examples/plot.py"), table, picture, *arguments], folder=out)
        return picture
    return draw


PICTURES = {
    "docs/com.png": of_the_demo("com.png"),
    "docs/capture_point.png": of_the_demo("capture_point.png"),
    "docs/forces.png": of_the_demo("forces.png"),
    "docs/mpc_and_baseline.png": both_controllers,
    "problems/push_recovery/impact_sweep.png": impact_sweep,
    "examples/car.png": of_an_example("car", "car.csv", "--inputs", "2"),
    "examples/heating.png": of_an_example("heating", "heating/trajectory.csv", "--inputs", "1", "--time", "t [h]", "--shade",
                                           "8", "18", "--shade", "30", "42"),
    "examples/ball.png": of_an_example("ball", "ball.csv", "--path", "distance [m]", "height [m]"),
    "examples/stance.png": of_an_example("stance", "stance.csv", "--inputs", "2"),
    "examples/crane.png": of_an_example("all_solvers", "crane.csv", "--inputs", "1"),
}
