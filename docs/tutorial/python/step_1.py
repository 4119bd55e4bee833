# Step 1: one phase. From a crouch to standing in half a second with minimum effort.
from hopper import *

rise = stance("rise", exactly(0.5))
rise.reach("straight", height, exactly(leg)).reach("at rest", speed, exactly(0.0))
problem = OptimalControlProblem("stand up").start_at([0.3, 0.0]).then(rise)

plan = solve(problem)
print(plan.message)
at = plan.trajectory.input
print(f"force: {at(0.0)[0]:.1f} N at the start, {at(0.499)[0]:.1f} N at the end; weight: {mass * gravity:.1f} N")
save(problem, plan, "step_1", state_names, input_names)
