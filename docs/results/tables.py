"""Building blocks of the tables of push recovery: the runs of each row and the cells of each column."""

import concurrent.futures
import dataclasses
import math
from typing import Callable, Dict, List, Tuple

README = "problems/push_recovery/experiments.md"
# Explicit values, so that figures do not depend on defaults.
PAPER = {"preset": "paper", "step.planner": "push_formula"}
ROBOT = {"preset": "robot", "drives": "ideal", "step.planner": "icp_formula"}


def markdown(titles, rows):
    lines = [titles, ["---"] * len(titles), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


@dataclasses.dataclass
class Row:
    name: str
    runs: List[Dict[str, object]]  # settings of push_recovery
    word: str = ""  # for a column that belongs to the row


@dataclasses.dataclass
class Table:
    title: str
    rows: List[Row]
    columns: List[Tuple[str, Callable]]  # title, cell(row, summaries)
    readme: str = README
    quick: bool = True
    timed: Tuple[str, ...] = ()  # columns with times
    exact: Tuple[str, ...] = ()  # columns whose whole numbers are counts

    def runs(self):
        return sum(len(row.runs) for row in self.rows)

    def shape(self):
        """Titles, and the number of rows."""
        return [title for title, _ in self.columns], len(self.rows)

    def make(self, programs):
        """As Markdown."""
        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            summaries = list(pool.map(lambda row: [programs.run(settings) for settings in row.runs], self.rows))
        return markdown([title for title, _ in self.columns],
                        [[cell(row, found) for _, cell in self.columns]
                         for row, found in zip(self.rows, summaries)])


def look_up(summary, key):
    for part in key.split("."):
        if summary is None:
            return None
        summary = summary.get(part)
    return summary


def figure(key, text="{:g}", factor=1.0, otherwise="", run=0, if_recovered=False):
    """A cell with one number of a summary, or `otherwise` if it is missing."""
    def cell(row, summaries):
        summary = summaries[run]
        value = look_up(summary, key)
        if value is None or (if_recovered and not summary["recovered"]):
            return otherwise
        return text.format(factor * value)
    return cell


def heights(row, summaries):
    return f"{summaries[0]['com_height_min_m']:.3f} to {summaries[0]['com_height_max_m']:.3f}"


def outcome(run=0):
    def cell(row, summaries):
        summary = summaries[run]
        return "yes" if summary["recovered"] else summary["reason"]
    return cell


def name(row, summaries):
    return row.name


def word(row, summaries):
    return row.word


def landing(row, summaries):
    summary = summaries[0]
    if summary["touchdown_s"] is None:
        return "none needed" if summary["recovered"] else ""
    return f"{summary['touchdown_s'] - summary['push_start_s']:.3f} s"


def error(row, summaries):
    if not summaries[0]["recovered"]:
        return ""
    millimetres = 1e3 * summaries[0]["final_com_error_m"]
    return "below 0.1 mm" if millimetres < 0.1 else f"{millimetres:.1f} mm"


def later(kind, run):
    """Settling time of the forces of both feet."""
    def cell(row, summaries):
        if not summaries[run]["recovered"]:
            return ""
        values = [look_up(summaries[run], f"force_settling.{kind}_{foot}_s") for foot in ("left", "right")]
        return "never" if None in values else f"{max(values):.2f}"
    return cell


def peak_force(row, summaries):
    body = summaries[0]["body"]
    return f"{max(body['left_force_peak_n'], body['right_force_peak_n']):.0f} N"


def too_much(run=0):
    """Largest |H|, marked if it violates the verdict."""
    def cell(row, summaries):
        value = f"{summaries[run]['angular_momentum_max']:.2f}"
        return value if summaries[run]["recovered"] else value + ", " + summaries[run]["reason"].split(";")[0]
    return cell


def peak_of(run):
    def cell(row, summaries):
        return peak_force(row, summaries[run:]).removesuffix(" N")
    return cell


def seeds_recovered(row, summaries):
    good = sum(summary["recovered"] for summary in summaries)
    return f"{good} of {len(summaries)}"


def worst(key, text, factor=1.0, least=False):
    """The worst value of all runs of a row, including falls."""
    def cell(row, summaries):
        values = [look_up(summary, key) for summary in summaries]
        values = [factor * value for value in values if value is not None]
        return text.format((min if least else max)(values)) if values else ""
    return cell


def toward(degrees, size, sensors, **settings):
    x, y = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {**ROBOT, "plant": "dart", "sensors": sensors, "push.impulse": size, "push.start": 1,
            "push.direction": f"[{x:.9f},{y:.9f},0]", **settings}


def with_and_without_a_step(sensors, sizes):
    """The two runs of each size."""
    def cell(row, summaries):
        words = []
        for size in sizes:
            may, may_not = (next(s for s, r in zip(summaries, row.runs)
                                 if r["sensors"] == sensors and r["push.impulse"] == size
                                 and r.get("stepping", "true") == stepping) for stepping in ("true", "false"))
            if may["recovered"]:
                words.append("steps" if may["touchdown_s"] is not None else "stands")
            else:
                words.append(("falls" if may["fell"] else "slips")
                             + (", BUT STANDING RECOVERS" if may_not["recovered"] else ""))
        return " / ".join(words)
    return cell


def both_controllers(row, summaries):
    body = summaries[0]["body"]
    return f"{body['planner_s_per_s'] + body['whole_body_control_s_per_s']:.2f} s"


def push(size, **settings):
    return {**PAPER, "push.impulse": size, **{k.replace("__", "."): v for k, v in settings.items()}}


def in_dart(size, **settings):
    return push(size, plant="dart", **settings)


def as_it_is(size, duration, seed, plant="dart"):
    settings = {**ROBOT, "plant": plant, "push.impulse": size, "push.start": 1, "sensor.seed": seed}
    return settings if duration is None else {**settings, "step.duration": duration}


TABLES = {
    "centroidal": Table(
        "Push recovery on the centroidal model",
        [Row("6 N s", [push(6)], "yes"), Row("7 N s", [push(7)], "yes"), Row("8 N s", [push(8)], "yes"),
         Row("8 N s", [push(8, stepping="false")], "no")],
        [("push", name), ("step", word), ("recovered", outcome()), ("CoM height, m", heights),
         ("largest angular momentum", figure("angular_momentum_max", "{:.2f} Nms")),
         ("final CoM error", error),
         ("capture point settles in", figure("icp_settling_s", "{:.2f} s"))]),
    "dart": Table(
        "MPC in DART, step of 0.6 s",
        [Row(f"{size} N s", [in_dart(size)]) for size in (4, 5, 6, 7, 8)],
        [("push", name), ("recovered", outcome()), ("landing after", landing),
         ("CoM height, m", heights), ("largest H, Nms", figure("angular_momentum_max", "{:.2f}")),
         ("capture point settles in", figure("icp_settling_s", "{:.2f} s")),
         ("slip", figure("body.slip_max_m", "{:.1f} mm", 1e3)), ("peak force", peak_force),
         ("largest torque", figure("body.torque_share_max", "{:.0f} %", 100.0)),
         ("nearest joint limit", figure("body.joint_limit_margin_rad", "{:.0f} mrad", 1e3)),
         ("time", both_controllers)],
        timed=("time",)),
    "settling": Table(
        "Settling of the vertical forces, MPC and baseline in DART",
        [Row(f"{size} N s", [in_dart(size), in_dart(size, controller="capture_point")])
         for size in (5, 6, 7, 8, 8.5)],
        [("push", name), ("MPC: planned", later("planned", 0)),
         ("capture point", figure("icp_settling_s", "{:.2f}", if_recovered=True)),
         ("largest H", too_much(0)), ("peak", peak_of(0)),
         ("baseline: planned", later("planned", 1)),
         ("its capture point", figure("icp_settling_s", "{:.2f}", run=1, if_recovered=True)),
         ("its largest H", too_much(1)), ("its peak", peak_of(1))]),
    "robot": Table(
        "Realistic robot: measured sensors, self-collision, joint speed limits, eight seeds each",
        [Row(text, [as_it_is(size, duration, seed, plant) for seed in range(1, 9)])
         for text, size, duration, plant in (
             ("4 N s, step of 0.6 s", 4, 0.6, "dart"), ("5 N s, step of 0.6 s", 5, 0.6, "dart"),
             ("6 N s, step of 0.6 s", 6, 0.6, "dart"), ("7 N s", 7, None, "dart"),
             ("8 N s", 8, None, "dart"), ("8 N s, step of 0.3 s", 8, 0.3, "dart"),
             ("10 N s, step of 0.3 s", 10, 0.3, "dart"),
             ("6 N s, step of 0.6 s, in MuJoCo", 6, 0.6, "mujoco"), ("7 N s, in MuJoCo", 7, None, "mujoco"))],
        [("push", name), ("recovered", seeds_recovered),
         ("largest H, Nms", worst("angular_momentum_max", "{:.2f}")),
         ("least clearance", worst("body.clearance_min_m", "{:.1f} mm", 1e3, least=True)),
         ("longest time above a speed limit", worst("body.joint_speed_over_s", "{:.0f} ms", 1e3)),
         ("largest joint speed / limit", worst("body.joint_speed_ratio_max", "{:.0f} %", 1e2)),
         ("nearest joint limit", worst("body.joint_limit_margin_rad", "{:.0f} mrad", 1e3, least=True)),
         ("slip of a corner", worst("body.slip_max_m", "{:.1f} mm", 1e3)),
         ("error of the CoM", worst("body.estimate_com_error_m", "{:.1f} mm", 1e3)),
         ("error of its velocity, RMS", worst("body.estimate_velocity_error_m_s", "{:.3f} m/s"))],
        quick=False),
    "stepping": Table(
        "Stepping compared with standing, by direction",
        [Row({0: "0 (forward)", 90: "90 (stance side)", 180: "180 (back)", 270: "270 (swing side)"}.get(
             degrees, f"{degrees:g}"),
             [toward(degrees, size, sensors, **settings) for sensors in ("ideal", "measured")
              for size in (6, 7, 8) for settings in ({}, {"stepping": "false"})])
         for degrees in (22.5 * k for k in range(16))],
        [("direction, degrees", name),
         ("ideal sensors, 6 / 7 / 8 N s", with_and_without_a_step("ideal", (6, 7, 8))),
         ("measured sensors, 6 / 7 / 8 N s", with_and_without_a_step("measured", (6, 7, 8)))],
        quick=False),
    "late": Table(
        "Delays of sensors and torques, preset robot in DART, step of 0.6 s",
        [Row(text, [{**as_it_is(size, 0.6, 1), **settings} for size in (4, 6)]) for text, settings in (
            ("default: 1 ms of delay, velocity filter of 1.5 ms", {}),
            ("velocity filter of 3 ms", {"sensor.velocity_lag_s": 0.003}),
            ("velocity filter of 5 ms", {"sensor.velocity_lag_s": 0.005}), ("velocity filter of 9 ms", {"sensor.velocity_lag_s": 0.009}),
            ("velocity filter of 19 ms", {"sensor.velocity_lag_s": 0.019}), ("velocity filter of 49 ms", {"sensor.velocity_lag_s": 0.049}),
            ("velocity filter of 89 ms", {"sensor.velocity_lag_s": 0.089}),
            *((f"all sensors delayed by {1000 * delay:g} ms", {f"sensor.{device}.delay": delay for device in (
                "encoder", "gyroscope", "accelerometer", "force_torque")}) for delay in (0.004, 0.006, 0.010)),
            ("motors of 50 Hz", {"motor.bandwidth_hz": 50}), ("motors of 20 Hz", {"motor.bandwidth_hz": 20}))],
        [("sensors", name), ("4 N s", outcome(0)),
         ("H of 4 N s, Nms", figure("angular_momentum_max", "{:.2f}")), ("6 N s", outcome(1)),
         ("H of 6 N s, Nms", figure("angular_momentum_max", "{:.2f}", run=1))],
        quick=False),
    "disturbances": Table(
        "6 N s in DART with a disturbance",
        [Row("none", [in_dart(6)]),
         Row("120 N for 0.05 s", [in_dart(6, push__duration=0.05)]),
         Row("30 N for 0.2 s", [in_dart(6, push__duration=0.2)]),
         Row("half-sine force for 0.1 s", [in_dart(6, push__shape="half_sine")]),
         Row("friction 0.4", [in_dart(6, simulator__friction=0.4)]),
         Row("nominal model with 5 % more mass", [in_dart(6, model__mass_error=0.05)]),
         Row("nominal model with 5 % less mass", [in_dart(6, model__mass_error=-0.05)]),
         Row("ground 1 cm higher", [in_dart(6, simulator__ground_step_m=0.01)]),
         Row("ground 1 cm lower", [in_dart(6, simulator__ground_step_m=-0.01)])],
        [("disturbance", name), ("recovered", outcome()), ("landing after", landing),
         ("capture point settles in", figure("icp_settling_s", "{:.2f} s")),
         ("slip of a corner", figure("body.slip_max_m", "{:.1f} mm", 1e3)),
         ("largest tilt", figure("body.base_tilt_max_rad", "{:.2f} rad"))],
        quick=False),
}
