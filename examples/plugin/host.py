#!/usr/bin/env python3
"""Loads a plugin with ctypes, without a compiler, and moves a cart by 1 m. Usage: host.py PLUGIN"""

import ctypes
import sys
from ctypes import POINTER, c_char_p, c_double, c_int, c_void_p


class Sizes(ctypes.Structure):
    _fields_ = [(name, c_int) for name in ("states", "inputs", "plan_states", "plan_inputs")] + [("period", c_double)]


class Tick(ctypes.Structure):
    _fields_ = ([("time", c_double)] + [(name, c_int) for name in ("provenance", "pieces", "iterations")] +
                [(name, c_double) for name in ("objective", "kkt", "violation", "preparation", "feedback", "check")] +
                [("solve", c_char_p)])


class Controller:
    """A controller of a plugin, by its name."""

    def __init__(self, path, name):
        self.plugin = ctypes.CDLL(path)
        if self.plugin.saltus_interface_version() != 1:
            sys.exit("host.py: the plugin has another interface")
        self.plugin.saltus_error.restype = c_char_p
        self.plugin.saltus_error.argtypes = self.plugin.saltus_destroy.argtypes = [c_void_p]
        for function, arguments in {
                "read_sizes": [POINTER(Sizes)],
                "set_data": [c_char_p, POINTER(c_double), c_int],
                "prepare": [c_double],
                "feedback": [POINTER(c_double), c_int, POINTER(Tick)],
                "read_piece": [c_int, POINTER(c_double), POINTER(c_double), POINTER(c_double), c_int, POINTER(c_int)],
                "read_plan": [POINTER(c_double), POINTER(c_int), POINTER(c_double), POINTER(c_double), c_int,
                              POINTER(c_int)]}.items():
            getattr(self.plugin, "saltus_" + function).argtypes = [c_void_p, *arguments]
        self.handle, self.sizes = c_void_p(), Sizes()
        self.check(self.plugin.saltus_create(name.encode(), ctypes.byref(self.handle)))
        self.call("read_sizes", self.sizes)

    def check(self, status):
        if status:
            raise RuntimeError(self.plugin.saltus_error(self.handle).decode())

    def call(self, function, *arguments):
        self.check(getattr(self.plugin, "saltus_" + function)(self.handle, *arguments))

    def set_data(self, name, *values):
        self.call("set_data", name.encode(), (c_double * len(values))(*values), len(values))

    def tick(self, time, state):
        """The tick and its input as a list of (length in seconds, values)."""
        tick, pieces = Tick(), []
        start, length, count = c_double(), c_double(), c_int()
        values = (c_double * self.sizes.plan_inputs)()
        self.call("prepare", time)
        self.call("feedback", (c_double * len(state))(*state), len(state), tick)
        for i in range(tick.pieces):
            self.call("read_piece", i, start, length, values, len(values), count)
            pieces.append((length.value, values[:count.value]))
        return tick, pieces

    def plan(self, capacity=256):
        """Times, states and inputs of the nodes."""
        nx, nu, rows = self.sizes.plan_states, self.sizes.plan_inputs, c_int()
        times, states, inputs = ((c_double * (capacity * n))() for n in (1, nx, nu))
        self.call("read_plan", times, None, states, inputs, capacity, rows)
        return (times[:rows.value], [states[k * nx:(k + 1) * nx] for k in range(rows.value)],
                [inputs[k * nu:(k + 1) * nu] for k in range(rows.value)])

    def close(self):
        self.plugin.saltus_destroy(self.handle)


def move(x, u, dt, steps=20):
    """The cart during dt seconds."""
    for _ in range(steps):
        drag = 0.2 * x[1] * (x[1]**2 + 0.01)**0.5
        x = [x[0] + dt / steps * x[1], x[1] + dt / steps * (u - drag)]
    return x


def main():
    cart = Controller(sys.argv[1], "cart")
    cart.set_data("target", 1.0)
    x = [0.0, 0.0]
    for k in range(200):
        tick, pieces = cart.tick(k * cart.sizes.period, x)
        for length, u in pieces:
            x = move(x, u[0], length)
    times, states, _ = cart.plan()
    print(f"{tick.solve.decode()}; {abs(x[0] - 1.0):.2f} m from the target; the last plan has {len(times)} nodes and "
          f"ends at {states[-1][0]:.2f} m")
    try:
        cart.set_data("targets", 1.0)
        print("an unknown name was accepted")
        return 1
    except RuntimeError as error:
        print(error)
    cart.close()
    return 0 if abs(x[0] - 1.0) < 0.02 else 1


if __name__ == "__main__":
    sys.exit(main())
