"""Stance feet over time, from summary.json."""


def intervals(summary, begin, end):
    """(from, until, number of feet, corners) of the successive supports within [begin, end], s and m."""
    records = summary["ground"]
    ends = [record["from_s"] for record in records[1:]] + [float("inf")]
    for record, until in zip(records, ends):
        first, last = max(record["from_s"], begin), min(until, end)
        if first < last:
            yield first, last, record["left"] + record["right"], record["corners"]


def stood_at_first(summary):
    """The initial support in words."""
    first = summary["ground"][0]
    return "both feet" if first["left"] and first["right"] else "left foot" if first["left"] else "right foot"
