# A ball is thrown at a target with one bounce. The velocity of the throw is unknown.
from saltus import *

g, restitution = 9.81, 0.8  # m/s^2


def flight(t, x):  # x = (along m, height m, two velocities m/s)
    return [x[2], x[3], 0.0, -g]


def height(t, x):
    return x[1]


down = Phase("down", flight, between(0.05, 2.0), nx=4).guess_duration(0.5)
down.ends_when("bounce", height, Crossing.falling)
down.minimise_at_start("speed of the throw", lambda t, x: x[2] ** 2 + x[3] ** 2)
up = Phase("up", flight, between(0.05, 2.0), nx=4).guess_duration(0.5)
up.reach("target", lambda t, x: x[:2], exactly([4.0, 1.0]))
problem = OptimalControlProblem("throw").start_within(
    [exactly(0.0), exactly(1.5), between(0, 20), between(-20, 20)], [0, 1.5, 4, 0])
problem.then(down).then(up, jump("bounce", lambda t, x: [x[0], x[1], x[2], -restitution * x[3]]))
plan = solve(problem)
print(f"{plan.message}: throw with {plan.trajectory.state(0.0)[2:].round(3)} m/s")
