"""Test cases with a temporary folder, which also holds the cache: tests do not write to the cache of the user."""

import json
import os
import shutil
import tempfile
import unittest
import unittest.mock


class OwnFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="saltus-bench-test-")
        self.addCleanup(shutil.rmtree, self.folder)
        cache = unittest.mock.patch.dict(os.environ, XDG_CACHE_HOME=self.path("cache"))
        cache.start()
        self.addCleanup(cache.stop)

    def path(self, name):
        return os.path.join(self.folder, name)

    def lines(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return [json.loads(line) for line in file]

    def own_problem(self, gradient):
        """A file of SALTUS_BENCH_PROGRAMS: min 1/2 w^2 + gradient w on [0, 4], with a guess and a warm start."""
        os.makedirs(self.path("own"), exist_ok=True)
        entry = {"row": [0], "col": [0], "value": [1.0]}
        with open(self.path("own/one.json"), "w", encoding="utf-8") as file:
            json.dump({"format": "saltus-qp 1", "problem": "own/one", "instance": 1, "variables": 1, "rows": 0, "hessian": entry,
                       "jacobian": {"row": [], "col": [], "value": []}, "gradient": [gradient], "constant": 0.0, "lower": [0.0],
                       "upper": [4.0], "row_lower": [], "row_upper": [], "stages": [],
                       "guess": [2.0], "warm": {"w": [-min(0.0, gradient)], "lambda": [], "z": [0.0]}}, file)
