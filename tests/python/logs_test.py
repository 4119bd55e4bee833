#!/usr/bin/env python3
"""Checks the MAT and MCAP files of `saltus run --log.formats csv,mat,mcap` with the packages of their users: h5py, the
reader of robot-log-visualizer, without a display, and mcap. Every number must equal that of the CSV file.

Usage: logs_test.py PROGRAM. SALTUS_LOG_PYTHON names a python3 that has the packages; skipped (77) if one is missing.
"""

import csv
import glob
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
PYTHON = os.environ.pop("SALTUS_LOG_PYTHON", "")
if PYTHON:
    os.execv(PYTHON, [PYTHON, "-B", *sys.argv])
try:
    import h5py
    from mcap.reader import make_reader
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    from qtpy.QtCore import QCoreApplication
    from robot_log_visualizer.signal_provider.matfile_signal_provider import MatfileSignalProvider
except ImportError as error:
    print(f"skipped: {error}; SALTUS_LOG_PYTHON names a python3 that has h5py, mcap and robot-log-visualizer")
    sys.exit(SKIPPED)

PROGRAM = sys.argv.pop(1)
ROOT = "robot_logger_device"
URDF = os.environ.get("SALTUS_ICUB_URDF", "")
RUNS = {"loop": ["C03", "--loop", "--solver", "riccati", "--loop.method", "step", "--loop.plan_every", "50"],
        "push": ["push_recovery", "--push.start", "0.1"]}
if os.path.exists(URDF):
    RUNS["body"] = [*RUNS["push"], "--plant", "dart"]
folder = tempfile.TemporaryDirectory(prefix="saltus-logs-")


def run(name):
    """A folder with the results, made once."""
    out = os.path.join(folder.name, name)
    if not os.path.exists(out):
        done = subprocess.run([PROGRAM, "run", *RUNS[name], "--pictures", "false", "--out", out, "--log.formats",
                               "csv,mat,mcap"], capture_output=True, text=True, check=False,
                              env={**os.environ, "SALTUS_PYTHON": sys.executable})
        if done.returncode != 0:
            raise RuntimeError(f"{name}: status {done.returncode}: {done.stdout}{done.stderr}")
    return out


def tables(out):
    """name -> column without its unit -> (unit in the head, cells), read without the package."""
    found = {}
    for file in sorted(glob.glob(os.path.join(out, "*.csv"))):
        with open(file, newline="", encoding="utf-8") as stream:
            head, *rows = csv.reader(stream)
        columns = {}
        for i, full in enumerate(head):
            name, _, unit = full.removesuffix("]").partition(" [")
            columns[name] = (unit, [row[i] for row in rows])
        if "t" in columns and rows:
            found[os.path.basename(file)[:-len(".csv")]] = columns
    return found


def numbers(cells):
    """None if a cell is not a number; NaN if it is empty."""
    try:
        return [float(cell) if cell else math.nan for cell in cells]
    except ValueError:
        return None


def same(one, other):
    return len(one) == len(other) and all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in zip(one, other))


class Logs(unittest.TestCase):
    def each(self):
        for name in RUNS:
            with self.subTest(name):
                yield name, run(name), tables(run(name))

    def mat_name(self, column):
        clean = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in column)
        return clean if clean[:1].isalpha() else "x" + clean

    def test_mat_by_h5py(self):
        for _, out, found in self.each():
            count = 0
            with h5py.File(os.path.join(out, "run.mat")) as file:
                for table, columns in found.items():
                    times = numbers(columns["t"][1])
                    for column, (unit, cells) in columns.items():
                        values = numbers(cells)
                        if column == "t" or values is None or len(times) < 2:
                            continue
                        signal = file[ROOT][self.mat_name(table)][self.mat_name(column)]
                        self.assertTrue(same(signal["data"][()].ravel().tolist(), values), f"{table}.{column}")
                        self.assertTrue(same(signal["timestamps"][()].ravel().tolist(), times))
                        said = "".join(chr(c[0]) for c in file[signal["units_of_measure"][0][0]]).strip()
                        self.assertEqual(said, unit, f"{table}.{column}")
                        count += 1
            self.assertGreater(count, 5)

    def test_mat_by_robot_log_visualizer(self):
        application = QCoreApplication.instance() or QCoreApplication([])
        self.assertIsNotNone(application)
        for name, out, found in self.each():
            reader = MatfileSignalProvider(0.03, ROOT)
            self.assertTrue(reader.open(os.path.join(out, "run.mat")))
            for table, columns in found.items():
                for column, (_, cells) in columns.items():
                    values = numbers(cells)
                    if column == "t" or values is None or len(cells) < 2:
                        continue
                    read, times = reader.get_item_from_path([self.mat_name(table), self.mat_name(column)])
                    self.assertTrue(same(read.tolist(), values), f"{table}.{column}")
                    self.assertTrue(same(times.tolist(), numbers(columns["t"][1])))
            if name == "body":
                self.assertIn("l_knee", reader.joints_name)
                positions, _ = reader.get_item_from_path(["joints_state", "positions"])
                knee = positions[:, reader.joints_name.index("l_knee")]
                self.assertTrue(same(knee.tolist(), numbers(found["body"]["q_l_knee"][1])))

    def test_mcap(self):
        for _, out, found in self.each():
            read = {table: [] for table in found}
            with open(os.path.join(out, "run.mcap"), "rb") as stream:
                for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
                    self.assertEqual((schema.encoding, channel.message_encoding), ("jsonschema", "json"))
                    content = json.loads(message.data)
                    self.assertEqual(set(content), set(json.loads(schema.data)["properties"]))
                    read[channel.topic.removeprefix("/")].append(content)
            for table, columns in found.items():
                for column, (_, cells) in columns.items():
                    got = [row["timestamp" if column == "t" else column] for row in read[table]]
                    values = numbers(cells)
                    if values is None:
                        self.assertEqual(got, cells)
                    else:
                        self.assertTrue(same([math.nan if v is None else v for v in got],
                                             [v if math.isfinite(v) else math.nan for v in values]), f"{table}.{column}")

    def test_every_column_of_a_robot_names_its_unit(self):
        without = ("_q", "two_feet", "friction", "is_left", "right_foot", "steps", "chosen", "feasible", "cost",
                   "provenance", "status", "iterations", "kkt")
        for name in set(RUNS) - {"loop"}:
            for table in ("trajectory", "body", "ticks", "plans", "steps"):
                path = os.path.join(run(name), f"{table}.csv")
                if not os.path.exists(path):
                    continue
                with open(path, newline="", encoding="utf-8") as stream:
                    head = next(csv.reader(stream))
                bare = [c for c in head if not c.endswith("]") and not any(word in c for word in without)]
                self.assertEqual(bare, [], f"{name}: {table}")

    def test_every_quantity_of_a_robot_has_a_unit(self):
        for name in set(RUNS) - {"loop"}:
            with h5py.File(os.path.join(run(name), "run.mat")) as file:
                bare = set()
                for table in ("trajectory", "body"):
                    for column, signal in file[ROOT].get(table, {}).items():
                        if not "".join(chr(c[0]) for c in file[signal["units_of_measure"][0][0]]).strip():
                            bare.add(column)
            # Quaternions, flags and ratios.
            self.assertEqual({c for c in bare if not any(word in c for word in ("_q", "two_feet", "friction", "is_left"))},
                             set())

    def test_missing_parts_are_reported(self):
        out = os.path.join(folder.name, "bare")
        # A python3 without packages.
        done = subprocess.run([PROGRAM, "run", "bryson_denham", "--pictures", "false", "--out", out, "--log.formats",
                               "mcap"], capture_output=True, text=True, check=False,
                              env={**os.environ, "SALTUS_PYTHON": os.path.join(folder.name, "python3")})
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("no logs: python3 could not run saltus.logs", done.stderr)
        self.assertTrue(os.path.exists(os.path.join(out, "trajectory.csv")))
        done = subprocess.run([PROGRAM, "run", "bryson_denham", "--out", out, "--log.formats", "csv,xls"],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("log.formats must name csv, mat or mcap", done.stderr)


if __name__ == "__main__":
    unittest.main()
