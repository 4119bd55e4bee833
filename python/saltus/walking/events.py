"""Pushes and landings of a run, from summary.json."""


def pushes(summary):
    """Pushes in order, without those of zero size and those after the end of the run: start_s, duration_s,
    impulse_ns, direction (None: unknown)."""
    asked = summary.get("pushes")
    if asked is None:  # results of a version that stored only the first push
        asked = [{"start_s": summary["push_start_s"], "duration_s": summary["push_duration_s"],
                  "impulse_ns": summary["push_impulse_ns"], "direction": summary.get("push_direction")}]
    return [push for push in asked if push["impulse_ns"] and push["start_s"] < summary["end_s"]]


def landings(summary):
    """Landing times, s."""
    times = [step["touchdown_s"] for step in summary.get("steps", [])] or [summary["touchdown_s"]]
    return [time for time in times if time is not None]


def span(summary, before, after):
    """The interesting interval, s: from a time before the first push to a time after the last push or landing.
    It begins at the start without pushes and ends at the end without landings."""
    given = pushes(summary)
    begin = max(0.0, given[0]["start_s"] - before) if given else 0.0
    last = max([push["start_s"] + push["duration_s"] for push in given] + landings(summary), default=float("inf"))
    return begin, min(summary["end_s"], last + after)


def impulse_in_words(summary):
    """A short description of all pushes, for a title."""
    sizes = [push["impulse_ns"] for push in pushes(summary)]
    if not sizes:
        return "no push"
    least, most = (f"{f(sizes):.3g}" if len(sizes) > 1 else f"{f(sizes):g}" for f in (min, max))
    size = f"{least} N s" if least == most else f"{least} to {most} N s"
    return size if len(sizes) == 1 else f"{len(sizes)} pushes of {size}"
