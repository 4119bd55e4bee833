# Step 4: a jump of the state. Push off, fly, land and end in a crouch at rest.
from hopper import *

push = stance("push off", between(0.05, 1.0))
push.ends_when("lift-off", off_the_ground, Crossing.rising)
push.reach("fast enough", apex, at_least(0.75)).guess_duration(0.3)
land = stance("land", between(0.05, 1.0))
land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0))
problem = OptimalControlProblem("hop").start_at([0.3, 0.0])
problem.then(push).then(flight("fly")).then(land, jump("landing", landing))

plan = solve(problem)
print(plan.message)
d = plan.durations
print(f"push off {d[0]:.4f} s, fly {d[1]:.4f} s, land {d[2]:.4f} s")
save(problem, plan, "step_4", state_names, input_names)
