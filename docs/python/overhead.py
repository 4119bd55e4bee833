"""Measures what Python adds: the definition of a problem, a solve, and a tick of a controller.

A solve and a tick spend their time in C++. The difference between the time around the call and the time that C++
reports is the overhead of Python.
"""

import time

import numpy as np

from saltus import *
import library


def median_of(call, repetitions):
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        reported = call()
        times.append((time.perf_counter() - begin, reported))
    return np.median(np.array(times), axis=0)


definition, _ = median_of(lambda: library.goddard_rocket() and 0.0, 50)
print(f"definition of the Goddard rocket: {1e3 * definition:.2f} ms")

problem, options, _ = library.goddard_rocket()
shooting = MultipleShooting(problem, **options)
solver = make_native_solver()
around, inside = median_of(lambda: solve(shooting, solver).seconds, 20)
print(f"solve of the Goddard rocket: {1e3 * around:.2f} ms, of which the solver takes {1e3 * inside:.2f} ms; the rest "
      "verifies the plan")

brake = Phase("brake", lambda t, x, u: [x[1], u[0]], exactly(1.0), nx=2, nu=1)
brake.track("rest", lambda t, x: x, [10.0, 1.0]).track("effort", lambda t, x, u: u, 0.01)
loop = OptimalControlProblem("brake").start_at([1.0, 0.0]).then(brake.bound_input(0, between(-20.0, 20.0)))
controller = RecedingHorizonController(MultipleShooting(loop, intervals_per_phase=20), period=0.05)
now = 0.0


def tick():
    global now
    now += 0.05
    done = controller.tick(now, np.array([1.0, 0.0]))
    return done.seconds + done.check


around, inside = median_of(tick, 2000)
print(f"tick: {1e6 * around:.1f} us, of which C++ takes {1e6 * inside:.1f} us; overhead {1e6 * (around - inside):.1f} us")
