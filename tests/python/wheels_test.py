#!/usr/bin/env python3
"""Checks that make_wheels.py finds interpreters and checks the content of wheels, and that `import` names missing libraries."""

import os
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "python"))
import make_wheels  # noqa: E402


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="saltus-wheels-")
        self.addCleanup(self.folder.cleanup)

    def path(self, *parts):
        return os.path.join(self.folder.name, *parts)

    def write(self, text, *parts):
        os.makedirs(os.path.dirname(self.path(*parts)), exist_ok=True)
        with open(self.path(*parts), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path(*parts), 0o755)
        return self.path(*parts)


class Interpreters(Folder):
    def setUp(self):
        super().setUp()
        before = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", before)

    def test_a_broken_stub_does_not_hide_an_interpreter(self):
        self.write("#!/bin/sh\nexit 127\n", "stubs", "python3.13")
        real = self.write("#!/bin/sh\necho cp313\n", "real", "python3.13")
        os.environ["PATH"] = self.path("stubs") + os.pathsep + self.path("real")
        self.assertEqual(make_wheels.interpreters([]), {"cp313": real})
        os.environ["PATH"] = self.path("stubs")
        self.assertEqual(make_wheels.interpreters([]), {})

    def test_a_given_interpreter_must_run(self):
        with self.assertRaisesRegex(SystemExit, "nowhere/python does not run"):
            make_wheels.interpreters([self.path("nowhere", "python")])
        self.assertEqual(list(make_wheels.interpreters([sys.executable])), ["cp%d%d" % sys.version_info[:2]])


class Wheels(Folder):
    def test_required_content_of_a_wheel(self):
        names = ["saltus/__init__.py", "saltus/_core.cpython-311-x86_64-linux-gnu.so", "saltus/_core.pyi", "saltus/py.typed",
                 "saltus/viewer.html", "saltus/uplot/uPlot.iife.js"]
        for left_out in (None, *names[1:]):
            path = self.path("w.whl")
            with zipfile.ZipFile(path, "w") as wheel:
                for name in names:
                    if name != left_out:
                        wheel.writestr(name, "")
            missing = make_wheels.missing_files(path)
            self.assertEqual(len(missing), 0 if left_out is None else 1, (left_out, missing))

    def test_a_missing_library_is_named_with_its_packages(self):
        self.write("raise ImportError('libipopt.so.1: cannot open shared object file: No such file or directory')\n",
                   "saltus", "_core.py")
        done = subprocess.run([sys.executable, "-B", "-c", "import saltus; saltus.Phase"], capture_output=True, text=True,
                              check=False, env={**os.environ, "PYTHONPATH": os.path.join(ROOT, "python") + os.pathsep + self.path()})
        said = done.stderr.strip().splitlines()[-1]
        self.assertIn("needs the library libipopt.so.1, which is missing: apt-get install libfmt-dev", said)
        self.assertIn("coinor-libipopt-dev", said)


if __name__ == "__main__":
    unittest.main()
