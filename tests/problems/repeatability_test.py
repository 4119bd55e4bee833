"""A repeated run is bit-identical, independent of other programs on the machine.
Usage: repeatability_test.py SALTUS
"""

import os
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
PUSH = ["run", "push_recovery", "--pictures", "false", "--quiet", "--push.impulse", "6"]
RUNS = {"centroidal": [*PUSH, "--plant", "centroidal"]}
if os.environ.get("SALTUS_ICUB_URDF"):  # the whole body, with random sensor noise
    RUNS["dart"] = [*PUSH, "--plant", "dart", "--sensors", "measured", "--push.start", "1"]


def start(arguments):
    return subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


class Repeated(unittest.TestCase):
    def test_is_bit_identical(self):
        with tempfile.TemporaryDirectory(prefix="saltus-repeatability-") as temporary:
            folders = {name: os.path.join(temporary, name) for name in RUNS}
            for name, arguments in RUNS.items():  # sequentially
                with start([*arguments, "--out", folders[name]]) as run:
                    printed = run.communicate()[0]
                self.assertTrue(os.path.exists(os.path.join(folders[name], "run.json")), printed)
            again = {name: start(["rerun", folder]) for name, folder in folders.items()}  # in parallel
            printed = {name: run.communicate()[0] for name, run in again.items()}
        for name, run in again.items():
            self.assertEqual(run.returncode, 0, printed[name])
            self.assertTrue(printed[name].endswith("bit-identical\n"), printed[name])


if __name__ == "__main__":
    unittest.main()
