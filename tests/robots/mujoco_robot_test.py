"""`saltus control` balances examples/mujoco_robot.py in another process, and both react to faults of the other.

Usage: mujoco_robot_test.py SALTUS ROBOT. Exits with 77 if the package mujoco is missing.
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

try:
    import mujoco
except ImportError as error:
    print(f"skipped: {error}; install it with: python3 -m pip install mujoco")
    sys.exit(77)

SALTUS, ROBOT = (os.path.abspath(name) for name in sys.argv[1:3])
del sys.argv[1:3]
DEADLINE = 300  # s, on a loaded machine
# Seconds per second of the robot. A fault of the link can only be noticed in real time, slowed for a loaded machine.
SLOW = "20"


class Link(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="saltus-link-")
        cls.model = os.path.join(cls.folder.name, "icub.xml")
        subprocess.run([SALTUS, "control", "--mjcf", cls.model], check=True, timeout=DEADLINE)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        self.running = []

    def tearDown(self):
        for process in self.running:
            process.kill()
            process.communicate()

    def start(self, *words):
        self.running.append(subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT))
        return self.running[-1]

    def controller(self, *words, link="udp:0"):
        self.out = os.path.join(self.folder.name, self.id())
        process = self.start(SALTUS, "control", "--link", link, "--out", self.out, *words)
        line = process.stdout.readline()
        port = re.search(r"UDP port (\d+)", line)
        return process, f"udp:{port[1]}" if port else link

    def robot(self, link, *words):
        return self.start(sys.executable, "-B", ROBOT, self.model, "--link", link, *words)

    def finish(self, process):
        text = process.communicate(timeout=DEADLINE)[0]
        return process.returncode, text

    def pair(self, *robot, link="udp:0"):
        """Exit status and output of the controller and of the robot."""
        controller, address = self.controller(link=link)
        robot = self.robot(address, *robot)
        return *self.finish(robot), *self.finish(controller)

    def summary(self):
        with open(os.path.join(self.out, "summary.json"), encoding="utf-8") as file:
            return json.load(file)

    def guarded(self, text):
        return int(re.search(r"guard: (\d+) periods", text)[1])

    def test_balances_over_both_transports(self):
        for link in ("udp:0", f"shm:saltus_test_{os.getpid()}"):
            with self.subTest(link=link[:3]):
                status, text, control_status, control_text = self.pair("--time", "0.3", link=link)
                self.assertEqual((status, control_status), (0, 0), text + control_text)
                self.assertEqual(self.guarded(text), 0)
                self.assertGreaterEqual(self.summary()["balanced_s"], 0.29)
        os.unlink(f"/dev/shm/saltus_test_{os.getpid()}")

    def test_balances_with_loss_and_jitter(self):
        status, text, control_status, control_text = self.pair("--time", "0.4", "--loss", "0.02", "--jitter", "0.004")
        self.assertEqual((status, control_status), (0, 0), text + control_text)
        messages = self.summary()["messages"]
        self.assertGreater(messages["late"], 0)
        self.assertGreater(messages["readings_replaced"], messages["late"])

    def test_nan_and_a_stopped_clock_stop_softly(self):
        for fault, sentence in (("nan", "encoder"), ("clock", "clock")):
            with self.subTest(fault=fault):
                _, text, status, control_text = self.pair("--time", "0.4", "--fault", fault, "--fault-at", "0.2")
                self.assertEqual(status, 7, control_text)
                self.assertIn(sentence, control_text)
                self.assertEqual(self.guarded(text), 0)  # commands continue: hold and damp

    def test_a_joint_sticks(self):
        """The fault is detected only after the push, when the joint is driven."""
        _, text, status, control_text = self.pair("--time", "1.5", "--fault", "stuck", "--fault-at", "0.2", "--push", "7",
                                                  "--push-at", "0.6", "--fault-joint", "7")
        self.assertEqual(status, 7, text + control_text)
        self.assertIn("r_hip_roll has not moved", control_text)
        self.assertGreater(self.summary()["balanced_s"], 0.6)

    def test_controller_killed(self):
        """The guard of the robot acts, once for all."""
        controller, link = self.controller()
        robot = self.robot(link, "--time", "0.6", "--pace", SLOW)
        self.wait_for_rows()
        controller.kill()
        status, text = self.finish(robot)
        self.assertIn(status, (0, 1), text)  # it may fall
        self.assertGreater(self.guarded(text), 100, text)

    def test_robot_killed(self):
        controller, link = self.controller()
        robot = self.robot(link, "--time", "5", "--pace", SLOW)
        self.wait_for_rows()
        robot.send_signal(signal.SIGKILL)
        status, text = self.finish(controller)
        self.assertEqual(status, 6, text)
        self.assertIn("no new message from the robot", text)

    def test_link_cut(self):
        """Nothing arrives any more: both sides react."""
        status, text, control_status, control_text = self.pair("--time", "0.6", "--pace", SLOW, "--fault", "silence",
                                                               "--fault-at", "0.1")
        self.assertIn(status, (0, 1), text)
        self.assertEqual(control_status, 6, control_text)

    def wait_for_rows(self):
        """Until the controller has balanced for some time."""
        table = os.path.join(self.out, "trajectory.csv")
        until = time.monotonic() + DEADLINE
        while time.monotonic() < until:
            with open(table, encoding="utf-8") as file:
                if sum(",balance," in line for line in file) > 20:
                    return
            time.sleep(0.1)
        self.fail("the controller does not balance")


if __name__ == "__main__":
    unittest.main()
