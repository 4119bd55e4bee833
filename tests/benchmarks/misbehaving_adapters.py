"""Adapters for one-variable programs, min 1/2 w^2 + g w on [low, high], that misbehave in one way each.

bench_scripts_test.py installs them as a plug-in of `saltus bench`.
"""

import json
import os
import sys
import threading
import time

import numpy as np
from peers import Adapter, Answer


class Honest(Adapter):
    name, package, about = "honest", "numpy", "solves the program"
    needs = ()

    def __init__(self, qp, tolerance):
        self.qp = qp

    def run(self):
        w = np.clip(-self.qp.gradient, self.qp.lower, self.qp.upper)
        self.found = Answer(w, np.zeros(self.qp.m), -(w + self.qp.gradient), claimed="optimal", solved=True, iterations=1)

    def read(self):
        return self.found


def spin(seconds=1e9):
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


class Waits(Honest):  # for another process, a GPU or a licence
    name = "waits"

    def run(self):
        time.sleep(0.05)
        super().run()


class OtherThread(Honest):
    name = "other-thread"

    def run(self):
        thread = threading.Thread(target=spin, args=(0.05,))
        thread.start()
        thread.join()
        super().run()


class OwnTimer(Honest):
    name = "own-timer"

    def run(self):
        spin(0.05)
        super().run()
        self.found.own_us = 0.01


class OtherClock(Honest):  # replaces the clocks of the interpreter
    name = "other-clock"

    def run(self):
        time.perf_counter_ns = time.process_time_ns = lambda: 0
        spin(0.05)
        super().run()


class AtSetUp(Honest):
    name = "at-set-up"

    def __init__(self, qp, tolerance):
        super().__init__(qp, tolerance)
        spin(0.05)
        super().run()

    def run(self):
        pass


class SleepsInSolve(Honest):
    name = "sleeps-in-solve"

    def run(self):
        time.sleep(1e6)


class SpinsInSetUp(Honest):
    name = "spins-in-set-up"

    def __init__(self, qp, tolerance):
        spin()


class SleepsAtImport(Honest):
    name = "sleeps-at-import"

    @classmethod
    def missing(cls):
        time.sleep(1e6)


class NeedsMemory(Honest):
    name = "needs-memory"

    def run(self):
        kept = []
        while True:
            kept.append(np.ones(4_000_000))
            time.sleep(0.001)


class Exits(Honest):
    name = "exits"

    def run(self):
        sys.exit(0)


class Aborts(Honest):
    name = "aborts"

    def run(self):
        os.abort()


class LeavesAChild(Honest):  # that has its files open
    name = "leaves-a-child"

    def run(self):
        if os.fork() == 0:
            time.sleep(1e6)
        os._exit(0)


def forged(name):
    return json.dumps({"problem": "own/one", "start": "cold", "solver": name, "instance": 1, "verdict": "solved", "claimed": "",
                       "kkt": {}, "times": {"wall_us": [0.1], "cpu_us": [0.1]}}) + "\n"


class Prints(Honest):  # lines that look like results, and a line without an end
    name = "prints"

    def run(self):
        text = forged(self.name).encode()
        for stream in range(1, 32):
            try:
                os.write(stream, text * 18 + b"iter 0 ...")
            except OSError:
                pass
        super().run()
        self.found.w = self.found.w + 1.0


class ChangesTheProgram(Honest):  # so that the judge would accept its point
    name = "changes-the-program"

    def run(self):
        self.qp.gradient[:] = 0.0
        super().run()


ALL = [value for value in list(globals().values()) if isinstance(value, type) and issubclass(value, Honest)]
