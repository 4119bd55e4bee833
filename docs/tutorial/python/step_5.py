# Step 5: a periodic motion. The start and the duration of a hop are unknowns.
from hopper import *

bounce = stance("bounce", between(0.1, 1.0))
bounce.ends_when("lift-off", off_the_ground, Crossing.rising)
bounce.reach("fast enough", apex, at_least(0.75)).guess_duration(0.4)
bounce.guess_state(Guess.interpolate([leg, -2.0], [leg, 2.0]))
fly = flight("fly").guess_state(Guess.interpolate([leg, 2.0], [leg, -2.0]))
problem = OptimalControlProblem("periodic hop")
problem.start_within([exactly(leg), between(-4.0, -0.5)], [leg, -2.0])
problem.then(bounce).then(fly).close(jump("landing", landing))

plan = solve(problem)
print(plan.message)
print(f"lands with {plan.trajectory.state(0.0)[1]:.4f} m/s; on the ground {plan.durations[0]:.4f} s, "
      f"in the air {plan.durations[1]:.4f} s")
save(problem, plan, "step_5", state_names, input_names)
