"""Tables of push recovery that compare choices: the time of the step, the losses of the real robot, the constants of
the baseline, solvers, and whole-body controllers."""

import statistics

from programs import rows_of
from tables import PAPER, Row, Table, as_it_is, figure, in_dart, name, push, toward

COMPASS = {0: "forward", 45: "forward left", 90: "left (stance side)", 135: "back left", 180: "back",
           225: "back right", 270: "right (swing side)", 315: "forward right"}


def momentum_or_reason(run):
    def cell(row, summaries):
        summary = summaries[run]
        if summary["fell"]:
            return "falls"
        word = f"{summary['angular_momentum_max']:.2f}"
        return word if summary["recovered"] else f"{word}, {summary['reason'].split(';')[0]}"
    return cell


# --- time and decision of the step ----------------------------------------------------------------

CONDITIONS = (("ideal", PAPER), ("ideal", {}), ("measured", {}))


def decided(word, *pushes, duration=0.1):
    longer = {} if duration == 0.1 else {"push.duration": duration}
    return Row(word, [toward(degrees, size, sensors, **preset, **longer)
                      for sensors, preset in CONDITIONS for degrees, size in pushes])


def recovered_with(condition):
    """The number of recovered runs, and their largest |H|."""
    def cell(row, summaries):
        count = len(summaries) // len(CONDITIONS)
        part = summaries[condition * count:(condition + 1) * count]
        values = [s["angular_momentum_max"] for s in part if s["recovered"]]
        if count == 1:
            return f"{values[0]:.2f}" if values else "falls" if part[0]["fell"] else part[0]["reason"]
        number = f"{len(values)} of {count}"
        return f"{number}, {min(values):.2f} to {max(values):.2f}" if values else number
    return cell


DECISIONS = Table(
    "Time of the step, in DART, push at 1 s; largest |H| in Nms of recovered runs",
    [decided("towards the stance side: 45 degrees 8 N s; 60: 6.5 and 7; 90: 6; 120: 7; 135: 8",
             (45, 8), (60, 6.5), (60, 7), (90, 6), (120, 7), (135, 8)),
     decided("right, 10 N s in 0.4 s", (270, 10), duration=0.4), decided("right, 12 N s in 0.5 s", (270, 12), duration=0.5),
     decided("right, 8 N s in 0.1 s", (270, 8))],
    [("push", name), ("preset paper", recovered_with(0)), ("preset robot, ideal sensors", recovered_with(1)),
     ("preset robot", recovered_with(2))],
    quick=False)


# --- losses by measured sensors -------------------------------------------------------------------

def with_short_steps(degrees):
    def run(size, sensors):
        if degrees == 270 and sensors == "measured":
            return as_it_is(size, 0.3, 1)  # also a run of the table `robot`
        return toward(degrees, size, sensors, **{"step.duration": 0.3})
    return Row(COMPASS[degrees], [run(size, sensors) for size in (8, 10) for sensors in ("ideal", "measured")])


SHORT_STEPS = Table(
    "Measured and ideal sensors, preset robot, step of 0.3 s; largest |H| in Nms",
    [with_short_steps(degrees) for degrees in (225, 270)],
    [("direction", name),
     *((f"{size} N s, {sensors} sensors", momentum_or_reason(run))
       for run, (size, sensors) in enumerate((size, sensors) for size in (8, 10) for sensors in ("ideal", "measured")))],
    quick=False)


# --- the constants of the baseline ----------------------------------------------------------------

def baseline(time):
    return Row(f"{time:g} s" + (" (the default)" if time == 0.8 else ""),
               [in_dart(size, push__start=0.5, controller="capture_point", capture_point__after_landing_s=time)
                for size in (6, 8)])


def planned_forces(row, summaries):
    values = [summaries[0]["force_settling"][f"planned_{foot}_s"] for foot in ("left", "right")]
    return "never" if None in values else f"{max(values):.2f}"


BASELINE = Table(
    "End of the baseline's trajectory, in DART, step of 0.6 s, push at 0.5 s",
    [baseline(time) for time in (0.5, 0.6, 0.8)],
    [("end after the landing", name), ("6 N s: capture point, s", figure("icp_settling_s", "{:.2f}")),
     ("planned forces, s", planned_forces), ("8 N s: H, Nms", momentum_or_reason(1))],
    quick=False)


# --- solvers of one tick --------------------------------------------------------------------------

def ticks(summary):
    return rows_of(summary["folder"], "ticks.csv")


def iterations(row, summaries):
    counts = [int(tick["iterations"]) for tick in ticks(summaries[0])]
    return f"{statistics.mean(counts):.1f} / {max(counts)}"


def median_time(row, summaries):
    return f"{1e-3 * summaries[0]['solve_us']['median']:.2f} ms"


SOLVERS_OF_A_TICK = Table(
    "Solvers of one tick, 7 N s on the centroidal model",
    [Row(solver, [push(7, solver=solver)]) for solver in ("riccati", "sparse")],
    [("solver", name), ("iterations per tick, mean / most", iterations), ("median tick", median_time)],
    timed=("median tick",))


# --- whole-body controllers -----------------------------------------------------------------------

STANDING, STEPPING = (3.5, 4, 4.2, 4.4, 4.6, 4.8), (4, 5, 5.5, 6, 8)


def of_controller(controller, stepping):
    """Empty for impulses without such a run."""
    def cell(row, summaries):
        for summary, settings in zip(summaries, row.runs):
            if (settings.get("whole_body.controller", "inverse_dynamics") == controller
                    and settings.get("stepping", "true") == stepping):
                return momentum_or_reason(0)(row, [summary])
        return ""
    return cell


def pushed_early(size):
    runs = []
    for choice in ({"whole_body__controller": "momentum"}, {}):
        if size in STANDING:
            runs.append(in_dart(size, push__start=0.3, stepping="false", **choice))
        if size in STEPPING:
            runs.append(in_dart(size, push__start=0.3, **choice))
    return Row(f"{size:g} N s", runs)


MOMENTUM = Table(
    "Momentum control from the literature and inverse dynamics, in DART, step of 0.6 s, push at 0.3 s",
    [pushed_early(size) for size in sorted({*STANDING, *STEPPING})],
    [("push", name), *((f"{word}, {step}", of_controller(controller, stepping))
                       for step, stepping in (("standing", "false"), ("with a step", "true"))
                       for word, controller in (("momentum", "momentum"),
                                                ("inverse dynamics", "inverse_dynamics")))],
    quick=False)

COMPARISONS = {"decisions": DECISIONS, "short_steps": SHORT_STEPS, "baseline": BASELINE, "ticks": SOLVERS_OF_A_TICK,
               "momentum": MOMENTUM}
