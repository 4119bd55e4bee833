"""Measures a long run of `saltus control` against `saltus robot serve`: allocations, page faults, growth, latency.

Usage: soak_control.py SALTUS COUNTER [--minutes 30] [--pace 1] [--skip 5] [--faults 0] [--out DIR] [-- OPTION ...]

COUNTER is the library of count_allocations_of_program.c. `--pace` slows the robot for a loaded machine. Exits with 1 if
the thread of the control loop allocated or had page faults after the first `--skip` seconds, or if the process grew by
more than 1 MB. The thread of the log may allocate. Its share is printed.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time

GROWTH = 1024  # kB, for the buffers of the log


def faults_and_size(pid):
    """Page faults of the main thread, and the resident size of the process in kB."""
    with open(f"/proc/{pid}/task/{pid}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    with open(f"/proc/{pid}/statm", encoding="ascii") as file:
        pages = int(file.read().split()[1])
    return int(fields[7]) + int(fields[9]), pages * os.sysconf("SC_PAGE_SIZE") // 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("saltus")
    parser.add_argument("counter")
    parser.add_argument("--minutes", type=float, default=30.0, help="wall-clock time in balance")
    parser.add_argument("--pace", type=float, default=1.0, help="wall-clock time per time of the robot")
    parser.add_argument("--skip", type=float, default=5.0, help="wall-clock seconds at the start that do not count")
    parser.add_argument("--faults", type=int, default=0, help="page faults that are permitted")
    parser.add_argument("--out", help="folder of the log; default: a temporary one")
    parser.add_argument("options", nargs="*", help="further options of `saltus control`")
    o = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="saltus-soak-") as folder:
        out = o.out or os.path.join(folder, "log")
        counts = os.path.join(folder, "allocations")
        control = subprocess.Popen([o.saltus, "control", "--link", "udp:0", "--out", out, "--log-every", "10", *o.options],
                                   env={**os.environ, "LD_PRELOAD": os.path.abspath(o.counter),
                                        "SALTUS_ALLOCATIONS": counts}, stdout=subprocess.PIPE, text=True)
        line = control.stdout.readline()
        port = re.search(r"UDP port (\d+)", line)
        if not port:
            print("soak: no controller: " + line)
            return 1
        seconds = 60.0 * o.minutes
        robot = subprocess.Popen([o.saltus, "robot", "serve", "--link", "udp:" + port[1], "--pace", str(o.pace), "--time",
                                  str((seconds + o.skip) / o.pace), "--guard", str(max(0.015, 0.05 / max(o.pace, 1e-3)))],
                                 stdout=subprocess.PIPE, text=True)
        time.sleep(o.skip)
        begin, begin_at = faults_and_size(control.pid), time.monotonic()
        end, end_at = begin, begin_at
        while robot.poll() is None and time.monotonic() < begin_at + seconds - 1.0:
            time.sleep(min(10.0, max(0.1, begin_at + seconds - 1.0 - time.monotonic())))
            if control.poll() is None:
                end, end_at = faults_and_size(control.pid), time.monotonic()
        text = robot.communicate(timeout=120)[0] + control.communicate(timeout=120)[0]
        print(text, end="")
        with open(os.path.join(out, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        with open(counts, encoding="ascii") as file:
            rows = [[int(word) for word in row.split()] for row in file]
    rows = [row for row in rows if begin_at <= row[0] and row[0] + 1 <= end_at]
    loop, others = sum(row[1] for row in rows), sum(row[2] for row in rows)
    faults, growth = end[0] - begin[0], end[1] - begin[1]
    print(f"soak: {end_at - begin_at:.0f} s of wall-clock time, {summary['balanced_s']:.0f} s in balance at pace {o.pace:g}; "
          f"end: {summary['end']}")
    print(f"control loop: {loop} allocations, {faults} page faults; other threads: {others} allocations; "
          f"growth of the process {growth} kB, size {end[1]} kB")
    for name, what in (("answer", "from arrival to command"), ("stamp_to_command", "from time stamp to command"),
                       ("interval", "between messages")):
        t = summary[name]
        if t["count"]:
            print(f"{what}: p50 {t['median_us']:.0f} us, p99 {t['p99_us']:.0f} us, p99.9 {t['p999_us']:.0f} us, "
                  f"max {t['max_us']:.0f} us ({t['count']})")
    is_good = summary["end"] == "request" and loop == 0 and faults <= o.faults and growth <= GROWTH and len(rows) > 0
    print("soak: " + ("passed" if is_good else "FAILED"))
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
