"""Units of the tables of a legged robot's run, whose columns carry none: trajectory, body, ticks, steps, plans."""

import re

# The first that fits a whole name counts.
_RULES = [(re.compile(pattern), unit) for pattern, unit in [
    (r"com_[xyz]|icp_[xy]|base_[xyz]|stance_[xyz]|(left|right)_sole_[xyz]|(left|right)_slip", "m"),
    (r"(alternative_\d+_)?place_[xyz]|landed_[xyz]|icp_slack_m", "m"),
    (r"vel_[xyz]|.*_velocity_[xyz]", "m/s"),
    (r"h_[xyz]", "Nms"),
    (r"push_[xyz]|(left|right)(_\w+)?_f[xyz]", "N"),
    (r"tau_\w+|(left|right)(_\w+)?_t[xyz]", "Nm"),
    (r"dq_\w+", "rad/s"),
    (r"q_\w+", "rad"),
    (r"lift_off|due|touchdown|(alternative_\d+_)?landing", "s"),
    (r"\w+_us", "us"),
]]


def unit_of(column):
    """"" where it has none, or none is known."""
    name = column.removeprefix("estimate_")
    return next((unit for pattern, unit in _RULES if pattern.fullmatch(name)), "")
