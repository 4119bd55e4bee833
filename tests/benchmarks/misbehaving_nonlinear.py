"""Adapters for nonlinear programs in files that misbehave in one way each, see misbehaving_adapters.py. They know the
optimum of the program of nonlinear_files_test.py: (1, 1) with the multiplier -2."""

import numpy as np
from peers import Adapter, Answer


class Knows(Adapter):
    name, package, about = "knows", "numpy", "knows the optimum"
    needs, takes_files, takes_pairs = (), True, False
    w, rows, bounds = (1.0, 1.0), (-2.0,), (0.0, 0.0)

    def __init__(self, file, tolerance):
        self.file = file

    def run(self):
        pass

    def read(self):
        return Answer(np.array(self.w), np.array(self.rows), np.array(self.bounds), claimed="optimal", solved=True, iterations=1)


class Elsewhere(Knows):
    name, w = "elsewhere", (2.0, 0.5)


class Infeasible(Knows):
    name, w = "infeasible", (0.9, 0.9)


class NoMultipliers(Knows):
    name, rows = "no-multipliers", (0.0,)


class WrongSign(Knows):
    name, rows = "wrong-sign", (2.0,)


class FakeBounds(Knows):  # bound multipliers cancel any slope
    name, w, rows, bounds = "fake-bounds", (2.0, 1.0), (0.0,), (-4.0, -2.0)


class NotANumber(Knows):
    name, w = "not-a-number", (float("nan"), 1.0)


class TooShort(Knows):
    name, w = "too-short", (1.0,)


class OtherOptimum(Knows):  # with the same cost
    name, w = "other-optimum", (-1.0, -1.0)


class ChangesTheFile(Knows):  # the data and the arrays, so that any point would be optimal
    name, w, rows = "changes-the-file", (3.0, 3.0), (0.0,)

    def run(self):
        self.file.data["blocks"].clear()
        self.file.row_lower[:] = self.file.lower[:] = -np.inf


ALL = [value for value in list(globals().values()) if isinstance(value, type) and issubclass(value, Knows)]
