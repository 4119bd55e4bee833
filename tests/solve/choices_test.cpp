// Solvers selected by name and by method find the same optimum, and names do not clash with the
// namespace of Ipopt.
#include <gtest/gtest.h>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/any_real_time_solver.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/solver/small_programs.hpp"
#include "tests/support/errors.hpp"

namespace Ipopt {  // NOLINT(readability-identifier-naming): as in the headers of Ipopt
class SmartPtrStandIn {};
}  // namespace Ipopt

using namespace saltus;  // as users do
using Ipopt::SmartPtrStandIn;

namespace {

MultipleShooting regulator() {
  const auto rate = [](const auto&, const auto&, const auto& u) { return u[0]; };
  Phase<1, 1> phase{"regulate", rate, exactly(1.0)};
  phase.bound_input(0, between(-0.3, 0.3))
      .track(
          "state", [](const auto&, const auto& x) { return x; }, VectorXd::Ones(1))
      .track(
          "input", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
  OptimalControlProblem ocp("regulator");
  return MultipleShooting(ocp.start_at({1.0}).then(phase),
                          {.intervals_per_phase = 10, .integrator = zero_order_hold()});
}

TEST(SolverChoice, EveryNameMakesASolverThatFindsTheOptimum) {
  MultipleShooting shooting = regulator();
  const double optimum = solve(shooting, *make_native_solver({.tolerance = 1e-10})).cost;
  for (const auto& [name, choice] : solver_choices()) {
    const Solution s = solve(shooting, *make_solver(choice, {.tolerance = 1e-10}));
    ASSERT_TRUE(s.ok()) << name << ": " << s.message;
    EXPECT_NEAR(s.cost, optimum, 1e-9) << name;  // two tolerances, for costs of about 1
  }
}

TEST(SolverChoice, NativeSolversHaveAQpMethod) {
  MultipleShooting shooting = regulator();
  for (const SolverChoice choice : {SolverChoice::sparse, SolverChoice::riccati}) {
    const auto solver = make_native_solver({.qp = qp_method(choice)});
    EXPECT_TRUE(solve(shooting, *solver).ok());
    EXPECT_NE(solver->name().find(choice == SolverChoice::sparse ? "sparse" : "stages"),
              std::string::npos)
        << solver->name();
  }
  EXPECT_THROW(qp_method(SolverChoice::ipopt), DefinitionError);
}

TEST(RealTimeChoice, EveryNameAndMethodGivesTheSameInput) {
  RecedingHorizonController plain(regulator(), {.period = 0.1});
  const double input = plain.tick(0.0, VectorXd{{1.0}}).input[0].input()[0];
  for (const auto& [name, solver] : solver_choices())
    for (const auto& [word, method] : tick_methods()) {
      RecedingHorizonController controller = make_controller(
          regulator(), {.solver = solver, .method = method, .tolerance = 1e-10}, {.period = 0.1});
      const ControlTick& tick = controller.tick(0.0, VectorXd{{1.0}});
      EXPECT_EQ(tick.provenance, Provenance::optimal) << name << ' ' << word;
      EXPECT_NEAR(tick.input[0].input()[0], input, 1e-6) << name << ' ' << word;
      const bool is_step = method == RealTimeChoice::Method::step && solver != SolverChoice::ipopt;
      EXPECT_EQ(controller.solver_name().starts_with("real-time iteration"), is_step)
          << controller.solver_name();
    }
}

// The multiplier of an unused slack is about as large as its weight. It must not hide the residuals
// of the inputs: x' = u from 0.5 to 1 in 1 s needs the input 0.5.
TEST(RealTimeChoice, HugePenaltyWeightsHideNoResidual) {
  for (const double weight : {1e2, 1e6, 1e12, 1e14})
    for (const auto& [name, solver] : solver_choices())
      for (const auto& [word, method] : tick_methods()) {
        Phase<1, 1> phase{"move", [](auto, const auto&, const auto& u) { return u; }, exactly(1.0)};
        phase
            .reach(
                "end", [](auto, auto x) { return x[0]; }, exactly(1.0), soft("end", weight))
            .track(
                "effort", [](auto, auto, auto u) { return u; }, VectorXd::Ones(1));
        OptimalControlProblem ocp("move");
        ocp.start_at({0.0}).then(phase);
        RecedingHorizonController controller = make_controller(
            MultipleShooting(ocp, {.intervals_per_phase = 20, .integrator = zero_order_hold()}),
            {.solver = solver, .method = method}, {.period = 0.05});
        controller.tick(0.0, VectorXd{{0.0}});
        const ControlTick& tick = controller.tick(0.0, VectorXd{{0.5}});
        SCOPED_TRACE(std::string(name) + ' ' + std::string(word) + ' ' + std::to_string(weight));
        EXPECT_NE(tick.status, SolveStatus::unbounded);
        if (weight <= 1e6) {
          EXPECT_EQ(tick.provenance, Provenance::optimal);
        }
        const double error = std::abs(tick.input[0].input()[0] - 0.5);
        if (tick.provenance == Provenance::optimal) {
          EXPECT_LE(error, 1e-3);
        }
        if (error > 1e-3) {
          EXPECT_NE(controller.report().status, SolveStatus::optimal);
        }
      }
}

TEST(RealTimeChoice, UsesTheIterationLimitOfTheUser) {
  for (const auto& [name, solver] : solver_choices()) {
    RecedingHorizonController controller =
        make_controller(regulator(), {.solver = solver, .max_iterations = 1}, {.period = 0.1});
    EXPECT_EQ(controller.tick(0.0, VectorXd{{1.0}}).status, SolveStatus::iteration_limit) << name;
  }
}

TEST(QpMethod, StageMethodNeedsStages) {
  testing_support::Parabola program(1.0, between(-10.0, 10.0), true);  // without stages
  const NlpPoint start{VectorXd::Zero(1), {}, {}};
  EXPECT_NEAR(make_native_solver()->solve(program, start, false).point.w[0], 1.0, 1e-8);
  expect_error<DefinitionError>(
      [&] { make_native_solver({.qp = riccati_qp()})->solve(program, start, false); },
      {"sparse_qp()"});
  EXPECT_THROW(make_real_time_iteration(program), DefinitionError);
}

}  // namespace
