"""Named experiments of push recovery, repeated over seeds: `bench robustness`. A claim is a rate with its Wilson
interval. All experiments have real drives, measured sensors and the same settings. The controllers know neither the
push nor the ground. A seed determines the sensor noise and all draws of its cases."""

import dataclasses
import fnmatch
import math
import random
import re
import shlex
import statistics
from typing import Callable, Dict

import campaign
from campaign import CampaignError

FIXED = {"drives": "real", "sensors": "measured"}
GRAVITY = 9.81  # m/s^2, as in the simulators
DIRECTIONS = 16
SLOPE = 0.0875  # rise per metre: 5 degrees
DELAY_TICKS = 5  # 10 ms in control periods of 2 ms


def towards_swing_side(impulse):
    """The default direction of the problem."""
    return lambda seed: [(f"{impulse:g} N s", {"push.impulse": impulse})]


def from_two_feet(seed):
    for i in range(DIRECTIONS):
        angle = 2.0 * math.pi * i / DIRECTIONS
        yield f"{360.0 * i / DIRECTIONS:g} degrees", {
            "stance": "both", "push.impulse": 8,
            "push.direction": f"[{math.cos(angle):.6f}, {math.sin(angle):.6f}, 0]"}


# Unknown grounds. The other ground begins 0.11 m beside the stance sole, so that the whole foot lands on it, at about
# 0.17 m. A ground that may be higher begins at 0.18 m, because the lifted foot is above the nearer part; the foot then
# lands across the edge.
NEAR, FAR = 0.11, 0.18
LIFTED = 0.003  # m, to which the ground may rise below the lifted foot
FOOT = (-0.06, 0.12)  # m, heel and toe


def slope(draw):
    """A slope in any direction, as high as the lifted foot allows."""
    forward, side = draw.uniform(-SLOPE, SLOPE), draw.uniform(-SLOPE, SLOPE)
    rise = max(forward * x for x in FOOT) + max(0.0, -side * 0.06)
    return {"simulator.ground_slope_forward": forward, "simulator.ground_slope_side": side,
            "simulator.ground_step_m": min(0.0, LIFTED - rise)}


def height(draw):
    step = draw.uniform(-0.02, 0.02)
    return {"simulator.ground_step_m": step} | ({"simulator.ground_edge_m": FAR} if step > LIFTED else {})


def height_of_3_cm(seed):
    yield "3 cm lower", {"push.impulse": 7, "simulator.ground_edge_m": NEAR, "simulator.ground_step_m": -0.03}
    yield "3 cm higher", {"push.impulse": 7, "simulator.ground_edge_m": FAR, "simulator.ground_step_m": 0.03}


def half_foothold(draw):
    """The ground ends below the middle of the foot, to the side or in front."""
    if draw.random() < 0.5:
        return {"simulator.ground_end_side_m": draw.uniform(0.045, 0.08)}
    return {"simulator.ground_end_forward_m": draw.uniform(0.0, 0.06)}


GROUNDS = {
    "height": height,
    "slope": slope,
    "half foothold": half_foothold,
    "soft": lambda draw: {"simulator.ground_sink_m": draw.uniform(0.001, 0.01)},
    "rough": lambda draw: {"simulator.ground_roughness_m": draw.uniform(0.002, 0.01),
                           "simulator.ground_seed": draw.randrange(1, 2 ** 31), "simulator.ground_edge_m": FAR},
    "low friction": lambda draw: {"simulator.ground_friction": draw.uniform(0.3, 0.6)},
}
MIXED = "mixed"  # two or more of them


def unknown_ground(seed):
    """One case per seed. The kinds alternate, so that any number of seeds has them in equal shares."""
    draw = random.Random(f"unknown_ground/{seed}")
    kinds = [*GROUNDS, MIXED]
    kind = kinds[(seed - 1) % len(kinds)]
    drawn = draw.sample(list(GROUNDS), draw.randint(2, len(GROUNDS))) if kind == MIXED else [kind]
    ground = {"simulator.ground_edge_m": FAR if kind == MIXED else NEAR}
    for one in drawn:
        ground |= GROUNDS[one](draw)
    if ground["simulator.ground_edge_m"] == FAR and "simulator.ground_end_side_m" in ground:
        ground["simulator.ground_end_side_m"] = max(0.01, ground["simulator.ground_end_side_m"] - (FAR - NEAR))
    return [(kind, {"push.impulse": 7} | {key: round(value, 5) for key, value in ground.items()})]


def mismatches(seed):
    """Errors of the controllers' model. A multiple of 1 is 2 Nm of dry friction in the joints of the legs."""
    yield "exact model", {"push.impulse": 7}
    for torque in (0, 1, 3, 4):
        yield f"friction {torque} Nm, compensated 2", {"push.impulse": 7, "drive.friction": torque / 2.0}
    for ratio in (0.7, 1.3):
        yield f"rotor inertia {100 * (ratio - 1):+.0f} %", {"push.impulse": 7, "drive.rotor_inertia": ratio}
    for error in (-0.1, 0.1):
        yield f"model's mass {100 * error:+.0f} %", {"push.impulse": 7, "model.mass_error": error}
    for axis, direction in (("[0.01, 0, 0]", "forward or back"), ("[0, 0.01, 0]", "to a side")):
        yield f"model's CoM 1 cm {direction}", {"push.impulse": 7, "model.com_error": axis}
    yield "torques 10 ms late", {"push.impulse": 7, "simulator.delay_ticks": DELAY_TICKS}


def minute_of_pushes(stance):
    """Ten pushes of 3 to 8 N s in random directions."""
    return lambda seed: [("one minute", {"stance": stance, "push.start": 1, "push.random.rate_hz": 0.16667,
                                         "push.random.seed": seed})]


@dataclasses.dataclass
class Experiment:
    about: str
    cases: Callable  # seed -> pairs of condition and settings
    seeds: Dict[str, int]  # by plant
    quick: int  # seeds of a quick run


EXPERIMENTS = {
    "swing_side_7": Experiment("7 N s from one foot towards the swing side", towards_swing_side(7),
                               {"dart": 100, "mujoco": 20}, 10),
    "swing_side_10": Experiment("10 N s from one foot towards the swing side", towards_swing_side(10),
                                {"dart": 100, "mujoco": 20}, 10),
    "two_feet_8": Experiment(f"8 N s on two feet in {DIRECTIONS} directions (0 is forward, 90 is left)", from_two_feet,
                             {"dart": 5, "mujoco": 1}, 1),
    "unknown_ground": Experiment("7 N s towards the swing side, landing on unknown ground", unknown_ground,
                                 {"dart": 1000, "mujoco": 100}, 28),
    "height_3_cm": Experiment("7 N s towards the swing side, landing on ground 3 cm lower or higher", height_of_3_cm,
                              {"dart": 20, "mujoco": 5}, 1),
    "mismatch": Experiment("7 N s towards the swing side with errors of the controllers' model", mismatches,
                           {"dart": 20, "mujoco": 5}, 1),
    "pushes_one_foot": Experiment("ten random pushes in a minute, at first on one foot", minute_of_pushes("left"),
                                  {"dart": 20, "mujoco": 20}, 1),
    "pushes_two_feet": Experiment("ten random pushes in a minute on two feet", minute_of_pushes("both"),
                                  {"dart": 20, "mujoco": 20}, 1),
}


def tasks_of(arguments):
    """The cases of the named experiments. A case does not depend on the number of seeds."""
    given = {}
    for text in arguments.set or ():
        key, separator, value = text.partition("=")
        if not separator:
            raise CampaignError(f"--set must be KEY=VALUE, not '{text}'")
        given[key] = value
    wanted = arguments.conditions.split(",") if arguments.conditions else ["*"]
    tasks = []
    for name in arguments.names or EXPERIMENTS:
        if name not in EXPERIMENTS:
            raise CampaignError(campaign.no_such("experiment", name, EXPERIMENTS))
        experiment = EXPERIMENTS[name]
        seeds = arguments.seeds or (experiment.quick if arguments.quick else experiment.seeds[arguments.plant])
        for seed in range(1, seeds + 1):
            for condition, settings in experiment.cases(seed):
                if not any(fnmatch.fnmatchcase(condition, pattern) for pattern in wanted):
                    continue
                settings = {**FIXED, "sensor.seed": seed, **settings}
                words = ["run", "push_recovery", "--plant", arguments.plant, "--pictures", "false"]
                for key, value in {**settings, **given}.items():
                    words += ["--set", f"{key}={value}"]
                tasks.append(campaign.task_of(
                    f"{name}, {condition}, seed {seed}", words, "summary.json",
                    {"experiment": name, "condition": condition, "seed": seed, "plant": arguments.plant, **settings}))
    if not tasks:
        raise CampaignError(f"no case has a condition '{arguments.conditions}'; without --conditions all run")
    return tasks


# Kinds of reasons. The first pattern that matches gives the kind.
CAUSES = (
    (r"^crashed", "crashed"), (r"^fell at .*before the push", "fell before the push"), (r"^fell", "fell"),
    (r"foot slipped", "slipped"), (r"angular momentum", "momentum"), (r"CoM (sank|rose)", "CoM height"),
    (r"capture point left|come to rest|missed its target", "not at rest"),
    (r"overlap of", "limb contact"), (r"speed of", "joint speed"), (r"position of", "joint limit"),
    (r"torque of", "joint torque"), (r"moment on the", "sole moment"), (r"force on the", "sole force"))


def cause_of(reason):
    """A fall also names the limit that was exceeded first."""
    last, _, first = reason.partition("; first")
    kind = next((kind for pattern, kind in CAUSES if re.search(pattern, last)), re.sub(r"[\d.]+", "*", last))
    return f"{kind}, first {cause_of(first)}" if first else kind


def is_crashed(line):
    return line["verdict"] == "crashed"


def stands(line):
    return not is_crashed(line) and not line["fell"]


def recovers(line):
    return line["verdict"] == "recovered"


def is_safe(line):
    return not is_crashed(line) and bool(line["hardware_safe"])


def causes_of(line):
    """Kinds of failure by verdict. A run that is not recovered has one cause; hardware can exceed several limits."""
    if is_crashed(line):
        return {"not recovered": ["crashed"]}
    found = {}
    if not recovers(line):
        found["not recovered"] = [cause_of(line["reason"])]
    if not is_safe(line):
        found["not hardware-safe"] = sorted(set(map(cause_of, line["hardware_excesses"])))
    return found


def rate(lines, is_good):
    """`93/100 93.0 % (86.3 to 96.6)`."""
    good = sum(map(is_good, lines))
    low, high = campaign.wilson(good, len(lines))
    return f"{good}/{len(lines)} {100 * good / len(lines):.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def landing_weights(lines):
    return [line["landing_force_n"] / (GRAVITY * line["mass_kg"]) for line in lines
            if not is_crashed(line) and line["touchdown_s"] is not None and line["landing_force_n"] is not None]


def rate_table(lines):
    yield ["condition", "cases", "stand, % (95 %)", "recovered, % (95 %)", "hardware-safe, % (95 %)",
           "landing force, weights: median", "largest"]
    groups = {}
    for line in lines:
        groups.setdefault(line["drawn"]["condition"], []).append(line)
    if len(groups) > 1:
        groups["all"] = lines
    for condition, of in groups.items():
        forces = landing_weights(of)
        yield [condition, str(len(of)), *(rate(of, is_good) for is_good in (stands, recovers, is_safe)),
               *((f"{statistics.median(forces):.2f}", f"{max(forces):.2f}") if forces else ("-", "-"))]


def failures(lines, commands):
    """Two lines for each cause: the number of cases, and a command that repeats one."""
    found = {}
    for line in lines:
        for verdict, kinds in causes_of(line).items():
            for kind in kinds:
                found.setdefault((verdict, kind), []).append(line)
    for (verdict, kind), of in sorted(found.items(), key=lambda item: (item[0][0] != "not recovered", -len(item[1]))):
        drawn = of[0]["drawn"]
        yield (f"{verdict}, {kind}: {len(of)} of {len(lines)}; for example {drawn['condition']}, seed {drawn['seed']}:\n"
               f"  saltus {shlex.join(commands[of[0]['problem']])}")


def write(records, out):
    """A table and the causes of failure for each experiment, and the processor time."""
    import table
    matrix = records.head["matrix"]
    commands = dict(zip(matrix["tasks"], matrix.get("commands", ())))
    lines = records.lines()
    if not lines:
        raise CampaignError("there are no runs")
    if not all("experiment" in line.get("drawn", {}) and line["problem"] in commands for line in lines):
        raise CampaignError("a run belongs to no experiment")
    for name in dict.fromkeys(line["drawn"]["experiment"] for line in lines):
        mine = [line for line in lines if line["drawn"]["experiment"] == name]
        about = EXPERIMENTS[name].about if name in EXPERIMENTS else "an experiment of another version"
        print(f"{name}, {mine[0]['drawn']['plant']}: {about}", file=out)
        table.write_rows(rate_table(mine), out)
        for text in failures(mine, commands):
            print(text, file=out)
        print(file=out)
    seconds = sum(line.get("times", {}).get("cpu_s", 0.0) for line in lines)
    print(f"processor time: {seconds:.0f} s for {len(lines)} runs", file=out)
