#!/usr/bin/env python3
"""Checks that the pages made by Saltus open in a browser without console messages and with the expected contents.

Usage: browser_test.py PROGRAM SOURCE_DIR. Makes the documentation (if Doxygen and its theme are installed), a report
and, if SALTUS_ICUB_URDF names a file, a view, and opens them in a headless Chromium. Exits with 77, "skipped",
without one.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
PATIENCE = 300  # s for a page; a scene is drawn without a graphics card
PYTHON = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
URDF = os.environ.get("SALTUS_ICUB_URDF", "")
BROWSER = next((path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if path), None)
# A message of the graphics drivers about screenshots with software rendering.
OF_THE_DRIVER = "GL Driver Message"

program, source = sys.argv[1:3] if len(sys.argv) == 3 else ("", "")
folder = tempfile.TemporaryDirectory(prefix="saltus-browser-")


def path(*parts):
    return os.path.join(folder.name, *parts)


def call(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stdout}{done.stderr}")


def push(name, *settings):
    call(program, "run", "push_recovery", "--out", path(name), "--push.start", "0.1", "--push.impulse", "6", *settings)


class Browser(unittest.TestCase):
    def opened(self, page, anchor="", *more):
        """The page after its scripts have run. There must be no console messages."""
        with tempfile.TemporaryDirectory(prefix="saltus-profile-") as profile:
            done = subprocess.run(
                [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader", f"--user-data-dir={profile}", "--window-size=400,320",
                 "--enable-logging=stderr", "--v=0", "--dump-dom", *more, f"file://{page}{anchor}"],
                capture_output=True, text=True, check=False, timeout=PATIENCE)
        said = [line for line in done.stderr.splitlines() if "CONSOLE" in line and OF_THE_DRIVER not in line]
        self.assertEqual(said, [], page)
        self.assertIn("</html>", done.stdout, page)
        return done.stdout

    def test_mistake_in_a_page_is_detected(self):
        with open(path("wrong.html"), "w", encoding="utf-8") as file:
            file.write("<html><script>nobody.knows()</script></html>")
        with self.assertRaisesRegex(AssertionError, "nobody is not defined"):
            self.opened(path("wrong.html"))

    def test_report(self):
        push("centroidal")
        page = self.opened(path("centroidal", "report.html"))
        self.assertIn("Recovered", page)

    def test_view_of_two_runs(self):
        for name in ("first", "second"):
            push(name, "--pictures", "false")
        done = subprocess.run([program, "view", path("first"), "--with", path("second")], capture_output=True, text=True,
                              check=False)
        if "uPlot is not installed" in done.stderr:
            self.skipTest(done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(self.opened(path("first", "view.html")), r"<b>com \[m\]</b>.*first.*second")

    @unittest.skipUnless(os.path.exists(URDF), "SALTUS_ICUB_URDF names no file")
    def test_report_and_view_of_the_whole_body(self):
        push("body", "--plant", "dart")
        self.assertIn("view.html", self.opened(path("body", "report.html")))
        if not os.path.exists(path("body", "view.html")):
            self.skipTest("no view was made: libjs-three or uPlot is missing")
        page = self.opened(path("body", "view.html"), "#movie=5&from=0.100&to=0.300")
        self.assertTrue(re.search(r'<pre id="film">\s*[A-Za-z0-9+/]{1000}', page), "nothing was drawn")

    @unittest.skipUnless(shutil.which("doxygen") and os.path.isdir("/usr/share/doxygen-awesome-css"),
                         "doxygen or doxygen-awesome-css is missing")
    @unittest.skipUnless(shutil.which("node") and os.path.isdir("/usr/share/javascript/katex"),
                         "nodejs or libjs-katex is missing")
    def test_documentation_and_its_search(self):
        call(PYTHON, "-B", os.path.join(source, "docs", "reference", "make.py"), path("docs"))
        html = path("docs", "html")
        for name, words in (("index.html", "hybrid optimal control"), ("page_docs_tutorial.html", "lift-off after"),
                            ("page_docs_concepts.html", "half open"), ("structsaltus_1_1Solution.html", "kkt")):
            self.assertTrue(words in self.opened(os.path.join(html, name)), f"{name} does not say {words}")
        with open(os.path.join(html, "index.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn('class="katex-display"', page, "the first page shows no formula")
        # Types a word and makes the content of the result frame readable.
        typed = """<script>
          const typed = () => {
            document.getElementById("MSearchField").value = "make_native_solver";
            searchBox.OnSearchFieldFocus(true);
            searchBox.Search();
          };
          const read = () => document.body.dataset.found = frames.MSearchResults.document.body.innerText;
          addEventListener("load", () => { setTimeout(typed, 500); setTimeout(read, 3000); });
        </script>"""
        with open(os.path.join(html, "typed.html"), "w", encoding="utf-8") as file:
            file.write(page.replace("</head>", typed + "</head>"))
        found = self.opened(os.path.join(html, "typed.html"), "", "--virtual-time-budget=5000",  # ms
                            "--allow-file-access-from-files")
        self.assertTrue(re.search(r'data-found="[^"]*make_native_solver', found), "the search finds nothing")


if __name__ == "__main__":
    if BROWSER is None:
        print("skipped: there is no Chromium (Debian's package chromium)")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
