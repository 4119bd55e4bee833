#!/usr/bin/env python3
"""The Python package: tables as arrays, runs by the program, and logs that other readers can read.

Usage: results_test.py PROGRAM. Tests that need h5py or mcap are skipped without them.
"""

import json
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
import numpy as np  # noqa: E402

import saltus  # noqa: E402

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else None

TRAJECTORY = """t [s],mode,height [m],force
0,stance,0.5,
0.1,stance,0.25,3
0.1,flight,0.1,0.30000000000000004
"""


class Results(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.run_folder = os.path.join(self.folder.name, "hop")
        os.mkdir(self.run_folder)
        self.write("trajectory.csv", TRAJECTORY)
        self.write("events.csv", "t [s],event\n0.1,lift-off\n")
        self.write("summary.json", json.dumps({"cost": 2.0, "robot": "hopper"}))
        self.loaded = saltus.load(self.run_folder)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        with open(os.path.join(self.run_folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def test_arrays_with_names_and_units(self):
        table = self.loaded.trajectory
        self.assertEqual(list(table), ["t", "mode", "height", "force"])
        self.assertEqual(table.units["height"], "m")
        self.assertEqual(table.units["force"], "")
        np.testing.assert_array_equal(table["height [m]"], [0.5, 0.25, 0.1])
        np.testing.assert_array_equal(table["height"], [0.5, 0.25, 0.1])
        self.assertTrue(np.isnan(table["force"][0]))
        self.assertEqual(list(table["mode"]), ["stance", "stance", "flight"])
        self.assertEqual(self.loaded.summary["cost"], 2.0)
        with self.assertRaises(KeyError):
            table["depth"]
        with self.assertRaisesRegex(FileNotFoundError, "not the folder of a run"):
            saltus.load(self.path("nothing"))

    def test_columns_that_differ_by_their_unit_alone(self):
        self.write("trajectory.csv", "t [s],v [m/s],v [rad/s],u [N]\n0,1,2,3\n")
        table = saltus.load(self.run_folder).trajectory
        self.assertEqual(list(table), ["t", "v [m/s]", "v [rad/s]", "u"])
        self.assertEqual([table[name][0] for name in ("v [m/s]", "v [rad/s]", "u", "u [N]")], [1.0, 2.0, 3.0, 3.0])
        self.assertEqual(table.units["v [rad/s]"], "rad/s")
        with self.assertRaises(KeyError):
            table["v"]

    def test_mat_is_read_back(self):
        try:
            import h5py
        except ModuleNotFoundError:
            self.skipTest("needs h5py")
        self.loaded.to_mat(self.path("hop.mat"))
        with open(self.path("hop.mat"), "rb") as file:
            head = file.read(128)
        self.assertTrue(head.startswith(b"MATLAB 7.3 MAT-file"))
        self.assertEqual(head[124:], b"\x00\x02IM")
        with h5py.File(self.path("hop.mat"), "r") as file:
            root = file["robot_logger_device"]
            group = root["trajectory"]["height"]
            np.testing.assert_array_equal(np.squeeze(group["data"]), self.loaded.trajectory["height"])
            np.testing.assert_array_equal(np.squeeze(group["timestamps"]), self.loaded.trajectory.time)

            def texts(dataset):  # as robot-log-visualizer does
                return ["".join(chr(c[0]) for c in file[ref]) for ref in dataset[0]]

            self.assertEqual(texts(group["elements_names"]), ["height"])
            self.assertEqual(texts(group["units_of_measure"]), ["m"])
            self.assertEqual(texts(root["description_list"]), ["hop"])
            self.assertEqual("".join(chr(c[0]) for c in root["yarp_robot_name"]), "hopper")
            self.assertEqual(root["trajectory"]["force"]["data"].shape, (3, 1, 1))

    def test_mcap_is_read_back(self):
        try:
            from mcap.reader import make_reader
        except ModuleNotFoundError:
            self.skipTest("needs mcap")
        self.loaded.to_mcap(self.path("hop.mcap"))
        with open(self.path("hop.mcap"), "rb") as file:
            read = [(schema, channel.topic, message.log_time, json.loads(message.data))
                    for schema, channel, message in make_reader(file).iter_messages(["/trajectory"])]
        self.assertEqual([message["height"] for *_, message in read], [0.5, 0.25, 0.1])
        self.assertEqual([message["force"] for *_, message in read], [None, 3.0, 0.1 + 0.2])
        self.assertEqual([time for _, _, time, _ in read], [0, 100000000, 100000000])
        schema = json.loads(read[0][0].data)
        self.assertEqual(read[0][0].encoding, "jsonschema")
        self.assertEqual(schema["properties"]["height"]["description"], "m")

    @unittest.skipUnless(PROGRAM, "needs the program")
    def test_run_makes_and_loads(self):
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        made = saltus.run("bryson_denham", out=self.path("block"), solver="sparse", pictures=False,
                          loop__plan_every=5)
        self.assertAlmostEqual(made.summary["cost"], 4.0, places=9)
        self.assertIn("plan_every: 5", made.config)
        self.assertGreater(len(made.trajectory.time), 100)
        with self.assertRaisesRegex(saltus.SaltusError, "must be riccati, sparse or ipopt") as caught:
            saltus.run("bryson_denham", out=self.path("block"), solver="spare")
        self.assertEqual(caught.exception.status, 2)


if __name__ == "__main__":
    unittest.main()
