"""Test programs: what is in them, how long they take, and how a run of them ends."""
import argparse
import json
import os
import resource
import signal
import subprocess
from functools import cached_property
from pathlib import Path

from relink import Failure

SLOW_TEST = 0.5   # s; those above run after all others of a layer
MEMORY = 6 << 30  # bytes that a program may take


class Parser(argparse.ArgumentParser):
    """Of a verb of ./saltus: mistakes are one sentence and status 2."""

    def __init__(self, verb, description):
        super().__init__(prog=f"saltus {verb}", description=description.split("\n\n", maxsplit=1)[0])

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}\n")


def processor_time():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def is_asleep(pid):
    """Whether no thread of a process computes or waits for the disk."""
    try:
        return all(stat.read_text().rsplit(")", 1)[1].split()[0] in "SZ"
                   for stat in Path(f"/proc/{pid}/task").glob("*/stat"))
    except OSError:
        return False


def run(command, folder, seconds):
    """(how it ended, what it printed): passed, failed, too long. Seconds are the processor's."""
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with open(folder / "output", "w+b") as output:
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=output,
                                   stderr=subprocess.STDOUT, preexec_fn=limit, start_new_session=True)
        ended = None
        try:
            asleep = 0
            while ended is None:
                try:
                    process.wait(1.0)
                    ended = "passed" if process.returncode == 0 else "failed"
                    if process.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
                        ended = "too long"
                except subprocess.TimeoutExpired:
                    asleep = asleep + 1 if is_asleep(process.pid) else 0
                    if asleep >= 30 or output.tell() > 1 << 30:
                        ended = "too long"
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        output.seek(0)
        return ended, output.read(1 << 20).decode(errors="replace")


def parts_of(asked):
    """(program, filter, folder) of PROGRAM[=FILTER][@FOLDER]: all tests, or chosen ones; about all files, or those of
    a folder."""
    asked, _, folder = asked.partition("@")
    name, _, chosen = asked.partition("=")
    return name, chosen or "*", folder


class Program:
    """A test program, or chosen tests of one. What is in it and how long its tests take when nothing is wrong is found
    out when it is asked for, and kept as long as the program is the same file."""

    def __init__(self, build, asked, scratch, kept, keep):
        self.build = build
        self.name, self._chosen, self._about = parts_of(asked)
        asked = asked.partition("@")[0]
        self._scratch = scratch
        built = (build.folder / self.name).stat().st_mtime
        if kept.get(asked, {}).get("built") != built:
            kept[asked] = {"built": built, "members": sorted(build.members(self.name))}
        self._facts = kept[asked]
        self._keep = keep

    @property
    def members(self):
        """Objects of ours that it is made of."""
        return set(self._facts["members"])

    def is_asked_about(self, file, objects):
        """Whether it may notice that this file, and with it these objects, are not as they were."""
        return file.startswith(self._about) and not self.members.isdisjoint(objects)

    @cached_property
    def tests(self):
        """Processor time of each test in s."""
        if "tests" not in self._facts:
            print(f"{self.name}, as it is", flush=True)
            self._facts["tests"] = times_of(self.build.place(self.name), self._chosen, self._scratch)
            self._keep()
        return self._facts["tests"]

    def parts(self):
        """(is slow, seconds, program, filter): all short tests at once, and long ones one by one."""
        slow = {test: seconds for test, seconds in self.tests.items() if seconds > SLOW_TEST}
        if len(slow) < len(self.tests):
            short = sum(self.tests.values()) - sum(slow.values())
            left_out = (":" if "-" in self._chosen else "-") + ":".join(slow)
            yield False, short, self, self._chosen + (left_out if slow else "")
        for test, seconds in slow.items():
            yield True, seconds, self, test


def times_of(program, chosen, scratch):
    """Runs a program as it is."""
    report = scratch / "report.json"
    before = processor_time()
    ended, said = run([str(program), f"--gtest_filter={chosen}", f"--gtest_output=json:{report}"], scratch, 3600)
    if ended != "passed":
        raise Failure(f"{program.name} fails before anything was changed: mend that first\n{said[-2000:]}")
    seconds = processor_time() - before
    tests = {f"{suite['name']}.{test['name']}": float(test["time"].rstrip("s"))
             for suite in json.loads(report.read_text())["testsuites"] for test in suite["testsuite"]}
    if not tests:
        raise Failure(f"{program.name} has no test '{chosen}': see tests/mutants/CMakeLists.txt")
    share = min(1.0, seconds / (sum(tests.values()) or 1.0))  # the rest is waiting for a processor
    return {test: share * time for test, time in tests.items()}


class Programs:
    """All that were asked for, by name."""

    def __init__(self, build, scratch):
        self._build = build
        self._scratch = scratch
        self._file = build.work / "programs.json"
        self._kept = json.loads(self._file.read_text()) if self._file.exists() else {}
        self._found = {}

    def __getitem__(self, name):
        if name not in self._found:
            self._found[name] = Program(self._build, name, self._scratch, self._kept, self._keep)
        return self._found[name]

    def _keep(self):
        self._file.write_text(json.dumps(self._kept))
