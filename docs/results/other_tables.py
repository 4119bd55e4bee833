"""Tables that are not rows of push recovery's runs: the suite, survival maps, other humanoids, solvers."""

import concurrent.futures
import dataclasses
import math
import os
import re
import statistics
from typing import Tuple

from comparisons import COMPASS
from programs import ROOT, humanoid, rows_of
from tables import README, markdown, toward


STEP_PLANNING = "problems/push_recovery/step_experiments.md"


@dataclasses.dataclass
class OtherTable:
    """Defaults of all tables of this file."""
    title: str
    readme = README  # the page with the table
    quick = False
    timed = ()  # columns with computing times
    exact = ()  # columns with counts and names


@dataclasses.dataclass
class Suite(OtherTable):
    """Cases of the library with computed and known values."""
    cases: Tuple[str, ...]
    readme = "problems/README.md"
    quick = True
    titles = ("case", "value", "reference", "digits", "between", "status")

    def runs(self):
        return len(self.cases)

    def shape(self):
        return list(self.titles), len(self.cases)

    def make(self, programs):
        rows = []
        for case in self.cases:
            found = next(c for c in programs.suite("ipopt", case)["cases"] if c["id"] == case)
            value = found["checked"][0]
            between = found["between_nodes"]
            known = min(value["digits_known"], 12)
            rows.append([f"{case} {found['name']}", f"{value['value']:.{min(known, 7)}g}",
                         f"{value['reference']:.{known}g}",
                         f"{value['digits_reached']}/{value['digits_known']}",
                         "-" if between is None else f"{between:.0e}" if between else "0", found["verdict"]])
        return markdown(list(self.titles), rows)


class Solvers(OtherTable):
    """The number of cases of the library that each solver solves."""
    readme = "README.md"
    exact = ("applicable cases", "within tolerance")
    names = ("ipopt", "sparse", "riccati")
    titles = ("solver", "applicable cases", "within tolerance")

    def runs(self):
        return len(self.names)

    def shape(self):
        return list(self.titles), len(self.names)

    def make(self, programs):
        rows = []
        for solver in self.names:
            found = programs.suite(solver)
            met = found["within_tolerance"]
            rows.append([solver, str(met + found["missed"] + found["failed"]), str(met)])
        return markdown(list(self.titles), rows)


class Library(OtherTable):
    """Computing times of the optimisation problems of the library: medians of several runs of the suite."""
    readme = "docs/gallery.md"
    repeats = 5
    solvers = ("ipopt", "sparse", "riccati")
    titles = ("problem", "ipopt, ms", "sparse, ms", "riccati, ms")
    timed = ("ipopt, ms", "sparse, ms", "riccati, ms")

    def runs(self):
        return self.repeats * len(self.solvers)

    def shape(self):
        with open(os.path.join(ROOT, "problems/library/cases.hpp"), encoding="utf-8") as file:
            return list(self.titles), len(re.findall(r"^ReferenceCase \w+\(\);", file.read(), re.MULTILINE))

    def make(self, programs):
        found = {solver: [{case["id"]: case for case in programs.suite(solver, repeat=repeat)["cases"]}
                          for repeat in range(self.repeats)] for solver in self.solvers}
        rows = []
        for name, case in found["ipopt"][0].items():
            if case["kind"] != "optimisation" or name == "C01":  # C01 is a set of quadratic programs from files
                continue
            times = (statistics.median(run[name]["seconds"] for run in found[solver]) for solver in self.solvers)
            rows.append([f"{name} {case['name']}", *(f"{1e3 * time:.1f}" for time in times)])
        return markdown(list(self.titles), rows)


def unbroken(rows, controller, step_time, direction):
    """The largest impulse up to which all pushes are recovered, and the bound of the pendulum there."""
    cells = sorted((float(r["impulse_ns"]), r["outcome"], float(r["bound_ns"])) for r in rows
                   if r["controller"] == controller and float(r["step_time_s"]) == step_time
                   and float(r["direction_deg"]) == direction)
    largest = 0.0
    for impulse, outcome, _ in cells:
        if outcome != "recovered":
            break
        largest = impulse
    return largest, cells[0][2]


@dataclasses.dataclass
class Map(OtherTable):
    """Rays of a survival map, and its picture."""
    arguments: Tuple[str, ...]
    step_times: Tuple[float, ...]
    directions: int
    picture: str

    def runs(self):
        return 1

    def _columns(self):
        columns = []
        for time in self.step_times:
            word = f", {time:g} s" if len(self.step_times) > 1 else ""
            columns += [("MPC" + word, "mpc", time, False), ("baseline" + word, "capture_point", time, False)]
        columns.append(("no step", "none", 0.0, False))
        for time in self.step_times:
            word = f", step of {time:g} s" if len(self.step_times) > 1 else ", step"
            columns.append(("pendulum's bound" + word, "mpc", time, True))
        columns.append(("pendulum's bound, no step", "none", 0.0, True))
        return columns

    def shape(self):
        return ["direction", *(title for title, *_ in self._columns())], self.directions

    @property
    def exact(self):
        """Cells of a map."""
        return self.shape()[0][1:]

    def make(self, programs):
        folder = programs.survival_map(*self.arguments)
        programs.pictures[self.picture] = folder + "/map.png"
        rows = rows_of(folder)
        lines = []
        for i in range(self.directions):
            direction = 360.0 * i / self.directions
            line = [COMPASS.get(direction, f"{direction:g} degrees")]
            for _, controller, time, is_bound in self._columns():
                largest, bound = unbroken(rows, controller, time, direction)
                line.append(f"{bound:.1f}" if is_bound else f"{largest:g}" if largest else "below 1")
            lines.append(line)
        return markdown(self.shape()[0], lines)


class Lost(OtherTable):
    """The largest push up to which all pushes are recovered, of the map in DART and of the table `stepping`."""
    sizes = (6, 7, 8)
    sensors = ("ideal", "measured")

    def runs(self):
        return 1 + len(COMPASS) * len(self.sizes) * len(self.sensors)

    def shape(self):
        tried = " / ".join(f"{size:g}" for size in self.sizes)
        return ["direction", "preset paper, MPC",
                *(f"preset robot, {sensors} sensors, of {tried}" for sensors in self.sensors)], len(COMPASS)

    @property
    def exact(self):
        """Cells of a map."""
        return self.shape()[0][1:]

    def make(self, programs):
        rows = rows_of(programs.survival_map(*OTHER_TABLES["map_dart"].arguments))
        lines = []
        for degrees, word in COMPASS.items():
            line = [word, f"{unbroken(rows, 'mpc', 0.6, degrees)[0]:g}"]
            for sensors in self.sensors:
                largest = f"below {self.sizes[0]:g}"
                for size in self.sizes:
                    if not programs.run(toward(degrees, size, sensors))["recovered"]:
                        break
                    largest = f"{size:g}"
                line.append(largest)
            lines.append(line)
        return markdown(self.shape()[0], lines)


@dataclasses.dataclass
class StepMap(OtherTable):
    """The gain from each freedom of the step planner on the pendulum, from the program step_map, with its picture."""
    picture: str
    variants = {"fixed": "time and place fixed", "place": "place free", "time": "time free", "both": "both",
                "steps": "up to three steps", "bound_0": "bound: no step", "bound_1": "one step",
                "bound_3": "three steps"}
    columns = (("area of the map, (N s)^2", "area", "{:.0f}"), ("forward, N s", "0.00", "{:.1f}"),
               ("to the right", "270.00", "{:.1f}"), ("to the left", "90.00", "{:.1f}"))

    def runs(self):
        return 1

    def shape(self):
        return ["free variables", *(title for title, *_ in self.columns), "area on two feet"], len(self.variants)

    def make(self, programs):
        table, picture = programs.drawn("step_map", "plot_step_map")
        programs.pictures[self.picture] = picture
        rows, on_two_feet = ({row["direction"]: row for row in rows_of(*os.path.split(made))}
                             for made in (table, programs.beside("step_map", "both")))
        return markdown(self.shape()[0], [
            [word, *(text.format(float(rows[direction][variant])) for _, direction, text in self.columns),
             f"{float(on_two_feet['area'][variant]):.0f}"]
            for variant, word in self.variants.items()])


class Humanoids(OtherTable):
    """Other humanoids, described from their URDF alone."""
    readme = "robots/README.md"
    robots = (("Unitree G1", "example-robot-data", "robots/g1_description/urdf/g1_29dof_rev_1_0.urdf"),
              ("Talos", "example-robot-data", "robots/talos_data/robots/talos_reduced.urdf"),
              ("JVRC1", "jvrc-description", "jvrc_description/urdf/jvrc1.urdf"))
    pushes = tuple((plant, impulse) for plant in ("dart", "mujoco") for impulse in (4, 8))
    words = {"dart": "DART", "mujoco": "MuJoCo"}

    def runs(self):
        return len(self.robots) * len(self.pushes)

    def shape(self):
        return ["robot", *(f"{self.words[plant]}, {impulse} N s" for plant, impulse in self.pushes)], len(self.robots)

    def make(self, programs):
        files = [programs.new_robot(humanoid(package, path)) for _, package, path in self.robots]

        def outcome(job):
            file, (plant, impulse) = job
            found = programs.run({"config": file, "plant": plant, "push.impulse": impulse, "step.planner": "icp_formula"})
            return "recovered" if found["recovered"] else found["reason"]
        jobs = [(file, one) for file in files for one in self.pushes]
        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            outcomes = list(pool.map(outcome, jobs))
        n = len(self.pushes)
        return markdown(self.shape()[0], [[robot[0], *outcomes[i * n:(i + 1) * n]]
                                          for i, robot in enumerate(self.robots)])


class Freedoms(OtherTable):
    """The gain from each freedom of the step on the whole body, by bisection to 1 N s (assuming that survival is
    monotone)."""
    readme = STEP_PLANNING
    exact = ("forward, N s", "to the right", "back", "to the left")
    directions = 8
    most = {"push_formula": 16, "ocp": 24}  # N s, by planner: not survived by any variant
    told = {"step.planner": "push_formula", "step.duration": 0.6}
    in_place = {"step.reach": "settings", "step.forward_max": 0.001, "step.lateral_min": 0.139, "step.lateral_max": 0.141}
    variants = {"time and place fixed, push known (the paper)": {**told, "step.placement": "fixed"},
                "place free, push known": told,
                "time free, push unknown": {"step.planner": "ocp", "step.most": 1, **in_place},
                "both free": {"step.planner": "ocp", "step.most": 1},
                "up to two steps": {"step.planner": "ocp"}}
    bounds = {"bound: no step": "none", "two steps": "mpc"}
    columns = ("area of the map, (N s)^2", "share of the bound", "forward, N s", "to the right", "back", "to the left")
    shown = (0, 270, 180, 90)

    def runs(self):
        return sum(self.directions * math.ceil(math.log2(self.most[settings["step.planner"]]))
                   for settings in self.variants.values()) + 1

    def shape(self):
        return ["free variables", *self.columns], len(self.variants) + len(self.bounds)

    def angles(self):
        return [360.0 * i / self.directions for i in range(self.directions)]

    def largest(self, programs, variant, degrees):
        survived, fallen = 0, self.most[self.variants[variant]["step.planner"]]
        while fallen - survived > 1:
            size = (survived + fallen) // 2
            settings = {**toward(degrees, size, "measured"), **self.variants[variant]}
            if programs.run(settings)["recovered"]:
                survived = size
            else:
                fallen = size
        return survived

    def line(self, word, radii, bound):
        text = "{:.1f}" if word in self.bounds else "{:.0f}"
        return [word, f"{area(radii):.0f}", "" if word in self.bounds else f"{100 * area(radii) / bound:.0f} %",
                *(text.format(radii[self.angles().index(degrees)]) for degrees in self.shown)]

    def make(self, programs):
        # The bound does not depend on the plant, so the smallest map suffices.
        rows = rows_of(programs.survival_map("--directions", str(self.directions), "--impulses", "1",
                                             "--controllers", "mpc,none", "--set", "step.planner=ocp"))
        bounds = {word: [unbroken(rows, controller, 0.0, degrees)[1] for degrees in self.angles()]
                  for word, controller in self.bounds.items()}
        jobs = [(variant, degrees) for degrees in self.angles() for variant in self.variants]
        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            largest = dict(zip(jobs, pool.map(lambda job: self.largest(programs, *job), jobs)))
        all_radii = {**{variant: [largest[variant, degrees] for degrees in self.angles()] for variant in self.variants},
                     **bounds}
        most = area(bounds["two steps"])
        return markdown(self.shape()[0], [self.line(word, radii, most) for word, radii in all_radii.items()])


def area(radii):
    """Area of the polygon with these radii, evenly spaced."""
    return 0.5 * math.sin(2 * math.pi / len(radii)) * sum(a * b for a, b in zip(radii, radii[1:] + radii[:1]))


class Agreement(OtherTable):
    """Cells at the limit of recovery with steps by optimal control, in both engines."""
    readme = STEP_PLANNING
    exact = ("N s",)
    border = {0: 17, 45: 8, 90: 6, 135: 8, 180: 13, 225: 14, 270: 16, 315: 20}  # N s, largest push recovered in DART
    engines = {"dart": "DART", "mujoco": "MuJoCo"}

    def runs(self):
        return 2 * len(self.border) * len(self.engines)

    def shape(self):
        return ["direction, degrees", "N s", *self.engines.values(), "agree"], len(self.border) + 1

    @staticmethod
    def word(found):
        if found["recovered"]:
            return "recovered"
        return "falls" if found["fell"] else "slips" if "slipped" in found["reason"] else "turns"

    def make(self, programs):
        cells = [(degrees, size) for degrees, largest in self.border.items() for size in (largest, largest + 1)]
        jobs = [(engine, *cell) for cell in cells for engine in self.engines]

        def run(job):
            engine, degrees, size = job
            return programs.run({**toward(degrees, size, "measured"), "step.planner": "ocp", "plant": engine})

        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            found = dict(zip(jobs, pool.map(run, jobs)))
        rows, agree = [], 0
        for degrees, largest in self.border.items():
            sizes = (largest, largest + 1)
            same = sum(found["dart", degrees, size]["recovered"] == found["mujoco", degrees, size]["recovered"]
                       for size in sizes)
            agree += same
            rows.append([f"{degrees:g}", " / ".join(map(str, sizes)),
                         *(" / ".join(self.word(found[engine, degrees, size]) for size in sizes) for engine in self.engines),
                         f"{same} of 2"])
        return markdown(self.shape()[0], [*rows, ["all", "", "", "", f"{agree} of {len(cells)}"]])


OTHER_TABLES = {
    "suite": Suite("Problems of the library compared with their known answers, solved by Ipopt",
                   ("A01", "A02", "B01", "B07", "B10", "C03", "D02", "D12")),
    "solvers": Solvers("Cases of the library that each solver solves"),
    "library": Library("Computing times of the problems of the library, each as one cold solve"),
    "map_centroidal": Map("Survival on the centroidal model", ("--set", "step.planner=push_formula"), (0.6, 0.45, 0.3), 16,
                          "problems/push_recovery/map_centroidal.png"),
    "map_dart": Map("Survival of the whole body in DART, preset paper",
                    ("--plant", "dart", "--set", "preset=paper", "--set", "step.planner=push_formula", "--directions", "8",
                     "--step-times", "0.6"),
                    (0.6,), 8, "problems/push_recovery/map_dart.png"),
    "lost": Lost("Loss against the ideal robot: largest push, N s, up to which all pushes are recovered"),
    "step_map": StepMap("Gain from each freedom of the step planner on the pendulum",
                        "problems/push_recovery/step_map.png"),
    "freedoms": Freedoms("Gain from each freedom of the step in DART: largest recovered push, preset robot, left foot"),
    "borders": Agreement("Pushes at the limit of recovery, in DART and in MuJoCo"),
    "humanoids": Humanoids("Humanoids described by `saltus robot new` alone, preset robot"),
}
