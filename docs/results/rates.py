"""Tables of push recovery over seeds: rates of the named experiments of `bench robustness`, and the cost of real
drives."""

import concurrent.futures
import dataclasses
import os
import sys
from typing import Tuple

from comparisons import COMPASS
from other_tables import OtherTable
from programs import ROOT
from tables import markdown, toward

sys.path.append(os.path.join(ROOT, "benchmarks/suite/scripts"))
import campaign  # noqa: E402
import robustness  # noqa: E402


@dataclasses.dataclass
class Rates(OtherTable):
    """Rates with their Wilson 95 % intervals."""
    parts: Tuple[Tuple[str, str, int], ...]  # experiment, plant, seeds
    by_condition: bool = False  # one row for each condition
    words = {"dart": "DART", "mujoco": "MuJoCo"}

    def jobs(self):
        """Row and settings of each run."""
        for experiment, plant, seeds in self.parts:
            for seed in range(1, seeds + 1):
                for condition, settings in robustness.EXPERIMENTS[experiment].cases(seed):
                    row = condition if self.by_condition else f"{robustness.EXPERIMENTS[experiment].about}, {self.words[plant]}"
                    yield row, {"plant": plant, **robustness.FIXED, "sensor.seed": seed, **settings}

    def runs(self):
        return sum(1 for _ in self.jobs())

    def shape(self):
        return next(robustness.rate_table([])), len({row for row, _ in self.jobs()}) + self.by_condition

    def make(self, programs):
        jobs = list(self.jobs())
        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            lines = [{**campaign.measures_of(found), "verdict": "recovered" if found["recovered"] else "not recovered",
                      "drawn": {"condition": row}}
                     for (row, _), found in zip(jobs, pool.map(programs.outcome, [settings for _, settings in jobs]))]
        titles, *rows = robustness.rate_table(lines)
        return markdown(titles, rows if self.by_condition else rows[:-1])  # a sum of experiments means nothing


class CostOfDrives(OtherTable):
    """The largest recovered push by direction, by bisection to 1 N s (assuming that recovery is monotone)."""
    most = 24  # N s, not recovered in any direction
    columns = {"ideal drives": ("ideal", "recovered"), "real drives": ("real", "recovered"),
               "real drives, also hardware-safe": ("real", "hardware_safe"), "real drives, stands": ("real", "stands")}
    exact = tuple(columns)

    def runs(self):
        return len(COMPASS) * len(self.columns) * 5

    def shape(self):
        return ["direction", *self.columns], len(COMPASS)

    def largest(self, programs, degrees, column):
        drives, verdict = self.columns[column]
        good, bad = 0, self.most
        while bad - good > 1:
            size = (good + bad) // 2
            found = programs.outcome({**toward(degrees, size, "measured"), "step.planner": "ocp", "drives": drives})
            is_good = not found["fell"] if verdict == "stands" else found["recovered"] and found[verdict]
            good, bad = (size, bad) if is_good else (good, size)
        return good

    def make(self, programs):
        with concurrent.futures.ThreadPoolExecutor(programs.jobs) as pool:
            rows = pool.map(lambda degrees: [f"{self.largest(programs, degrees, column):g}" for column in self.columns],
                            COMPASS)
            return markdown(self.shape()[0], [[word, *row] for word, row in zip(COMPASS.values(), rows)])


RATES = {
    "cost_of_drives": CostOfDrives("Largest recovered push, N s, with ideal and real drives, in DART"),
    "rates": Rates("Rates of recovery with real drives and measured sensors",
                   (("swing_side_7", "dart", 100), ("swing_side_7", "mujoco", 20), ("swing_side_10", "dart", 100),
                    ("swing_side_10", "mujoco", 20), ("two_feet_8", "dart", 5), ("pushes_one_foot", "dart", 20),
                    ("pushes_two_feet", "dart", 20))),
    "mismatch": Rates("Rates of recovery from 7 N s with errors of the controllers' model, in DART",
                      (("mismatch", "dart", 10),), by_condition=True),
    "unknown_ground": Rates("Rates of recovery from 7 N s on unknown ground, in DART",
                            (("unknown_ground", "dart", 1000),), by_condition=True),
    "unknown_ground_mujoco": Rates("Rates of recovery from 7 N s on unknown ground, in MuJoCo",
                                   (("unknown_ground", "mujoco", 100),), by_condition=True),
    "height_3_cm": Rates("Rates of recovery from 7 N s on ground 3 cm lower or higher, in DART",
                         (("height_3_cm", "dart", 20),), by_condition=True),
}
