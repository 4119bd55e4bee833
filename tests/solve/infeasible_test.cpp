// The message "The constraints cannot all be satisfied" requires a proof. Without one, the message
// reports an apparent local minimum of the violation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/infeasibility_proof.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

constexpr SolverChoice all_solvers[] = {SolverChoice::sparse, SolverChoice::riccati,
                                        SolverChoice::ipopt};
constexpr auto effort = [](auto, auto, auto u) { return u[0] * u[0]; };

Solution solved(const OptimalControlProblem& problem, SolverChoice choice) {
  return solve(problem, {.solver = make_solver(choice)});
}
bool is_proved(const Solution& plan) {
  return plan.message.find("the constraints cannot all be satisfied") == 0;
}
bool is_local(const Solution& plan) {
  return plan.message.find("apparent local minimum of their violation") != std::string::npos;
}

// A chain of three integrators. It needs an input of at least 1e-2 / gain^3.
OptimalControlProblem chain(double gain, double limit = infinity) {
  Phase<3, 1> phase{"chain",
                    [gain](auto, auto x, auto u) {
                      return decltype(x){gain * x[1], gain * x[2], gain * u[0]};
                    },
                    exactly(1.0)};
  phase.minimise("effort", effort)
      .reach("there", [](auto, auto x) { return x; }, {exactly(1e-2), exactly(0.0), exactly(0.0)});
  if (limit < infinity) phase.bound_input(0, between(-limit, limit));
  OptimalControlProblem problem("chain");
  problem.start_at({0.0, 0.0, 0.0}).then(phase);
  return problem;
}

// Minimum input of the chain: 0.32 / gain^3, bang-bang.
TEST(Infeasible, SmallGainsAreNotAProof) {
  for (const double gain : {1.0, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6})
    for (const SolverChoice choice : all_solvers) {
      SCOPED_TRACE(fmt::format("{} {}", gain, name_of(choice)));
      const Solution plan = solved(chain(gain), choice);
      EXPECT_FALSE(is_proved(plan)) << plan.message;
      if (gain >= 1e-3) {
        EXPECT_TRUE(plan.ok()) << plan.message;
      }
      if (plan.status == SolveStatus::infeasible) {
        EXPECT_TRUE(is_local(plan)) << plan.message;
      }
    }
  for (const double gain : {1.0, 1e-1, 1e-2, 1e-3, 1e-4}) {
    const double least = 0.32 / (gain * gain * gain);
    for (const double share : {0.5, 0.9, 1.1, 2.0}) {
      MultipleShooting shooting(chain(gain, share * least),
                                {.intervals_per_phase = 30, .integrator = runge_kutta4()});
      EXPECT_EQ(is_proved_infeasible(shooting.nlp(), shooting.initial_guess().w), share < 1.0)
          << gain << " " << share;
    }
  }
}

// A cart that cannot reach its target, in other units of length and force.
OptimalControlProblem too_far(double length, double force, double curvature) {
  Phase<2, 1> ride{
      "ride",
      [=](auto, auto x, auto u) {
        return decltype(x){x[1], length / force * u[0] - curvature / length * x[1] * x[1]};
      },
      exactly(2.0)};
  ride.minimise("effort", [=](auto, auto, auto u) { return u[0] * u[0] / (force * force); })
      .bound_input(0, between(-force, force))
      .reach(
          "there", [](auto, auto x) { return x[0]; }, exactly(5.0 * length));
  OptimalControlProblem problem("cart");
  problem.start_at({0.0, 0.0}).then(ride);
  return problem;
}

TEST(Infeasible, LinearProblemsAreProvedInAnyUnits) {
  for (const double length : {1e-3, 1.0, 1e3, 1e6})
    for (const double force : {1e-6, 1.0, 1e6})
      for (const SolverChoice choice : all_solvers) {
        const Solution plan = solved(too_far(length, force, 0.0), choice);
        EXPECT_EQ(plan.status, SolveStatus::infeasible);
        EXPECT_TRUE(is_proved(plan))
            << length << " " << force << " " << name_of(choice) << ": " << plan.message;
      }
}

TEST(Infeasible, OtherProblemsAreNotProved) {
  for (const SolverChoice choice : all_solvers) {
    const Solution plan = solved(too_far(1.0, 1.0, 0.1), choice);
    EXPECT_EQ(plan.status, SolveStatus::infeasible) << plan.message;
    EXPECT_TRUE(is_local(plan)) << plan.message;
  }
}

// Explanations say "cannot be met" only with the same proof.
TEST(Infeasible, ExplanationsHaveTheSameCertainty) {
  EXPECT_NE(explain(too_far(1.0, 1.0, 0.0)).text().find("cannot be met"), std::string::npos);
  EXPECT_EQ(explain(too_far(1.0, 1.0, 0.1)).text().find("cannot be met"), std::string::npos);
  EXPECT_EQ(explain(chain(1e-5)).text().find("cannot be met"), std::string::npos);
}

}  // namespace
}  // namespace saltus
