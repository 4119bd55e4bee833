# Swing-up of a double pendulum in free time: torque at the shoulder only, angles from the vertical.
from saltus import *
import numpy as np

m, l, g = 1.0, 0.5, 9.81  # kg, m, m/s^2: both links


def double_pendulum(t, x, u):
    a, b, da, db = x
    c, s = cos(a - b), sin(a - b)
    mass = np.array([[2.0, c], [c, 1.0]]) * (m * l * l)
    force = np.array([u[0] - m * l * l * db * db * s + 2.0 * m * g * l * sin(a),
                      m * l * l * da * da * s + m * g * l * sin(b)])
    det = mass[0, 0] * mass[1, 1] - mass[0, 1] * mass[1, 0]
    return [da, db, (mass[1, 1] * force[0] - mass[0, 1] * force[1]) / det,
            (mass[0, 0] * force[1] - mass[1, 0] * force[0]) / det]


swing = Phase("swing up", double_pendulum, between(0.5, 6.0), nx=4, nu=1)
swing.bound_input(0, between(-12.0, 12.0)).track("effort", lambda t, x, u: u, 0.01)
swing.reach("upright", lambda t, x: x, exactly([0.0] * 4)).minimise_at_end("time", lambda t, x: t)
swing.guess_duration(2.5).guess_state(Guess.interpolate([np.pi, np.pi, 0, 0], [0.0] * 4))
problem = OptimalControlProblem("double pendulum").start_at([np.pi, np.pi, 0, 0]).then(swing)
plan = solve(problem, intervals_per_phase=60, integrator=runge_kutta8(steps=2))
print(f"{plan.message}: {plan.durations[0]:.3f} s")
