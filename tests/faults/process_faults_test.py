"""Programs that are stopped, killed, without disk space, or two in one folder: files on disk are complete, the exit
status gives the reason, and the next start resumes. Usage: process_faults_test.py SALTUS
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
BENCH = ["bench", "run", "--problems", "sequence,steps/car", "--solvers", "riccati,sparse", "--instances", "4", "--repetitions", "1"]
SOLVE = ["run", "b01_bryson_denham", "--pictures", "false"]
LITTLE_TIME = 60  # s, for a program that takes 0.1 s
ROOT = pathlib.Path(__file__).resolve().parents[2]
SEED = 19
DEADLINE = 300  # s, for a program on a loaded machine


def unreadable(folder):
    """Files below the folder that are truncated, or left by a stopped program."""
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
        out, error = process.communicate(timeout=DEADLINE)
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
        """The next start always succeeds as if nothing had happened."""
        whole = self.time_of(words)
        for _ in range(times):
            process = self.start(words)
            time.sleep(self.random.uniform(0.0, 1.1 * whole))
            process.send_signal(kind)
            status, out, error = self.finish(process)
            # The program may have ended already.
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

    def test_run_is_stopped_and_continued(self):
        """Stops and continues a program, as a slow disk or a sleeping machine would."""
        process = self.start(RUN)
        for _ in range(5):
            time.sleep(self.random.uniform(0.0, 0.2))
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
            process.send_signal(signal.SIGCONT)
        status, out, error = self.finish(process)
        self.assertEqual(status, 0, out + error)
        self.assertEqual(unreadable(self.out), [])

    def stop_bench(self, kind, times):
        """`bench run` keeps complete tasks and resumes after them."""
        os.makedirs(self.out)
        results = os.path.join(self.out, "r.json")

        def start():
            return subprocess.Popen([PROGRAM, *BENCH, "--out", results], text=True, start_new_session=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.PIPE)

        begin = time.monotonic()
        status, out, error = self.finish(start())
        self.assertEqual(status, 0, out + error)
        whole = time.monotonic() - begin
        with open(results, encoding="utf-8") as file:
            tasks = sum('{"done"' in line for line in file)
        os.remove(results)
        for _ in range(times):
            process = start()
            time.sleep(self.random.uniform(0.0, 1.1 * whole))
            os.killpg(process.pid, kind)  # as a terminal does
            status, out, error = self.finish(process)
            self.assertIn(status, (0, 2, 130, -kind, 128 + kind), out + error)
            self.assertNotIn("Traceback", error)
        status, out, error = self.finish(start())
        self.assertEqual(status, 0, out + error)
        with open(results, encoding="utf-8") as file:
            lines = [json.loads(line) for line in file]
        done = [line["done"] for line in lines if "done" in line]
        self.assertEqual((len(done), len(set(done))), (tasks, tasks))

    def test_bench_is_killed(self):
        self.stop_bench(signal.SIGKILL, 4)

    def test_bench_is_interrupted(self):
        self.stop_bench(signal.SIGINT, 3)

    def test_bench_is_terminated(self):
        self.stop_bench(signal.SIGTERM, 3)

    def test_two_benches_into_one_file(self):
        os.makedirs(self.out)
        results = os.path.join(self.out, "r.json")
        both = [subprocess.Popen([PROGRAM, *BENCH, "--out", results], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                for _ in range(2)]
        statuses = [self.finish(process)[0] for process in both]
        self.assertIn(0, statuses)
        report = subprocess.run([PROGRAM, "bench", "report", results], capture_output=True, text=True, check=False, timeout=DEADLINE)
        self.assertEqual(report.returncode, 0, report.stderr)

    def reproduce(self, tree):
        return subprocess.Popen([sys.executable, "-B", str(tree / "docs/results/reproduce.py"), PROGRAM, "centroidal", "--write"], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)

    def tree(self):
        """The files that reproduce.py reads and writes, outside of the project."""
        tree = pathlib.Path(self.temporary.name, "tree")
        for folder in ("docs", "problems", "robots", "benchmarks", "framework", "python"):
            for path in (ROOT / folder).rglob("*"):
                if path.suffix in (".md", ".py") and path.is_file():
                    copy = tree / path.relative_to(ROOT)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(path, copy)
        for name in ("README.md", "CHANGELOG.md"):
            shutil.copy(ROOT / name, tree / name)
        return tree

    def test_reproduce_is_stopped(self):
        tree = self.tree()
        results = [tree / "docs/results/made_by.md", tree / "problems/push_recovery/experiments.md"]

        def lengths():
            return [result.read_text(encoding="utf-8").count("\n") for result in results]
        begin = time.monotonic()
        status, out, error = self.finish(self.reproduce(tree))
        self.assertIn(status, (0, 3), out + error)  # 3: the numbers differ on this machine
        whole = time.monotonic() - begin
        made = lengths()
        for kind in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM):
            process = self.reproduce(tree)
            time.sleep(self.random.uniform(0.0, 1.0) * whole)
            os.killpg(process.pid, kind)
            stopped, out, error = self.finish(process)
            self.assertIn(stopped, (status, 1, 2, 130, -kind, 128 + kind), out + error)
            self.assertEqual(lengths(), made, "half a table")
        again, out, error = self.finish(self.reproduce(tree))
        self.assertEqual(again, status, out + error)

    def test_reproduce_into_an_unwritable_folder(self):
        tree = self.tree()
        result = tree / "docs/results/made_by.md"
        result.unlink()
        result.mkdir()
        status, out, error = self.finish(self.reproduce(tree))
        self.assertNotEqual(status, 0, out + error)
        self.assertNotIn("Traceback", error)

    def entry_script(self):
        """The entry script in a tree whose commands take half a second instead of minutes."""
        tree, tools = pathlib.Path(self.temporary.name, "tree"), pathlib.Path(self.temporary.name, "tools")
        tools.mkdir()
        (tree / "robots/icub").mkdir(parents=True)
        (tree / "python/saltus").mkdir(parents=True)
        shutil.copy(ROOT / "saltus", tree / "saltus")
        fetch = 'if [ "$1" = --version ]; then echo 1.0; exit; fi\nsleep 0.2; exit 1\n'
        stubs = {
            tree / "robots/icub/fetch_icub_model": fetch,
            tree / "python/saltus/fetch_uplot": fetch,
            tools / "dpkg-query": 'shift 3; shift 0; for p in "$@"; do echo "installed $p"; done\n',
            tools / "cmake": 'while [ $# -gt 0 ]; do [ "$1" = -B ] && build=$2; shift; done\nsleep 0.2; echo "# rules" > "$build/build.ninja"; sleep 0.2\n',
            tools / "ninja": 'build=$2\ncase " $* " in *" -n "*) if [ -x "$build/saltus" ]; then echo "no work to do"; else echo "[1/1] work"; fi; exit;; esac\n'
                             'sleep 0.2; printf "#!/bin/sh\\necho whole\\n" > "$build/saltus.part"; chmod +x "$build/saltus.part"; sleep 0.2; mv "$build/saltus.part" "$build/saltus"\n',
        }
        for path, text in stubs.items():
            path.write_text("#!/bin/sh\n" + text, encoding="utf-8")
            path.chmod(0o755)
        env = dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}")
        env.pop("CI", None)
        return tree, lambda: subprocess.Popen([str(tree / "saltus"), "list"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                              env=env, start_new_session=True, stdin=subprocess.DEVNULL)

    def test_set_up_is_stopped(self):
        tree, start = self.entry_script()
        begin = time.monotonic()
        status, out, error = self.finish(start())
        self.assertEqual((status, out), (0, "whole\n"), error)
        whole = time.monotonic() - begin
        for kind in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM) * 2:
            shutil.rmtree(tree / "build")
            process = start()
            time.sleep(self.random.uniform(0.0, 1.0) * whole)
            os.killpg(process.pid, kind)
            status, out, error = self.finish(process)
            self.assertIn(status, (0, 1, -kind, 128 + kind), out + error)
            status, out, error = self.finish(start())
            self.assertEqual((status, out), (0, "whole\n"), error)

    def test_two_set_ups_in_one_folder(self):
        _, start = self.entry_script()
        for process in [start(), start()]:
            status, out, error = self.finish(process)
            self.assertEqual((status, out), (0, "whole\n"), error)

    def test_set_up_where_nothing_can_be_written(self):
        tree, start = self.entry_script()
        (tree / "build").write_text("in the way", encoding="utf-8")
        status, out, error = self.finish(start())
        self.assertEqual(status, 1, out)
        self.assertRegex(error, "is not writable")

    def test_two_in_one_folder(self):
        first, second = self.start(RUN), self.start(RUN)
        for process in (first, second):
            status, out, error = self.finish(process)
            self.assertIn(status, (0, 2), out + error)  # both succeed, or one is rejected
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
        """No file may exceed 4 kB: the error is that of a full disk, with different wording."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        status, out, error = self.once(RUN, preexec_fn=limit)
        self.assertEqual(status, 2, out + error)
        self.assertRegex(error, r"saltus: .*results")
        self.assertEqual(error.strip().count("\n"), 0, error)
        if os.path.isdir(self.out):
            self.assertEqual(unreadable(self.out), [])

    def test_file_limit_of_any_size(self):
        """The program itself makes SIGXFSZ an error of the write; Python's Popen leaves the signal at its default."""
        for size in (0, 1, 512, 1024, 4096, 16384):
            with self.subTest(size=size):
                status, out, error = self.once(SOLVE, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
                self.assertIn(status, (0, 2) if size > 4096 else (2,), out + error)
                if status == 2:
                    self.assertRegex(error, r"^saltus: [^\n]*results[^\n]*\n$")
                if os.path.isdir(self.out):
                    self.assertEqual(unreadable(self.out), [])
                    self.assertEqual(list(pathlib.Path(self.out).glob(".*.part")), [])

    def test_little_address_space(self):
        """Allocations fail in the loader, in OpenBLAS, in Ipopt and in our code: nothing hangs, and each case ends with
        a message."""
        for megabytes in (50, 75, 100, 125, 150, 175, 200, 225, 250, 300, 350, 400, 500, 700, 1000):
            for words in (SOLVE, SOLVE + ["--solver", "sparse"], SOLVE + ["--solver", "riccati"], ["list"]):
                with self.subTest(megabytes=megabytes, words=words):
                    limit = megabytes << 20
                    process = subprocess.run([PROGRAM, *words, *([] if words == ["list"] else ["--out", self.out])], text=True, capture_output=True,
                                             check=False, timeout=LITTLE_TIME, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
                    # 127: the loader lacks memory for the libraries and reports it before the program starts.
                    self.assertIn(process.returncode, (0, 2, 127), process.stdout + process.stderr)
                    if process.returncode != 0:
                        self.assertEqual(process.stderr.strip().count("\n"), 0, process.stderr)
                        self.assertTrue(process.stderr.strip())
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

    def test_output_pipe_is_closed(self):
        for words in (["list"], ["--version"], [*SOLVE, "--out", self.out]):
            with self.subTest(words=words), open("/dev/full", "w", encoding="utf-8") as full:
                process = subprocess.run([PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
                self.assertEqual(process.returncode, 2, "a failed print counts as successful")
                self.assertEqual(process.stderr.strip().count("\n"), 0, process.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
