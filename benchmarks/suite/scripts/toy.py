"""A solver that returns wrong answers as solved, and one that does not end, to test the check and the engine. They are
selected by name only."""

import numpy as np

from peers import Answer


class Toy:
    name, package = "toy", "numpy"
    about = "wrong on purpose"
    ladder = (1.0,)
    needs = ()

    def __init__(self, qp, tolerance):
        self.qp = qp

    def solve(self, start):
        w = np.clip(np.zeros(self.qp.n), self.qp.lower, self.qp.upper)
        return Answer(w, np.zeros(self.qp.m), np.zeros(self.qp.n), claimed="optimal", solved=True,
                      iterations=1, own_us=0.1)


class Endless(Toy):
    name, about = "endless", "never ends"

    def solve(self, start):
        while True:
            pass
