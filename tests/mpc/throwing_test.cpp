// A controller never ends the program. If formulas or user functions throw any exception at any
// time, the controller uses the previous plan or the fallback.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {
namespace {

constexpr double step = 0.1;  // s

// Exception that formulas throw while it is set.
enum class Thrown { nothing, exception, number };
Thrown thrown = Thrown::nothing;
void throw_if_asked() {
  if (thrown == Thrown::exception) throw std::runtime_error("no formula today");
  if (thrown == Thrown::number) throw 42;
}

struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    throw_if_asked();
    return {x[1], sin(x[0]) + u[0]};
  }
};

enum class Back { stages, riccati, sparse, ipopt, sqp, cvodes };
MultipleShooting pendulum(Back which, CostRule rule) {
  Phase<2, 1> phase{"pendulum", Pendulum{}, exactly(5 * step)};
  phase.bound_input(0, between(-2.0, 2.0))
      .track(
          "upright", [](const auto&, const auto& x) { return x; }, Vec<double, 2>{10.0, 1.0})
      .track(
          "torque", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.1});
  OptimalControlProblem ocp("pendulum");
  ocp.start_at({0.5, 0.0}).then(phase).costs(rule);
  const IntegratorChoice integrator = which == Back::cvodes ? cvodes() : runge_kutta4();
  return MultipleShooting(std::move(ocp), {.intervals_per_phase = 5, .integrator = integrator});
}

RecedingHorizonController controller_for(Back which, ControllerOptions options = {}) {
  // CVODES gives no second derivatives of integrals, which the real-time iteration needs.
  const CostRule rule = which == Back::cvodes ? CostRule::nodes : CostRule::integrated;
  MultipleShooting shooting = pendulum(which, rule);
  std::unique_ptr<RealTimeSolver> solver;
  RealTimeIterationOptions iteration;
  if (which == Back::riccati) iteration.qp = riccati_qp();
  if (which == Back::sparse) iteration.qp = sparse_qp();
  if (which == Back::ipopt)
    solver = make_real_time_solver(make_ipopt());
  else if (which == Back::sqp)
    solver = make_real_time_solver(make_native_solver({}));
  else
    solver = make_real_time_iteration(shooting.nlp(), iteration);
  options.period = step;
  options.fallback_input = VectorXd::Constant(1, 0.7);
  return {std::move(shooting), std::move(solver), std::move(options)};
}

const VectorXd tilted = Vec<double, 2>{0.4, 0.0};

class Throwing : public ::testing::TestWithParam<Back> {
 protected:
  ~Throwing() override { thrown = Thrown::nothing; }
};

TEST(RealTimeIteration, UsesDifferencesWithoutAHessian) {
  MultipleShooting shooting = pendulum(Back::cvodes, CostRule::integrated);
  const auto iteration = make_real_time_iteration(shooting.nlp());
  EXPECT_NE(iteration->name().find("differenced"), std::string::npos) << iteration->name();
}

TEST_P(Throwing, TickUsesTheFallbackOrThePreviousPlan) {
  for (const Thrown what : {Thrown::exception, Thrown::number}) {
    RecedingHorizonController controller = controller_for(GetParam());
    thrown = what;
    const ControlTick& tick = controller.tick(0.0, tilted);
    EXPECT_EQ(tick.provenance, Provenance::fallback);
    EXPECT_EQ(tick.status, SolveStatus::evaluation_failed);
    EXPECT_EQ(tick.input[0].input()[0], 0.7);
    thrown = Thrown::nothing;
    controller.tick(0.0, tilted);
    ASSERT_TRUE(is_of_this_tick(tick.provenance)) << describe(tick.status);
    const double next = controller.report().trajectory.input(1.5 * step)[0];
    thrown = what;
    controller.tick(step, tilted);
    EXPECT_EQ(tick.provenance, Provenance::shifted);
    EXPECT_NEAR(tick.input[0].input()[0], next, 1e-12);
    EXPECT_ANY_THROW(controller.report());  // outside the loop, the exception is passed on
    thrown = Thrown::nothing;
    // The exception leaves no trace: the result equals that of a controller without it.
    RecedingHorizonController other = controller_for(GetParam());
    other.tick(0.0, tilted);
    other.tick(step, VectorXd::Constant(2, std::nan("")));
    const ControlTick& expected = other.tick(2 * step, tilted);
    controller.tick(2 * step, tilted);
    ASSERT_TRUE(is_of_this_tick(tick.provenance)) << describe(tick.status);
    EXPECT_EQ(tick.provenance, expected.provenance);
    EXPECT_NEAR(tick.input[0].input()[0], expected.input[0].input()[0], 1e-9);
  }
}

TEST_P(Throwing, FailedPreparationIsRepeatedInTheTick) {
  for (const Thrown what : {Thrown::exception, Thrown::number}) {
    RecedingHorizonController controller = controller_for(GetParam());
    RecedingHorizonController other = controller_for(GetParam());
    thrown = what;
    controller.prepare(0.0);
    thrown = Thrown::nothing;
    const ControlTick& tick = controller.feedback(tilted);
    const ControlTick& expected = other.tick(0.0, tilted);
    ASSERT_TRUE(is_of_this_tick(tick.provenance)) << describe(tick.status);
    EXPECT_NEAR(tick.input[0].input()[0], expected.input[0].input()[0], 1e-9);
  }
}

TEST_P(Throwing, FeedbackUsesTheFallbackOrAnUncheckedPlan) {
  for (const Thrown what : {Thrown::exception, Thrown::number}) {
    RecedingHorizonController controller = controller_for(GetParam());
    controller.prepare(0.0);
    thrown = what;
    const ControlTick& tick = controller.feedback(tilted);
    thrown = Thrown::nothing;
    // The linearised problem needs no formula any more, but the check does. The input is available,
    // and its plan is unchecked.
    if (tick.provenance == Provenance::step) {
      EXPECT_EQ(tick.status, SolveStatus::step_taken);
      EXPECT_EQ(tick.kkt, infinity);
      EXPECT_EQ(tick.violation, infinity);
      EXPECT_FALSE(controller.report().ok());
    } else {
      EXPECT_EQ(tick.provenance, Provenance::fallback);
      EXPECT_EQ(tick.input[0].input()[0], 0.7);
    }
    EXPECT_TRUE(tick.input.all_finite());
  }
}

const char* name_of(Back which) {
  constexpr const char* names[] = {"Stages", "Riccati", "Sparse", "Ipopt", "Sqp", "Cvodes"};
  return names[static_cast<int>(which)];
}
INSTANTIATE_TEST_SUITE_P(Solvers, Throwing,
                         ::testing::Values(Back::stages, Back::riccati, Back::sparse, Back::ipopt,
                                           Back::sqp, Back::cvodes),
                         [](const auto& instance) { return name_of(instance.param); });

TEST(ThrowingFunctions, DoNotInterruptTheTick) {
  for (const Thrown what : {Thrown::exception, Thrown::number}) {
    const auto throws = [what] {
      thrown = what;
      struct Reset {
        ~Reset() { thrown = Thrown::nothing; }
      } reset;
      throw_if_asked();
    };
    ControllerOptions options;
    int sent = 0;
    options.send = [&](const ControlTick&) {
      ++sent;
      throws();
    };
    RecedingHorizonController sends = controller_for(Back::stages, options);
    const ControlTick& tick = sends.tick(0.0, tilted);
    EXPECT_TRUE(is_of_this_tick(tick.provenance));
    EXPECT_LT(tick.kkt, infinity);  // the plan is checked nonetheless
    EXPECT_EQ(sent, 1);

    options = {};
    options.fallback = [&](double, const VectorRef&, VectorOut) { throws(); };
    RecedingHorizonController falls = controller_for(Back::stages, options);
    const ControlTick& fallen = falls.tick(0.0, VectorXd::Constant(2, std::nan("")));
    EXPECT_EQ(fallen.provenance, Provenance::fallback);
    EXPECT_EQ(fallen.input[0].input()[0], 0.7);
  }
}

// Wrong names and sizes are programming errors and throw at once. NaN comes from outside and is
// handled in the tick.
TEST(ThrowingFunctions, NanDataAreReportedInTheTick) {
  RecedingHorizonController controller = controller_for(Back::stages);
  EXPECT_THROW(controller.set_data("nothing", VectorXd::Zero(1)), DefinitionError);
  EXPECT_THROW(controller.set_previous_input(VectorXd::Zero(2)), DefinitionError);
  EXPECT_NO_THROW(controller.set_previous_input(VectorXd::Constant(1, infinity)));
  EXPECT_EQ(controller.tick(0.0, tilted).provenance, Provenance::fallback);
  EXPECT_TRUE(is_of_this_tick(controller.tick(0.0, tilted).provenance));
}

}  // namespace
}  // namespace saltus
