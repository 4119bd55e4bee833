"""Programs that are stopped, killed, left without disk or given one folder for two: what is on disk is whole, the
exit status says what happened, and the next start goes on. Usage: process_faults_test.py SALTUS
"""

import csv
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
RUN = ["run", "push_recovery", "--plant", "centroidal", "--pictures", "false"]
MAP = ["map", "--plant", "centroidal", "--directions", "4", "--impulses", "1:1:3", "--step-times", "0.6",
       "--controllers", "mpc", "--jobs", "2", "--set", "pictures=false"]
SEED = 19


def unreadable(folder):
    """Files below the folder that end before they should, or that a stopped program left beside its own."""
    bad = []
    for path in pathlib.Path(folder).rglob("*"):
        if path.is_dir():
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if path.suffix == ".json":
            try:
                json.loads(text)
            except ValueError:
                bad.append(path.name)
        elif path.suffix == ".csv":
            rows = list(csv.reader(text.splitlines()))
            if not rows or not text.endswith("\n") or {len(row) for row in rows} != {len(rows[0])}:
                bad.append(path.name)
    return bad


class Stopped(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="saltus-faults-")
        self.out = os.path.join(self.temporary.name, "results")
        self.random = random.Random(SEED)

    def tearDown(self):
        self.temporary.cleanup()

    def start(self, words, **options):
        return subprocess.Popen([PROGRAM, *words, "--out", self.out], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def finish(self, process):
        out, error = process.communicate(timeout=120)
        return process.returncode, out, error

    def once(self, words, **options):
        return self.finish(self.start(words, **options))

    def time_of(self, words):
        begin = time.monotonic()
        status, out, error = self.once(words)
        self.assertEqual(status, 0, out + error)
        shutil.rmtree(self.out)
        return time.monotonic() - begin

    def stop_at_random(self, words, kind, times):
        """Every time the next start goes on as if nothing had been."""
        whole = self.time_of(words)
        for _ in range(times):
            process = self.start(words)
            time.sleep(self.random.uniform(0.0, 1.1 * whole))
            process.send_signal(kind)
            status, out, error = self.finish(process)
            # It may have been done before.
            self.assertIn(status, (0, -kind, 128 + kind), out + error)
            self.assertEqual(unreadable(self.out), [], f"seed {SEED}")
        status, out, error = self.once(words)
        self.assertEqual(status, 0, out + error)
        self.assertEqual(unreadable(self.out), [])
        self.assertEqual(list(pathlib.Path(self.out).glob(".*.part")), [], "left by those that were killed")

    def test_run_is_killed(self):
        self.stop_at_random(RUN, signal.SIGKILL, 6)

    def test_run_is_interrupted(self):
        self.stop_at_random(RUN, signal.SIGINT, 4)

    def test_run_is_terminated(self):
        self.stop_at_random(RUN, signal.SIGTERM, 4)

    def test_map_is_killed(self):
        self.stop_at_random(MAP, signal.SIGKILL, 6)

    def test_map_is_interrupted(self):
        self.stop_at_random(MAP, signal.SIGINT, 4)

    def test_two_in_one_folder(self):
        first, second = self.start(RUN), self.start(RUN)
        for process in (first, second):
            status, out, error = self.finish(process)
            self.assertIn(status, (0, 2), out + error)  # both as they please, or one is refused
        self.assertEqual(unreadable(self.out), [])

    def test_two_maps_in_one_folder(self):
        first, second = self.start(MAP), self.start(MAP)
        statuses = []
        for process in (first, second):
            status, out, error = self.finish(process)
            statuses.append(status)
            self.assertIn(status, (0, 2), out + error)
        self.assertIn(0, statuses)
        self.assertEqual(unreadable(self.out), [])

    def test_disk_is_full(self):
        """No file may grow above 4 kB: what the system says then is what it says of a full disk, but for the word."""
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        status, out, error = self.once(RUN, preexec_fn=limit)
        self.assertEqual(status, 2, out + error)
        self.assertRegex(error, r"saltus: .*results")
        self.assertEqual(error.strip().count("\n"), 0, error)
        if os.path.isdir(self.out):
            self.assertEqual(unreadable(self.out), [])

    @unittest.skipIf(os.geteuid() != 0, "mounting a small disk needs root")
    def test_small_disk(self):
        os.makedirs(self.out)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=32k", "tmpfs", self.out], check=False,
                          stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("this machine does not let root mount")
        try:
            status, out, error = self.once(RUN)
            self.assertEqual(status, 2, out + error)
            self.assertRegex(error, "No space left")
            self.assertEqual(unreadable(self.out), [])
        finally:
            subprocess.run(["umount", self.out], check=True)

    def test_folder_goes_away(self):
        process = self.start(RUN)
        for _ in range(200):
            shutil.rmtree(self.out, ignore_errors=True)
            if process.poll() is not None:
                break
            time.sleep(0.01)
        status, out, error = self.finish(process)
        self.assertIn(status, (0, 2), out + error)

    def test_nobody_reads_what_is_printed(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            process = subprocess.run([PROGRAM, "list"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertNotEqual(process.returncode, 0, "what could not be printed counts as printed")
        self.assertIn(process.returncode, (1, 2, 4, 5), process.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
