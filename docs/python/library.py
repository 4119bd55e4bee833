"""Problems of the library in Python. Each function has the name of its file in problems/library and returns the problem,
the options of solve_refined() or solve(), and the known optimum.
"""

from saltus import *  # noqa: F401, F403
import numpy as np

linear = InputParametrisation.piecewise_linear_continuous


def first(t, x):
    return x[0]


def second(t, x):
    return x[1]


def clock(t, x):
    return t


def block(t, x, u):
    return [x[1], u[0]]


def effort(t, x, u):
    return 0.5 * u[0] * u[0]


def bryson_denham():
    part = between(0.05, 0.9)
    climb = Phase("climb", block, part, nx=2, nu=1).keep("ceiling", first, at_most(1.0 / 9.0))
    climb.minimise("effort", effort).reach("no impact", second, exactly(0.0))
    slide = Phase("along the ceiling", block, part, nx=2, nu=1).bound_input(0, exactly(0.0))
    descend = Phase("descend", block, part, nx=2, nu=1).keep("ceiling", first, at_most(1.0 / 9.0))
    descend.minimise("effort", effort).reach("ground", first, exactly(0.0))
    descend.reach("landing speed", second, exactly(-1.0))
    problem = OptimalControlProblem("Bryson-Denham").start_at([0, 1])
    for phase in (climb, slide, descend):
        problem.then(phase.inputs(linear).guess_duration(0.3))
    return problem.total_time(exactly(1.0)), dict(intervals_per_phase=10, integrator=runge_kutta4()), 4.0


def brachistochrone():
    gravity = 9.80665
    slide = Phase("slide", lambda t, x, u: [x[2] * sin(u[0]), -x[2] * cos(u[0]), gravity * cos(u[0])],
                  between(0.5, 10.0), nx=3, nu=1)
    slide.inputs(linear).bound_input(0, between(-np.pi / 2, np.pi)).minimise_at_end("time", clock)
    slide.reach("end, along", first, exactly(10.0)).reach("end, height", second, exactly(5.0))
    slide.nominal([10, 10, 10], 1).guess_state(Guess.interpolate([0, 10, 0], [10, 5, 10]))
    slide.guess_input(Guess.interpolate([0], [np.pi / 2])).guess_duration(2.0)
    problem = OptimalControlProblem("brachistochrone").start_at([0, 10, 0]).then(slide)
    return problem, dict(intervals_per_phase=10, integrator=runge_kutta8()), 1.801603122453081


def bang_bang():
    problem = OptimalControlProblem("bang-bang").start_at([0, 0])
    for name in ("accelerate", "brake"):
        phase = Phase(name, block, between(1.0, 100.0), nx=2, nu=1).bound_input(0, between(-2.0, 1.0))
        phase.nominal([100.0, 10.0], 1.0).nominal_duration(10.0).guess_duration(10.0)
        if name == "brake":
            phase.reach("distance", first, exactly(300.0)).reach("at rest", second, exactly(0.0))
            phase.minimise_at_end("time", clock)
        problem.then(phase)
    return problem, dict(intervals_per_phase=1, integrator=runge_kutta4()), 30.0


def goddard_rocket():
    def rocket(t, x, thrust):
        drag = 310.0 * x[1] * x[1] * exp(-500.0 * (x[0] - 1.0))
        return [x[1], (thrust[0] - drag) / x[2] - 1.0 / (x[0] * x[0]), -thrust[0] / 0.5]

    boost, sustain, coast = (Phase(name, rocket, between(0.005, 0.3), nx=3, nu=1)
                             for name in ("boost", "sustain", "coast"))
    boost.bound_input(0, exactly(3.5)).guess_input([3.5])
    sustain.bound_input(0, between(0.1 * 3.5, 0.9 * 3.5)).guess_input([0.5 * 3.5]).inputs(linear)
    coast.bound_input(0, exactly(0.0)).reach("empty", lambda t, x: x[2], exactly(0.6))
    coast.minimise_at_end("height", lambda t, x: -x[0])
    problem = OptimalControlProblem("Goddard rocket").start_at([1, 0, 1])
    for phase in (boost, sustain, coast):
        problem.then(phase.nominal([0.01, 0.1, 1.0], 1.0).nominal_duration(0.1).guess_duration(0.05))
    return problem, dict(intervals=[5, 6, 10], integrator=runge_kutta8(steps=2)), -1.01283691832


def catalyst_mixing():
    def reactions(t, x, u):
        exchange = u[0] * (10.0 * x[1] - x[0])
        return [exchange, -exchange - (1.0 - u[0]) * x[1]]

    pure, mixed, last = (Phase(name, reactions, between(0.01, 0.98), nx=2, nu=1)
                         for name in ("first catalyst", "mixed", "second catalyst"))
    pure.bound_input(0, exactly(1.0))
    mixed.bound_input(0, between(0.05, 0.95)).guess_input([0.5])
    last.bound_input(0, exactly(0.0)).minimise_at_end("product", lambda t, x: x[0] + x[1] - 1.0)
    problem = OptimalControlProblem("catalyst mixing").start_at([1, 0])
    for phase in (pure, mixed, last):
        problem.then(phase.guess_duration(1.0 / 3.0))
    return (problem.total_time(exactly(1.0)), dict(intervals_per_phase=2, integrator=runge_kutta8(steps=4)),
            -0.048055685861)


def hanging_chain():
    chain = Phase("chain", lambda t, x, u: [u[0], sqrt(1.0 + u[0] * u[0])], exactly(1.0), nx=2, nu=1)
    chain.minimise("height", lambda t, x, u: x[0] * sqrt(1.0 + u[0] * u[0]))
    chain.reach("end", first, exactly(3.0)).reach("length", second, exactly(4.0)).inputs(linear)
    chain.guess_state(Guess.interpolate([1, 0], [3, 4])).guess_input(Guess.interpolate([-2], [6]))
    problem = OptimalControlProblem("hanging chain").start_at([1, 0]).then(chain)
    return problem, dict(intervals_per_phase=40, integrator=runge_kutta8()), 5.06848011099342


def moon_lander():
    def lander(thrust):
        return lambda t, x: [x[1], thrust / x[2] - 1.0, -thrust / 2.349]

    coast = Phase("coast", lander(0.0), between(0.0, 2.0), nx=3).guess_duration(0.5)
    burn = Phase("burn", lander(1.227), between(0.0, 1.5), nx=3).reach("ground", first, exactly(0.0))
    burn.reach("at rest", second, exactly(0.0)).minimise_at_end("fuel", lambda t, x: -x[2]).guess_duration(0.5)
    problem = OptimalControlProblem("moon lander").start_at([1, -0.783, 1]).then(coast).then(burn)
    return problem, dict(intervals=[1, 10], integrator=runge_kutta8()), -0.395354363964


def interior_point():
    before, after = (Phase(name, lambda t, x, u: u, exactly(length), nx=1, nu=1)
                     for name, length in (("to the point", 0.75), ("to the end", 0.25)))
    for phase in (before, after):
        phase.inputs(linear).minimise("cost", lambda t, x, u: x[0] * x[0] + u[0] * u[0])
    before.reach("point", first, exactly(0.9))
    after.reach("end", first, exactly(0.75))
    problem = OptimalControlProblem("interior point").start_at([1]).then(before).then(after)
    return problem, dict(intervals=[60, 20], integrator=runge_kutta8()), 0.920531441473003


def van_der_pol():
    def oscillator(t, x, u):
        return [(1.0 - x[1] * x[1]) * x[0] - x[1] + u[0], x[0]]

    problem = OptimalControlProblem("Van der Pol").start_at([0, 1])
    for name, bounds in (("at the lower bound", exactly(-0.3)), ("rise", between(-0.3, 1.0)),
                         ("at the upper bound", exactly(1.0)), ("fade", between(-0.3, 1.0))):
        phase = Phase(name, oscillator, between(0.01, 5.0), nx=2, nu=1).bound_input(0, bounds)
        phase.inputs(linear).minimise("cost", lambda t, x, u: x[0] * x[0] + x[1] * x[1] + u[0] * u[0])
        problem.then(phase.guess_duration(1.25))
    return (problem.total_time(exactly(5.0)), dict(intervals=[2, 15, 4, 40], integrator=runge_kutta8()), 2.86726105)


def turbo_car():
    def above_turbo(t, x):
        return x[1] - 10.0

    def car(gain):
        return lambda t, x, u: [x[1], gain * u[0]]

    gains = {"start": 1.0, "charge": 3.0, "cruise": 3.0, "brake": 3.0, "stop": 1.0}
    phases = {name: Phase(name, car(gain), between(0.1, 20.0), nx=2, nu=1) for name, gain in gains.items()}
    phases["start"].ends_when("turbo on", above_turbo, Crossing.rising)
    phases["charge"].bound_state(1, at_most(20.0))
    phases["cruise"].bound_state(1, between(10.0, 20.0))
    phases["brake"].bound_state(1, at_most(20.0)).ends_when("turbo off", above_turbo, Crossing.falling)
    phases["stop"].reach("at the end", first, exactly(200.0)).reach("at rest", second, exactly(0.0))
    phases["stop"].minimise_at_end("time", clock)
    speeds = [0.0, 10.0, 20.0, 20.0, 10.0, 0.0]
    problem = OptimalControlProblem("turbo car").start_at([0, 0])
    for j, phase in enumerate(phases.values()):
        phase.bound_input(0, between(-5.0, 5.0)).nominal([100, 10], 5).guess_duration(3.0)
        phase.guess_state(Guess.interpolate([40.0 * j, speeds[j]], [40.0 * (j + 1), speeds[j + 1]]))
        problem.then(phase)
    return problem, dict(intervals=[1, 1, 8, 1, 1], integrator=runge_kutta4()), 40.0 / 3.0


def juggled_ball():
    def ball(t, x, u):
        return [x[1], u[0] - 9.81]

    fall, rise = (Phase(name, ball, between(0.1, 0.9), nx=2, nu=1) for name in ("fall", "rise"))
    fall.ends_when("impact", first, Crossing.falling)
    rise.reach("back", first, exactly(1.0)).reach("at rest", second, exactly(0.0))
    for phase in (fall, rise):
        phase.inputs(linear).keep("ground", first, at_least(0.0)).minimise("effort", effort).guess_duration(0.5)
    problem = OptimalControlProblem("juggled ball").start_at([1, 0])
    problem.then(fall).then(rise, jump("bounce", lambda t, x: [x[0], -0.8 * x[1]]))
    return (problem.total_time(exactly(1.0)), dict(intervals_per_phase=10, integrator=runge_kutta4()),
            2.570651595764464)


def dido():
    length = np.pi / 3.0
    rise, fall = (Phase(name, lambda t, x, u: u, exactly(duration), nx=1, nu=1)
                  for name, duration in (("rise", 0.4), ("fall", 0.6)))
    for phase in (rise, fall):
        phase.minimise("area", lambda t, x: -x[0]).inputs(linear).bound_input(0, between(-2.0, 2.0))
        phase.bound_integral("length", lambda t, x, u: sqrt(1.0 + u[0] * u[0]), at_most(length))
    fall.reach("end", first, exactly(0.0))
    rise.guess_input(Guess.interpolate([0.5], [0.1]))
    fall.guess_input(Guess.interpolate([0.1], [-0.5]))
    problem = OptimalControlProblem("Dido").start_at([0]).then(rise).then(fall)
    return problem, dict(intervals=[40, 60], integrator=runge_kutta4()), -0.5 * (length - np.sqrt(0.75))


def linked_phases():
    def weighted(weight):
        return lambda t, x, u: weight * u[0] * u[0]

    there, on, uphill = (Phase(name, lambda t, x, u: u, between(0.1, 2.0), nx=1, nu=1).guess_duration(1.0)
                         .minimise("effort", weighted(weight))
                         for name, weight in (("there", 1.0), ("on", 1.0), ("uphill", 2.0)))
    there.reach("place", first, exactly(0.5))
    problem = OptimalControlProblem("linked phases").start_at([0]).then(there).then(on).then(uphill)
    problem.total_time(exactly(3.0))
    problem.link("one ahead", lambda a, b: b.x[0] - a.x[0], exactly(1.0), end_of(there), end_of(uphill))
    problem.link("equally long", lambda a, b: b.duration - a.duration, exactly(0.0), start_of(there), start_of(uphill))
    root = np.sqrt(6.0)
    return (problem, dict(intervals_per_phase=5, integrator=runge_kutta4()),
            (1.5 + root) * (1.0 / 12.0 + 1.0 / (3.0 * root)))


def tide():
    crossing = Phase("crossing", lambda t, x, u: u[0] + cos(t), exactly(1.0), nx=1, nu=1)
    crossing.minimise("effort", lambda t, x, u: u[0] * u[0]).reach("shore", first, exactly(2.0))
    problem = OptimalControlProblem("tide").start_at([0]).start_time(between(-2.0, 2.0), 0.5).then(crossing)
    return problem, dict(intervals_per_phase=10, integrator=runge_kutta8()), (2.0 - 2.0 * np.sin(0.5)) ** 2


def thermostat():
    heater = Automaton(2, 0, 1).mode("heating", lambda t, x, u, p: [p[0] - x[0], 0.0])
    heater.mode("idle", lambda t, x: [-x[0], 0.0]).store_mode_in(1)
    heater.event("warm", "heating", "idle", lambda t, x: x[0] - 2.0, Crossing.rising)
    heater.event("cold", "idle", "heating", lambda t, x: x[0] - 1.0, Crossing.falling)
    room = Phase("room", heater, exactly(np.log(16.0 / 3.0))).unknown("heater", 2.8, between(2.2, 5.0))
    room.minimise_at_end("size", lambda t, x, u, p: p[0] * p[0]).reach("temperature", first, exactly(1.5))
    room.guess_state(Guess.simulate())
    problem = OptimalControlProblem("thermostat").start_at([1, 0]).then(room)
    return problem, dict(intervals_per_phase=12, integrator=runge_kutta8(steps=2)), 9.0


def soft_targets():
    pull = Phase("pull", lambda t, x, u: u, exactly(1.0), nx=3, nu=3)
    pull.minimise("effort", lambda t, x, u: 0.5 * (u @ u)).inputs(InputParametrisation.piecewise_linear)
    pull.reach("first", first, at_least(1.0), soft("first", 0.4))
    pull.bound_integral("third", lambda t, x: x[2], Limits(at_least(1.0), huber("third", 2.0, 0.25)))
    problem = OptimalControlProblem("soft targets").start_at([0, 0, 0]).then(pull)
    problem.link("second", lambda start, end: end.x[1] - start.x[1],
                 Limits(at_least(1.0), soft("second", 2.0, Penalty.L2)), start_of(pull), end_of(pull))
    return (problem, dict(intervals_per_phase=10, integrator=runge_kutta4()), 8.0 / 25.0 + 1.0 / 3.0 + 19.0 / 48.0)


CASES = (bryson_denham, brachistochrone, bang_bang, goddard_rocket, catalyst_mixing, hanging_chain, moon_lander,
         interior_point, van_der_pol, turbo_car, juggled_ball, dido, linked_phases, tide, thermostat, soft_targets)
