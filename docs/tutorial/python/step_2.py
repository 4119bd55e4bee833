# Step 2: a phase that ends by its state. Push off until the leg is straight.
from hopper import *

push = stance("push off", between(0.05, 1.0))
push.ends_when("lift-off", off_the_ground, Crossing.rising)
push.reach("fast enough", apex, at_least(0.75)).guess_duration(0.3)
problem = OptimalControlProblem("push off").start_at([0.3, 0.0]).then(push)

plan = solve(problem)
print(plan.message)
print(f"lift-off after {plan.durations[0]:.4f} s")
for crossing in plan.crossings:
    print(f"'{crossing.event}' at {crossing.rate:.3f} m/s")
save(problem, plan, "step_2", state_names, input_names)
