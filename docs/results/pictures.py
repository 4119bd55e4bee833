"""The pictures of the READMEs: their runs and how they are drawn."""

import io
import json
import os
import sys

from programs import PACKAGE, ROOT, NotHere, call
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


def moving(programs):
    """The scene of the demo from just before the push until the robot stands again, at half its speed. It shows the
    meshes of icub-models, so that the picture has their licence, CC BY-SA 4.0 (.reuse/dep5)."""
    sys.path.insert(0, PACKAGE)
    from PIL import Image
    from saltus.walking import movie
    run = programs.run_folder({"plant": "dart"}, pictures=True)
    with open(os.path.join(run, "robot.json"), encoding="utf-8") as file:
        if not os.path.exists(json.load(file)["urdf"]):
            raise NotHere("the meshes of iCub come with its official model (./saltus setup fetches it)")
    begin, end = movie.span(run)
    rate = 15  # pictures per second of the run
    try:
        drawn = movie.pictures_of(os.path.join(run, "view.html"), begin + 0.3, end - 0.6, rate)
    except SystemExit as why:  # Chromium is missing or draws nothing
        raise NotHere(str(why)) from None
    pictures = [Image.open(io.BytesIO(picture)) for picture in drawn]
    frames = [picture.crop((140, 0, 540, picture.height)) for picture in pictures]
    out = os.path.join(programs.folder, "push_recovery.webp")
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=[2000 // rate] * (len(frames) - 1) + [1500],
                   loop=0, quality=55, method=6)
    return out


def impact_sweep(programs):
    return programs.drawn("impact_sweep", "plot_sweep")[1]


def of_an_example(name, table, *arguments):
    """Builds as examples/README.md describes."""
    def draw(programs):
        built = os.environ.get("SALTUS_EXAMPLES", os.path.join(ROOT, "examples/build"))
        program = os.path.join(built, f"example_{name}")
        if not os.path.exists(program):
            raise NotHere(f"{program} is not built (see examples/README.md; SALTUS_EXAMPLES may name another folder)")
        out = os.path.join(programs.folder, "examples")
        os.makedirs(out, exist_ok=True)
        call([program], good=(0,), folder=out)
        picture = os.path.join(out, f"{name}.png")
        call([sys.executable, "-B", os.path.join(ROOT, "examples/plot.py"), table, picture, *arguments], folder=out)
        return picture
    return draw


PICTURES = {
    "docs/push_recovery.webp": moving,
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
