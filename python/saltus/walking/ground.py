"""Stance feet over time, and the shape of the ground, from summary.json."""


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


def outlines(summary):
    """Closed outlines, x and y, of the parts of the ground that differ from level ground."""
    for box in summary.get("ground_boxes", [])[1:]:
        w, a, b, c = box["rotation"]
        along = (1 - 2 * (b * b + c * c), 2 * (a * b + w * c))
        across = (2 * (a * b - w * c), 1 - 2 * (a * a + c * c))
        up = (2 * (a * c + w * b), 2 * (b * c - w * a))
        corners = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5))
        yield [[box["position"][i] + u * box["size"][0] * along[i] + v * box["size"][1] * across[i]
                + 0.5 * box["size"][2] * up[i] for u, v in corners] for i in (0, 1)]
