#!/usr/bin/env python3
"""The type stubs name every class, function, argument and option of the extension.

Usage: stubs_test.py BUILD, with the folder python of the build, or `installed` for the installed package.
"""

import ast
import os
import sys
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
build = sys.argv.pop(1)
if build != "installed":
    sys.path[:0] = [os.path.join(ROOT, "python"), build]
import saltus.modelling  # noqa: E402

if build == "installed":
    sys.path.append(os.path.join(ROOT, "python"))
import make_stubs  # noqa: E402
from saltus import _core  # noqa: E402


def outline(text):
    """Names with their arguments. Types differ between releases of pybind11."""
    def of(body, prefix):
        for node in body:
            if isinstance(node, ast.ClassDef):
                yield prefix + node.name
                yield from of(node.body, f"{prefix}{node.name}.")
            elif isinstance(node, ast.FunctionDef):
                names = [a.arg for a in (*node.args.args, *node.args.kwonlyargs)]
                yield f"{prefix}{node.name}({', '.join(names)})"
            elif isinstance(node, ast.AnnAssign):
                yield prefix + node.target.id
    return sorted(of(ast.parse(text).body, ""))


class Stubs(unittest.TestCase):
    def test_they_are_up_to_date(self):
        with open(os.path.join(ROOT, "python", "saltus", "_core.pyi"), encoding="utf-8") as file:
            written = file.read()
        self.assertEqual(outline(written), outline(make_stubs.stubs(_core)), "python/make_stubs.py BUILD writes them")
        self.assertIn("def solve(problem: OptimalControlProblem, *, intervals_per_phase: int = ...", written)

    def test_the_package_has_the_same_names(self):
        with open(os.path.join(ROOT, "python", "saltus", "__init__.pyi"), encoding="utf-8") as file:
            imports = [node for node in ast.parse(file.read()).body if isinstance(node, ast.ImportFrom)]
        names = {name.name for node in imports for name in node.names if node.module != "results"}
        core = {name for name in dir(_core) if not name.startswith("_")}
        self.assertEqual(names - {"*", "load", "run", "Run", "Table", "SaltusError", "view"},
                         set(saltus.modelling.__all__) - core)

    def test_everything_has_a_docstring(self):
        for name in saltus.modelling.__all__:
            value = getattr(saltus.modelling, name)
            if callable(value):
                self.assertTrue(value.__doc__, name)


if __name__ == "__main__":
    unittest.main()
