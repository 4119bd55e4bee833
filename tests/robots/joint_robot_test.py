"""Robots for `saltus control`: the C robot of the examples with a plugin, DART in a second process, and recorded logs.

Usage: joint_robot_test.py SALTUS ROBOT PLUGIN CONVERSION
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

SALTUS, ROBOT, PLUGIN, CONVERSION = (os.path.abspath(name) for name in sys.argv[1:5])
del sys.argv[1:5]
DEADLINE = 120  # s, on a loaded machine
# Pace (wall-clock seconds per robot second) of faults that can only be detected in real time.
SLOW = "5"
# No load acts on the cart, so a small torque must move it.
CART = "guards: {stuck_limit: 0.3}\njoints:\n  slider: {torque: 3.0, speed: 5.0, limits: [-10, 10], start: 0.3}\n"


class Link(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="saltus-joints-")
        self.addCleanup(self.folder.cleanup)
        self.out = os.path.join(self.folder.name, "out")
        self.running, self.files = [], 0

    def tearDown(self):
        for process in self.running:
            process.kill()
            process.communicate()

    def write(self, text):
        self.files += 1
        name = os.path.join(self.folder.name, f"robot{self.files}.yaml")
        with open(name, "w", encoding="utf-8") as file:
            file.write(text)
        return name

    def start(self, *words):
        self.running.append(subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT))
        return self.running[-1]

    def finish(self, process):
        text = process.communicate(timeout=DEADLINE)[0]
        return process.returncode, text

    def control(self, *words):
        """The controller, and its port."""
        out = [] if "--out" in words else ["--out", self.out]
        process = self.start(SALTUS, *words, "--link", "udp:0", *out)
        line = process.stdout.readline()
        port = re.search(r"UDP port (\d+)", line)
        self.assertTrue(port, line)
        return process, port[1]

    def cart(self, *words):
        return self.control("control", "--plugin", PLUGIN, "--robot", self.write(CART), *words)

    def pair(self, *robot):
        """Exit status and output of the robot and of the controller."""
        controller, port = self.cart()
        robot = self.start(ROBOT, port, *robot, "slider=1,0.2,3,0.25")
        return *self.finish(robot), *self.finish(controller)

    def summary(self):
        with open(os.path.join(self.out, "summary.json"), encoding="utf-8") as file:
            return json.load(file)

    def wait_for_rows(self, mode):
        table, until = os.path.join(self.out, "trajectory.csv"), time.monotonic() + DEADLINE
        while time.monotonic() < until:
            with open(table, encoding="utf-8") as file:
                if sum(f",{mode}," in line for line in file) > 5:
                    return
            time.sleep(0.05)
        self.fail("the controller does not run")

    def guarded(self, text):
        return int(re.search(r"guard: (\d+) periods", text)[1])


class Cart(Link):
    def test_moves_to_its_target(self):
        status, text, control_status, control_text = self.pair("--time", "2")
        self.assertEqual((status, control_status), (0, 0), text + control_text)
        self.assertEqual(self.guarded(text), 0)
        self.assertLess(abs(float(re.search(r"joints: (\S+);", text)[1])), 0.01)
        summary = self.summary()
        self.assertAlmostEqual(summary["balanced_s"], 2.0, delta=0.01)
        self.assertEqual(summary["tick"]["count"], 101)  # every 20 ms
        self.assertEqual(summary["ticks_without_plan"], 0)
        self.assertEqual(summary["messages"]["lost"], 0)

    def test_converts_state_and_input(self):
        """The plugin has another state and another input than the joints."""
        controller, port = self.control("control", "--plugin", CONVERSION, "--robot",
                                        self.write(CART.replace("torque: 3.0", "torque: 6.0")))
        status, text = self.finish(self.start(ROBOT, port, "--time", "2.5", "slider=2,0.4,6,0.25"))
        control_status, control_text = self.finish(controller)
        self.assertEqual((status, control_status), (0, 0), text + control_text)
        self.assertAlmostEqual(float(re.search(r"joints: (\S+);", text)[1]), 1.0, delta=0.02)

    def test_readings_arrive_late(self):
        status, text, control_status, control_text = self.pair("--time", "0.5", "--delay", "5")
        self.assertEqual((status, control_status), (0, 0), text + control_text)

    def test_faults_stop_softly(self):
        for fault, sentence in (("nan", "the encoder of slider reads NaN"), ("clock", "check its clock"),
                                ("stuck", "slider has not moved for 0.30 s although it is driven")):
            with self.subTest(fault=fault):
                status, text, control_status, control_text = self.pair("--time", "5", "--fault", fault,
                                                                       "--fault-at", "0.0")
                self.assertEqual((status, control_status), (0, 7), text + control_text)
                self.assertIn(sentence, control_text)
                self.assertEqual(self.guarded(text), 0)  # commands continue: hold and damp

    def test_controller_killed(self):
        controller, port = self.cart()
        robot = self.start(ROBOT, port, "--time", "100", "--pace", SLOW, "slider=1,0.2,3,0.31")
        self.wait_for_rows("balance")
        controller.kill()
        status, text = self.finish(robot)
        self.assertEqual(status, 1, text)
        self.assertGreater(self.guarded(text), 100, text)

    def test_robot_killed(self):
        controller, port = self.cart()
        robot = self.start(ROBOT, port, "--time", "100", "--pace", SLOW, "slider=1,0.2,3,0.31")
        self.wait_for_rows("balance")
        robot.kill()
        status, text = self.finish(controller)
        self.assertEqual(status, 6, text)
        self.assertIn("no new message from the robot", text)

    def test_link_cut(self):
        controller, port = self.cart()
        robot = self.start(ROBOT, port, "--time", "5", "--pace", SLOW, "--fault", "silence", "--fault-at", "0.1",
                           "slider=1,0.2,3,0.31")
        control_status, control_text = self.finish(controller)
        self.assertEqual(control_status, 6, control_text)

    def test_wrong_arguments(self):
        robot = self.write(CART)
        for words, sentence in ((("--plugin", PLUGIN), "needs --robot FILE with the joints of the robot"),
                                (("--plugin", PLUGIN, "--robot", robot, "--controller", "sled"), "no controller sled"),
                                (("--plugin", robot, "--robot", robot), "--plugin"),
                                (("--plugin", PLUGIN, "--robot", self.write(CART + "  arm: {torque: 1}\n")),
                                 "has 2 states, expected the positions and velocities of 2 joints"),
                                (("--plugin", PLUGIN, "--robot", self.write(CART + "period: 0.003\n")),
                                 "is not a multiple"),
                                (("--plugin", PLUGIN, "--robot", self.write("joints: {slider: {speed: 1}}\n")),
                                 "joints.slider.torque must be the largest torque"),
                                (("--plugin", PLUGIN, "--robot", self.write(CART + "gains: {stiff: 1}\n")), "stiff")):
            with self.subTest(sentence=sentence):
                done = subprocess.run([SALTUS, "control", "--link", "udp:0", "--out", self.out, *words], text=True,
                                      capture_output=True, timeout=DEADLINE)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(sentence, done.stderr)
                self.assertFalse(os.path.exists(self.out))


class Example(unittest.TestCase):
    def test_wrong_arguments(self):
        for joint in ("-1", "2", "nan"):
            done = subprocess.run([ROBOT, "9", "--fault-joint", joint, "hip", "knee"], text=True, capture_output=True,
                                  timeout=DEADLINE)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("wrong argument --fault-joint", done.stderr)


class Check(Link):
    ARM = """joints:
  shoulder: {torque: 20, speed: 5, limits: [-1, 1]}
  elbow: {torque: 10, speed: 5, limits: [-2, 2], start: 0.5}
"""

    def check(self, *robot):
        """Exit status and output of `robot check`, and its results by joint."""
        controller, port = self.control("robot", "check", "--robot", self.write(self.ARM))
        robot = self.start(ROBOT, port, "--time", "100", "--fault-joint", "1", "--fault-at", "-1", *robot,
                           "shoulder=0.5,1,20,0", "elbow=0.2,0.5,10,0.5")
        status, text = self.finish(controller)
        self.assertEqual(self.finish(robot)[0], 0)
        return status, text, {joint["joint"]: joint for joint in self.summary()["joints"]}

    def test_right_joints(self):
        status, text, joints = self.check("--delay", "4")
        self.assertEqual(status, 0, text)
        for joint in joints.values():
            self.assertEqual(joint["sign"], 1)
            self.assertEqual(joint["findings"], [])
            self.assertAlmostEqual(joint["delay_s"], 0.005, delta=1e-9)  # 4 periods, and that of the motion
            self.assertAlmostEqual(joint["followed"], 1.0, delta=0.05)
            self.assertAlmostEqual(joint["velocity_ratio"], 1.0, delta=0.01)

    def test_wrong_joints(self):
        for fault, sentence in (("sign", "wrong elbow: it moves against its torque"),
                                ("offset", "wrong elbow: it is off by +0.020 rad in its known posture"),
                                ("velocity", "wrong elbow: its velocities are -1.00 times the motion"),
                                ("stuck", "wrong elbow: it moves by less than 0.010 rad")):
            with self.subTest(fault=fault):
                status, text, joints = self.check("--fault", fault)
                self.assertEqual(status, 5, text)
                self.assertIn(sentence, text)
                self.assertEqual(joints["shoulder"]["findings"], [])
                self.assertEqual(len(joints["elbow"]["findings"]), 1)
                if fault != "offset":  # no spring acted on the joint
                    self.assertEqual(joints["elbow"]["followed"], 0.0)


class Dart(Link):
    def play(self, folder):
        controller, port = self.control("control")
        status, text = self.finish(self.start(SALTUS, "robot", "play", folder, "--link", "udp:" + port))
        self.assertEqual(self.finish(controller)[0], 0)
        return status, text

    def test_simulated_and_recorded(self):
        recorded = os.path.join(self.folder.name, "recorded")
        controller, port = self.control("control", "--log-every", "1", "--out", recorded)
        robot = self.start(SALTUS, "robot", "serve", "--link", "udp:" + port, "--time", "0.3", "--loss", "0.02", "--jitter",
                           "0.003")
        status, text = self.finish(robot)
        control_status, control_text = self.finish(controller)
        self.assertEqual((status, control_status), (0, 0), text + control_text)
        self.assertIn("robot: stands in DART", text)
        self.assertEqual(self.guarded(text), 0)

        status, text = self.play(recorded)
        self.assertEqual(status, 0, text)
        self.assertIn("the commands agree", text)
        self.assertGreater(int(re.search(r"(\d+) commands compared", text)[1]), 100)

        table = os.path.join(recorded, "trajectory.csv")
        with open(table, encoding="utf-8") as file:
            lines = file.read().splitlines()
        column = lines[0].split(",").index("torque_l_knee [Nm]")
        row = next(i for i, line in enumerate(lines) if line.startswith("0.1") and ",balance," in line)
        cells = lines[row].split(",")
        cells[column] = str(float(cells[column]) + 1.0)
        lines[row] = ",".join(cells)
        with open(table, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        status, text = self.play(recorded)
        self.assertEqual(status, 5, text)
        self.assertIn("largest difference 1 Nm (l_knee at", text)

    def test_without_a_controller(self):
        done = subprocess.run([SALTUS, "robot", "serve", "--link", "udp:9", "--wait", "0.2"], text=True,
                              capture_output=True, timeout=DEADLINE)
        self.assertEqual(done.returncode, 6, done.stderr)
        self.assertIn("no controller balances", done.stderr)


if __name__ == "__main__":
    unittest.main()
