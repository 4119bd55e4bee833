#!/usr/bin/env python3
"""Builds wheels of the package saltus and tests them in clean virtual environments.

Usage: make_wheels.py OUT [--python PYTHON]... [--prefix PREFIX] [--test] [--notebook]

OUT receives the wheels and the build folders, which later calls reuse. PYTHON is an interpreter with its headers; the default
is each of python3.11 and python3.13 on the PATH. The extension is linked to the Saltus in PREFIX. Without PREFIX, Saltus
is compiled once for any processor. --test runs the tests of tests/python and the programs of
docs/python with the installed wheel and without a network, and checks the stubs with mypy. --notebook also executes a
notebook. Packages of PyPI are downloaded.
"""

import argparse
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import time
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DEFAULTS = ("python3.11", "python3.13")
COMPONENTS = "core;sundials;ipopt"
OFF = ("TESTS", "BENCHMARKS", "PROGRAM", "PYTHON")
SKIPPED = 77
CONTENT = ("saltus/_core.*.so", "saltus/_core.pyi", "saltus/py.typed", "saltus/viewer.html", "saltus/uplot/uPlot.iife.js")
FOR_TESTS = ("pandas", "xarray", "mypy")
FOR_NOTEBOOKS = ("nbclient", "nbformat", "nbconvert", "ipykernel")


def run(*command, **how):
    """Runs a command. On failure, prints the end of its output and exits with status 1. Tests may be skipped."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **how)
    if done.returncode not in (0, SKIPPED):
        print("\n".join(done.stdout.splitlines()[-60:]), file=sys.stderr)
        sys.exit(f"wheels: {' '.join(command)} ended with status {done.returncode}")
    return done.stdout


def interpreters(given):
    """Interpreters that run, by the tag of their release."""
    found = {}
    for command in given or DEFAULTS:
        for path in [command] if given else every(command):
            code = "import sys; print('cp%d%d' % sys.version_info[:2])"
            done = subprocess.run([path, "-c", code], capture_output=True, text=True, check=False) if shutil.which(path) else None
            if done and done.returncode == 0:
                found.setdefault(done.stdout.strip(), path)
            elif given:
                sys.exit(f"wheels: {command} does not run; give the path of an interpreter")
    return found


def every(command):
    """All programs of this name on the PATH: the first may be the stub of a version manager."""
    places = [os.path.join(place, command) for place in os.environ.get("PATH", "").split(os.pathsep)]
    return [place for place in places if os.access(place, os.X_OK)]


def install_saltus(out):
    """Compiles Saltus for any processor and installs it into a prefix, whose path is returned."""
    build, prefix = os.path.join(out, "saltus"), os.path.join(out, "prefix")
    run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release",
        "-D", f"SALTUS_COMPONENTS={COMPONENTS}", *(word for part in OFF for word in ("-D", f"SALTUS_BUILD_{part}=OFF")))
    run("cmake", "--build", build, "-j", str(len(os.sched_getaffinity(0))))
    run("cmake", "--install", build, "--prefix", prefix)
    return prefix


def make_wheel(python, tag, prefix, out):
    """The path of the wheel for this interpreter."""
    made = os.path.join(out, tag, "wheel")
    shutil.rmtree(made, ignore_errors=True)
    environment = os.path.join(out, tag, "build")
    if not os.path.exists(os.path.join(environment, "bin", "python")):
        run(python, "-m", "venv", environment)
    run(os.path.join(environment, "bin", "python"), "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", made,
        os.path.join(ROOT, "python"), env={**os.environ, "CMAKE_PREFIX_PATH": prefix})
    name = os.listdir(made)[0]
    if f"-{tag}-{tag}-" not in name:
        sys.exit(f"wheels: {name} is not for {tag}")
    shutil.copy(os.path.join(made, name), out)
    missing = missing_files(os.path.join(out, name))
    if missing:
        sys.exit(f"wheels: {name} lacks {', '.join(missing)}")
    return os.path.join(out, name)


def missing_files(wheel):
    """Required files that this wheel lacks."""
    names = zipfile.ZipFile(wheel).namelist()
    return [wanted for wanted in CONTENT if not fnmatch.filter(names, wanted)]


def offline():
    """Prefix of a command that runs it without a network, or nothing if the system does not allow this."""
    words = ["unshare", "--map-root-user", "--net"]
    allowed = shutil.which("unshare") and subprocess.run([*words, "true"], capture_output=True, check=False).returncode == 0
    return words if allowed else []


def test(python, tag, wheel, out, notebook):
    """Installs the wheel into a clean environment and runs the tests with it."""
    environment = os.path.join(out, tag, "use")
    shutil.rmtree(environment, ignore_errors=True)
    run(python, "-m", "venv", environment)
    own = os.path.join(environment, "bin", "python")
    run(own, "-m", "pip", "install", "--quiet", wheel, *FOR_TESTS, *(FOR_NOTEBOOKS if notebook else ()))
    folder = os.path.join(out, tag, "folder")  # contains no sources of the package
    os.makedirs(folder, exist_ok=True)
    variables = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    alone = offline()
    if not alone:
        print("wheels: this system cannot run commands without a network; the tests run with it")

    def step(name, *words):
        began = time.monotonic()
        said = run(*alone, own, "-B", *words, cwd=folder, env=variables)
        counts = [line for line in said.splitlines() if line.startswith(("Ran ", "OK", "Success", "skipped"))]
        print(f"wheels: {tag}: {name}: {' '.join(counts) or 'passed'} ({time.monotonic() - began:.0f} s)", flush=True)
        return said

    tests = os.path.join(ROOT, "tests", "python")
    step("modelling", os.path.join(tests, "modelling_test.py"), "installed")
    step("stubs", os.path.join(tests, "stubs_test.py"), "installed")
    step("stubs by mypy", "-m", "mypy.stubtest", "saltus._core", "--allowlist", os.path.join(tests, "stubtest_allowed.txt"))
    step("types of the programs", "-m", "mypy", *programs())
    with open(os.path.join(ROOT, "docs", "python.md"), encoding="utf-8") as page:
        shown = dict(re.findall(r"<!-- output: (\w+) -->\n```\n(.*?)```", page.read(), re.S))
    for program in programs():
        name = os.path.basename(program)
        if step(name, program) != shown[name[:-len(".py")]]:
            sys.exit(f"wheels: {name} prints another result than docs/python.md")
    step("viewer", os.path.join(tests, "viewer_test.py"), ROOT, "installed")
    if notebook:
        step("notebook", os.path.join(tests, "notebook_test.py"), ROOT, os.path.join(out, "notebook"))


def programs():
    folder = os.path.join(ROOT, "docs", "python")
    return [os.path.join(folder, f"{name}.py") for name in ("swing_up", "bounce", "pendulum_mpc")]


def main():
    parser = argparse.ArgumentParser(prog="make_wheels.py")
    parser.add_argument("out")
    parser.add_argument("--python", action="append", default=[])
    parser.add_argument("--prefix")
    parser.add_argument("--test", action="store_true")
    parser.add_argument("--notebook", action="store_true")
    given = parser.parse_args()
    out = os.path.abspath(given.out)
    os.makedirs(out, exist_ok=True)
    found = interpreters(given.python)
    for missing in (name for name in DEFAULTS if not given.python and f"cp{name[6:].replace('.', '')}" not in found):
        print(f"wheels: no {missing} on the PATH; --python gives the path of one")
    if not found:
        sys.exit("wheels: no interpreter was found")
    prefix = os.path.abspath(given.prefix) if given.prefix else install_saltus(out)
    for tag, python in found.items():
        began = time.monotonic()
        wheel = make_wheel(python, tag, prefix, out)
        print(f"{wheel}: {os.path.getsize(wheel) / 1e6:.1f} MB ({time.monotonic() - began:.0f} s)", flush=True)
        if given.test or given.notebook:
            test(python, tag, wheel, out, given.notebook)


if __name__ == "__main__":
    main()
