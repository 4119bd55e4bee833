"""Numbers in the READMEs' prose: the words around them, and the runs that they come from.

A sentence is in order if the README says exactly these words with these numbers (however its lines are broken)."""

import dataclasses
import math
from typing import Callable, Dict, List

from programs import rows_of
from tables import README, in_dart, push


@dataclasses.dataclass
class Sentence:
    words: str  # with {} where the numbers come
    runs: List[Dict[str, object]]
    numbers: Callable  # (summaries) -> the numbers
    readme: str = README
    quick: bool = True

    def make(self, programs):
        return self.words.format(*self.numbers([programs.run(settings) for settings in self.runs]))


def momentum(summary):
    return summary["angular_momentum_max"]


def outcomes(summaries):
    """A word of each run."""
    return ["recovered" if s["recovered"] else s["reason"] for s in summaries]


def all_recovered(summaries):
    """Nothing if so; else whom to look at, which no README says."""
    return "; ".join(f"NOT SO: {s['push_impulse_ns']:g} N s: {s['reason']}"
                     for s in summaries if not s["recovered"])


def furthest(summary):
    """The largest distance of the capture point from where it was when the push began, m."""
    rows = [(float(r["t"]), float(r["icp_x"]), float(r["icp_y"]))
            for r in rows_of(summary["folder"], "trajectory.csv")]
    _, x, y = next(r for r in rows if r[0] > summary["push_start_s"] - 1e-9)
    return max(math.hypot(r[1] - x, r[2] - y) for r in rows)


def later(size, **settings):
    """Pushed at 0.3 s, which spares two seconds of standing."""
    return in_dart(size, push__start=0.3, **settings)


SHORT = [in_dart(size, step__duration=0.3) for size in (8, 10, 12, 14, 16)]
PLACED = {"step__placement": "fixed", "step__fixed_place": "[0,0.14]"}

SENTENCES = {
    "edge_of_8": Sentence(
        "the angular momentum may reach 1 Nms, and does so between 8 N s ({:.2f}) and 8.2 N s ({:.2f}, not recovered)",
        [in_dart(8), in_dart(8.2)], lambda s: [momentum(s[0]), momentum(s[1])]),
    "short_steps": Sentence(
        "a step of 0.3 s: 8, 10, 12, 14 and 16 N s{} (capture point settled in {:.2f} s up to 14 N s, {:.2f} s at 16;",
        SHORT, lambda s: [all_recovered(s), max(x["icp_settling_s"] for x in s[:4]), s[4]["icp_settling_s"]],
        quick=False),
    "fixed_place": Sentence(
        "0.14 m beside the stance sole: 6 N s with a step of 0.6 s and 11 with 0.3 s{} (6.2 and 11.5 fall{})",
        [in_dart(6, **PLACED), in_dart(11, step__duration=0.3, **PLACED),
         in_dart(6.2, **PLACED), in_dart(11.5, step__duration=0.3, **PLACED)],
        lambda s: [all_recovered(s[:2]), "" if all(x["fell"] for x in s[2:]) else " NOT SO"], quick=False),
    "engines": Sentence(
        "4 to 7 N s in MuJoCo: farthest capture point within {:.1f} mm, touch-down within {:.0f} ms of DART",
        [push(size, plant=plant) for size in (4, 5, 6, 7) for plant in ("dart", "mujoco")],
        lambda s: [1e3 * max(abs(furthest(a) - furthest(b)) for a, b in zip(s[::2], s[1::2])),
                   1e3 * max(abs(a["touchdown_s"] - b["touchdown_s"])
                             for a, b in zip(s[2::2], s[3::2]))], quick=False),
    "momentum_standing": Sentence(
        "| momentum | 3.5, 4, 4.2, 4.4{}; 4.6 falls{} |",
        [later(size, stepping="false", whole_body__controller="momentum") for size in (3.5, 4, 4.2, 4.4, 4.6)],
        lambda s: [all_recovered(s[:4]), "" if s[4]["fell"] else " NOT SO"], quick=False),
    "inverse_dynamics_standing": Sentence(
        "| inverse dynamics | 3.5, 4, 4.2, 4.4, 4.6{}; 4.8 falls{} |",
        [later(size, stepping="false") for size in (3.5, 4, 4.2, 4.4, 4.6, 4.8)],
        lambda s: [all_recovered(s[:5]), "" if s[5]["fell"] else " NOT SO"], quick=False),
    "mirror": Sentence(
        "in DART at 6 N s the farthest capture point to {:.2f} mm and the touch-down to the millisecond{}",
        [in_dart(6), in_dart(6, stance="right", push__direction="[0,1,0]")],
        lambda s: [1e3 * abs(furthest(s[0]) - furthest(s[1])),
                   "" if abs(s[0]["touchdown_s"] - s[1]["touchdown_s"]) < 1.5e-3 else " NOT SO"]),
}
