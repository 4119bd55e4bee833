"""Adapters for one-variable programs, min 1/2 w^2 + g w on [low, high], that misbehave in one way each.

liars_test.py installs them as a plug-in of `saltus bench`. Each class states the expected reaction:
    verdict: verdict on its answers, "solved" by default
    at_least_us: the smallest time that may be reported
    told: a text that the run must print, or that its line must contain
"""

import ctypes
import json
import os
import signal
import sys
import threading
import time

import numpy as np
from peers import Adapter, Answer

BUSY = 0.05  # s


class Honest(Adapter):
    name, package, about = "honest", "numpy", "solves the program"
    needs = ()
    verdict, at_least_us, told = "solved", 0.0, ""

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


# Wrong answers


class WrongPoint(Honest):
    name, verdict = "wrong-point", "wrong"

    def run(self):
        super().run()
        self.found.w = self.found.w + 1e-3


class NoMultipliers(Honest):
    name, verdict = "no-multipliers", "wrong"

    def __init__(self, qp, tolerance):
        super().__init__(qp, tolerance)
        self.qp.upper[:] = 0.5

    def run(self):
        super().run()
        self.found.bound_multipliers = 0.0 * self.found.bound_multipliers


class NotANumber(Honest):
    name, verdict = "not-a-number", "wrong"

    def run(self):
        super().run()
        self.found.w = self.found.w * np.nan


class Rounds(Honest):  # rounds its answer to single precision
    name, verdict = "rounds", "wrong"

    def run(self):
        super().run()
        self.found.w = (self.found.w / 3.0).astype(np.float32) * 3.0 + np.float32(1e-7)


class Wavers(Honest):  # its last repetition is wrong
    name, verdict, solves = "wavers", "wrong", 0

    def run(self):
        super().run()
        Wavers.solves += 1
        if Wavers.solves >= 6:  # after the probes, the first solve and the first repetition
            self.found.w = self.found.w + 1.0


class ChangesTheProgram(Honest):  # changes it so that the judge would accept the point
    name, verdict = "changes-the-program", "wrong"

    def run(self):
        self.qp.gradient[:] = 0.0
        super().run()


class ReplacesTheJudge(Honest):
    name, verdict = "replaces-the-judge", "wrong"

    def run(self):
        import quadratic_program
        quadratic_program.kkt_residual = lambda *_: dict.fromkeys(("stationarity", "feasibility", "complementarity"), 0.0)
        super().run()
        self.found.w = self.found.w + 1.0


class Prints(Honest):  # prints lines that look like results, and a line without an end
    name, verdict = "prints", "wrong"

    def run(self):
        text = json.dumps({"problem": "own/one", "start": "cold", "solver": self.name, "instance": 1, "verdict": "solved", "claimed": "",
                           "kkt": {}, "times": {"wall_us": [0.1], "cpu_us": [0.1]}}).encode() + b"\n"
        for stream in range(1, 32):
            try:
                os.write(stream, text * 18 + b"iter 0 ...")
            except OSError:
                pass
        super().run()
        self.found.w = self.found.w + 1.0


# Invalid answers


class TooShort(Honest):
    name, verdict, told = "too-short", "error", "its w has the shape (0,), not (1,)"

    def run(self):
        super().run()
        self.found.w = self.found.w[:-1]


class AnswersNothing(Honest):
    name, verdict, told = "answers-nothing", "error", "AttributeError"

    def run(self):
        self.found = None


class Throws(Honest):
    name, verdict, told = "throws", "error", "RuntimeError: no"

    def run(self):
        raise RuntimeError("no")


class ReadsTheWarmStart(Honest):  # reads it in a cold task
    name, verdict, told = "reads-the-warm-start", "error", "TypeError"

    def run(self):
        super().run()
        self.found.w = self.qp.warm["w"]


# Times


class Slow(Honest):
    name, at_least_us = "slow", 4e4

    def run(self):
        spin(BUSY)
        super().run()


class Waits(Honest):  # for another process, a GPU or a licence
    name, at_least_us = "waits", 4e4

    def run(self):
        time.sleep(BUSY)
        super().run()


class OtherThread(Honest):
    name, at_least_us = "other-thread", 4e4

    def run(self):
        thread = threading.Thread(target=spin, args=(BUSY,))
        thread.start()
        thread.join()
        super().run()


class OwnTimer(Honest):
    name, at_least_us = "own-timer", 4e4

    def run(self):
        spin(BUSY)
        super().run()
        self.found.own_us = 0.01


class OtherClock(Honest):  # replaces the clocks of the interpreter
    name, at_least_us = "other-clock", 4e4

    def run(self):
        kept = time.perf_counter_ns, time.process_time_ns
        time.perf_counter_ns = time.process_time_ns = lambda: 0
        spin(BUSY)
        super().run()
        time.perf_counter_ns, time.process_time_ns = kept


class AtSetUp(Honest):
    name, told = "at-set-up", '"setup_us": '

    def __init__(self, qp, tolerance):
        super().__init__(qp, tolerance)
        spin(BUSY)
        super().run()

    def run(self):
        pass


class AtHandOver(Honest):
    name, told = "at-hand-over", "at-hand-over: it works outside of its timed call"

    def hand_over(self, start):
        spin(BUSY)
        super().run()

    def run(self):
        pass


class WhenRead(Honest):  # computes its point when it is read
    name, told = "when-read", "when-read: it works outside of its timed call"

    class Later:
        def __init__(self, values):
            self.values = values

        def __array__(self, *_, **__):
            spin(BUSY)
            return self.values

    def run(self):
        super().run()
        self.found.w = self.Later(self.found.w)


class Remembers(Honest):  # remembers the answers of earlier solves
    name, told = "remembers", "remembers: its first solve takes much longer"

    def __init__(self, qp, tolerance):
        super().__init__(qp, tolerance)
        self.known = None

    def run(self):
        if self.known is None:
            spin(BUSY)
            super().run()
            self.known = self.found


# Others


class Chatty(Honest):
    name = "chatty"

    def run(self):
        os.write(1, b"iter 0 ...")
        super().run()


class Denies(Honest):  # calls a right answer infeasible
    name, told = "denies", "infeasible"

    def run(self):
        super().run()
        self.found.claimed, self.found.solved = "infeasible", False


class ChangesTheStart(Honest):  # changes the start of the solvers after it
    name = "changes-the-start"

    def run(self):
        if self.start is not None:
            self.start[0][:] = np.nan
        super().run()


class LeavesADaemon(Honest):  # leaves a process outside of its process group
    name = "leaves-a-daemon"

    def run(self):
        if not os.path.exists("daemon"):
            child = os.fork()
            if child == 0:
                os.setsid()
                if os.fork() == 0:
                    with open("daemon", "w", encoding="ascii") as file:
                        file.write(str(os.getpid()))
                    time.sleep(1e6)
                os._exit(0)
            os.waitpid(child, 0)
        super().run()


# The process


class Exits(Honest):
    name, verdict, told = "exits", "crashed", "status 0 during its solve"

    def run(self):
        sys.exit(0)


class Aborts(Honest):
    name, verdict, told = "aborts", "crashed", "SIGABRT during its solve"

    def run(self):
        os.abort()


class ReadsNowhere(Honest):
    name, verdict, told = "reads-nowhere", "crashed", "SIGSEGV during its solve"

    def run(self):
        ctypes.string_at(0)


class LeavesAChild(Honest):  # that has its files open
    name, verdict = "leaves-a-child", "crashed"

    def run(self):
        if os.fork() == 0:
            time.sleep(1e6)
        os._exit(0)


class Spins(Honest):
    name, verdict, told = "spins", "too slow", "its solve took longer than its limit"

    def run(self):
        spin()


class Sleeps(Honest):
    name, verdict, told = "sleeps", "too slow", "its solve took longer than its limit"

    def run(self):
        time.sleep(1e6)


class StopsItself(Honest):
    name, verdict, told = "stops-itself", "too slow", "its solve took longer than its limit"

    def run(self):
        os.kill(os.getpid(), signal.SIGSTOP)


class SpinsInSetUp(Honest):
    name, verdict, told = "spins-in-set-up", "too slow", "its set-up took longer than its limit"

    def __init__(self, qp, tolerance):
        spin()


class SleepsAtImport(Honest):
    name, verdict, told = "sleeps-at-import", "too slow", "its import took longer than its limit"

    @classmethod
    def missing(cls):
        time.sleep(1e6)


class NeedsMemory(Honest):
    name, verdict, told = "needs-memory", "out of memory", "limit of 0.2 GB"

    def run(self):
        kept = []
        while True:
            kept.append(np.ones(10_000_000))
            time.sleep(0.01)


ALL = [value for value in list(globals().values()) if isinstance(value, type) and issubclass(value, Honest)]
