"""Numbers in the READMEs' prose: the words around them, and the runs that they come from."""

import math
import os
import re
import statistics

from other_tables import OTHER_TABLES
from programs import ROOT, NotHere, rows_of
from sentence import Sentence
from tables import ROBOT, TABLES, as_it_is, in_dart, look_up, push, toward


def momentum(summary):
    return summary["angular_momentum_max"]


def all_recovered(summaries):
    """Nothing if so; else whom to look at, which no README says."""
    return "".join(f" NOT SO: {s['push_impulse_ns']:g} N s: {s['reason']}" for s in summaries if not s["recovered"])


def furthest(summary):
    """The largest distance of the capture point from where it was when the push began, m."""
    rows = [(float(r["t"]), float(r["icp_x"]), float(r["icp_y"]))
            for r in rows_of(summary["folder"], "trajectory.csv")]
    _, x, y = next(r for r in rows if r[0] > summary["push_start_s"] - 1e-9)
    return max(math.hypot(r[1] - x, r[2] - y) for r in rows)


def early(size, **settings):
    """Pushed at 0.3 s, which spares two seconds of standing."""
    return in_dart(size, push__start=0.3, **settings)


def unless(claim):
    """Nothing if the claim holds."""
    return "" if claim else " NOT SO"


def most(summaries, key):
    return max(look_up(summary, key) for summary in summaries)


def least(summaries, key):
    return min(look_up(summary, key) for summary in summaries)


def column(summary, name, table="trajectory.csv"):
    return [float(row[name]) for row in rows_of(summary["folder"], table)]


def excursion(values):
    return max(abs(value - values[0]) for value in values)


def mean_iterations(summary):
    return statistics.mean(column(summary, "iterations", "ticks.csv"))


def planned(summary):
    """When the planned forces of both feet have settled, s after the last landing."""
    return max(summary["force_settling"][f"planned_{foot}_s"] for foot in ("left", "right"))


def apart(a, b):
    """Largest distance of the CoM from the mirror image of another run, m."""
    return max(math.hypot(xa - xb, ya + yb, za - zb) for xa, ya, za, xb, yb, zb in zip(
        *(column(run, f"com_{axis}") for run in (a, b) for axis in "xyz")))


def left_the_sole(summary):
    """When the capture point left the stance sole to the right, s after the push began."""
    edge = min(y for _, y in summary["left_sole"])
    return next(t for t, y in zip(column(summary, "t"), column(summary, "icp_y")) if y < edge) - summary["push_start_s"]


def sideways(summary):
    """The CoM's largest excursion to the right, its target there (cm), and the range of its height (cm)."""
    return [-100 * min(column(summary, "com_y")), -100 * summary["target"][1],
            100 * (summary["com_height_max_m"] - summary["com_height_min_m"])]


def cells_of_the_map(programs, name):
    return rows_of(programs.survival_map(*OTHER_TABLES[name].arguments))


def of_the_map(programs):
    """How many cells were spared, how many were run, of how many, and the seconds that these took."""
    cells = cells_of_the_map(programs, "map_centroidal")
    run = [cell for cell in cells if cell["outcome"] != "not_run" and not cell["known_from"]]
    return [sum(cell["outcome"] == "not_run" for cell in cells), len(run), len(cells),
            sum(float(cell["seconds"]) for cell in run)]


def slips_of_the_map(programs):
    """Of the MPC in DART, mm: forward with 15 N s, back right with 7 and 9."""
    cells = {(cell["direction_deg"], cell["impulse_ns"]): cell["reason"]
             for cell in cells_of_the_map(programs, "map_dart") if cell["controller"] == "mpc"}
    return [int(re.search(r"slipped by (\d+) mm", cells[key]).group(1))
            for key in (("0", "15"), ("225", "7"), ("225", "9"))]


def stairs(programs):
    """Largest steps in cost between neighbouring impact times, rounded to grids of 10 and 50 ms."""
    rows = rows_of(*os.path.split(programs.beside("impact_sweep")))
    found = []
    for grid in ("10", "50"):
        costs = [float(row["cost"]) for row in rows
                 if (row["dt_ms"], row["intervals"], row["costs"], row["wrench_change"], row["impact"])
                 == (grid, "15", "nodes", "0", "rounded")]
        found.append(max(abs(b - a) for a, b in zip(costs, costs[1:])))
    return found


def other_icubs(programs):
    """Of the package icub-models, which the set-up fetches."""
    found = []
    for name in ("iCubGazeboV2_7", "iCubGenova02", "iCubGenova11"):
        urdf = os.path.join(os.path.dirname(programs.program), "venv/share/iCub/robots", name, "model.urdf")
        if not os.path.exists(urdf):
            raise NotHere(f"{urdf} comes with `./saltus setup`")
        found.append(programs.run({**as_it_is(6, 0.6, 1), "robot.urdf": urdf}))
    return [all_recovered(found)]


def on_two_feet(degrees, size):
    return toward(degrees, size, "measured", **{"stance": "both", "step.planner": "reactive"})


def after_a_landing(degrees, later):
    """7 N s to the right, and 6 N s so long after the landing, which comes 0.4 s after the first."""
    return toward(270, 7, "measured", **{"step.planner": "reactive", "pushes": f"{1 + 0.4 + later:g} 6 {degrees:g}"})


def at_random(seed):
    return {**ROBOT, "plant": "dart", "stance": "both", "step.planner": "reactive", "push.start": 1, "sensor.seed": seed,
            "push.random.rate": 0.16667, "push.random.seed": seed}


def recovered(summaries):
    return sum(summary["recovered"] for summary in summaries)


def swing(summary):
    """Of the first step, s."""
    return summary["steps"][0]["touchdown_s"] - summary["steps"][0]["lift_off_s"]


def lines_of(path):
    """How many lines a file of the project has."""
    def count(programs):
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            return [len(file.readlines())]
    return count


SHORT = [in_dart(size, step__duration=0.3) for size in (8, 10, 12, 14, 16)]
PLACED = {"step__placement": "fixed", "step__fixed_place": "[0,0.14]"}
THEIRS = {"weights__gamma": "[0,0,100,1000,1000,20,1e5,1e5,1e5]",
          "weights__wrench": "[0.002,0.002,1e-5,0.02,0.02,0.02]"}
SOFT_POINT = {"weights__capture_point": "[1e4,1e4]"}
DISTURBED = [settings for row in TABLES["disturbances"].rows for settings in row.runs]
SETTLING = [settings for row in TABLES["settling"].rows[:3] for settings in row.runs]
SLOW_MOTORS = {"motor.bandwidth": 20}
FRICTION = {"simulator.friction": 0.4}

OF_THE_MAIN_README = {
    "lines_of_the_car": Sentence("A car shifts once, in {:d} lines.", [], lines_of("docs/first_problem.cpp"),
                                 readme="README.md"),
}

OF_PUSH_RECOVERY = {
    "mirror_centroidal": Sentence(
        "On the centroidal model the CoM of the two runs agrees to {:.1f} mm",
        [push(6), push(6, stance="right", push__direction="[0,1,0]")], lambda s: [1e3 * apart(*s)]),
    "mirror": Sentence(
        "In DART at 6 N s the farthest capture point agrees to {:.2f} mm and the touch-down to the millisecond{}",
        [in_dart(6), in_dart(6, stance="right", push__direction="[0,1,0]")],
        lambda s: [1e3 * abs(furthest(s[0]) - furthest(s[1])),
                   unless(abs(s[0]["touchdown_s"] - s[1]["touchdown_s"]) < 1.5e-3)]),
    "their_weights": Sentence(
        "with their weights a push of 7 N s is not recovered{}. The angular momentum stays at {:.2f} Nms, and the height, "
        "which has almost no weight, goes from {:.2f} to {:.2f} m",
        [push(7, **THEIRS)], lambda s: [unless(not s[0]["recovered"]), momentum(s[0]), s[0]["com_height_min_m"],
                                        s[0]["com_height_max_m"]]),
    "soft_capture_point": Sentence(
        "at 6 N s on the whole body the capture point then settles in {:.2f} s instead of {:.2f} s",
        [in_dart(6, **SOFT_POINT), in_dart(6)], lambda s: [x["icp_settling_s"] for x in s]),
    "landing_force": Sentence(
        "The planned force of the landing foot reaches {:.0f} N at 7 N s on the centroidal model and {:.0f} N in DART",
        [push(7), in_dart(7)], lambda s: [max(column(x, "right_fz")) for x in s]),
    "no_failed_solve": Sentence(
        "no solve failed{}, our KKT residual was at most 1e-8 in every tick{}, and the capture point never left the hull{}. "
        "With 7 N s the sparse solver gives the same results{}",
        [push(6), push(7), push(8), push(7, solver="sparse")],
        lambda s: [unless(all(x["failures"] == 0 for x in s[:3])), unless(most(s[:3], "kkt_max") <= 1e-8),
                   unless(most(s[:3], "icp_slack_max_m") < 1e-6),
                   unless(all(abs(s[1][key] - s[3][key]) < 1e-3 for key in
                              ("com_height_min_m", "com_height_max_m", "angular_momentum_max", "icp_settling_s")))]),
    "baseline_centroidal": Sentence(
        "it recovers the same pushes{} with {:.2f} to {:.2f} Nms of angular momentum",
        [push(size, controller="capture_point") for size in (6, 7, 8)],
        lambda s: [all_recovered(s), least(s, "angular_momentum_max"), most(s, "angular_momentum_max")]),
    "cells_spared": Sentence("This saved {:d} cells.", [], lambda programs: of_the_map(programs)[:1], quick=False),
    "cells_run": Sentence("{:d} runs for {:d} cells.", [], lambda programs: of_the_map(programs)[1:3], quick=False),
    "time_of_the_map": Sentence("takes {:.0f} s of processor time,", [], lambda programs: of_the_map(programs)[3:],
                                quick=False, timed=True),
    "ends_of_rays": Sentence(
        "Forward, at 15 N s, a corner of the stance sole slips by {:.0f} mm. To the swing side the foot is at the limit of its "
        "reach. Back right a corner slips by more than a centimetre ({:.0f} mm at 7 N s, {:.0f} mm at 9 N s)", [], slips_of_the_map,
        quick=False),
    "stairs": Sentence(
        "with steps of up to {:.2f} in cost at 10 ms and {:.2f} at 50 ms", [], stairs, quick=False),
    "no_wrench_change": Sentence(
        "a tick takes {:.1f} iterations instead of {:.1f}",
        [push(7, weights__wrench_change=0), push(7)], lambda s: [mean_iterations(x) for x in s]),
    "missed_ticks": Sentence(
        "6 N s were recovered with each of four seeds{}",
        [push(6, mpc__deadline=0.001, mpc__missed_share=0.2, mpc__missed_seed=seed) for seed in range(1, 5)],
        lambda s: [all_recovered(s)], quick=False),
    "mass": Sentence("(neck and wrists fixed), {:.2f} kg,", [in_dart(6)], lambda s: [s[0]["mass_kg"]]),
    "edge_of_8": Sentence(
        "the limit of 1 Nms is exceeded between 8 N s ({:.2f}) and 8.2 N s ({:.2f}, not recovered)",
        [in_dart(8), in_dart(8.2)], lambda s: [momentum(s[0]), momentum(s[1])]),
    "torque_limit": Sentence(
        "A torque is at its limit {:.0f} to {:.0f} % of the time from 5 N s on",
        [in_dart(size) for size in (5, 6, 7, 8)],
        lambda s: [100 * least(s, "body.torque_limit_share"), 100 * most(s, "body.torque_limit_share")]),
    "simulator_time": Sentence(
        "(the simulator takes another {:.2f} s)", [in_dart(7)], lambda s: [s[0]["body"]["plant_s_per_s"]],
        quick=False, timed=True),
    "steps_of_0_3_s": Sentence(
        "a step of 0.3 s: 8, 10, 12, 14 and 16 N s{} (capture point settled in {:.2f} s up to 14 N s, {:.2f} s at 16;",
        SHORT, lambda s: [all_recovered(s), max(x["icp_settling_s"] for x in s[:4]), s[4]["icp_settling_s"]],
        quick=False),
    "short_steps_of_the_baseline": Sentence(
        "the baseline 8 and 10{});", [{**settings, "controller": "capture_point"} for settings in SHORT[:2]],
        lambda s: [all_recovered(s)]),
    "fixed_place": Sentence(
        "0.14 m beside the stance sole: 6 N s with a step of 0.6 s and 11 with 0.3 s{} (6.2 and 11.5 fall{})",
        [in_dart(6, **PLACED), in_dart(11, step__duration=0.3, **PLACED),
         in_dart(6.2, **PLACED), in_dart(11.5, step__duration=0.3, **PLACED)],
        lambda s: [all_recovered(s[:2]), unless(all(x["fell"] for x in s[2:]))], quick=False),
    "engines": Sentence(
        "4 to 7 N s in MuJoCo: farthest capture point within {:.1f} mm, touch-down within {:.0f} ms of DART",
        [push(size, plant=plant) for size in (4, 5, 6, 7) for plant in ("dart", "mujoco")],
        lambda s: [1e3 * max(abs(furthest(a) - furthest(b)) for a, b in zip(s[::2], s[1::2])),
                   1e3 * max(abs(a["touchdown_s"] - b["touchdown_s"])
                             for a, b in zip(s[2::2], s[3::2]))], quick=False),
    "slow_motors": Sentence(
        "With a motor bandwidth of 20 Hz a joint exceeds its speed limit by {:.0f} % for {:.0f} ms",
        [{**as_it_is(6, 0.6, 1), **SLOW_MOTORS}],
        lambda s: [100 * (s[0]["body"]["joint_speed_ratio_max"] - 1), 1e3 * s[0]["body"]["joint_speed_over_s"]],
        quick=False),
    "com_against_the_paper": Sentence(
        "moves to {:.0f} cm and back to its target at {:.0f} cm in one swing; height within {:.1f} cm", [in_dart(7)],
        lambda s: sideways(s[0])),
    "capture_point_against_the_paper": Sentence(
        "leaves it {:.2f} s after the start of the push, is inside the hull from touch-down on{}, and is within 1 cm of its "
        "final position {:.2f} s later",
        [in_dart(7)], lambda s: [left_the_sole(s[0]), unless(s[0]["icp_slack_max_m"] < 1e-6), s[0]["icp_settling_s"]]),
    "forward_against_the_paper": Sentence(
        "moves by {:.0f} mm in x", [in_dart(7)], lambda s: [1e3 * excursion(column(s[0], "icp_x"))]),
    "landing_against_the_paper": Sentence(
        "{:.2f} s: the ground carries 20 N before", [in_dart(7)], lambda s: [s[0]["touchdown_s"]]),
    "horizons": Sentence(
        "6 N s are also recovered with 5 and 8 intervals{}", [in_dart(6, mpc__intervals=n) for n in (5, 8)],
        lambda s: [all_recovered(s)], quick=False),
    "time_of_a_tick": Sentence("{:.1f} ms (median)", [in_dart(7)], lambda s: [1e-3 * s[0]["solve_us"]["median"]],
                               quick=False, timed=True),
    "faster_than_the_baseline": Sentence(
        "The MPC's planned forces settle {:.1f} to {:.1f} times as fast", SETTLING,
        lambda s: [min(planned(b) / planned(a) for a, b in zip(s[::2], s[1::2])),
                   max(planned(b) / planned(a) for a, b in zip(s[::2], s[1::2]))]),
    "forces_of_a_soft_capture_point": Sentence(
        "with a weight of 1e4 on the capture point its planned forces settle in {:.2f} s", [in_dart(6, **SOFT_POINT)],
        lambda s: [planned(s[0])]),
    "single_samples": Sentence(
        "Single samples at landing reach {:.0f} N at 7 N s", [in_dart(7)],
        lambda s: [max(column(s[0], "right_measured_fz", "body.csv"))]),
    "box_of_friction": Sentence(
        "at 6 N s the ratio reached {:.2f} and {:.2f} with coefficients of 0.4 and 0.2",
        [in_dart(6, simulator__friction=0.4), in_dart(6, simulator__friction=0.2)],
        lambda s: [x["body"]["friction_max"] for x in s]),
    "inscribed_friction": Sentence(
        "with a coefficient of 0.4 at 6 N s, {:.3f} N s and {:.1f} mm of slip, and with the box {:.3f} N s and {:.1f} mm",
        [{**as_it_is(6, 0.6, 1), **FRICTION}, {**as_it_is(6, 0.6, 1), **FRICTION, "dart.friction": "box"}],
        lambda s: [v for x in s for v in (x["body"]["friction_beyond_ns"], 1e3 * x["body"]["slip_max_m"])], quick=False),
    "round_friction": Sentence(
        "MuJoCo has round cones: {:.3f} with 0.4", [push(6, plant="mujoco", simulator__friction=0.4)],
        lambda s: [s[0]["body"]["friction_max"]], quick=False),
    "disturbed_joints": Sentence(
        "In all cases the joints stay at least {:.0f} mrad from their limits", DISTURBED,
        lambda s: [1e3 * least(s, "body.joint_limit_margin_rad")], quick=False),
    "ground_in_mujoco": Sentence(
        "MuJoCo also recovers on the higher and the lower ground{}, with touch-down within two milliseconds of DART{}",
        [push(6, plant=plant, simulator__ground_step=step) for step in (0.01, -0.01) for plant in ("dart", "mujoco")],
        lambda s: [all_recovered(s), unless(all(abs(a["touchdown_s"] - b["touchdown_s"]) < 2.5e-3
                                                for a, b in zip(s[::2], s[1::2])))], quick=False),
    "lower_ground": Sentence(
        "On lower ground the robot leans over and the CoM sinks to {:.2f} m", [in_dart(6, simulator__ground_step=-0.01)],
        lambda s: [s[0]["com_height_min_m"]], quick=False),
    "standing_as_it_is": Sentence(
        "towards the swing side, 4.5 N s are recovered{} and 5 are not{}",
        [toward(270, size, "measured", stepping="false") for size in (4.5, 5)],
        lambda s: [all_recovered(s[:1]), unless(not s[1]["recovered"])], quick=False),
    "two_feet_10": Sentence(
        "At 10 N s all 16 directions are recovered{} without a step{} ({:.2f} to {:.2f} Nms)",
        [on_two_feet(22.5 * k, 10) for k in range(16)],
        lambda s: [all_recovered(s), unless(not any(x["steps"] for x in s)), least(s, "angular_momentum_max"),
                   most(s, "angular_momentum_max")], quick=False),
    "two_feet_14": Sentence(
        "At 14 N s {:d} of 8 directions are recovered. To the sides and diagonals the robot stands{}, with up to {:.2f} Nms. "
        "Backwards it takes a step of {:.2f} s. Forwards it steps and stands{}, but the angular momentum reaches {:.2f} Nms",
        [on_two_feet(45 * k, 14) for k in range(8)],
        lambda s: [recovered(s), unless(not any(x["steps"] for k, x in enumerate(s) if k not in (0, 4))),
                   most([x for k, x in enumerate(s) if k not in (0, 4)], "angular_momentum_max"), swing(s[4]),
                   unless(s[0]["steps"] and not s[0]["fell"]), momentum(s[0])], quick=False),
    "second_pushes": Sentence(
        "7 N s to the right (landing after {:.2f} s) and then 6 N s in any of 8 directions 0.1, 0.3 and 0.5 s after the "
        "landing: {:d} of 24 recovered",
        [after_a_landing(45 * k, later) for k in range(8) for later in (0.1, 0.3, 0.5)],
        lambda s: [s[0]["steps"][0]["touchdown_s"] - 1, recovered(s)], quick=False),
    "random_pushes": Sentence(
        "In 60 s with random pushes of 3 to 8 N s on two feet, seeds 1 to 3 of both pushes and sensors: {:d} of 3 runs "
        "recover without a step{}",
        [at_random(seed) for seed in (1, 2, 3)],
        lambda s: [recovered(s), unless(not any(x["steps"] for x in s))], quick=False),
    "time_with_random_pushes": Sentence(
        "{:.1f} s of processor time per simulated second", [at_random(1)],
        lambda s: [sum(s[0]["body"][part] for part in ("planner_s_per_s", "whole_body_control_s_per_s", "plant_s_per_s"))],
        quick=False, timed=True),
    "slip_of_controllers": Sentence(
        "In recoveries with a step its stance sole slips by up to {:.1f} mm, that of inverse dynamics by up to {:.1f} mm",
        [*(early(size, whole_body__controller="momentum") for size in (4, 5)), *(early(size) for size in (4, 5, 5.5, 6))],
        lambda s: [1e3 * most([x for x in part if x["recovered"]], "body.slip_max_m") for part in (s[:2], s[2:])],
        quick=False),
}

OF_ROBOTS = {
    "other_icubs": Sentence(
        "the URDFs iCubGazeboV2_7, iCubGenova02 and iCubGenova11 of icub-models recover 6 N s in DART as well{}",
        [], other_icubs, readme="robots/README.md", quick=False),
}

SENTENCES = {**OF_THE_MAIN_README, **OF_PUSH_RECOVERY, **OF_ROBOTS}
