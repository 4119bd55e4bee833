// What does the controller hand over: when an event falls inside the tick, and when a solve fails?
#include <gtest/gtest.h>

#include <memory>

#include "framework/mpc/receding_horizon.hpp"
#include "framework/solver/ipopt.hpp"
#include "integrators/zero_order_hold.hpp"

namespace saltus {
namespace {

struct Integrator1 {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0]);
  }
};

constexpr double step = 0.1;  // s
constexpr int intervals = 5;

// Drive x to zero; from the event on the input is twice as strong.
MultipleShooting gate(double event_time) {
  Phase<1, 1> phase{"gate", Integrator1{}, exactly(step * intervals)};
  phase.bound_input(0, between(-1.0, 1.0), Window{.to = event("open")})
      .bound_input(0, between(-2.0, 2.0), Window{.from = event("open")})
      .minimise("distance", [](auto, auto x, auto u) { return x[0] * x[0] + 1e-3 * u[0] * u[0]; });
  OptimalControlProblem ocp("gate");
  ocp.schedule(Schedule({"closed", "open"}, {{"open", event_time}})).start_at({10.0}).then(phase);
  return MultipleShooting(std::move(ocp),
                          {.intervals_per_phase = intervals, .integrator = zero_order_hold()});
}

// Solves with Ipopt except in the calls that are to fail.
class Unreliable final : public Solver {
 public:
  explicit Unreliable(std::vector<bool> fails) : fails_(std::move(fails)) {}
  std::string name() const override { return "unreliable"; }
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    NlpResult result = solver_->solve(program, start, warm);
    if (fails_.at(calls_++)) result.status = SolveStatus::numerical_failure;
    return result;
  }

 private:
  std::vector<bool> fails_;
  std::size_t calls_ = 0;
  std::unique_ptr<Solver> solver_ = make_solver(Ipopt{});
};

TEST(HeldInput, IsOnePieceWithoutAnEventAndTwoWithOne) {
  RecedingHorizonController controller(gate(0.137), make_solver(Ipopt{}), step);
  const VectorXd x = VectorXd::Constant(1, 10.0);
  const ControlTick before = controller.tick(0.0, x);
  ASSERT_EQ(before.input.size(), 1u);
  EXPECT_NEAR(before.input[0].input[0], -1.0, 1e-6);

  const ControlTick across = controller.tick(0.1, x);
  ASSERT_EQ(across.input.size(), 2u);
  EXPECT_NEAR(across.input[0].start, 0.1, 1e-12);
  EXPECT_NEAR(across.input[0].length, 0.037, 1e-12);
  EXPECT_NEAR(across.input[0].input[0], -1.0, 1e-6);
  EXPECT_NEAR(across.input[1].start, 0.137, 1e-12);
  EXPECT_NEAR(across.input[0].length + across.input[1].length, step, 1e-12);
  EXPECT_NEAR(across.input[1].input[0], -2.0, 1e-6);

  const ControlTick after = controller.tick(0.2, x);
  ASSERT_EQ(after.input.size(), 1u);
  EXPECT_NEAR(after.input[0].input[0], -2.0, 1e-6);
}

TEST(RecedingHorizon, GoesOnWithTheLastPlanWhenASolveFails) {
  auto solver = std::make_unique<Unreliable>(std::vector<bool>{true, false, true, true});
  RecedingHorizonController controller(gate(infinity), std::move(solver), step);
  VectorXd x = VectorXd::Constant(1, 0.15);
  const ControlTick first = controller.tick(0.0, x);
  EXPECT_EQ(first.provenance, Provenance::none);
  EXPECT_TRUE(first.input.empty());

  const ControlTick good = controller.tick(0.0, x);
  ASSERT_EQ(good.provenance, Provenance::optimal);
  const Trajectory plan = good.solution.trajectory;
  const ControlTick shifted = controller.tick(step, x);
  EXPECT_EQ(shifted.provenance, Provenance::shifted);
  ASSERT_EQ(shifted.input.size(), 1u);
  EXPECT_EQ(shifted.input[0].input, plan.input(1.5 * step));

  // Beyond the end of the plan its last input goes on.
  const ControlTick late = controller.tick(10.0, x);
  EXPECT_EQ(late.provenance, Provenance::shifted);
  ASSERT_EQ(late.input.size(), 1u);
  EXPECT_EQ(late.input[0].input, plan.input(plan.end_time()));
  EXPECT_NEAR(late.input[0].length, step, 1e-12);
}

}  // namespace
}  // namespace saltus
