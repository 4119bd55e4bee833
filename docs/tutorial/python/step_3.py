# Step 3: two phases. Push off and fly; both durations are unknowns.
from hopper import *

push = stance("push off", between(0.05, 1.0))
push.ends_when("lift-off", off_the_ground, Crossing.rising).guess_duration(0.3)
fly = Phase("rise in the air", in_flight, between(0.05, 2.0), nx=2)
fly.ends_when("apex", speed, Crossing.falling)
fly.reach("high enough", height, at_least(0.75)).guess_duration(0.2)
problem = OptimalControlProblem("jump").start_at([0.3, 0.0]).then(push).then(fly)

plan = solve(problem)
print(plan.message)
print(f"lift-off after {plan.durations[0]:.4f} s, apex after {plan.durations.sum():.4f} s")
save(problem, plan, "step_3", state_names, input_names)
