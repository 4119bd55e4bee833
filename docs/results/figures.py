"""Tables of single figures. Each row has a name, a value in words and numbers, and the runs that determine it."""

import dataclasses
import math
import os
import re
import statistics
from typing import Callable, Dict, List, Tuple

from other_tables import OTHER_TABLES
from programs import NotHere, rows_of
from tables import README, ROBOT, TABLES, as_it_is, in_dart, look_up, markdown, push, toward


@dataclasses.dataclass
class Figure:
    """One row. A field for words such as {} is empty if the claim holds, and VIOLATED otherwise."""
    name: str
    value: str  # with {} for the numbers
    runs: List[Dict[str, object]]  # settings of push_recovery
    numbers: Callable  # (summaries) -> the numbers; (programs) if there are no runs

    def make(self, programs):
        found = self.numbers([programs.run(settings) for settings in self.runs] if self.runs else programs)
        return self.value.format(*found)


@dataclasses.dataclass
class Figures:
    """A table of figures that are not rows of other tables."""
    title: str
    rows: List[Figure]
    readme: str = README
    quick: bool = True
    timed: Tuple[str, ...] = ()
    exact: Tuple[str, ...] = ()
    titles = ("figure", "value")

    def runs(self):
        return sum(len(row.runs) for row in self.rows)

    def shape(self):
        return list(self.titles), len(self.rows)

    def make(self, programs):
        return markdown(list(self.titles), [[row.name, row.make(programs)] for row in self.rows])


def momentum(summary):
    return summary["angular_momentum_max"]


def all_recovered(summaries):
    """Empty if all recovered; otherwise the other runs, which then differ from the printed text."""
    return "".join(f" VIOLATED: {s['push_impulse_ns']:g} N s: {s['reason']}" for s in summaries if not s["recovered"])


def furthest(summary):
    """The largest distance of the capture point from its position at the start of the push, m."""
    rows = [(float(r["t"]), float(r["icp_x"]), float(r["icp_y"]))
            for r in rows_of(summary["folder"], "trajectory.csv")]
    _, x, y = next(r for r in rows if r[0] > summary["push_start_s"] - 1e-9)
    return max(math.hypot(r[1] - x, r[2] - y) for r in rows)


def early(size, **settings):
    """A push at 0.3 s, which saves two seconds of standing."""
    return in_dart(size, push__start=0.3, **settings)


def unless(claim):
    """Empty if the claim holds."""
    return "" if claim else " VIOLATED"


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
    """Settling time of the planned forces of both feet, s after the last landing."""
    return max(summary["force_settling"][f"planned_{foot}_s"] for foot in ("left", "right"))


def apart(a, b):
    """Largest distance of the CoM from the mirror image of another run, m."""
    return max(math.hypot(xa - xb, ya + yb, za - zb) for xa, ya, za, xb, yb, zb in zip(
        *(column(run, f"com_{axis}") for run in (a, b) for axis in "xyz")))


def left_the_sole(summary):
    """The time at which the capture point leaves the stance sole to the right, s after the start of the push."""
    edge = min(y for _, y in summary["left_sole"])
    return next(t for t, y in zip(column(summary, "t"), column(summary, "icp_y")) if y < edge) - summary["push_start_s"]


def sideways(summary):
    """The CoM's largest excursion to the right, its target there (cm), and the range of its height (cm)."""
    return [-100 * min(column(summary, "com_y")), -100 * summary["target"][1],
            100 * (summary["com_height_max_m"] - summary["com_height_min_m"])]


def cells_of_the_map(programs, name):
    return rows_of(programs.survival_map(*OTHER_TABLES[name].arguments))


def of_the_map(programs):
    """The numbers of cells that were run and skipped, each with the number of all cells."""
    cells = cells_of_the_map(programs, "map_centroidal")
    run = [cell for cell in cells if cell["outcome"] != "not_run" and not cell["known_from"]]
    return [len(run), len(cells), sum(cell["outcome"] == "not_run" for cell in cells), len(cells)]


def slips_of_the_map(programs):
    """Slip of the MPC in DART, mm: forward with 15 N s, back right with 7 and 9."""
    cells = {(cell["direction_deg"], cell["impulse_ns"]): cell["reason"]
             for cell in cells_of_the_map(programs, "map_dart") if cell["controller"] == "mpc"}
    return [int(re.search(r"slipped by (\d+) mm", cells[key]).group(1))
            for key in (("0", "15"), ("225", "7"), ("225", "9"))]


def stairs(programs):
    """Largest steps in cost between adjacent impact times, rounded to grids of 10 and 50 ms."""
    rows = rows_of(*os.path.split(programs.beside("impact_sweep")))
    found = []
    for grid in ("10", "50"):
        costs = [float(row["cost"]) for row in rows
                 if (row["dt_ms"], row["intervals"], row["costs"], row["wrench_change"], row["impact"])
                 == (grid, "15", "nodes", "0", "rounded")]
        found.append(max(abs(b - a) for a, b in zip(costs, costs[1:])))
    return found


def other_icubs(programs):
    """Other models of the package icub-models, which the set-up downloads."""
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
    """7 N s to the right, then 6 N s this long after the landing, which comes 0.4 s after the first push."""
    return toward(270, 7, "measured", **{"step.planner": "reactive", "pushes": f"{1 + 0.4 + later:g} 6 {degrees:g}"})


def at_random(seed):
    return {**ROBOT, "plant": "dart", "stance": "both", "step.planner": "reactive", "push.start": 1, "sensor.seed": seed,
            "push.random.rate_hz": 0.16667, "push.random.seed": seed}


def recovered(summaries):
    return sum(summary["recovered"] for summary in summaries)


def swing(summary):
    """Duration of the first step, s."""
    return summary["steps"][0]["touchdown_s"] - summary["steps"][0]["lift_off_s"]


SHORT = [in_dart(size, step__duration=0.3) for size in (8, 10, 12, 14, 16)]
PLACED = {"step__placement": "fixed", "step__fixed_place": "[0,0.14]"}
THEIRS = {"weights__gamma": "[0,0,100,1000,1000,20,1e5,1e5,1e5]",
          "weights__wrench": "[0.002,0.002,1e-5,0.02,0.02,0.02]"}
SOFT_POINT = {"weights__capture_point": "[1e4,1e4]"}
DISTURBED = [settings for row in TABLES["disturbances"].rows for settings in row.runs]
SETTLING = [settings for row in TABLES["settling"].rows[:3] for settings in row.runs]
SLOW_MOTORS = {"motor.bandwidth_hz": 20}
FRICTION = {"simulator.friction": 0.4}

QUICK = [
    Figure("centroidal model, 6 N s, mirrored run: difference of the CoM", "{:.1f} mm",
           [push(6), push(6, stance="right", push__direction="[0,1,0]")], lambda s: [1e3 * apart(*s)]),
    Figure("DART, 6 N s, mirrored run: difference of the farthest capture point; of the touch-down",
           "{:.2f} mm; less than 1.5 ms{}",
           [in_dart(6), in_dart(6, stance="right", push__direction="[0,1,0]")],
           lambda s: [1e3 * abs(furthest(s[0]) - furthest(s[1])),
                      unless(abs(s[0]["touchdown_s"] - s[1]["touchdown_s"]) < 1.5e-3)]),
    Figure("centroidal model, 7 N s, weights of the authors", "not recovered{}; H {:.2f} Nms; height {:.2f} to {:.2f} m",
           [push(7, **THEIRS)], lambda s: [unless(not s[0]["recovered"]), momentum(s[0]), s[0]["com_height_min_m"],
                                           s[0]["com_height_max_m"]]),
    Figure("DART, 6 N s: settling time of the capture point, with a weight of 1e4 on it; by default", "{:.2f} s; {:.2f} s",
           [in_dart(6, **SOFT_POINT), in_dart(6)], lambda s: [x["icp_settling_s"] for x in s]),
    Figure("DART, 6 N s: settling time of planned forces, with a weight of 1e4 on the capture point", "{:.2f} s",
           [in_dart(6, **SOFT_POINT)], lambda s: [planned(s[0])]),
    Figure("7 N s: largest planned force of the landing foot, centroidal model; DART", "{:.0f} N; {:.0f} N",
           [push(7), in_dart(7)], lambda s: [max(column(x, "right_fz")) for x in s]),
    Figure("centroidal model, 6 to 8 N s: failed solves; KKT residual; capture point outside of the hull",
           "none{}; at most 1e-8{}; never{}", [push(6), push(7), push(8)],
           lambda s: [unless(all(x["failures"] == 0 for x in s)), unless(most(s, "kkt_max") <= 1e-8),
                      unless(most(s, "icp_slack_max_m") < 1e-6)]),
    Figure("centroidal model, 7 N s: riccati and sparse differ by", "less than 1e-3 in height, H and settling{}",
           [push(7), push(7, solver="sparse")],
           lambda s: [unless(all(abs(s[0][key] - s[1][key]) < 1e-3 for key in
                                 ("com_height_min_m", "com_height_max_m", "angular_momentum_max", "icp_settling_s")))]),
    Figure("centroidal model, baseline, 6 to 8 N s", "recovered{}, H {:.2f} to {:.2f} Nms",
           [push(size, controller="capture_point") for size in (6, 7, 8)],
           lambda s: [all_recovered(s), least(s, "angular_momentum_max"), most(s, "angular_momentum_max")]),
    Figure("centroidal model, 7 N s: iterations per tick without the cost on changes of wrenches; with it",
           "{:.1f}; {:.1f}", [push(7, weights__wrench_change=0), push(7)], lambda s: [mean_iterations(x) for x in s]),
    Figure("mass of the robot", "{:.2f} kg", [in_dart(6)], lambda s: [s[0]["mass_kg"]]),
    Figure("DART: H at 8 N s; at 8.2 N s", "{:.2f} Nms; {:.2f} Nms, not recovered{}",
           [in_dart(8), in_dart(8.2)], lambda s: [momentum(s[0]), momentum(s[1]), unless(not s[1]["recovered"])]),
    Figure("DART, 5 to 8 N s: time with a torque at its limit", "{:.0f} to {:.0f} %",
           [in_dart(size) for size in (5, 6, 7, 8)],
           lambda s: [100 * least(s, "body.torque_limit_share"), 100 * most(s, "body.torque_limit_share")]),
    Figure("DART, baseline, step of 0.3 s, 8 and 10 N s", "recovered{}",
           [{**settings, "controller": "capture_point"} for settings in SHORT[:2]], lambda s: [all_recovered(s)]),
    Figure("DART, 7 N s: CoM to the right; its target; range of its height", "{:.0f} cm; {:.0f} cm; {:.1f} cm",
           [in_dart(7)], lambda s: sideways(s[0])),
    Figure("DART, 7 N s: capture point leaves the sole after the start of the push; settles after touch-down",
           "{:.2f} s; {:.2f} s, never outside of the hull{}", [in_dart(7)],
           lambda s: [left_the_sole(s[0]), s[0]["icp_settling_s"], unless(s[0]["icp_slack_max_m"] < 1e-6)]),
    Figure("DART, 7 N s: capture point moves in x by", "{:.0f} mm", [in_dart(7)],
           lambda s: [1e3 * excursion(column(s[0], "icp_x"))]),
    Figure("DART, 7 N s: the ground force reaches 20 N at", "{:.2f} s", [in_dart(7)], lambda s: [s[0]["touchdown_s"]]),
    Figure("DART, 5 to 7 N s: settling time of planned forces, baseline over MPC", "{:.1f} to {:.1f}", SETTLING,
           lambda s: [min(planned(b) / planned(a) for a, b in zip(s[::2], s[1::2])),
                      max(planned(b) / planned(a) for a, b in zip(s[::2], s[1::2]))]),
    Figure("DART, 7 N s: largest single sample of a force at landing", "{:.0f} N", [in_dart(7)],
           lambda s: [max(column(s[0], "right_measured_fz", "body.csv"))]),
    Figure("DART, 6 N s, friction box: ratio of tangential to normal force with coefficient 0.4; 0.2", "{:.2f}; {:.2f}",
           [in_dart(6, simulator__friction=0.4), in_dart(6, simulator__friction=0.2)],
           lambda s: [x["body"]["friction_max"] for x in s]),
]

SLOW = [
    Figure("map of the centroidal model: cells that were run; skipped", "{:d} of {:d}; {:d} of {:d}", [], of_the_map),
    Figure("map in DART: slip of a corner forward at 15 N s; back right at 7 N s; at 9 N s",
           "{:.0f} mm; {:.0f} mm; {:.0f} mm", [], slips_of_the_map),
    Figure("rounded events: largest step in cost on a grid of 10 ms; of 50 ms", "{:.2f}; {:.2f}", [], stairs),
    Figure("DART, step of 0.3 s, 8, 10, 12, 14 and 16 N s: capture point settles up to 14 N s; at 16 N s",
           "recovered{}, {:.2f} s; {:.2f} s", SHORT,
           lambda s: [all_recovered(s), max(x["icp_settling_s"] for x in s[:4]), s[4]["icp_settling_s"]]),
    Figure("DART, foot placed 0.14 m beside the stance sole: 6 N s with a step of 0.6 s and 11 N s with 0.3 s; 6.2 and 11.5 N s",
           "recovered{}; falls{}",
           [in_dart(6, **PLACED), in_dart(11, step__duration=0.3, **PLACED),
            in_dart(6.2, **PLACED), in_dart(11.5, step__duration=0.3, **PLACED)],
           lambda s: [all_recovered(s[:2]), unless(all(x["fell"] for x in s[2:]))]),
    Figure("MuJoCo against DART, 4 to 7 N s: difference of the farthest capture point; of the touch-down",
           "{:.1f} mm; {:.0f} ms", [push(size, plant=plant) for size in (4, 5, 6, 7) for plant in ("dart", "mujoco")],
           lambda s: [1e3 * max(abs(furthest(a) - furthest(b)) for a, b in zip(s[::2], s[1::2])),
                      1e3 * max(abs(a["touchdown_s"] - b["touchdown_s"]) for a, b in zip(s[2::2], s[3::2]))]),
    Figure("preset robot, 6 N s, motors of 20 Hz: largest excess over a joint speed limit; its duration", "{:.0f} %; {:.0f} ms",
           [{**as_it_is(6, 0.6, 1), **SLOW_MOTORS}],
           lambda s: [100 * (s[0]["body"]["joint_speed_ratio_max"] - 1), 1e3 * s[0]["body"]["joint_speed_over_s"]]),
    Figure("preset robot, 6 N s, coefficient of 0.4: impulse beyond Coulomb's law and slip, inscribed; box",
           "{:.3f} N s and {:.1f} mm; {:.3f} N s and {:.1f} mm",
           [{**as_it_is(6, 0.6, 1), **FRICTION}, {**as_it_is(6, 0.6, 1), **FRICTION, "dart.friction": "box"}],
           lambda s: [v for x in s for v in (x["body"]["friction_beyond_ns"], 1e3 * x["body"]["slip_max_m"])]),
    Figure("MuJoCo, 6 N s: ratio of tangential to normal force with coefficient 0.4", "{:.3f}",
           [push(6, plant="mujoco", simulator__friction=0.4)], lambda s: [s[0]["body"]["friction_max"]]),
    Figure("all rows of the table of disturbances: nearest joint limit", "{:.0f} mrad", DISTURBED,
           lambda s: [1e3 * least(s, "body.joint_limit_margin_rad")]),
    Figure("ground 1 cm higher and lower, 6 N s, DART and MuJoCo: difference of the touch-down", "recovered{}, below 2.5 ms{}",
           [push(6, plant=plant, simulator__ground_step_m=step) for step in (0.01, -0.01) for plant in ("dart", "mujoco")],
           lambda s: [all_recovered(s), unless(all(abs(a["touchdown_s"] - b["touchdown_s"]) < 2.5e-3
                                                   for a, b in zip(s[::2], s[1::2])))]),
    Figure("DART, 6 N s, ground 1 cm lower: least height of the CoM", "{:.2f} m", [in_dart(6, simulator__ground_step_m=-0.01)],
           lambda s: [s[0]["com_height_min_m"]]),
    Figure("preset robot, to the swing side, standing: 4.5 N s; 5 N s", "recovered{}; not recovered{}",
           [toward(270, size, "measured", stepping="false") for size in (4.5, 5)],
           lambda s: [all_recovered(s[:1]), unless(not s[1]["recovered"])]),
    Figure("two feet, 10 N s, 16 directions", "recovered{} without a step{}, H {:.2f} to {:.2f} Nms",
           [on_two_feet(22.5 * k, 10) for k in range(16)],
           lambda s: [all_recovered(s), unless(not any(x["steps"] for x in s)), least(s, "angular_momentum_max"),
                      most(s, "angular_momentum_max")]),
    Figure("two feet, 14 N s: recovered", "{:d} of 8", [on_two_feet(45 * k, 14) for k in range(8)], lambda s: [recovered(s)]),
    Figure("two feet, 14 N s: to the sides and diagonals; backwards; forwards",
           "no step{}, H up to {:.2f} Nms; a step of {:.2f} s; steps and stands{}, H {:.2f} Nms",
           [on_two_feet(45 * k, 14) for k in range(8)],
           lambda s: [unless(not any(x["steps"] for k, x in enumerate(s) if k not in (0, 4))),
                      most([x for k, x in enumerate(s) if k not in (0, 4)], "angular_momentum_max"), swing(s[4]),
                      unless(s[0]["steps"] and not s[0]["fell"]), momentum(s[0])]),
    Figure("7 N s to the right: time of the landing; then 6 N s in 8 directions, 0.1, 0.3 and 0.5 s after it",
           "{:.2f} s; {:d} of 24 recovered",
           [after_a_landing(45 * k, later) for k in range(8) for later in (0.1, 0.3, 0.5)],
           lambda s: [s[0]["steps"][0]["touchdown_s"] - 1, recovered(s)]),
    Figure("60 s of random pushes of 3 to 8 N s on two feet, seeds 1 to 3", "{:d} of 3 recovered without a step{}",
           [at_random(seed) for seed in (1, 2, 3)],
           lambda s: [recovered(s), unless(not any(x["steps"] for x in s))]),
    Figure("recoveries with a step: slip of the stance sole with momentum control; with inverse dynamics",
           "{:.1f} mm; {:.1f} mm",
           [*(early(size, whole_body__controller="momentum") for size in (4, 5)), *(early(size) for size in (4, 5, 5.5, 6))],
           lambda s: [1e3 * most([x for x in part if x["recovered"]], "body.slip_max_m") for part in (s[:2], s[2:])]),
]

FIGURES = {
    "figures": Figures("Single figures of push recovery", QUICK),
    "more_figures": Figures("Single figures of push recovery whose runs take minutes", SLOW, quick=False),
    "other_icubs": Figures(
        "Other models of iCub", [Figure("iCubGazeboV2_7, iCubGenova02, iCubGenova11, 6 N s in DART", "recovered{}", [], other_icubs)],
        readme="robots/README.md", quick=False),
}
