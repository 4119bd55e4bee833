#!/usr/bin/env python3
"""Runs the commands of the pages as a new user of an installed Saltus.

Usage: new_user.py SOURCES WORK [--icub-urdf FILE]

SOURCES is a checkout or a copy of it: its README.md, docs/, problems/README.md and their files. The installed library
and program are used, not those of SOURCES. WORK is created anew. Every command is printed with its minutes and
processor time; the exit status is 1 if the result of one of them differs from its page. `./saltus` on a page is the program
`saltus`.
"""

import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
import time

# Commands of the pages that need a checkout, other solvers or files, or a browser.
LEFT_OUT = re.compile(r"saltus (test|setup|docs|reproduce|movie|robot new|bench run|bench latency --against)\b")
# Replacements for commands that take hours or have alternatives in brackets; they take a minute.
SHORTENED = {
    "saltus map": "saltus map --plant centroidal --directions 2 --impulses 2:4:6 --step-times 0.6 --out results/map",
    "saltus bench latency": "saltus bench latency --quick --only kI=7",
    "saltus suite": "saltus suite --only A0 --set solver=riccati",
}
KINDS = ["trajectory", "controller", "switched"]
MINUTES_TO_FIRST = 10.0


def blocks(page, language=""):
    """Lines of the samples of a page in that language, one list per sample."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    found = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.M | re.S)
    return [body.splitlines() for kind, body in found if kind == language]


def command_of(line):
    """The command without its comment, and with the first of its alternatives."""
    words = re.split(r"\s+#", line)[0].strip()
    return re.sub(r"^\./saltus\b", "saltus", words)


class User:
    def __init__(self, work):
        self.work, self.failed, self.began = work, [], time.monotonic()

    def spent(self):
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    def types(self, command, folder=".", good=(0,), seconds=1800):
        began, processor = time.monotonic(), self.spent()
        try:
            done = subprocess.run(["bash", "-c", command], cwd=os.path.join(self.work, folder), capture_output=True,
                                  text=True, check=False, timeout=seconds)
            status, said = done.returncode, done.stdout + done.stderr
        except subprocess.TimeoutExpired:
            status, said = "no end", ""
        print(f"{(time.monotonic() - began) / 60:6.2f} min {self.spent() - processor:7.1f} s  {command}", flush=True)
        if status not in good:
            self.failed.append(command)
            print(f"  status {status}\n  " + "\n  ".join(said.splitlines()[-30:]), flush=True)
        return said


def own_projects(user):
    """`saltus new`, and the commands in the README of the project; the first must be solved within ten minutes."""
    for kind in KINDS:
        began = time.monotonic()
        user.types(f"saltus new my_{kind} --kind {kind}")
        folder = os.path.join(user.work, f"my_{kind}")
        if not os.path.isdir(folder):
            continue
        for line in blocks(os.path.join(folder, "README.md"))[0]:
            user.types(command_of(line), f"my_{kind}")
        for run in ("plan", "loop"):
            if not os.path.exists(os.path.join(folder, "results", run, "trajectory.csv")):
                user.failed.append(f"results/{run} of my_{kind}")
        minutes = (time.monotonic() - began) / 60
        print(f"        own problem of kind {kind}: {minutes:.1f} minutes", flush=True)
        if minutes > MINUTES_TO_FIRST:
            user.failed.append(f"my_{kind} took more than {MINUTES_TO_FIRST:g} minutes")


def tutorial(user, sources):
    """All steps, built by the CMakeLists.txt of the page, and the unchanged page."""
    page = os.path.join(sources, "docs", "tutorial.md")
    folder = os.path.join(user.work, "tutorial")
    os.makedirs(folder)
    given = os.path.join(sources, "docs", "tutorial")
    for name in os.listdir(given):
        if name.endswith((".cpp", ".hpp")):
            shutil.copy(os.path.join(given, name), folder)
    with open(os.path.join(folder, "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write("\n".join(blocks(page, "cmake")[0]) + "\n")
    for line in blocks(page)[0]:
        user.types(command_of(line), "tutorial")
    checker = os.path.join(sources, "docs", "page.py")
    user.types(f"python3 -B {shlex.quote(checker)} {shlex.quote(page)} build", "tutorial")


def readme(user, sources, has_body):
    pages = [os.path.join(sources, page) for page in ("README.md", "docs/running.md", "problems/README.md")]
    user.types("saltus run push_recovery --print-config > my.yaml")
    lines = [line for page in pages for block in blocks(page) for line in block if line.startswith("./saltus ")]
    for line in lines:
        command = command_of(line)
        if LEFT_OUT.match(command) or (not has_body and re.search("demo|--plant", command)):
            print(f"     left out            {command}")
            continue
        command = next((short for verb, short in SHORTENED.items() if command.startswith(verb)), command)
        if command == "saltus demo":  # a verb of the checkout's script
            command = "saltus run push_recovery --plant dart --out results/demo"
        user.types(command, good=(0, 4) if "--loop" in command else (0,))
    for block in [block for page in pages for block in blocks(page, "python")][:1]:
        user.types(f"python3 -m venv --system-site-packages environment && environment/bin/pip install -q "
                   f"{shlex.quote(os.path.join(sources, 'python'))} mcap h5py")
        with open(os.path.join(user.work, "sample.py"), "w", encoding="utf-8") as file:
            file.write("\n".join(block) + "\n")
        user.types("environment/bin/python sample.py && ls run.mat run.mcap")


def main(sources, work):
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    user = User(work)
    own_projects(user)
    tutorial(user, sources)
    readme(user, sources, os.path.exists(os.environ.get("SALTUS_ICUB_URDF", "")))
    print(f"in all {(time.monotonic() - user.began) / 60:.1f} minutes, {user.spent():.0f} s of processor time")
    for command in user.failed:
        print(f"did not do what its page says: {command}")
    return 1 if user.failed else 0


if __name__ == "__main__":
    if len(sys.argv) == 5 and sys.argv[3] == "--icub-urdf":
        os.environ["SALTUS_ICUB_URDF"] = os.path.abspath(sys.argv[4])
    elif len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])))
