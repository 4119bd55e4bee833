"""Test cases with a temporary folder, which also holds the cache: tests do not write to the cache of the user."""

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
