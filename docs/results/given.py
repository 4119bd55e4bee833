"""Numbers of the READMEs that are no measurements of ours, by README and kind, each with the words around it.

A phrase that begins with | is a table's title row and stands for the whole table. What a test holds fails there."""

from tables import README

SETTING = "setting"  # of a run, of the program, a default
DEFINITION = "definition"  # bounds of a verdict, units, sizes, versions, states of exit
CITED = "cited"  # of the paper, of makers, of the literature
HELD = "held by a test"  # that the words or the line around them name

GIVEN = {
    "README.md": {
        DEFINITION: ["on Debian 12, Debian 13 and Ubuntu 24.04", "BSD 3-clause", "CC BY-SA 4.0"],
    },
    "docs/formulation.md": {
        DEFINITION: ["phases i = 1, ..., N.", "the next phase k = i + 1", "- (1) and (2) are the dynamics and the algebraic equations of index 1.",
                     "- (3) is the jump", "- (4) holds in the window of the constraint, (5) at", "- (6) is a guard", "- (7) and (8) join one or several phases, (9) closes", "| Symbol | Meaning | Call |", "equations (1) and (2) with index 1"],
        HELD: [
            "where the exact optimum is 1.68950",
            "With 10, 30 and 100 intervals the integral gives 1.69203, 1.68978 and 1.68952. The sum gives 1.6601, 1.6804 and "
            "1.6868"],
    },
    "problems/README.md": {
        DEFINITION: ["the exit status is 3"],
    },
    "benchmarks/README.md": {
        DEFINITION: ["| Exit status | Meaning |",
                     "SHA-256",
                     "1e-8 by default", "loosest of 1, 0.1, 0.01, 0.001 times", "some 30 lines",
                     "one judge (KKT residual 1e-8 from the data)"],
        SETTING: ["eps_rel 0,", "at most 20,000 iterations, step size adapted every 50 iterations", "below 1,000 variables",
                  "20,000 working sets, 5 s at most | up to 250 variables", "CasADi uses 1e8 for absent bounds", "it gets 1e6",
                  "(Python 3.11 and 3.13 on x86-64)", "needs more than 10 s of CPU time", "Solves above 0.1 s have no",
                  "up to 200 variables |"],
        HELD: ["both have to agree to 1e-10"],
    },
    "examples/README.md": {
        SETTING: ["drives 100 m", "by 2 m in 3 s"],
        DEFINITION: ["ends with 1 if"],
    },
    "robots/README.md": {
        DEFINITION: ["one in 200 lines", "Unitree G1 (29 joints)", "status 2 if something is wrong",
                     "before, the filter finds the first tilt"],
        CITED: ["| sensor | tells | defaults (`sensor.*`) |"],
        SETTING: ["`sensor.velocity_lag` (1.5 ms)", "both from 0.25 s on", "more than 1.2 % of the robot", "boxes 5 mm thick",
                  "within 1 cm of each other", "keeps them 5 mm apart", "below 90 % of the largest speeds",
                  "swings stay below 75 %", "at 50 rad/s^2"],
        HELD: ["The biped of the tests (47 kg, 14 joints, CoM at 0.71 m) stands against 2 N s and catches 12 N s"],
    },
    "problems/push_recovery/README.md": {
        SETTING: [
            "Every 10 ms this problem over 15 intervals of 10 ms", "no multiple of 10 ms", "by CVODES at 1e-11",
            "fixed 0.1 s after the trigger", "due 0.5 s after the capture point left", "until 0.1 s before the landing",
            "a push of 0.4 s is not over after 0.1 s", "Forces: 0.002, 0.002, 1e-4 (vertical: 1e-5). Torques: 0.02.",
            "Change of a wrench between intervals: 1e-4", "Capture point after the landing: 1e5.",
            "3e4 forward and 3e5 sideways",
            "16 directions, 1 to 16 N s in steps of 1, and step times of 0.3, 0.45 and 0.6 s", "The push comes at 1 s",
            "measured over 20 ms", "(mean over 20 ms)", "in DART or MuJoCo at 1 kHz", "Every 10 ms the planner",
            "Every 2 ms one quadratic program", "the ground carries 20 N in the second half", "fitted to 90 ms",
            "the ground 18 cm beside the stance sole", "is 3 mm outside the support polygon", "`step.shortest` (0.3 s)"],
        DEFINITION: [
            "the CoM height is 0.45 to 0.60 m and the angular momentum at most 1 Nms",
            "From 4 s after the landing, for one second, the capture point is in the hull, the speed is below 0.05 m/s, the CoM "
            "is within 2 cm of its target, and the angular momentum is below 0.1 Nms",
            "no corner of a planted foot may slip by 1 cm",
            '("fell at 2.86 s; first, at 1.41 s, the right foot slipped")', "| Exit status | Meaning |",
            "neither sole ever 1 cm from its start, and the base never tilted by 0.05 rad",
            "stays within 5 % of the robot's weight (16 N)", "iCubGazeboV2_5 with 23 torque-controlled joints"],
        CITED: ["| | CoM x, y, z | velocity x, y, z | angular momentum |", "(Humanoids 2016)", "Pucci, 2016"],
    },
    README: {
        SETTING: [
            "In DART, the push at 1 s.",
            "on the left foot, 0.1 s, steps of at most 0.25 m forward and 0.31 m apart, swings of 0.3 to 0.9 s (fixed: 0.6 s), "
            "at 16 directions, found by bisection to 0.5 N s", "Preset robot in 16 directions", "(seed 1), push at 1 s",
            "(measured sensors, seed 1), push of 0.1 s on the chest at 1 s", "the height must not (1e5, 1000 on its speed)",
            "the momentum may move (400)", "With a capture point at 1e4", "push towards -y for 0.1 s at 2.4 s, landing at 3.0 s",
            "eight directions and steps of 0.6 s", "instance ICUB-1 of the tests", "a deadline of 1 ms", "MuJoCo at 1 kHz",
            "on the chest for 0.1 s, step of 0.6 s", "8 N s are the edge:", "Forces are means over 20 ms",
            "(4 N s: from the end of the push)", "pushed at 1 s. The controllers assume less friction than the paper's (0.25)",
            "here, in DART, 7 N s,", "(mean over 20 ms)", "in DART, push at 2.4 s:", "their mean over 20 ms",
            "whose controllers count on 1/3",
            "In DART with `--preset paper`, a step of 0.6 s, 6 N s in 0.1 s", "(preset robot in DART, step of 0.6 s, push at 1 s, seed 1)",
            "of the encoders (1 ms unless stated)",
            "the largest push (N s, seed 1)", "With a step of 0.3 s nothing is lost", "as they do at 8 N s above",
            "at which the trajectory ends, pushed at 0.5 s", "in DART, a step of 0.6 s, the push at 0.3 s"],
        DEFINITION: [
            "the feet stayed within 1 cm of where they were", "21 in place of 9", "iCubGazeboV2_5 with 23 torque-controlled joints", "up to sqrt(2) times"],
        CITED: [
            "(push at 2.4 s, landing at 3.0 s, 10 ms, horizon of 15)", "foot hits the ground at 3.0 s",
            "with fewer than 15 intervals", "0.1 s for a solution (MATLAB, MOSEK)"],
        HELD: [
            "Without a step the robot falls at 8 N s.",
            "and may use 1 Nms of angular momentum", "It survives 7.4 N s at the height of the posture (`tests/problems/standing_claim_test.cpp`", "passes 8 N s at 0.50 m",
            "the same objective to 1e-7 in every tick (`tests/problems`)",
            "- 6 N s with DART's own collision detector, FCL, Bullet and ODE, and with both contact solvers; forward 13 N s "
            "(`tests/problems/claims_test.cpp`)"],
    },
}
