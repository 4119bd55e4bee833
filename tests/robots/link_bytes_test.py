"""The Python robot of the examples writes and reads the bytes of the C header (saltus_robot_test.cpp).

Usage: link_bytes_test.py ROBOT MESSAGES
"""

import importlib.util
import sys
import types
import unittest

import numpy as np

ROBOT, MESSAGES = sys.argv[1:3]
del sys.argv[1:3]
sys.modules["mujoco"] = types.ModuleType("mujoco")  # the protocol does not need the simulator
specification = importlib.util.spec_from_file_location("mujoco_robot", ROBOT)
robot = importlib.util.module_from_spec(specification)
specification.loader.exec_module(robot)
with open(MESSAGES, encoding="ascii") as file:
    SENSORS, COMMAND = (bytes.fromhex(line) for line in file)


class Bytes(unittest.TestCase):
    def setUp(self):
        self.protocol = robot.Protocol(["hip", "knee", "ankle"])

    def test_sensors(self):
        numbers = np.arange(22 + 2 * 3) / 4
        self.assertEqual(self.protocol.sensors(7, 1.5, 0.5, True, numbers).hex(), SENSORS.hex())

    def test_guard_flag(self):
        numbers = np.arange(22 + 2 * 3) / 4
        self.assertEqual(self.protocol.sensors(7, 1.5, 0.5, False, numbers, guards=True)[22:24], b"\x02\0")

    def test_command(self):
        sequence, answers, state, *numbers = self.protocol.command(COMMAND)
        self.assertEqual((sequence, answers, state), (9, 7, 2))
        np.testing.assert_array_equal(np.concatenate(numbers), np.arange(15) / 4)

    def test_guard_has_the_times_of_the_header(self):
        with open(ROBOT, encoding="utf-8") as file:
            text = file.read()
        self.assertIn('"--guard", type=float, default=0.015', text)
        self.assertIn('"--guard-damping", type=float, default=0.2', text)
        self.assertIn('"--guard-release", type=float, default=0.3', text)


if __name__ == "__main__":
    unittest.main()
