#!/usr/bin/env python3
"""Checks the page of `saltus view`: its data without a browser, and the page itself in a headless Chromium.

Usage: viewer_test.py SOURCE_DIR UPLOT_DIR [BUILD], a folder with uPlot.iife.js, or `installed` for the installed package;
and the folder python of the build, for plans. Exits with 77, "skipped", without numpy or uPlot. Without Chromium or
three.js the tests of the page are skipped.
"""

import contextlib
import importlib.util
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SKIPPED = 77
source, uplot, build = (sys.argv[1:] + ["", "", ""])[:3]
sys.argv[1:] = []
if importlib.util.find_spec("numpy") is None:
    print("skipped: this python3 has no numpy")
    sys.exit(SKIPPED)
INSTALLED = uplot == "installed"
if not INSTALLED and not os.path.exists(os.path.join(uplot, "uPlot.iife.js")):
    print(f"skipped: there is no uPlot in {uplot} (./saltus setup fetches it)")
    sys.exit(SKIPPED)
cache = tempfile.TemporaryDirectory(prefix="saltus-viewer-")
os.environ["XDG_CACHE_HOME"] = cache.name
os.makedirs(os.path.join(cache.name, "saltus"))
if not INSTALLED:
    os.symlink(os.path.abspath(uplot), os.path.join(cache.name, "saltus", "uplot"))
    os.environ["PYTHONPATH"] = os.pathsep.join(path for path in (os.path.join(source, "python"), build) if path)
    sys.path[:0] = os.environ["PYTHONPATH"].split(os.pathsep)
sys.path.append(os.path.join(source, "docs", "reference"))

import numpy as np  # noqa: E402
import open_pages  # noqa: E402
import saltus  # noqa: E402
from saltus import viewer  # noqa: E402
from saltus.results import Table  # noqa: E402

CHROMIUM = next((path for path in map(shutil.which, open_pages.BROWSERS) if path), None)
FLAGS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
OF_THE_DRIVER = "GL Driver Message"  # about screenshots with software rendering
HAS_THREE = os.path.exists(os.path.join(viewer.THREE, "three.min.js"))
HAS_CORE = importlib.util.find_spec("saltus._core") is not None
LENGTH = 2.0  # s
SCENE = {"view": "xz", "items": [
    {"name": "cart", "shape": "box", "size": [0.4, 0.2, 0.2], "at": ["position", 0, {"column": "height", "times": 2, "plus": 1}]},
    {"name": "pole", "on": "cart", "axis": "y", "angle": "-angle"},
    {"name": "bob", "on": "pole", "shape": "sphere", "size": 0.1, "at": [0, 0, 1]},
    {"shape": "line", "points": ["cart", "bob"], "width": 0.02}, {"shape": "path", "of": "bob"},
    {"name": "push", "on": "cart", "shape": "arrow", "vector": ["force", 0, 0]}]}


def write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text if isinstance(text, str) else json.dumps(text))


def rows(until, scale=1.0):
    """A cart that moves along t^2 and jumps up at 1 s."""
    text = "t [s],mode,position [m],height [m],angle [rad],force [N]\n"
    for i in range(round(until * 100) + 1):
        t = i / 100
        for late in ((False, True) if i == 100 else (t > 1,)):
            text += f"{t},{'high' if late else 'low'},{scale * t * t},{0.5 if late else 0},{math.pi * t},{2 - t if t < 1.5 else ''}\n"
    return text


def make_run(folder, scale=1.0, scene=True):
    os.makedirs(folder)
    write(folder, "trajectory.csv", rows(LENGTH, scale))
    write(folder, "events.csv", "t [s],event,kind,mode before,mode after\n1,lift-off,jumps,low,high\n")
    write(folder, "plans.csv", "made at [s],t [s],mode,position [m]\n" +
          "".join(f"{made},{made + t},low,{made}\n" for made in (0, 1) for t in (0, 0.5, 1)))
    write(folder, "summary.json", {"name": "cart", "cost": 1.5, "states": ["position [m]", "height [m]", "angle [rad]"],
                                   "inputs": ["force [N]"], "costs": [{"phase": "low", "term": "effort", "value": 1.5}],
                                   "misses": [{"phase": "high", "term": "ceiling", "amount": 0.25}]})
    if scene:
        write(folder, "scene.json", SCENE)
    return folder


def ball():
    """The plan of a point mass with a speed limit, and its closed loop."""
    drive = saltus.Phase("drive", lambda t, x, u: [x[1], u[0]], saltus.exactly(1.0), nx=2, nu=1)
    drive.minimise("effort", lambda t, x, u: 0.5 * u[0] * u[0]).keep("limit", lambda t, x: x[1], saltus.at_most(1.2))
    drive.reach("there", lambda t, x: x, saltus.exactly([1.0, 0.0]))
    problem = saltus.OptimalControlProblem("ball").start_at([0, 0]).then(drive)
    plan = saltus.solve(problem)
    law = saltus.simulate_closed_loop(lambda t, x: plan.trajectory.input(t + 1e-6),  # of the interval after t
                                      saltus.nominal_plant(problem, saltus.runge_kutta4()), duration=1.0, period=1.0 / 30)
    return problem, plan, law


def run_module(*words, **how):
    return subprocess.run([sys.executable, "-B", "-m", "saltus.viewer", *words], capture_output=True, text=True, check=False, **how)


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="saltus-view-")
        self.addCleanup(self.folder.cleanup)

    def path(self, *parts):
        return os.path.join(self.folder.name, *parts)


class Data(Folder):
    def test_vectors_share_a_panel_and_planned_columns_join_the_real_ones(self):
        t = np.linspace(0, 1, 5)
        table = Table({"t [s]": t, "com_x [m]": t, "com_y [m]": t, "com_z [m]": t, "planned com_x [m]": t, "l_hip_roll [rad]": t,
                       "l_hip_pitch [rad]": t, "left force [N]": t, "right force [N]": t, "x": t, "mass [kg]": t, "cart [m]": t, "cart [m/s]": t})
        panels = {f"{panel['title']} [{panel['unit']}]": [s["column"] for s in panel["series"]] for panel in viewer.panels_of("body", table)}
        self.assertEqual(panels, {"com [m]": ["com_x", "planned com_x", "com_y", "com_z"], "l_hip [rad]": ["l_hip_roll", "l_hip_pitch"],
                                  "force [N]": ["left force", "right force"], "x []": ["x"], "mass [kg]": ["mass"],
                                  "cart [m]": ["cart [m]"], "cart [m/s]": ["cart [m/s]"]})

    def test_columns_keep_their_values(self):
        import base64
        values = np.array([1.0, np.nan, -3.5, 1e6])
        fine = np.frombuffer(base64.b64decode(viewer.pack(values, True)["f"]), "<f4")
        np.testing.assert_allclose(fine, values, rtol=1e-7)
        coarse = viewer.pack(values, False)
        levels = np.frombuffer(base64.b64decode(coarse["u"]), "<u2").astype(float)
        self.assertEqual(levels[1], 65535)
        np.testing.assert_allclose((coarse["low"] + coarse["step"] * levels)[[0, 2, 3]], values[[0, 2, 3]], atol=coarse["step"])

    def test_large_tables_are_thinned(self):
        t = np.arange(3000.0)
        packed = viewer.pack_table(Table({"t [s]": t, **{f"c{i}": t for i in range(400)}}))
        self.assertEqual(packed["every"], 4)

    def test_wrong_scenes_are_refused_by_name(self):
        folder = make_run(self.path("run"))
        for change, text in (({"shape": "boxx"}, "unknown shape 'boxx'"), ({"at": ["speed", 0, 0]}, "needs column 'speed'"),
                             ({"on": "nobody"}, "refers to 'nobody'"), ({"points": ["nobody"]}, "has a point at 'nobody'"),
                             ({"at": ["feet:x", 0, 0]}, "of table 'feet'")):
            write(folder, "scene.json", {"items": [{"name": "wrong", **change}]})
            done = run_module(folder)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn(text, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
        write(folder, "scene.json", "{")
        self.assertIn("scene.json: ", run_module(folder).stderr)

    def test_objects_that_are_not_runs_are_refused(self):
        with self.assertRaisesRegex(viewer.ViewError, "int is not a run; give a folder"):
            saltus.view(7)

    def test_folder_without_tables(self):
        done = run_module(self.folder.name)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (3, 1), done.stderr)
        write(self.folder.name, "map.csv", "impulse [N s],recovered\n1,1\n")
        self.assertIn("no table with a column t", run_module(self.folder.name).stderr)
        with self.assertRaisesRegex(viewer.ViewError, "no table with a column t"):
            saltus.view(saltus.load(self.folder.name))

    @unittest.skipUnless(HAS_CORE, "the extension is not built")
    def test_multipliers_of_a_plan(self):
        problem, plan, _ = ball()
        self.assertTrue(plan.ok(), plan.message)
        saltus.save(problem, plan, self.path("plan"))
        run = saltus.load(self.path("plan"))
        self.assertEqual(list(run.tables["multipliers"]), ["t", "limit", "costate 0", "costate 1"])
        entries = {(m["term"], m["row"]): m for m in run.summary["multipliers"]}
        # The cost is 6 without the limit. Its derivative with respect to the speed limit is not positive.
        self.assertEqual(set(entries), {("limit", 0), ("there", 0), ("there", 1)})
        self.assertLess(entries["limit", 0]["upper"], -1.0)
        self.assertAlmostEqual(entries["limit", 0]["lower"], 0.0, places=6)
        curves = run.tables["multipliers"]["limit"]
        self.assertAlmostEqual(np.nansum(curves), entries["limit", 0]["upper"], places=5)
        sections = {section["title"].split(":")[0]: dict((row[0], row[1]) for row in section["rows"]) for section in viewer.notes_of([run])}
        self.assertEqual(set(sections), {"Cost terms", "Multipliers", "Violations and checks", "Summary"})
        self.assertEqual(list(sections["Multipliers"])[1:], ["drive: limit", "drive: there 0", "drive: there 1"])

    @unittest.skipUnless(HAS_THREE, "three.js is missing (package libjs-three)")
    def test_page_is_small_and_needs_no_network(self):
        folder = make_run(self.path("run"))
        page = saltus.view(folder)._repr_html_()
        self.assertTrue(page.startswith("<iframe srcdoc="))
        done = run_module(folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(folder, "view.html"), encoding="utf-8") as file:
            text = file.read()
        self.assertLess(len(text), 2e6)
        self.assertNotIn("@@", text.split("<script>")[0])
        for wanted in ("src=", "href=", "@import"):
            self.assertNotIn(wanted, text.split("<script>")[0])

    @unittest.skipIf(INSTALLED, "the package has no scenes of the library")
    def test_scene_in_the_documentation_is_that_of_the_library(self):
        with open(os.path.join(source, "docs", "viewer.md"), encoding="utf-8") as page, \
                open(viewer.find_scene(self.folder.name, "c03_pendulum_on_cart"), encoding="utf-8") as scene:
            self.assertIn(scene.read(), page.read())

    @unittest.skipIf(INSTALLED, "the package has no scenes of the library")
    def test_scene_of_a_project_and_of_the_library(self):
        os.makedirs(self.path("project"))
        write(self.path("project"), "scene.json", SCENE)
        folder = make_run(self.path("project", "results", "plan"), scene=False)
        self.assertEqual(viewer.find_scene(folder, None), self.path("project", "scene.json"))
        os.remove(self.path("project", "scene.json"))
        self.assertTrue(viewer.find_scene(folder, "c03_pendulum_on_cart").endswith("scenes/c03_pendulum_on_cart.json"))
        self.assertIsNone(viewer.find_scene(folder, "../secret"))


@unittest.skipUnless(CHROMIUM, "there is no Chromium (Debian's package chromium)")
@unittest.skipUnless(HAS_THREE, "three.js is missing (package libjs-three)")
class Page(Folder):
    @contextlib.contextmanager
    def opened(self, page):
        """A browser with the page; no errors may be on the console at the end."""
        with tempfile.TemporaryDirectory(prefix="saltus-profile-", ignore_cleanup_errors=True) as profile:
            browser = open_pages.Browser(CHROMIUM, profile, *FLAGS)
            browser.window(1280)
            said = browser.open(page)
            browser.evaluate("set_playing(false); 0")
            yield browser
            said += [sentence for sentence in map(browser.error, browser.events) if sentence]
            browser.close()
        self.assertEqual([sentence for sentence in said if OF_THE_DRIVER not in sentence], [])

    def test_time_moves_curves_and_scene(self):
        folder = make_run(self.path("run"))
        saltus.view(folder).save(self.path("view.html"))
        with self.opened(self.path("view.html")) as browser:
            self.assertEqual(browser.evaluate("panels.length"), 4)
            self.assertEqual(browser.evaluate("mode_names(runs[0])"), ["low", "high"])
            # Scrubbing by the slider: time, scene, values and lines.
            browser.evaluate("scrub.value = 0.75 * scrub.max; scrub.dispatchEvent(new Event('input')); 0")
            self.assertAlmostEqual(browser.evaluate("time"), 1.5)
            place = browser.evaluate("world_of_scene.named.cart.position.toArray()")
            for got, expected in zip(place, (2.25, 0, 2)):
                self.assertAlmostEqual(got, expected, places=5)
            bob = browser.evaluate("new THREE.Vector3().setFromMatrixPosition("
                                   "world_of_scene.named.bob.matrixWorld).toArray()")
            for got, expected in zip(bob, (3.25, 0, 2)):  # turned by -1.5 pi about y: towards +x
                self.assertAlmostEqual(got, expected, places=5)
            self.assertFalse(browser.evaluate("world_of_scene.named.push.children[0].visible"))  # no force after 1.5 s
            self.assertIn("2.25", browser.evaluate("panels[0].box.innerText"))
            lines = "panels.map(p => new DOMMatrix(getComputedStyle(p.line).transform).e / p.plot.over.clientWidth)"
            for share in browser.evaluate(lines):
                self.assertAlmostEqual(share, 0.75, delta=0.01)
            # Zoom and hover of one panel act on all.
            browser.evaluate("panels[0].plot.setScale('x', { min: 0.5, max: 1.5 }); 0")
            time.sleep(0.2)
            self.assertEqual(browser.evaluate("panels.map(p => [p.plot.scales.x.min, p.plot.scales.x.max])"), [[0.5, 1.5]] * 4)
            self.assertEqual(browser.evaluate("plan_at(runs[0], 0.9) * 10 + plan_at(runs[0], 1.1)"), 1)
            notes = browser.evaluate("[...document.querySelectorAll('details.menu')].map(d => d.textContent)")
            self.assertTrue(any("effort1.5" in note for note in notes) and any("ceiling" in note for note in notes), notes)
            # Curves on demand.
            browser.evaluate("view_data.panels.forEach(p => { p.shown = p.title === 'angle'; }); build_panels(); 0")
            self.assertEqual(browser.evaluate("panels.length"), 1)
            # Playing reaches the end.
            browser.evaluate("go(1.9); set_playing(true); 0")
            deadline = time.monotonic() + 60
            while browser.evaluate("playing") and time.monotonic() < deadline:
                time.sleep(0.2)
            self.assertEqual(browser.evaluate("time"), LENGTH)

    def test_comparison_without_a_scene(self):
        runs = [make_run(self.path("first"), scene=False), make_run(self.path("second"), 2.0, scene=False)]
        saltus.view(*runs).save(self.path("view.html"))
        with self.opened(self.path("view.html")) as browser:
            self.assertEqual(browser.evaluate("world_of_scene"), None)
            browser.evaluate("go(1.5); 0")
            text = browser.evaluate("panels[0].box.innerText")
            self.assertIn("first 2.250", text)
            self.assertIn("second 4.500", text)

    @unittest.skipUnless(HAS_CORE, "the extension is not built")
    def test_plan_against_plant(self):
        _, plan, log = ball()
        saltus.view(log, plan).save(self.path("view.html"))
        with self.opened(self.path("view.html")) as browser:
            self.assertEqual(browser.evaluate("runs.map(run => run.name)"), ["closed loop", "plan"])
            browser.evaluate("go(0.5); 0")
            text = browser.evaluate("panels[0].box.innerText")
            self.assertTrue("closed loop 0.500" in text and "plan 0.500" in text, text)
            # Multipliers are drawn on demand.
            self.assertNotIn("limit", browser.evaluate("panels.map(p => p.box.innerText).join()"))
            browser.evaluate("view_data.panels.forEach(p => { p.shown = p.table === 'multipliers' && p.title === 'limit'; });"
                             "build_panels(); 0")
            self.assertEqual(browser.evaluate("panels.length"), 1)
            self.assertIn("limit", browser.evaluate("panels[0].box.innerText"))

    def test_logarithmic_time(self):
        folder = make_run(self.path("run"), scene=False)
        write(folder, "summary.json", {"logarithmic_time": True})
        saltus.view(folder).save(self.path("view.html"))
        with self.opened(self.path("view.html")) as browser:
            browser.evaluate("scrub.value = 0.5 * scrub.max; scrub.dispatchEvent(new Event('input')); 0")
            self.assertAlmostEqual(browser.evaluate("time"), math.sqrt(0.001 * LENGTH), places=4)

    def test_page_follows_a_run_that_continues(self):
        folder = make_run(self.path("run"))
        os.remove(os.path.join(folder, "summary.json"))
        write(folder, "trajectory.csv", rows(0.5))
        viewing = subprocess.Popen([sys.executable, "-B", "-m", "saltus.viewer", folder, "--live"], stdout=subprocess.PIPE,
                                   text=True)
        self.addCleanup(viewing.stdout.close)
        try:
            self.assertTrue(viewing.stdout.readline().strip().endswith("view.html"))
            with self.opened(os.path.join(folder, "view.html")) as browser:
                def reaches(condition):
                    deadline = time.monotonic() + 60
                    while not browser.evaluate(condition):
                        self.assertLess(time.monotonic(), deadline, condition)
                        time.sleep(0.2)
                reaches("end === 0.5 && is_live")
                write(folder, "trajectory.csv", rows(1.2))
                reaches("end === 1.2 && time === 1.2 && is_live")
                write(folder, "trajectory.csv", rows(LENGTH))
                time.sleep(0.01)
                write(folder, "summary.json", {"name": "cart"})
                reaches(f"end === {LENGTH} && !is_live")
            self.assertEqual(viewing.wait(60), 0)
        finally:
            if viewing.poll() is None:
                viewing.send_signal(signal.SIGINT)
                viewing.wait()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
