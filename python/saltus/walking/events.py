"""What happens to a robot in a run, of summary.json: pushes and landings."""


def pushes(summary):
    """One after the other, without those of nothing and those that the run did not live to see: start_s, duration_s,
    impulse_ns, direction (None: not known)."""
    asked = summary.get("pushes")
    if asked is None:  # of a version that told of the first one alone
        asked = [{"start_s": summary["push_start_s"], "duration_s": summary["push_duration_s"],
                  "impulse_ns": summary["push_impulse_ns"], "direction": summary.get("push_direction")}]
    return [push for push in asked if push["impulse_ns"] and push["start_s"] < summary["end_s"]]


def landings(summary):
    """Times, s."""
    times = [step["touchdown_s"] for step in summary.get("steps", [])] or [summary["touchdown_s"]]
    return [time for time in times if time is not None]


def span(summary, before, after):
    """What is worth seeing, s: from so long before the first push until so long after the last push or landing.
    Without pushes from the start, and without landings to the end."""
    given = pushes(summary)
    begin = max(0.0, given[0]["start_s"] - before) if given else 0.0
    last = max([push["start_s"] + push["duration_s"] for push in given] + landings(summary), default=float("inf"))
    return begin, min(summary["end_s"], last + after)


def impulse_in_words(summary):
    """Of all pushes, short enough for a title."""
    sizes = [push["impulse_ns"] for push in pushes(summary)]
    if not sizes:
        return "no push"
    least, most = (f"{f(sizes):.3g}" if len(sizes) > 1 else f"{f(sizes):g}" for f in (min, max))
    size = f"{least} N s" if least == most else f"{least} to {most} N s"
    return size if len(sizes) == 1 else f"{len(sizes)} pushes of {size}"
