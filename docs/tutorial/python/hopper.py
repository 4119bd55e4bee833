"""The hopper of the tutorial in Python: a body on a light leg."""

from saltus import *  # noqa: F401, F403

gravity = 9.81  # m/s^2
mass = 10.0  # kg
leg = 0.5  # m, length of the straight leg
deepest = 0.25  # m, lowest height of the body
strongest = 400.0  # N, largest force of the leg


def in_stance(t, x, u):  # x = (height m, speed upwards m/s), u = force of the leg, N
    return [x[1], u[0] / mass - gravity]


def in_flight(t, x):  # no force
    return [x[1], -gravity]


def height(t, x):
    return x[0]


def speed(t, x):
    return x[1]


def force(t, x, u):
    return u[0]


def off_the_ground(t, x):  # zero if the leg is straight
    return x[0] - leg


def apex(t, x):  # predicted apex of the flight, m
    return x[0] + x[1] * x[1] / (2.0 * gravity)


def landing(t, x):  # the foot has a twentieth of the mass and stops at landing
    return [x[0], 0.95 * x[1]]


def stance(name, duration):
    """Stance with a bounded force."""
    return (Phase(name, in_stance, duration, nx=2, nu=1)
            .bound_input(0, between(0.0, strongest))
            .bound_state(0, between(deepest, leg))
            .track("effort", force, 1e-4)
            .nominal([0.5, 2.0], 100.0))


def flight(name):
    """Flight until the straight leg touches the ground."""
    return (Phase(name, in_flight, between(0.05, 2.0), nx=2)
            .ends_when("touch-down", off_the_ground, Crossing.falling).guess_duration(0.4))


state_names = ["height [m]", "speed [m/s]"]
input_names = ["force [N]"]
