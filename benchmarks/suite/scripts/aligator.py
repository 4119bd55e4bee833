"""ProxDDP of aligator. The package libaligator is a C++ library. aligator_program.cpp, about 100 lines that pass
a program to it, is compiled against it at first use and kept in the user's cache. ctypes calls the compiled library as C.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
import sysconfig

import numpy as np

import peers
from cache import cache_folder, not_installed
from peers import Adapter, Answer, NotApplicable
from trajectories import Trajectory

ITERATIONS = 1000
LEAST_PENALTY = 1e-8  # its bounds
SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "aligator_program.cpp")
EIGEN = "/usr/include/eigen3"
# There is no -march=native, because the package aligns memory for the generic architecture, and both sides must agree.
FLAGS = ["-std=c++20", "-O2", "-fPIC", "-shared", "-w", "-DALIGATOR_ENABLE_TEMPLATE_INSTANTIATION", "-DALIGATOR_WITH_PINOCCHIO"]
REAL, WHOLE, PLACE = ctypes.c_double, ctypes.c_int, ctypes.c_void_p


def prefix():
    return os.path.join(sysconfig.get_paths()["purelib"], "cmeel.prefix")


def library():
    """The compiled library. Raises NotApplicable with the first error of the compiler."""
    with open(SOURCE, "rb") as file:
        key = hashlib.sha256(file.read() + f"{FLAGS} {prefix()} {peers.version_of('libaligator')}".encode()).hexdigest()[:24]
    path = os.path.join(cache_folder("aligator"), key + ".so")
    if not os.path.exists(path):
        partial, lib = f"{path}.{os.getpid()}", os.path.join(prefix(), "lib")
        fmt = next(name for name in sorted(os.listdir(lib)) if name.startswith("libfmt.so."))
        done = subprocess.run(["g++", *FLAGS, "-I", os.path.join(prefix(), "include"), "-I", EIGEN, SOURCE, "-o", partial, f"-L{lib}",
                               f"-Wl,-rpath,{lib}", "-laligator", f"-l:{fmt}"], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            error = next((line for line in done.stderr.splitlines() if "error" in line), "no reason is given")
            raise NotApplicable(f"g++ cannot compile its driver: {error[:160]}")
        os.replace(partial, path)
    functions = ctypes.CDLL(path)
    functions.aligator_new.restype = PLACE
    functions.aligator_delete.argtypes = [PLACE]
    functions.aligator_stage.argtypes = [PLACE, WHOLE, WHOLE, WHOLE, *[PLACE] * 12]
    functions.aligator_finish.argtypes = [PLACE, WHOLE, WHOLE, *[PLACE] * 6, REAL, REAL, WHOLE]
    functions.aligator_solve.argtypes = [PLACE] * 4
    return functions


class _Columns:
    """Column-major matrices, kept alive as long as this object."""

    def __init__(self):
        self.kept = []

    def __call__(self, array):
        self.kept.append(np.asfortranarray(array, dtype=float))
        return self.kept[-1].ctypes.data


class AligatorProxddp(Adapter):
    name, package = "aligator-proxddp", "libaligator"
    about = ("augmented Lagrangian with a proximal Riccati recursion, all rows as constraints; the package is built for "
             "any x86-64; its initial penalty is ten times the requested tolerance")

    @classmethod
    def missing(cls):
        """An empty string if the package is available, otherwise one sentence."""
        if peers.version_of(cls.package) is None:
            return not_installed(cls.package)
        for needed, there in (("g++", shutil.which("g++")), (EIGEN, os.path.isdir(EIGEN))):
            if not there:
                return f"{needed} is needed to compile its driver"
        return ""

    def __init__(self, qp, tolerance):
        t = self.trajectory = Trajectory(qp)
        self.functions, at = library(), _Columns()
        self.program = self.functions.aligator_new()
        for s, (C, D, low, high) in zip(t.stages[:-1], t.rows):
            self.functions.aligator_stage(self.program, s.nx, s.nu, len(low), at(s.Q), at(s.S.T), at(s.R), at(s.q), at(s.r), at(s.A),
                                          at(s.B), at(s.b), at(C), at(D), at(low), at(high))
        s, (C, _, low, high) = t.stages[-1], t.rows[-1]
        if self.functions.aligator_finish(self.program, t.nx, len(low), at(s.Q), at(s.q), at(C), at(low), at(high), at(t.start),
                                          tolerance, max(10.0 * tolerance, LEAST_PENALTY), ITERATIONS) != 0:
            raise NotApplicable("it rejects the program")

    def hand_over(self, start):
        t = self.trajectory
        w, rows, bounds = start if start is not None else (None, np.zeros(t.qp.m), np.zeros(t.qp.n))
        states, inputs = t.split(w)
        costates, pushes = t.split_multipliers(rows, bounds)
        self.found, self.made = t.joined(states, inputs), [np.concatenate(costates), np.concatenate(pushes)]
        self.places = [part.ctypes.data for part in (self.found, self.made[1], self.made[0])]

    def run(self):
        self.count = self.functions.aligator_solve(self.program, *self.places)

    def read(self):
        t, found, made, count = self.trajectory, self.found, self.made, self.count
        ends = np.cumsum([len(low) for _, _, low, _ in t.rows])[:-1]
        rows, bounds = t.joined_multipliers(found, np.split(made[0], len(t.stages)), np.split(made[1], ends))
        return Answer(found, rows, bounds, claimed="converged" if count >= 0 else "not converged", solved=count >= 0,
                      iterations=count if count >= 0 else -count - 1)

    def __del__(self):
        if getattr(self, "program", None):
            self.functions.aligator_delete(self.program)
