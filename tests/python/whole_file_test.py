#!/usr/bin/env python3
"""Checks that files are written completely or not at all, and that processes end with their parents."""

import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

PACKAGE = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
sys.path.insert(0, PACKAGE)
from saltus.tables import read_table  # noqa: E402
from saltus.viewer import json_text  # noqa: E402
from saltus.whole_file import whole_file, write_text  # noqa: E402


class WholeFile(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.path = os.path.join(self.folder, "a.html")

    def content(self):
        with open(self.path, encoding="utf-8") as file:
            return file.read()

    def test_file_appears_when_complete_with_default_permissions(self):
        with whole_file(self.path) as partial:
            self.assertEqual(os.stat(partial).st_mode & (stat.S_IRWXG | stat.S_IRWXO), 0)
            with open(partial, "w", encoding="utf-8") as file:
                file.write("all of it")
            self.assertFalse(os.path.exists(self.path))
        self.assertEqual(self.content(), "all of it")
        self.assertEqual(os.listdir(self.folder), ["a.html"])
        with open(os.path.join(self.folder, "other"), "w", encoding="utf-8"):
            pass
        self.assertEqual(os.stat(self.path).st_mode, os.stat(os.path.join(self.folder, "other")).st_mode)

    def test_failed_write_keeps_the_old_file(self):
        write_text(self.path, "before")
        for error in (KeyboardInterrupt, ValueError):
            with self.assertRaises(error), whole_file(self.path) as partial:
                with open(partial, "w", encoding="utf-8") as file:
                    file.write("half")
                raise error
        self.assertEqual(self.content(), "before")
        self.assertEqual(os.listdir(self.folder), ["a.html"])
        with self.assertRaises(OSError) as caught:
            write_text(os.path.join(self.folder, "none", "b"), "")
        self.assertTrue(caught.exception.filename.endswith("none/b"))

    def test_two_writers_do_not_conflict(self):
        with whole_file(self.path) as one, whole_file(self.path) as two:
            self.assertNotEqual(one, two)
            for partial, text in ((one, "first, and longer"), (two, "second")):
                with open(partial, "w", encoding="utf-8") as file:
                    file.write(text)
        self.assertEqual(self.content(), "first, and longer")

    def test_device_is_not_a_table(self):
        with self.assertRaisesRegex(ValueError, "is not a file"):
            read_table("/dev/zero")

    def test_names_cannot_end_or_hide_a_script(self):
        text = json_text({"name": "</script><!--<script>"})
        self.assertNotIn("<", text)
        self.assertIn("\\u003c/script>", text)


def state_of(process):
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:
            return file.read().rpartition(") ")[2][:1]
    except OSError:
        return ""


@unittest.skipIf(sys.platform != "linux", "prctl is Linux's")
class Children(unittest.TestCase):
    def test_children_end_with_their_parent(self):
        child = "import time; time.sleep(60)"
        parent = ("import subprocess, sys; from saltus.children import end_with_parent; "
                  f"c = subprocess.Popen([sys.executable, '-c', {child!r}], preexec_fn=end_with_parent); print(c.pid, flush=True); c.wait()")
        process = subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": PACKAGE})
        number = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        process.communicate()
        for _ in range(100):  # 5 s
            if state_of(number) in ("", "Z"):  # ended, or its status has not been read yet
                return
            time.sleep(0.05)
        os.kill(number, signal.SIGKILL)
        self.fail("the child keeps running")


if __name__ == "__main__":
    unittest.main()
