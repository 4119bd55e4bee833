#!/usr/bin/env python3
"""Checks that the scripts that draw a run write all their files.

Usage: pictures_test.py PROGRAM SOURCE_DIR. Runs the program for two short pushes: on the whole body if SALTUS_ICUB_URDF
names a file, and on the centroidal model. Exits with 77, "skipped", if matplotlib is missing.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
PYTHON = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
URDF = os.environ.get("SALTUS_ICUB_URDF", "")
LEAST_PICTURE = 5000  # bytes: an empty page of this size compresses to less
PNG = b"\x89PNG\r\n\x1a\n"

program, source = sys.argv[1:3] if len(sys.argv) == 3 else ("", "")
sys.path.insert(0, os.path.join(source, "python"))
from saltus.tables import read_by_names  # noqa: E402
from saltus.walking import events, ground  # noqa: E402
folder = tempfile.TemporaryDirectory(prefix="saltus-pictures-")
printed = {}  # by runs


def path(*parts):
    return os.path.join(folder.name, *parts)


def script(name, *arguments, **how):
    environment = {**os.environ, "PYTHONPATH": os.path.join(source, "python")}
    return subprocess.run([PYTHON, "-B", "-m", f"saltus.walking.{name}", *arguments], capture_output=True,
                          text=True, env=environment, **how)


def simulate(name, *settings):
    """A push at 0.1 s; the folder of its results."""
    push = [] if "--push.impulse" in settings else ["--push.impulse", "6"]
    command = [program, "run", "push_recovery", "--out", path(name), "--pictures", "false",
               "--push.start", "0.1", *push, *settings]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stdout}{done.stderr}")
    printed[name] = done.stdout
    return path(name)


def summary_of(results):
    with open(os.path.join(results, "summary.json"), encoding="utf-8") as file:
        return json.load(file)


def page_about(results):
    """The report, written again."""
    done = script("report", results)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    with open(os.path.join(results, "report.html"), encoding="utf-8") as file:
        return file.read()


class Pictures(unittest.TestCase):
    def test_full_disk_is_reported(self):
        results = path("full")
        shutil.copytree(path("baseline"), results)
        def no_room():  # limits files to 4 kB; longer writes fail as on a full disk
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

        done = script("plot_run", results, preexec_fn=no_room)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("com.png: File too large", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertEqual([name for name in os.listdir(results) if name.endswith(".part")], [])

    def is_picture(self, *parts):
        name = path(*parts)
        self.assertTrue(os.path.exists(name), name)
        with open(name, "rb") as file:
            data = file.read()
        self.assertEqual(data[:8], PNG, name)
        self.assertGreater(len(data), LEAST_PICTURE, name)

    def is_drawn(self, done):
        self.assertEqual(done.returncode, 0, done.stderr)

    @classmethod
    def setUpClass(cls):
        simulate("baseline", "--controller", "capture_point")
        if os.path.exists(URDF):
            simulate("body", "--plant", "dart")

    def test_run_on_the_centroidal_model(self):
        self.is_drawn(script("plot_run", path("baseline")))
        for name in ("com", "capture_point", "from_above", "forces"):
            self.is_picture("baseline", name + ".png")
        self.is_drawn(script("report", path("baseline")))
        with open(path("baseline", "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("<img"), 4)
        self.assertIn("towards (0, -1, 0)", page)
        self.assertRegex(page, r"Saltus \d+\.\d+\.\d+, commit \w+")
        self.assertIn("Planned vertical force, left foot", page)
        self.assertNotIn("Measured vertical force", page)
        self.assertFalse(os.path.exists(path("baseline", "view.html")))

    # A first push of zero does not count as a push. Old results contain only the first push.
    def test_pushes_match_the_given_ones(self):
        pushed = simulate("list", "--push.impulse", "0", "--pushes", "0.5 3 90; 2 4 0 0.2")
        summary = summary_of(pushed)
        self.assertEqual([(p["start_s"], p["impulse_ns"], p["duration_s"]) for p in summary["pushes"]],
                         [(0.5, 3, 0.1), (2, 4, 0.2)])
        self.assertEqual((summary["push_start_s"], summary["push_impulse_ns"]), (0.5, 3))
        self.assertEqual(events.impulse_in_words(summary), "2 pushes of 3 to 4 N s")
        begin, end = events.span(summary, before=0.4, after=2.0)
        self.assertAlmostEqual(begin, 0.1)
        self.assertAlmostEqual(end, 4.2)
        self.is_drawn(script("plot_run", pushed))
        self.is_picture("list", "from_above.png")
        self.assertIn("push of 3 N s in 0.1 s at 0.5 s towards (0, 1, 0); push of 4 N s in 0.2 s at 2 s towards (1, 0, 0)",
                      page_about(pushed))
        with open(os.path.join(pushed, "summary.json"), "w", encoding="utf-8") as file:
            json.dump({key: value for key, value in summary.items() if key != "pushes"}, file)
        self.is_drawn(script("plot_run", pushed))
        self.assertIn("push of 3 N s in 0.1 s at 0.5 s towards (0, 1, 0); controller", page_about(pushed))

    def test_no_push_is_reported_without_a_push(self):
        stands = simulate("stands", "--push.impulse", "0")
        self.assertEqual(events.pushes(summary_of(stands)), [])
        self.is_drawn(script("plot_run", stands))
        page = page_about(stands)
        self.assertIn("<title>Push recovery: no push</title>", page)
        self.assertNotIn("push of", page)
        self.is_drawn(script("compare_runs", stands, stands, path("stand.png")))

    def test_plans_of_steps(self):
        simulate("planned", "--step.planner", "ocp")
        self.is_drawn(script("plot_run", path("planned")))
        self.is_picture("planned", "step_plans.png")
        self.is_drawn(script("report", path("planned")))
        with open(path("planned", "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("<img"), 5)
        self.assertIn("considered and chosen places", page)

    def test_every_ground_of_two_steps_is_reported(self):
        simulate("two_steps", "--step.planner", "ocp", "--step.most", "3", "--push.impulse", "18", "--push.direction", "[-1, 0, 0]")
        with open(path("two_steps", "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        self.assertGreater(len(summary["steps"]), 1)
        grounds = summary["ground"]
        self.assertEqual(ground.stood_at_first(summary), "left foot")
        self.assertLess(max(abs(x) for x, _ in grounds[0]["corners"]), 0.2)  # at the origin, before any step
        for one, other in zip(grounds, grounds[1:]):
            self.assertNotEqual((one["left"], one["right"]), (other["left"], other["right"]))
            self.assertLess(one["from_s"], other["from_s"])
        landings = [step["touchdown_s"] for step in summary["steps"]]
        self.assertEqual([g["from_s"] for g in grounds if g["left"] and g["right"]], landings)
        pieces = list(ground.intervals(summary, 0.0, 10.0))
        self.assertEqual([piece[1] for piece in pieces[:-1]], [piece[0] for piece in pieces[1:]])
        self.is_drawn(script("plot_run", path("two_steps")))
        self.is_picture("two_steps", "capture_point.png")
        # Capture point and forces settle from the same instant.
        self.assertEqual(summary["icp_settling_from_s"], landings[-1])
        self.assertIn(f"; settling times from {landings[-1]:.3f} s on: capture point", printed["two_steps"])
        self.assertIn("Settling after the last landing or push", page_about(path("two_steps")))
        table = read_by_names(os.path.join(path("two_steps"), "trajectory.csv"))
        band = 0.05 * summary["mass_kg"] * 9.81  # N
        for foot in ("left", "right"):
            forces = list(zip(table["t"], table[foot + "_fz"]))
            at_the_end = [f for t, f in forces if summary["end_s"] - 1.0 - 1e-6 < t < summary["end_s"] - 1e-6]
            mean = sum(at_the_end) / len(at_the_end)
            outside = [t for t, f in forces if abs(f - mean) > band and t >= landings[-1]]
            settled = landings[-1] + summary["force_settling"][f"planned_{foot}_s"]
            self.assertAlmostEqual(settled, outside[-1] + 0.01)  # one period later

    # Ten metres in ten seconds, horizontally or as a fall.
    def test_capture_point_stays_in_the_picture(self):
        code = """if True:
            import types
            from saltus.walking import compare_runs, plot_run
            way = [0.1 * i for i in range(101)]
            table = {name: way for name in ("t", "com_x", "com_y", "icp_x", "icp_y")}
            def standing(last):
                return [{"from_s": t, "left": True, "right": True, "corners": [[t - 0.1, t - 0.1], [t + 0.1, t + 0.1]]}
                        for t in range(last + 1)]
            def told(last):
                return {"ground": standing(last), "pushes": [], "touchdown_s": None, "end_s": 10.0}
            plot_run.save = lambda figure, *_: print(*(limit for axes in figure.axes for limit in axes.get_ylim()))
            for last in (9, 0):
                plot_run.draw_capture_point(table, told(last), "", 0.0, 10.0, "")
                axes = plot_run.plt.figure().gca()
                run = types.SimpleNamespace(trajectory=table, summary=told(last), name="")
                compare_runs.draw_both(axes, [run, run], "icp_y", "", 0.0, 10.0)
                print(*axes.get_ylim())
        """
        environment = {**os.environ, "PYTHONPATH": os.path.join(source, "python")}
        done = subprocess.run([PYTHON, "-B", "-c", code], capture_output=True, text=True, env=environment, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        limits = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
        expected = [[-0.13, 10.05, -0.13, 10.05], [-0.01, 10.01], [-0.13, 1.1, -0.13, 1.1], [-0.01, 1.1]]
        for one, other in zip(limits, expected):
            for a, b in zip(one, other):
                self.assertAlmostEqual(a, b)

    @unittest.skipUnless(os.path.exists(URDF), "SALTUS_ICUB_URDF names no file")
    def test_run_on_the_whole_body(self):
        self.is_drawn(script("plot_run", path("body")))
        for name in ("com", "capture_point", "from_above", "forces", "measured_forces", "feet", "torques",
                     "estimate", "step_plans"):
            self.is_picture("body", name + ".png")
        self.is_drawn(script("report", path("body")))
        with open(path("body", "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("<img"), 9)
        for text in ("Error of the estimate", "Measured vertical force", "Largest slip of the left sole", "Largest tilt",
                     "Smallest distance of a joint from its limit", "Simulator"):
            self.assertIn(text, page)

    def test_movie_needs_a_view(self):
        done = subprocess.run([program, "movie", path("baseline")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("/view.html; a run with", done.stderr)

    def test_comparison_of_two_runs(self):
        other = "body" if os.path.exists(URDF) else "baseline"
        self.is_drawn(script("compare_runs", path(other), path("baseline"), path("two.png")))
        self.is_picture("two.png")
        self.assertNotEqual(script("compare_runs", path(other)).returncode, 0)

    def test_map(self):
        done = subprocess.run([program, "map", "--directions", "4", "--impulses", "5:1:5",
                               "--step-times", "0.6", "--controllers", "capture_point,none",
                               "--jobs", "2", "--out", path("map")],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        os.remove(path("map", "map.png"))
        self.is_drawn(script("plot_map", path("map")))
        self.is_picture("map", "map.png")

    def test_problems_of_the_library(self):
        for name, pictures in (("a20", ["trajectory.png"]), ("robertson_kinetics", ["trajectory.png"]),
                               ("a19", ["trajectory_crossing.png", "trajectory_entering.png"])):
            done = subprocess.run([program, "run", name, "--out", path(name)], capture_output=True,
                                  text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(done.stderr, "")
            for picture in pictures:
                self.is_picture(name, picture)

    def test_library_problem_in_closed_loop(self):
        done = subprocess.run([program, "run", "a20", "--loop", "--loop.period", "0.05", "--out",
                               path("loop")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stderr, "")
        self.is_picture("loop", "trajectory.png")

    def test_missing_matplotlib_gives_a_sentence(self):
        os.makedirs(path("none"))
        with open(path("none", "matplotlib.py"), "w", encoding="utf-8") as file:
            file.write("raise ModuleNotFoundError('matplotlib')")
        done = subprocess.run([program, "run", "d07", "--out", path("d07")], capture_output=True,
                              text=True, env=dict(os.environ, PYTHONPATH=path("none")))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("has no matplotlib", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertTrue(os.path.exists(path("d07", "trajectory.csv")))


if __name__ == "__main__":
    if not program:
        sys.exit(__doc__)
    if subprocess.run([PYTHON, "-c", "import matplotlib"], capture_output=True).returncode != 0:
        print("skipped: matplotlib is missing (package python3-matplotlib)")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1], verbosity=2)
