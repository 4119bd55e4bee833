# Step 6: control. Four hops and a landing, with a disturbance in flight.
from hopper import *

problem = OptimalControlProblem("four hops").start_at([leg, -2.1])
for hop in range(1, 5):
    bounce = stance(f"bounce {hop}", between(0.05, 1.0))
    bounce.ends_when("lift-off", off_the_ground, Crossing.rising)
    bounce.reach("fast enough", apex, exactly(0.75)).guess_duration(0.4)
    bounce.guess_state(Guess.interpolate([leg, -2.1], [leg, 2.2]))
    fly = flight(f"fly {hop}").guess_state(Guess.interpolate([leg, 2.2], [leg, -2.2]))
    problem.then(bounce, jump("landing", landing) if hop > 1 else None).then(fly)
land = stance("land", between(0.05, 1.0))
land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0))
land.guess_state(Guess.interpolate([leg, -2.1], [0.3, 0.0]))
problem.then(land, jump("landing", landing))
plan = solve(problem, intervals_per_phase=15)
print("plan:", plan.message)

# Every 10 ms the rest of the motion is planned from the measured state.
controller = ShrinkingHorizonController(problem, intervals_per_phase=15, integrator=runge_kutta4(), period=0.01)
controller.adopt_plan(plan.trajectory)
plant = PhasedPlant(problem, runge_kutta4())
highest = 0.0


def push_down(t, x):
    return [0.0, -1.0 if abs(t - 1.45) < 1e-6 else 0.0]  # m/s


def watch(t, x):
    global highest
    highest = max(highest, x[0])


def report(event):
    global highest
    if event.name == "touch-down":
        print(f"touch-down at {event.time:.3f} s, after {highest:.3f} m")
        highest = 0.0


log = simulate_closed_loop(controller, plant, duration=5.0, state_names=state_names, input_names=input_names,
                           disturbances=Disturbances(state=push_down), before_tick=watch, on_event=report)
print(f"{log.message}; ends at {log.final_state[0]:.3f} m with {log.final_state[1]:.3f} m/s")
log.write("step_6")
