# MPC of a pendulum whose mass is 10 % larger than the controller knows.
from saltus import *
import numpy as np

l, g = 0.5, 9.81  # m, m/s^2


def pendulum(t, x, u, p):  # x = (angle from the upright position rad, rate rad/s), p = mass kg
    return [x[1], (p[0] * g * l * sin(x[0]) + u[0] - 0.05 * x[1]) / (p[0] * l * l)]


balance = Phase("balance", pendulum, exactly(1.0), nx=2, nu=1, np=1).data("mass", 0.5)
balance.bound_input(0, between(-4.0, 4.0)).track("effort", lambda t, x, u: u, 0.1)
balance.track("upright", lambda t, x: x, [10.0, 0.5])
balance.track_at_end("arrive", lambda t, x: x, [50.0, 5.0])
problem = OptimalControlProblem("pendulum").start_at([0.6, 0.0]).then(balance)
shooting = MultipleShooting(problem, intervals_per_phase=20, integrator=runge_kutta4())
controller = RecedingHorizonController(shooting, period=0.02)
plant = nominal_plant(problem, cvodes())
plant.set_parameters([0.55])
log = simulate_closed_loop(controller, plant, duration=4.0)
print(f"{log.message}; upright and at rest: {np.abs(log.final_state).max() < 1e-6}")
