"""HPIPM from a shared library, called as C: that of the package comma-deps-acados, or one that the user built for this
processor and names in SALTUS_HPIPM. Only the sizes of its structures are known, from the library itself."""

import ctypes
import functools
import importlib.util
import os
import sys

import numpy as np

from cache import not_installed
from peers import ITERATIONS, Adapter, Answer, NotApplicable
from quadratic_program import Reduced

OWN_LIBRARY = "SALTUS_HPIPM"
SPEED, BALANCE = 1, 2  # modes
FAR_AWAY = 1e6  # represents infinity in versions without masks, which do not converge with larger values


def package_library():
    """The library of acados, or None. Its folder is separate from the peers, because the package has an old casadi."""
    file = os.path.join(sys.prefix, "acados/acados/install/lib/libhpipm.so")
    return file if os.path.exists(file) else None


def libraries_of(file):
    """Files of the library and of BLASFEO, which is in the same folder, by name. Empty without a file."""
    beside = os.path.join(os.path.dirname(file), "libblasfeo.so")
    return {OWN_LIBRARY: file, f"{OWN_LIBRARY}, libblasfeo.so": beside} if file else {}


class Library:
    """Functions d_ocp_qp_NAME as attributes."""

    def __init__(self, file):
        # The package of casadi has a library of the same name, which it would otherwise load from here.
        if importlib.util.find_spec("casadi"):
            import casadi
            casadi.has_conic("hpipm")
        beside = os.path.join(os.path.dirname(file), "libblasfeo.so")
        if os.path.exists(beside):
            ctypes.CDLL(beside)
        self.functions = ctypes.CDLL(file)

    def __getattr__(self, name):
        function = getattr(self.functions, "d_ocp_qp_" + name)
        function.restype = ctypes.c_size_t if name.endswith("size") else None
        setattr(self, name, function)
        return function

    def has(self, name):
        return hasattr(self.functions, "d_ocp_qp_" + name)


@functools.cache
def library(file):
    return Library(file)


def block(size):
    """Zeroed memory, aligned to a cache line."""
    line = 64
    memory = ctypes.create_string_buffer(size + line)
    address = ctypes.addressof(memory)
    return memory, ctypes.c_void_p(-(-address // line) * line)


def values(array):
    array = np.asfortranarray(array, dtype=float)
    return array.ctypes.data_as(ctypes.c_void_p), array


class _Hpipm(Adapter):
    level = 1  # of warm starts. 1: states and inputs; 2, 3: multipliers too; 0 is its own start
    mode = SPEED

    @classmethod
    def warm_levels(cls):
        """Older libraries, as that of comma-deps-acados, end the process when they are given multipliers."""
        return (1, 2, 3) if library(cls.file()).has("sol_set_pi") else (1,)

    @classmethod
    def file(cls):
        raise NotImplementedError

    def __init__(self, qp, tolerance):
        if not qp.stages:
            raise NotApplicable("it has no stages")
        self.f = library(self.file())
        self.stages = stages_of(qp)
        self.reduced = self.stages[0].reduced
        self.made = []
        N = len(self.stages) - 1
        dim = self._make("dim", ctypes.c_int(N))
        for k, s in enumerate(self.stages):
            for name, count in (("nx", s.nx), ("nu", s.nu), ("nbx", len(s.bounded_x)), ("nbu", len(s.bounded_u)),
                                ("ng", len(s.low))):
                self.f.dim_set(name.encode(), ctypes.c_int(k), ctypes.c_int(count), dim)
        self.qp, self.sol = self._make("", dim), self._make("sol", dim)
        self.arg = self._make("ipm_arg", dim)
        self.f.ipm_arg_set_default(ctypes.c_int(self.mode), self.arg)
        for name in ("tol_stat", "tol_eq", "tol_ineq", "tol_comp"):
            self._argument(name, ctypes.c_double(tolerance))
        self._argument("iter_max", ctypes.c_int(ITERATIONS))
        self.ws = self._make("ipm_ws", dim, self.arg)
        self.has_masks = self.f.has("set_lg_mask")
        for k, s in enumerate(self.stages):
            self._load(k, s)

    def _make(self, name, *of):
        """A structure and its memory, created for `of`."""
        name += "_" if name else ""
        structure, at = block(getattr(self.f, name + "strsize")())
        memory, memory_at = block(getattr(self.f, name + "memsize")(*of))
        getattr(self.f, name + "create")(*of, at, memory_at)
        self.made += [structure, memory]
        return at

    def _argument(self, name, value):
        self.f.ipm_arg_set(name.encode(), ctypes.byref(value), self.arg)

    def _set(self, name, k, array):
        if np.size(array):
            at, kept = values(array)
            self.f.set(name.encode(), ctypes.c_int(k), at, self.qp)
            del kept

    def _load(self, k, s):
        for name in ("Q", "S", "R", "q", "r", "A", "B", "b", "C", "D"):
            self._set(name, k, getattr(s, name))
        for name, places in (("idxbx", s.bounded_x), ("idxbu", s.bounded_u)):
            if len(places):
                numbers = np.array(places, dtype=np.int32)
                self.f.set(name.encode(), ctypes.c_int(k), numbers.ctypes.data_as(ctypes.c_void_p), self.qp)
        absent = 0.0 if self.has_masks else FAR_AWAY
        for name, low, high in (("bx", s.x_low, s.x_high), ("bu", s.u_low, s.u_high), ("g", s.low, s.high)):
            for side, sides, sign in (("l", low, -1.0), ("u", high, 1.0)):
                there = np.isfinite(sides)
                self._set(side + name, k, np.where(there, sides, sign * absent))
                if self.has_masks:
                    self._set(f"{side}{name}_mask", k, there.astype(float))

    def hand_over(self, start):
        level = 0 if start is None else self.level
        if level:
            self._give(start, False)
        if level > 1:  # its slacks have no setter, and those of the previous solve must not help
            self._argument("warm_start", ctypes.c_int(1))
            self._argument("iter_max", ctypes.c_int(0))
            self.run()
            self._argument("iter_max", ctypes.c_int(ITERATIONS))
            self._give(start, True)
        self._argument("warm_start", ctypes.c_int(level))

    def _give(self, start, with_multipliers):
        w, rows, bounds = start
        for k, s in enumerate(self.stages):
            given = {"x": w[s.x], "u": w[s.u]}
            if with_multipliers:
                given["pi"] = rows[s.dynamics]
                for name, pushes in (("g", rows[s.rows]), ("bx", bounds[s.x.start + s.bounded_x]),
                                     ("bu", bounds[s.u.start + s.bounded_u])):
                    given |= {"lam_l" + name: np.maximum(-pushes, 0.0), "lam_u" + name: np.maximum(pushes, 0.0)}
            for name, array in given.items():
                if len(array):
                    where, kept = values(array)
                    self.f.sol_set(name.encode(), ctypes.c_int(k), where, self.sol)
                    del kept

    def run(self):
        self.f.ipm_solve(self.qp, self.sol, self.arg, self.ws)

    def _get(self, name, k, count):
        found = np.zeros(count)
        if count:
            self.f.sol_get(name.encode(), ctypes.c_int(k), self.sol, found.ctypes.data_as(ctypes.c_void_p))
        return found

    def read(self):
        r = self.reduced
        w, rows, bounds = np.zeros(len(r.gradient)), np.zeros(len(r.row_lower)), np.zeros(len(r.gradient))
        for k, s in enumerate(self.stages):
            w[s.x], w[s.u] = self._get("x", k, s.nx), self._get("u", k, s.nu)
            rows[s.dynamics] = self._get("pi", k, s.dynamics.stop - s.dynamics.start)

            def pushes(name, low, high):
                lower, upper = (self._get(f"lam_{side}{name}", k, len(low)) for side in "lu")
                return np.where(np.isfinite(high), upper, 0.0) - np.where(np.isfinite(low), lower, 0.0)
            rows[s.rows] = pushes("g", s.low, s.high)
            bounds[s.x.start + s.bounded_x] = pushes("bx", s.x_low, s.x_high)
            bounds[s.u.start + s.bounded_u] = pushes("bu", s.u_low, s.u_high)
        status, iterations = ctypes.c_int(-1), ctypes.c_int(-1)
        self.f.ipm_get(b"status", self.ws, ctypes.byref(status))
        self.f.ipm_get(b"iter", self.ws, ctypes.byref(iterations))
        return Answer(*r.expand(w, rows, bounds), claimed=f"status {status.value}", solved=status.value == 0,
                      iterations=iterations.value)


class Stage:
    """One stage of a program without its fixed variables, in the notation of HPIPM; x, u, dynamics and rows are index
    ranges."""

    def __init__(self, reduced, x, u, dynamics, rows, following):
        r, H, J = reduced, reduced.hessian, reduced.jacobian
        self.reduced, self.x, self.u, self.dynamics, self.rows = reduced, x, u, dynamics, rows
        self.nx, self.nu = x.stop - x.start, u.stop - u.start
        self.Q, self.S, self.R = H[x, x].toarray(), H[u, x].toarray(), H[u, u].toarray()
        self.q, self.r = r.gradient[x], r.gradient[u]
        self.A, self.B = J[dynamics, x].toarray(), J[dynamics, u].toarray()
        self.b = -r.row_lower[dynamics]  # A x + B u - next = -b
        if (J[dynamics, following] + np.eye(following.stop - following.start)).any():
            raise NotApplicable("its dynamics are not equations of the next state")
        self.C, self.D = J[rows, x].toarray(), J[rows, u].toarray()
        self.low, self.high = r.row_lower[rows], r.row_upper[rows]
        for name, at in (("x", x), ("u", u)):
            low, high = r.lower[at], r.upper[at]
            bounded = np.flatnonzero(np.isfinite(low) | np.isfinite(high))
            setattr(self, "bounded_" + name, bounded)
            setattr(self, name + "_low", low[bounded])
            setattr(self, name + "_high", high[bounded])


def stages_of(qp, reduced=None):
    """Variables x_0, u_0, x_1, ... and rows (dynamics of stage 0, its rows, ...), without fixed variables, or in the
    order of `reduced`."""
    reduced = reduced or Reduced(qp)
    is_free = np.zeros(qp.n, dtype=int)
    is_free[reduced.free] = 1
    place = np.concatenate([[0], np.cumsum(is_free)])  # index among the free variables
    states, inputs, first = [], [], 0
    for nx, nu, _ in qp.stages:
        states.append(slice(place[first], place[first + nx]))
        inputs.append(slice(place[first + nx], place[first + nx + nu]))
        first += nx + nu
    stages, row, nothing = [], 0, slice(0, 0)
    for k, (_, _, count) in enumerate(qp.stages):
        following = states[k + 1] if k + 1 < len(states) else nothing
        end = row + following.stop - following.start
        stages.append(Stage(reduced, states[k], inputs[k], slice(row, end), slice(end, end + count), following))
        row = end + count
    return stages


class AcadosHpipm(_Hpipm):
    name, package = "acados-hpipm", "comma-deps-acados"
    about = ("HPIPM of the package comma-deps-acados, mode SPEED: an older version, for Haswell, about 1.45 times slower "
             "than a build for this processor. Results must not be quoted as HPIPM without this note")

    @classmethod
    def file(cls):
        return package_library()

    @classmethod
    def missing(cls):
        """An empty string if the library is available, otherwise one sentence."""
        return "" if package_library() else not_installed(cls.package)


class AcadosHpipmBalance(AcadosHpipm):
    name, mode = "acados-hpipm-balance", BALANCE
    about = "the same, mode BALANCE"


class OwnHpipm(_Hpipm):
    name, package = "hpipm", ""
    about = "HPIPM, mode SPEED, of the library that SALTUS_HPIPM names"

    @classmethod
    def file(cls):
        return os.environ[OWN_LIBRARY]

    @classmethod
    def missing(cls):
        named = os.environ.get(OWN_LIBRARY, "")
        if not named:
            return f"{OWN_LIBRARY} names no library; a build for this processor is faster than the packages"
        return "" if os.path.exists(named) else f"there is no library '{named}', which {OWN_LIBRARY} names"


class OwnHpipmBalance(OwnHpipm):
    name, mode = "hpipm-balance", BALANCE
    about = "the same, mode BALANCE"
