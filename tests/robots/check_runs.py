#!/usr/bin/env python3
"""Recomputes random runs of push recovery on the whole body with Pinocchio, from their tables and the robot's URDF.

Usage: check_runs.py SALTUS [--runs 10] [--seed 1]. For each run it recomputes mass, CoM, momentum and the soles from
base and joints, integrates the forces of ground and push over time, and locates the centre of pressure in the soles.
Exits with 77, "skipped", if the package pin (PyPI) is missing, and with 1 if a deviation is too large.
"""

import argparse
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile

SKIPPED = 77
GRAVITY = 9.81  # m/s^2
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
LOADED = 20.0  # N; below it the centre of pressure has no meaning
SUNK = 0.8  # of the initial height of the CoM; below it a falling robot may touch the ground with its limbs
# Largest deviations. Positions agree to rounding. Velocities come from differences over two control periods, and
# impulses from one force per period, so a landing leaves errors there; these are root mean squares over the run. A
# sole that tilts touches the ground with the edge of its box, which is slightly outside the rectangle.
LIMITS = {"mass, kg": 1e-9, "CoM, m": 1e-9, "pose of soles": 1e-9, "velocity of CoM, m/s": 5e-3,
          "angular momentum, Nms": 0.05, "linear impulse, N s": 0.1, "angular impulse, Nms": 0.1,
          "centre of pressure outside sole, m": 1e-3}

try:
    import numpy as np
    import pinocchio as pin
except ImportError:
    print("skipped: this python3 has no Pinocchio (package pin of PyPI)")
    sys.exit(SKIPPED)


def columns_of(path):
    """Name without unit -> values."""
    with open(path, encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    values = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return {name.split(" [")[0]: values[:, i] for i, name in enumerate(header)}


def vectors(table, prefix, names):
    return np.column_stack([table[f"{prefix}{name}"] for name in names])


def poses(table, prefix):
    quaternions = vectors(table, prefix, ("qx", "qy", "qz", "qw"))
    return [pin.SE3(pin.Quaternion(q).matrix(), p) for q, p in zip(quaternions, vectors(table, prefix, "xyz"))]


def pose_of(described):
    return pin.SE3(pin.Quaternion(*described["rotation"]).matrix(), np.array(described["position"]))


def model_of(urdf, joints):
    """The free-floating robot with all other joints frozen at zero."""
    model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    return pin.buildReducedModel(model, [i for i in range(2, model.njoints) if model.names[i] not in joints],
                                 pin.neutral(model))


def beyond_edges(sole, wrench):
    """Largest distance of the centre of pressure from the sole's rectangle, in the axes of the sole."""
    loaded = wrench[wrench[:, 2] > LOADED]
    if not len(loaded):
        return 0.0
    places = np.column_stack([-loaded[:, 4], loaded[:, 3]]) / loaded[:, 2:3]
    edges = np.array([sole["foot_x"], sole["foot_y"]])
    return max(0.0, (edges[:, 0] - places).max(), (places - edges[:, 1]).max())


def rms(error):
    return math.sqrt(float(np.mean(error ** 2)))


def deviations(folder):
    """The deviations of one run, by the names of LIMITS."""
    with open(os.path.join(folder, "robot.json"), encoding="utf-8") as file:
        robot = json.load(file)
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    body, centre = (columns_of(os.path.join(folder, name)) for name in ("body.csv", "trajectory.csv"))
    joints = [body_["joint"] for body_ in robot["bodies"] if body_["joint"]]
    model = model_of(robot["urdf"], joints)
    data, t = model.createData(), body["t"]
    mass, pushed = pin.computeTotalMass(model), model.getFrameId(summary["push_link"])
    q = np.tile(pin.neutral(model), (len(t), 1))
    q[:, :7] = vectors(body, "base_", ("x", "y", "z", "qx", "qy", "qz", "qw"))
    for joint in joints:
        q[:, model.joints[model.getJointId(joint)].idx_q] = body["q_" + joint]
    soles = {side: (model.getJointId(robot["bodies"][robot[side]["body"]]["joint"]), pose_of(robot[side]),
                    poses(body, side + "_"), vectors(body, side.replace("sole", "measured_"), WRENCH))
             for side in ("left_sole", "right_sole")}
    com, momentum, rate = np.zeros((len(t), 3)), np.zeros((len(t), 6)), np.zeros((len(t), 6))
    push, place = vectors(centre, "push_", "xyz"), 0.0
    for k, row in enumerate(q):
        before, after = max(k - 1, 0), min(k + 1, len(t) - 1)
        speed = pin.difference(model, q[before], q[after]) / (t[after] - t[before])
        momentum[k] = pin.computeCentroidalMomentum(model, data, row, speed).vector
        com[k] = data.com[0]
        rate[k, :3] = push[k] - [0.0, 0.0, mass * GRAVITY]
        at = pin.updateFramePlacement(model, data, pushed).act(np.array(summary["push_point"]))
        rate[k, 3:] = np.cross(at - com[k], push[k])
        for joint, offset, seen, wrench in soles.values():
            sole = data.oMi[joint] * offset
            place = max(place, np.abs(sole.homogeneous - seen[k].homogeneous).max())
            force = sole.rotation @ wrench[k, :3]
            rate[k] += [*force, *(np.cross(sole.translation - com[k], force) + sole.rotation @ wrench[k, 3:])]
    outside = max(beyond_edges(robot[side], wrench) for side, (*_, wrench) in soles.items())
    told = np.hstack([mass * vectors(centre, "vel_", "xyz"), vectors(centre, "h_", "xyz")])
    wrong = (momentum - told)[1:-1]  # at the ends there is only a one-sided difference
    gained = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t)[:, None], axis=0)
    sunk = np.flatnonzero(com[:, 2] < SUNK * com[0, 2])
    missing = (told[1:] - told[0] - gained)[:sunk[0] if len(sunk) else None]
    return {"mass, kg": abs(mass - summary["mass_kg"]), "CoM, m": np.abs(com - vectors(centre, "com_", "xyz")).max(),
            "pose of soles": place, "velocity of CoM, m/s": rms(wrong[:, :3]) / mass,
            "angular momentum, Nms": rms(wrong[:, 3:]), "linear impulse, N s": rms(missing[:, :3]),
            "angular impulse, Nms": rms(missing[:, 3:]), "centre of pressure outside sole, m": outside}


def settings_of(draw, number):
    angle = draw.uniform(0.0, 2.0 * math.pi)
    return {"plant": ("dart", "mujoco")[number % 2], "drives": ("ideal", "real")[number // 2 % 2],
            "stance": draw.choice(("left", "right", "both")), "push.start": 1, "push.impulse": round(draw.uniform(3, 12), 3),
            "push.direction": f"[{math.cos(angle):.6f}, {math.sin(angle):.6f}, 0]", "sensor.seed": draw.randrange(1, 2 ** 31)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("saltus")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    draw, is_good = random.Random(arguments.seed), True
    print(f"{arguments.runs} runs, seed {arguments.seed}, Pinocchio {pin.__version__}")
    for number in range(arguments.runs):
        settings = settings_of(draw, number)
        with tempfile.TemporaryDirectory(prefix="saltus-check-") as folder:
            words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
            done = subprocess.run([arguments.saltus, "run", "push_recovery", "--quiet", "--pictures", "false", *words,
                                   "--out", folder], capture_output=True, text=True, check=False)
            if done.returncode not in (0, 3):
                print(f"saltus ended with status {done.returncode}: {done.stderr.strip()}")
                return 1
            found = deviations(folder)
        bad = [name for name, value in found.items() if not value <= LIMITS[name]]
        is_good = is_good and not bad
        print(" ".join(f"{key}={value}" for key, value in settings.items()))
        for name, value in found.items():
            print(f"  {name:<36}{value:.1e}{'  TOO LARGE' if name in bad else ''}")
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
