#!/usr/bin/env python3
"""Checks for every problem of the program that --config accepts the output of --print-config, gives the same run, and
that the JSON Schema of --print-schema allows it.

Usage: configuration_test.py PROGRAM. The schemas are checked only if python3 has the packages jsonschema and yaml.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import jsonschema
    import yaml
except ImportError:
    jsonschema = None

PROGRAM = sys.argv.pop(1)
# Run twice, with settings other than the defaults: short ones of each kind.
RUNS = {"B22": ["intervals=12", "samples=3"], "E01": [], "A04": [], "C03": ["solver=riccati", "loop.run=true", "loop.seed=3"],
        "push_recovery": ["push.impulse=7", "push.start=0.1", "weights.wrench_change=2e-4"],
        "sway": [], "quadruped": ["duration=0.5"],
        "whole_body": ["task=hop", "track=false"]}
COMPUTING = ("solve time", "processor time", "check time")


def saltus(*words, status=(0,)):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    if done.returncode not in status:
        raise AssertionError(f"{' '.join(words)}: status {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def problems():
    return [line.split()[0] for line in saltus("list").splitlines() if line.strip()]


def tables(folder):
    """The rows of each CSV file, without computing times."""
    found = {}
    for name in sorted(os.listdir(folder)):
        if name.endswith(".csv"):
            with open(os.path.join(folder, name), newline="", encoding="utf-8") as file:
                found[name] = [{key: value for key, value in row.items() if not key.startswith(COMPUTING)}
                               for row in csv.DictReader(file)]
    return found


class Configuration(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def kept(self, text):
        file = self.path("config.yaml")
        with open(file, "w", encoding="utf-8") as stream:
            stream.write(text)
        return file

    def test_printed_configuration_round_trips(self):
        names = problems()
        self.assertGreater(len(names), 50)
        for name in names:
            with self.subTest(name):
                printed = saltus("run", name, "--print-config")
                self.assertEqual(saltus("run", name, "--config", self.kept(printed), "--print-config"), printed)

    def test_settings_are_included(self):
        for name, settings in RUNS.items():
            words = [word for setting in settings for word in ("--set", setting)]
            with self.subTest(name):
                printed = saltus("run", name, *words, "--print-config")
                self.assertEqual(saltus("run", name, "--config", self.kept(printed), "--print-config"), printed)

    def test_run_is_the_same(self):
        for name, settings in RUNS.items():
            words = [word for setting in settings for word in ("--set", setting)]
            with self.subTest(name):
                one, other = self.path(f"{name}_one"), self.path(f"{name}_other")
                file = self.kept(saltus("run", name, *words, "--set", "pictures=false", "--print-config"))
                saltus("run", name, *words, "--set", "pictures=false", "--out", one)
                saltus("run", name, "--config", file, "--out", other)
                self.assertEqual(tables(one), tables(other))
                self.assertTrue(tables(one))

    @unittest.skipIf(jsonschema is None, "this python3 has no packages jsonschema and yaml")
    def test_schema_agrees_with_the_program(self):
        for name in problems():
            with self.subTest(name):
                schema = json.loads(saltus("run", name, "--print-schema"))
                jsonschema.Draft202012Validator.check_schema(schema)
                validator = jsonschema.Draft202012Validator(schema)
                config = yaml.safe_load(saltus("run", name, "--print-config"))
                self.assertEqual([error.message for error in validator.iter_errors(config)], [])
                config["no_such_key"] = 1
                self.assertFalse(validator.is_valid(config))

    @unittest.skipIf(jsonschema is None, "this python3 has no packages jsonschema and yaml")
    def test_verdicts_of_check_match_their_schema(self):
        validator = jsonschema.Draft202012Validator(json.loads(saltus("check", "--print-schema")))
        page = json.loads(saltus("check", "B22", "--json"))
        self.assertEqual([error.message for error in validator.iter_errors(page)], [])
        self.assertTrue(page["ok"])
        self.assertIn("derivatives", [line["aspect"] for line in page["lines"]])
        self.assertEqual(saltus("check", "B22", "--quiet"), "")
        coarse = json.loads(saltus("check", "B22", "--intervals", "1", "--json", status=(0, 5)))
        self.assertEqual([error.message for error in validator.iter_errors(coarse)], [])


if __name__ == "__main__":
    unittest.main()
