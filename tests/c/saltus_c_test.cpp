// The C interface: ticks neither allocate nor throw, every error is a status with a text, and input
// and plan are those of the controller.
#include "saltus/c/saltus_c.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "saltus/c/register_controller.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

constexpr double period = 0.1;  // s
bool throws = false;            // formulas throw while it is set

// x = (height, speed), u = force per mass, p = target; the second phase also has a fuel and no
// input.
struct Lift {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    if (throws) throw std::runtime_error("no formula today");
    return {x[1], u[0] - 0.1 * x[1] * x[1]};
  }
};
struct Coast {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 0>&, const Vec<S, 1>&) const {
    return {x[1], -x[2], S(0.0)};
  }
};

MultipleShooting lift() {
  const auto distance = [](auto, auto x, auto, auto p) { return x[0] - p[0]; };
  const auto force = [](auto, auto, auto u, auto) { return u[0]; };
  Phase<2, 1, 1> powered{"powered", Lift{}, exactly(0.5)};
  powered.bound_input(0, between(-2.0, 2.0))
      .data("target", VectorXd::Zero(1))
      .track("distance", distance, VectorXd::Constant(1, 10.0))
      .track("force", force, VectorXd::Constant(1, 0.1));
  Phase<3, 0, 1> coast{"coast", Coast{}, exactly(0.5)};
  coast.data("target", VectorXd::Zero(1));
  OptimalControlProblem problem("lift");
  problem.start_at({0.0, 0.0})
      .then(powered)
      .then(coast, jump<2, 1>("stop", [](auto, auto x, auto, auto) {
              using S = std::decay_t<decltype(x[0])>;
              return Vec<S, 3>{x[0], x[1], S(0.5)};
            }));
  return {problem, {.intervals_per_phase = 5, .integrator = runge_kutta4()}};
}

RecedingHorizonController make_lift(ControllerOptions options) {
  options.period = period;
  options.fallback_input = VectorXd::Constant(1, 0.25);
  return {lift(), options};
}
RecedingHorizonController make_invalid(ControllerOptions options) {
  options.period = -1.0;
  return {lift(), options};
}
RecedingHorizonController make_number(ControllerOptions) { throw 42; }

const RegisterController registered("lift", make_lift), invalid("invalid", make_invalid),
    number("number", make_number);

class CInterface : public ::testing::Test {
 protected:
  CInterface() { EXPECT_EQ(saltus_create("lift", &lift_), SALTUS_OK) << error(); }
  ~CInterface() override {
    saltus_destroy(lift_);
    throws = false;
  }
  std::string error() const { return saltus_error(lift_); }
  // A tick from height 0 and its first input.
  saltus_tick tick(double t, const double* state, double& u) {
    saltus_tick result{};
    double start = 0.0, length = 0.0;
    int count = 0;
    EXPECT_EQ(saltus_prepare(lift_, t), SALTUS_OK);
    EXPECT_EQ(saltus_feedback(lift_, state, 2, &result), SALTUS_OK);
    EXPECT_EQ(saltus_read_piece(lift_, 0, &start, &length, &u, 1, &count), SALTUS_OK);
    EXPECT_EQ(start, t);
    EXPECT_EQ(count, 1);
    return result;
  }

  saltus_controller* lift_ = nullptr;
  const double start_[2] = {0.0, 0.0};
};

TEST_F(CInterface, TicksAreThoseOfTheController) {
  RecedingHorizonController same = make_lift({});
  const double target = 0.3;
  ASSERT_EQ(saltus_set_data(lift_, "target", &target, 1), SALTUS_OK) << error();
  same.set_data("target", target);
  for (int k = 0; k < 5; ++k) {
    double u = 0.0;
    const saltus_tick c = tick(k * period, start_, u);
    const ControlTick& cpp = same.tick(k * period, VectorXd::Zero(2));
    EXPECT_EQ(u, cpp.input[0].input()[0]);
    EXPECT_EQ(int{c.provenance}, static_cast<int>(cpp.provenance));
    EXPECT_EQ(c.objective, cpp.objective);
    EXPECT_EQ(c.pieces, static_cast<int>(cpp.input.size()));
    EXPECT_STREQ(c.solve, describe(cpp.status));
    EXPECT_GT(u, 0.0);
  }
}

TEST_F(CInterface, TicksDoNotAllocate) {
  double u = 0.0, largest = 0.0;
  const double target = 0.3;
  tick(0.0, start_, u);
  const testing::AllocationCount count;
  for (int k = 1; k < 10; ++k) {
    saltus_set_data(lift_, "target", &target, 1);
    tick(k * period, k % 3 == 0 ? nullptr : start_, u);
    largest = std::max(largest, u);
  }
  EXPECT_EQ(count.made(), 0);
  EXPECT_GT(largest, 0.0);
}

TEST_F(CInterface, EveryTickHasAnInput) {
  double u = 0.0;
  EXPECT_EQ(tick(0.0, nullptr, u).provenance, SALTUS_FALLBACK);
  EXPECT_EQ(u, 0.25);
  EXPECT_NE(tick(period, start_, u).provenance, SALTUS_FALLBACK);
  EXPECT_EQ(tick(2 * period, nullptr, u).provenance, SALTUS_SHIFTED);
  const double lost[2] = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  EXPECT_EQ(tick(3 * period, lost, u).provenance, SALTUS_SHIFTED);
  throws = true;
  EXPECT_EQ(tick(4 * period, start_, u).provenance, SALTUS_SHIFTED);
  throws = false;
  // A wrong count is reported, and the tick ran.
  saltus_tick result{};
  const double wide[3] = {0.0, 0.0, 0.0};
  EXPECT_EQ(saltus_feedback(lift_, wide, 3, &result), SALTUS_BAD_ARGUMENT);
  EXPECT_EQ(error(), "saltus_feedback: the state has 3 entries, expected 2");
  EXPECT_EQ(result.provenance, SALTUS_SHIFTED);
  EXPECT_NEAR(result.time, 5 * period, 1e-12);  // rounding of a sum
}

TEST_F(CInterface, TheInputIsSentBeforeTheTickReturns) {
  struct Seen {
    saltus_controller* controller;
    double u = -1.0, time = -1.0;
  } seen{lift_};
  const auto send = [](void* context, const saltus_tick* tick) {
    Seen& to = *static_cast<Seen*>(context);
    double start = 0.0, length = 0.0;
    int count = 0;
    to.time = tick->time;
    saltus_read_piece(to.controller, 0, &start, &length, &to.u, 1, &count);
  };
  ASSERT_EQ(saltus_on_input(lift_, send, &seen), SALTUS_OK);
  double u = 0.0;
  tick(0.0, start_, u);
  EXPECT_EQ(seen.u, u);
  EXPECT_EQ(seen.time, 0.0);
  ASSERT_EQ(saltus_on_input(lift_, nullptr, nullptr), SALTUS_OK);
  tick(period, start_, u);
  EXPECT_EQ(seen.time, 0.0);
}

TEST_F(CInterface, PlansHaveARowPerNodeAndTwoPerEvent) {
  saltus_sizes sizes{};
  ASSERT_EQ(saltus_read_sizes(lift_, &sizes), SALTUS_OK);
  EXPECT_EQ(sizes.states, 2);
  EXPECT_EQ(sizes.inputs, 1);
  EXPECT_EQ(sizes.plan_states, 3);
  EXPECT_EQ(sizes.plan_inputs, 1);
  EXPECT_EQ(sizes.period, period);
  std::vector<double> times(20), states(60), inputs(20);
  std::vector<int> phases(20);
  int rows = 0;
  const auto read = [&](int capacity) {
    return saltus_read_plan(lift_, times.data(), phases.data(), states.data(), inputs.data(),
                            capacity, &rows);
  };
  EXPECT_EQ(read(20), SALTUS_NO_PLAN);
  double u = 0.0;
  tick(2.0, start_, u);
  EXPECT_EQ(read(11), SALTUS_BAD_ARGUMENT);
  EXPECT_EQ(error(), "saltus_read_plan: the plan has 12 rows, the arrays 11");
  ASSERT_EQ(read(20), SALTUS_OK) << error();
  ASSERT_EQ(rows, 12);  // five intervals and the end, per phase
  EXPECT_EQ(times[0], 2.0);
  EXPECT_EQ(inputs[0], u);
  EXPECT_NEAR(times[5], 2.5, 1e-12);  // rounding of sums of intervals
  EXPECT_EQ(times[5], times[6]);
  EXPECT_EQ(phases[5], 0);
  EXPECT_EQ(phases[6], 1);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(states[15 + i], states[18 + i], 1e-7);  // of the solver
  EXPECT_TRUE(std::isnan(states[17]));
  EXPECT_NEAR(states[20], 0.5, 1e-7);  // of the solver
  EXPECT_TRUE(std::isnan(inputs[6]));
  EXPECT_NEAR(times[11], 3.0, 1e-12);
  EXPECT_EQ(saltus_read_plan(lift_, times.data(), nullptr, nullptr, nullptr, 20, &rows), SALTUS_OK);
  ASSERT_EQ(saltus_prepare(lift_, 2.0 + period), SALTUS_OK);
  EXPECT_EQ(read(20), SALTUS_NO_PLAN);
}

TEST_F(CInterface, ErrorsHaveATextUntilTheNextCall) {
  const double value = 1.0;
  EXPECT_EQ(saltus_set_data(lift_, "targets", &value, 1), SALTUS_BAD_DEFINITION);
  EXPECT_NE(error().find("did you mean 'target'?"), std::string::npos) << error();
  EXPECT_EQ(saltus_set_data(lift_, "target", &value, 1), SALTUS_OK);
  EXPECT_EQ(error(), "");
  EXPECT_EQ(saltus_retime(lift_, "noon", 1.0), SALTUS_BAD_DEFINITION);
  EXPECT_EQ(saltus_set_data(lift_, std::string(5000, 'x').c_str(), &value, 1),
            SALTUS_BAD_DEFINITION);
  EXPECT_EQ(error().size(), 1023);
  EXPECT_EQ(saltus_set_data(lift_, nullptr, &value, 1), SALTUS_BAD_ARGUMENT);
  EXPECT_EQ(saltus_read_piece(lift_, 0, nullptr, nullptr, nullptr, 0, nullptr),
            SALTUS_BAD_ARGUMENT);
  double start = 0.0, length = 0.0, u = 0.0;
  int count = 0;
  EXPECT_EQ(saltus_read_piece(lift_, 0, &start, &length, &u, 1, &count), SALTUS_NO_PLAN);
  tick(0.0, start_, u);
  EXPECT_EQ(saltus_read_piece(lift_, 9, &start, &length, &u, 1, &count), SALTUS_BAD_ARGUMENT);
  EXPECT_EQ(saltus_read_piece(lift_, 0, &start, &length, &u, 0, &count), SALTUS_BAD_ARGUMENT);
  EXPECT_EQ(saltus_prepare(nullptr, 0.0), SALTUS_BAD_ARGUMENT);
  EXPECT_STREQ(saltus_error(nullptr), "no controller: a null pointer");
}

TEST_F(CInterface, AControllerThatCannotBeCreatedSaysWhy) {
  const auto create = [](const char* name, saltus_status expected) {
    saltus_controller* controller = nullptr;
    EXPECT_EQ(saltus_create(name, &controller), expected);
    std::string text = saltus_error(controller);
    EXPECT_EQ(saltus_prepare(controller, 0.0), SALTUS_BAD_DEFINITION);
    saltus_destroy(controller);
    return text;
  };
  EXPECT_EQ(create("lifts", SALTUS_UNKNOWN_NAME), "no controller 'lifts' is registered");
  EXPECT_NE(create("invalid", SALTUS_BAD_DEFINITION).find("the period is -1 s"), std::string::npos);
  EXPECT_EQ(create("number", SALTUS_FAILURE), "an exception that is not a std::exception");
  EXPECT_EQ(create(nullptr, SALTUS_BAD_ARGUMENT), "saltus_create: no name");
  EXPECT_EQ(saltus_create("lift", nullptr), SALTUS_BAD_ARGUMENT);
  const RegisterController again("lift", make_lift);
  EXPECT_EQ(create("lift", SALTUS_BAD_DEFINITION), "2 controllers 'lift' are registered");
}

TEST_F(CInterface, RegistrationsEndWithTheirObjects) {
  EXPECT_EQ(saltus_controllers(), 3);
  EXPECT_EQ(saltus_controller_name(3), nullptr);
  EXPECT_EQ(saltus_controller_name(-1), nullptr);
  {
    const RegisterController first("first", make_lift);
    {
      const RegisterController second("second", make_lift);
      EXPECT_STREQ(saltus_controller_name(0), "second");
      EXPECT_EQ(saltus_controllers(), 5);
    }
    EXPECT_STREQ(saltus_controller_name(0), "first");
  }
  EXPECT_EQ(saltus_controllers(), 3);
  EXPECT_EQ(saltus_interface_version(), SALTUS_INTERFACE_VERSION);
  EXPECT_NE(std::string(saltus_version()).find('.'), std::string::npos);
}

}  // namespace
}  // namespace saltus
