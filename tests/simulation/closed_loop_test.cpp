// The closed loop matches the discrete system, and its log contains the result.
#include "saltus/simulation/closed_loop.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <thread>
#include <type_traits>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using testing_support::Cart;

constexpr double step = 0.1;  // s
constexpr int intervals = 8;

// Costs are summed at the nodes, as in a discrete linear-quadratic regulator of `intervals` steps.
const Vec<double, 2> state_weight{4.0, 0.5}, end_weight{10.0, 2.0};
const Vec<double, 1> input_weight{0.3};

OptimalControlProblem regulator() {
  const auto state = [](const auto&, const auto& x) { return x; };
  const auto input = [](const auto&, const auto&, const auto& u) { return u; };
  Phase<2, 1> phase{"regulate", Cart{}, exactly(step * intervals)};
  phase.track("state", state, state_weight)
      .track("input", input, input_weight)
      .track_at_end("end", state, end_weight);
  OptimalControlProblem ocp("regulator");
  ocp.start_at({1.0, -0.5}).then(phase).costs(CostRule::nodes);
  return ocp;
}

RecedingHorizonController controller_for(OptimalControlProblem ocp,
                                         ControllerOptions options = {}) {
  MultipleShooting shooting(std::move(ocp),
                            {.intervals_per_phase = intervals, .integrator = zero_order_hold()});
  auto solver = make_real_time_iteration(shooting.nlp());
  options.period = step;
  return {std::move(shooting), std::move(solver), std::move(options)};
}

// Gain of the first step, by the Riccati recursion on the exactly sampled system.
struct SampledRegulator {
  Mat<double, 2, 2> A;
  Vec<double, 2> B;
  Mat<double, 1, 2> K;

  SampledRegulator() {
    A << 1.0, step, 0.0, 1.0;
    B << 0.5 * step * step, step;
    const Mat<double, 2, 2> Q = (step * state_weight).asDiagonal();
    const double R = step * input_weight[0];
    Mat<double, 2, 2> P = end_weight.asDiagonal();
    for (int k = 0; k < intervals; ++k) {
      K = (B.transpose() * P * A) / (R + B.dot(P * B));
      P = Q + A.transpose() * P * (A - B * K);
    }
  }
};

TEST(ClosedLoop, LinearQuadraticControlMatchesTheDiscreteClosedLoop) {
  RecedingHorizonController controller = controller_for(regulator());
  IntegratorPlant plant = nominal_plant(regulator(), zero_order_hold());
  const LoopLog log =
      simulate_closed_loop(controller, plant, {.duration = 2.0, .samples_per_tick = 3});
  ASSERT_TRUE(log.completed) << log.message;
  ASSERT_EQ(log.ticks.size(), 20u);
  ASSERT_EQ(log.recording.samples.size(), 61u);
  EXPECT_EQ(log.count(Provenance::optimal), 20);
  const SampledRegulator known;
  Vec<double, 2> x{1.0, -0.5};
  for (std::size_t k = 0; k <= 20; ++k) {
    const Sample& sample = log.recording.samples[3 * k];
    EXPECT_NEAR(sample.time, step * static_cast<double>(k), 1e-12);
    // The solver's tolerance of 1e-8, in scaled variables of order one.
    EXPECT_LT((sample.state - x).norm(), 1e-7) << k;
    if (k < 20) {
      EXPECT_NEAR(sample.input[0], -(known.K * x)[0], 1e-6) << k;
    }
    x = known.A * x - known.B * (known.K * x)[0];
  }
}

TEST(ClosedLoop, FeedbackLawMatchesTheDiscreteClosedLoop) {
  const SampledRegulator known;
  IntegratorPlant plant = make_plant<2, 1>(Cart{}, zero_order_hold(), VectorXd{{1.0, -0.5}});
  const LoopLog log =
      simulate_closed_loop([&](double, const VectorRef& x, VectorOut u) { u = -known.K * x; },
                           plant, {.duration = 2.0, .period = step});
  Vec<double, 2> x{1.0, -0.5};
  for (int k = 0; k < 20; ++k) x = known.A * x - known.B * (known.K * x)[0];
  EXPECT_LT((log.final_state() - x).norm(), 1e-12);
  EXPECT_FALSE(log.ticks[0].provenance);
}

// x' = p u, where the model of the controller has p = 1.
struct Drift {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return Vec<S, 1>(p[0] * u[0]);
  }
};
IntegratorPlant drift(double p = 1.0) {
  return make_plant<1, 1, 1>(Drift{}, runge_kutta4(), VectorXd{{1.0}}, VectorXd{{p}});
}
const FeedbackLaw down = [](double, const VectorRef&, VectorOut u) { u[0] = -1.0; };

TEST(ClosedLoop, PlantMayHaveOtherParameters) {
  IntegratorPlant plant = drift(1.5);
  EXPECT_NEAR(simulate_closed_loop(down, plant, {.duration = 0.4}).final_state()[0], 0.4, 1e-12);
  plant.set_parameters(VectorXd{{0.5}});
  const LoopLog log = simulate_closed_loop(down, plant, {.duration = 0.4});
  EXPECT_NEAR(log.recording.samples.front().time, 0.4, 1e-12);  // the loop continues
  EXPECT_NEAR(log.final_state()[0], 0.2, 1e-12);
}

TEST(ClosedLoop, DelayedInputsKeepTheirLength) {
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 0.5, .period = step};
  options.disturbances.input_delay = 0.13;
  options.disturbances.first_input = VectorXd{{2.0}};
  const LoopLog log = simulate_closed_loop(down, plant, options);
  EXPECT_NEAR(log.final_state()[0], 1.0 + 2.0 * 0.13 - 0.37, 1e-12);
  bool seen = false;  // the log has a sample at each change of the input
  for (const Sample& s : log.recording.samples) seen = seen || std::abs(s.time - 0.13) < 1e-12;
  EXPECT_TRUE(seen);
}

TEST(ClosedLoop, DelaysMeasurements) {
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 1.0, .period = step};
  options.disturbances.measurement_delay = 3 * step;
  const LoopLog log = simulate_closed_loop(down, plant, options);
  for (std::size_t k = 0; k < log.ticks.size(); ++k)
    EXPECT_NEAR(log.ticks[k].measured[0], 1.0 - step * (k < 3 ? 0.0 : double(k) - 3.0), 1e-12);
}

TEST(ClosedLoop, DisturbancesAddUp) {
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 1.0, .period = step};
  options.disturbances.input = [](double t, const VectorRef&, VectorOut w) {
    w[0] = t < 0.45 ? 0.5 : 0.0;  // the input changes at 0.5 s: it is constant from tick to tick
  };
  options.disturbances.state = [](double t, const VectorRef&, VectorOut w) {
    w[0] = std::abs(t - 0.3) < 1e-9 ? 7.0 : 0.0;
  };
  const LoopLog log = simulate_closed_loop(down, plant, options);
  EXPECT_NEAR(log.final_state()[0], 1.0 - 1.0 + 0.25 + 7.0, 1e-12);
}

TEST(ClosedLoop, NoiseIsWhiteAndSeeded) {
  const auto run = [](std::uint64_t seed) {
    IntegratorPlant plant = drift();
    LoopOptions options{.duration = 200.0, .period = step};
    options.disturbances.measurement_noise = VectorXd{{0.2}};
    options.disturbances.seed = seed;
    return simulate_closed_loop([](double, const VectorRef&, VectorOut u) { u[0] = 0.0; }, plant,
                                options);
  };
  const LoopLog one = run(1);
  EXPECT_EQ(one.recording.trajectory_csv(), run(1).recording.trajectory_csv());
  EXPECT_EQ(one.ticks[7].measured[0], run(1).ticks[7].measured[0]);
  EXPECT_NE(one.ticks[7].measured[0], run(2).ticks[7].measured[0]);
  double sum = 0.0, square = 0.0, lag = 0.0, before = 0.0;
  for (const LoopLog::Tick& tick : one.ticks) {
    const double e = tick.measured[0] - 1.0;
    sum += e;
    square += e * e;
    lag += e * before;
    before = e;
  }
  const auto n = static_cast<double>(one.ticks.size());
  // The tolerance is four standard deviations of the estimates from 2000 numbers.
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.2 / std::sqrt(n));
  EXPECT_NEAR(square / n, 0.04, 4.0 * 0.04 * std::sqrt(2.0 / n));
  EXPECT_NEAR(lag / n, 0.0, 4.0 * 0.04 / std::sqrt(n));
}

// A ball that loses a fifth of its speed at every impact: x = (height m, speed m/s).
constexpr double gravity = 9.81, restitution = 0.8;
Automaton<2, 1> ball() {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  Automaton<2, 1> automaton;
  automaton
      .mode("flight",
            [](const auto&, const auto& x, const auto& u) {
              return decltype(x.eval()){x[1], u[0] - gravity};
            })
      .event("impact", "flight", "flight", height, Crossing::falling,
             [](const auto&, const auto& x) {
               return decltype(x.eval()){x[0], -restitution * x[1]};
             });
  return automaton;
}

TEST(ClosedLoop, ReportsTimesOfPlantEvents) {
  IntegratorPlant plant =
      make_plant(ball(), cvodes({.method = CvodesOptions::Method::Adams, .tolerance = 1e-11}),
                 VectorXd{{1.0, 0.0}});
  EXPECT_EQ(plant.mode(), "flight");
  int heard = 0;
  LoopOptions options{.duration = 2.0, .period = 0.01};
  options.on_event = [&](const HybridEvent& e) { heard += e.name == "impact"; };
  const LoopLog log = simulate_closed_loop(
      [](double, const VectorRef&, VectorOut u) { u[0] = 0.0; }, plant, options);
  ASSERT_TRUE(log.completed) << log.message;
  const double first = std::sqrt(2.0 / gravity);
  ASSERT_EQ(log.recording.events.size(), 3u);
  EXPECT_EQ(heard, 3);
  double t = first, flight = 2.0 * first;
  for (const HybridEvent& e : log.recording.events) {
    // Two hundred intervals with a local error of 1e-11.
    EXPECT_NEAR(e.time, t, 1e-8);
    EXPECT_EQ(e.kind, HybridEvent::Kind::jumps);
    EXPECT_NEAR(e.after[1], -restitution * e.before[1], 1e-12);
    flight *= restitution;
    t += flight;
  }
}

TEST(ClosedLoop, FailingPlantEndsTheRun) {
  IntegratorPlant plant = make_plant(ball(), runge_kutta4(), VectorXd{{1.0, 0.0}});
  const LoopLog log =
      simulate_closed_loop([](double, const VectorRef&, VectorOut u) { u[0] = 0.0; }, plant,
                           {.duration = 8.0, .period = 1.0});
  EXPECT_FALSE(log.completed);  // impacts accumulate at 4.06 s
  EXPECT_NE(log.message.find("4.06"), std::string::npos) << log.message;
  EXPECT_LT(log.recording.samples.back().time, 5.0);
  EXPECT_NE(log.summary_json().find("\"completed\": false"), std::string::npos);
}

// x warms up or cools down at 1 / s. The mode switches half a degree above and below the set-point
// u + p.
Automaton<1, 1, 1> thermostat() {
  const auto above = [](const auto&, const auto& x, const auto& u, const auto& p) {
    return x[0] - (u[0] + p[0] + 0.5);
  };
  const auto below = [](const auto&, const auto& x, const auto& u, const auto& p) {
    return x[0] - (u[0] + p[0] - 0.5);
  };
  Automaton<1, 1, 1> automaton;
  automaton.mode("heating", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
      .mode("cooling", [](const auto&, const auto& x) { return -1.0 + 0.0 * x[0]; })
      .event("warm", "heating", "cooling", above, Crossing::rising)
      .event("cold", "cooling", "heating", below, Crossing::falling);
  return automaton;
}

TEST(ClosedLoop, JumpOfTheSetPointSwitches) {
  const auto set_point = [](double t) { return t < 0.25 ? 20.0 : t < 0.95 ? 19.0 : 25.0; };
  const auto expect = [](const LoopLog& log) {
    ASSERT_TRUE(log.completed) << log.message;
    ASSERT_EQ(log.recording.events.size(), 2u);
    EXPECT_EQ(log.recording.events[0].name, "warm");  // at 20.3, the set-point at 19
    EXPECT_NEAR(log.recording.events[0].time, 0.3, 1e-12);
    EXPECT_EQ(log.recording.events[1].name, "cold");  // at 19.6, the set-point at 25
    EXPECT_NEAR(log.recording.events[1].time, 1.0, 1e-12);
    EXPECT_NEAR(log.final_state()[0], 20.6, 1e-12);
    EXPECT_EQ(log.recording.samples.back().mode, "heating");
  };
  LoopOptions options{.duration = 2.0, .period = step};
  IntegratorPlant by_input =
      make_plant(thermostat(), runge_kutta4(), VectorXd{{20.0}}, VectorXd{{0.0}});
  expect(simulate_closed_loop([&](double t, const VectorRef&, VectorOut u) { u[0] = set_point(t); },
                              by_input, options));
  IntegratorPlant by_parameter =
      make_plant(thermostat(), runge_kutta4(), VectorXd{{20.0}}, VectorXd{{0.0}});
  options.before_tick = [&](double t, const VectorRef&) {
    by_parameter.set_parameters(VectorXd{{set_point(t)}});
  };
  expect(simulate_closed_loop([](double, const VectorRef&, VectorOut u) { u[0] = 0.0; },
                              by_parameter, options));
}

// Without hysteresis the state slides on the set-point until the set-point moves away or a push
// occurs.
TEST(ClosedLoop, DoesNotSlideOnAJumpingSurface) {
  Automaton<1, 1> relay;
  relay.mode("below", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
      .mode("above", [](const auto&, const auto& x) { return -1.0 + 0.0 * x[0]; })
      .surface("set-point", "below", "above",
               [](const auto&, const auto& x, const auto& u) { return x[0] - u[0]; });
  IntegratorPlant plant = make_plant(relay, runge_kutta4(), VectorXd{{19.9}});
  LoopOptions options{.duration = 2.5, .period = step};
  options.disturbances.state = [](double t, const VectorRef&, VectorOut w) {
    w[0] = std::abs(t - 1.5) < 1e-9 ? 0.55 : 0.0;
  };
  const LoopLog log = simulate_closed_loop(
      [](double t, const VectorRef&, VectorOut u) { u[0] = t < 0.25 ? 20.0 : 19.0; }, plant,
      options);
  ASSERT_TRUE(log.completed) << log.message;
  std::vector<double> times;
  for (const HybridEvent& e : log.recording.events)
    if (e.kind == HybridEvent::Kind::slides) times.push_back(e.time);
  ASSERT_EQ(times.size(), 3u);
  EXPECT_NEAR(times[0], 0.1, 1e-9);
  EXPECT_NEAR(times[1], 1.3, 1e-9);   // from 20 at 0.3 s down to 19
  EXPECT_NEAR(times[2], 2.05, 1e-9);  // from 19.55 at 1.5 s
  EXPECT_NEAR(log.final_state()[0], 19.0, 1e-12);
}

// x' = u, until the formula throws.
bool armed = false;
struct Fragile {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    if (armed) throw std::runtime_error("the table ends here");
    return Vec<S, 1>(u[0]);
  }
};

TEST(ClosedLoop, ThrowingFormulaEndsTheRunWithAMessage) {
  const FeedbackLaw up = [](double, const VectorRef&, VectorOut u) { u[0] = 1.0; };
  const auto expect = [](const LoopLog& log, std::initializer_list<const char*> parts) {
    armed = false;
    EXPECT_FALSE(log.completed);
    for (const char* part : parts)
      EXPECT_NE(log.message.find(part), std::string::npos) << log.message;
    EXPECT_NEAR(log.final_state()[0], 0.5, 1e-12);  // earlier records are kept
  };
  for (const IntegratorChoice& scheme :
       {runge_kutta4(), cvodes({.method = CvodesOptions::Method::Adams, .tolerance = 1e-11})}) {
    IntegratorPlant plant = make_plant<1, 1>(Fragile{}, scheme, VectorXd{{0.0}});
    LoopOptions options{.duration = 1.0, .period = step};
    options.before_tick = [](double t, const VectorRef&) { armed = t > 0.45; };
    expect(simulate_closed_loop(up, plant, options),
           {"0.5 s", "a formula threw", "the table ends here"});
  }
  {
    IntegratorPlant plant = make_plant<1, 1>(Fragile{}, runge_kutta4(), VectorXd{{0.0}});
    const FeedbackLaw throws = [](double t, const VectorRef&, VectorOut u) {
      if (t > 0.45) throw 42;
      u[0] = 1.0;
    };
    expect(simulate_closed_loop(throws, plant, {.duration = 1.0, .period = step}),
           {"feedback law threw", "t = 0.5 s", "not a std::exception"});
  }
}

// If the formula of the controller's model throws, the fallback continues.
TEST(ClosedLoop, ThrowingModelUsesTheFallback) {
  Phase<1, 1> phase{"drift", Fragile{}, exactly(step * intervals)};
  phase.minimise("effort", [](const auto&, const auto& x, const auto& u) {
    return x[0] * x[0] * x[0] * x[0] + u[0] * u[0];
  });
  OptimalControlProblem ocp("drift");
  ocp.start_at({1.0}).then(phase);
  MultipleShooting shooting(std::move(ocp),
                            {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
  auto solver = make_real_time_iteration(shooting.nlp());
  RecedingHorizonController controller(std::move(shooting), std::move(solver),
                                       {.period = step, .fallback_input = VectorXd{{-0.25}}});
  IntegratorPlant plant = drift();
  armed = true;
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 1.0, .plan_every = 1});
  armed = false;
  EXPECT_TRUE(log.completed) << log.message;
  EXPECT_EQ(log.count(Provenance::fallback), 10);
  EXPECT_TRUE(log.plans.empty());
  EXPECT_TRUE(std::isinf(log.ticks[0].objective));  // without a plan its cells are empty
  EXPECT_NE(log.ticks_csv().find(",0,,,,"), std::string::npos) << log.ticks_csv();
  EXPECT_NEAR(log.final_state()[0], 0.75, 1e-12);
}

TEST(ClosedLoop, InfeasibleStartUsesTheFallback) {
  OptimalControlProblem ocp = regulator();
  const auto position = [](const auto&, const auto& x) { return x[0]; };
  Phase<2, 1> phase{"stop in time", Cart{}, exactly(step * intervals)};
  phase.bound_input(0, between(-1.0, 1.0))
      .keep("wall", position, at_most(2.0), Window{.from = step})
      .minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  OptimalControlProblem wall("wall");
  wall.start_at({0.0, 0.0}).then(phase);
  ControllerOptions options;
  options.fallback_input = VectorXd{{-1.0}};
  RecedingHorizonController controller = controller_for(wall, options);
  // At 3 m, 1 m beyond the wall, no input brings the cart back within a step.
  IntegratorPlant plant = make_plant<2, 1>(Cart{}, zero_order_hold(), VectorXd{{3.0, 0.0}});
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 3.0, .plan_every = 1});
  ASSERT_TRUE(log.completed);
  ASSERT_EQ(log.ticks[0].provenance, Provenance::fallback);
  EXPECT_EQ(log.recording.samples[0].input[0], -1.0);
  EXPECT_GT(log.count(Provenance::fallback), 5);  // until it is within the wall again
  EXPECT_GT(log.count(Provenance::optimal), 5);
  EXPECT_EQ(static_cast<int>(log.plans.size()), 30 - log.count(Provenance::fallback));
  EXPECT_EQ(log.statistics.count(Provenance::fallback), log.count(Provenance::fallback));
  EXPECT_LT(log.final_state()[0], 2.0);
}

TEST(ClosedLoop, RejectsBackwardTime) {
  IntegratorPlant plant = drift();
  for (const double length : {-0.1, std::nan("")}) {
    EXPECT_FALSE(plant.advance(VectorXd::Ones(1), length));
    EXPECT_NE(plant.failure().find("expected 0 or more"), std::string::npos) << plant.failure();
    EXPECT_EQ(plant.time(), 0.0);
  }
  EXPECT_TRUE(plant.advance(VectorXd::Ones(1), 0.0));
}

// A user-defined plant with four functions.
class Counter final : public LoopPlant {
 public:
  double time() const override { return time_; }
  VectorXd state() const override { return VectorXd{{count_}}; }
  int inputs() const override { return 1; }
  bool advance(const VectorRef& input, double length) override {
    if (count_ >= 5.0) throw std::runtime_error("the counter is full");
    count_ += input[0];
    time_ += length;
    return count_ < 5.0;
  }

 private:
  double time_ = 0.0, count_ = 0.0;
};

TEST(ClosedLoop, DrivesACustomPlant) {
  Counter plant;
  const FeedbackLaw up = [](double, const VectorRef&, VectorOut u) { u[0] = 1.0; };
  EXPECT_EQ(simulate_closed_loop(up, plant, {.duration = 0.03}).final_state()[0], 3.0);
  const LoopLog log = simulate_closed_loop(up, plant, {.duration = 0.03});
  EXPECT_FALSE(log.completed);
  EXPECT_EQ(log.message, "the plant could not advance");
  const LoopLog wrecked = simulate_closed_loop(up, plant, {.duration = 0.03});
  EXPECT_FALSE(wrecked.completed);
  EXPECT_NE(wrecked.message.find("the counter is full"), std::string::npos) << wrecked.message;
  LoopOptions options{.duration = 0.03};
  options.disturbances.state_noise = VectorXd{{1.0}};
  EXPECT_THROW(simulate_closed_loop(up, plant, options), DefinitionError);
}

// A user-defined controller. It counts down from the measured state, at half the rate of its ticks.
class CountDown final : public LoopController {
 public:
  double period() const override { return step; }
  std::string name() const override { return "count down"; }
  const HeldInput& tick(double t, const VectorRef& measured) override {
    if (ticks++ % 2 == 0) rate_ = -measured[0];
    input_.clear();
    HeldInput::Piece& piece = input_.add();
    piece.start = t;
    piece.length = step;
    piece.size = 1;
    piece.values[0] = rate_;
    return input_;
  }

  int ticks = 0;

 private:
  double rate_ = 0.0;
  HeldInput input_{1, 1};
};

TEST(ClosedLoop, DrivesWithACustomController) {
  IntegratorPlant plant = drift(), again = drift();
  CountDown controller, silent;
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 1.0});
  EXPECT_TRUE(log.completed) << log.message;
  EXPECT_EQ(log.controller, "count down");
  EXPECT_EQ(controller.ticks, 10);
  EXPECT_EQ(log.ticks.size(), 10u);
  // Every two ticks the state is multiplied by 1 - 2 step.
  EXPECT_NEAR(log.final_state()[0], std::pow(1.0 - 2.0 * step, 5), 1e-12);
  // The duration is infinite and nothing is recorded.
  LoopOptions options{.duration = infinity, .record = false};
  EXPECT_THROW(simulate_closed_loop(silent, again, options), DefinitionError);
  options.until = [](double t, const VectorRef&) { return t > 1.0 - 0.5 * step; };
  const LoopLog none = simulate_closed_loop(silent, again, options);
  EXPECT_TRUE(none.completed);
  EXPECT_EQ(none.ticks.size(), 10u);
  EXPECT_TRUE(none.recording.samples.empty());
  EXPECT_EQ(again.state(), plant.state());
}

// Records every second tick only, like a planner that runs at half the rate.
class RecordsItsPlans final : public LoopController {
 public:
  double period() const override { return step; }
  std::string name() const override { return inner_.name(); }
  const HeldInput& tick(double t, const VectorRef& measured) override {
    return inner_.tick(t, measured);
  }
  std::optional<LoopLog::Tick> last_tick() override {
    if (inner_.ticks % 2 == 0) return {};
    LoopLog::Tick tick;
    tick.provenance = Provenance::optimal;
    tick.message = "planned";
    return tick;
  }

 private:
  CountDown inner_;
};

TEST(ClosedLoop, TheLogHasTheTicksThatAControllerReports) {
  IntegratorPlant plant = drift();
  RecordsItsPlans controller;
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 1.0});
  ASSERT_EQ(log.ticks.size(), 5u);
  EXPECT_NEAR(log.ticks[1].time, 2.0 * step, 1e-12);
  EXPECT_EQ(log.ticks[1].message, "planned");
  EXPECT_EQ(log.ticks[1].measured[0], log.recording.samples[2].state[0]);
  EXPECT_EQ(log.statistics.count(Provenance::optimal), 5);
}

// The state of `drift()` at the end of a run of one second with these pulses.
double drifted(const std::vector<Pulse>& pulses) {
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 1.0, .period = step};
  options.disturbances.pulses = pulses;
  const FeedbackLaw rest = [](double, const VectorRef&, VectorOut input) { input[0] = 0.0; };
  const LoopLog log = simulate_closed_loop(rest, plant, options);
  EXPECT_TRUE(log.completed) << log.message;
  return plant.state()[0];
}

TEST(ClosedLoop, PulseChangesTheStateByItsImpulse) {
  const VectorXd up = VectorXd::Constant(1, 2.0);
  const double rest = drifted({});
  for (const PulseShape shape :
       {PulseShape::rectangle, PulseShape::half_sine, PulseShape::triangle})
    for (const double duration : {0.013, 0.1, 0.25}) {
      const Pulse pulse{0.5, up, 0.3141, duration, shape};
      EXPECT_NEAR(drifted({pulse}), rest + 1.0, 1e-12) << describe(shape) << ", " << duration;
    }
  EXPECT_NEAR(drifted({{0.5, up, 0.9, 0.2}}), rest + 0.5, 1e-12);  // half of it after the end
  EXPECT_THROW(drifted({{0.5, VectorXd::Ones(2), 0.3, 0.1}}), DefinitionError);
  const double nan = std::nan("");
  for (const Pulse& bad : std::vector<Pulse>{{0.5, up, 0.3, 0.0},
                                             {0.5, up, 0.3, -0.1},
                                             {0.5, up, nan, 0.1},
                                             {0.5, up, 0.3, infinity},
                                             {nan, up, 0.3, 0.1},
                                             {0.5, nan * up, 0.3, 0.1}})
    EXPECT_THROW(drifted({bad}), DefinitionError) << bad.start << " " << bad.duration;
}

// A plant that applies pulses itself receives them once, and its state is not changed by the loop.
class PushedPlant final : public LoopPlant {
 public:
  double time() const override { return time_; }
  VectorXd state() const override { return VectorXd::Zero(1); }
  int inputs() const override { return 1; }
  bool advance(const VectorRef&, double length) override {
    time_ += length;
    return true;
  }
  bool take_pulses(std::span<const Pulse> pulses) override {
    received.assign(pulses.begin(), pulses.end());
    return true;
  }

  std::vector<Pulse> received;

 private:
  double time_ = 0.0;
};

TEST(ClosedLoop, PlantMayApplyPulsesItself) {
  PushedPlant plant;
  CountDown controller;
  LoopOptions options{.duration = 1.0};
  options.disturbances.pulses = {{7.0, VectorXd::Ones(3), 0.2, 0.1}};
  EXPECT_TRUE(simulate_closed_loop(controller, plant, options).completed);
  ASSERT_EQ(plant.received.size(), 1u);
  EXPECT_EQ(plant.received[0].impulse, 7.0);
}

TEST(ClosedLoop, EndsWhenUntilReturnsTrue) {
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 5.0, .period = step};
  options.until = [](double, const VectorRef& x) { return x[0] < 0.25; };
  const LoopLog log = simulate_closed_loop(down, plant, options);
  EXPECT_TRUE(log.completed);
  EXPECT_EQ(log.ticks.size(), 8u);
  EXPECT_NE(log.message.find("t = 0.8 s"), std::string::npos) << log.message;
}

TEST(ClosedLoop, NanInputEndsTheRun) {
  IntegratorPlant plant = drift();
  const LoopLog log = simulate_closed_loop(
      [](double t, const VectorRef&, VectorOut u) { u[0] = t < 0.25 ? 1.0 : std::nan(""); }, plant,
      {.duration = 1.0, .period = step});
  EXPECT_FALSE(log.completed);
  EXPECT_EQ(log.message, "the controller's input at t = 0.3 s is not finite");
  EXPECT_NEAR(log.final_state()[0], 1.3, 1e-12);
}

TEST(ClosedLoop, WritesItsTablesDuringTheRun) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("saltus-live-{}", ::getpid());
  IntegratorPlant plant = drift();
  LoopOptions options{.duration = 0.05, .live_folder = folder.string()};
  bool is_written = false;
  options.before_tick = [&](double t, const VectorRef&) {
    is_written = is_written || std::filesystem::exists(folder / "trajectory.csv");
    if (t == 0.0)
      std::this_thread::sleep_for(std::chrono::milliseconds(600));  // more than the pause
  };
  simulate_closed_loop(down, plant, options);
  EXPECT_TRUE(is_written);
  EXPECT_GT(std::filesystem::remove_all(folder), 1u);
}

TEST(ClosedLoop, RejectsMismatchedSizes) {
  IntegratorPlant plant = drift();
  const auto refused = [&](const LoopOptions& options) {
    EXPECT_THROW(simulate_closed_loop(down, plant, options), DefinitionError);
  };
  refused({.duration = 0.0});
  refused({.period = 0.0});
  refused({.samples_per_tick = 0});
  refused({.disturbances = {.measurement_noise = VectorXd{{1.0, 1.0}}}});
  refused({.disturbances = {.measurement_noise = VectorXd{{-1.0}}}});
  refused({.disturbances = {.state_noise = VectorXd{{infinity}}}});
  refused({.disturbances = {.measurement_noise = VectorXd{{std::nan("")}}}});
  refused({.disturbances = {.measurement_delay = 0.015}});
  refused({.disturbances = {.measurement_delay = infinity}});
  refused({.disturbances = {.input_delay = -1.0}});
  refused({.disturbances = {.first_input = VectorXd{{1.0, 1.0}}}});
  refused({.disturbances = {.first_input = VectorXd{{std::nan("")}}}});
  EXPECT_THROW(simulate_closed_loop(FeedbackLaw{}, plant, {}), DefinitionError);
  RecedingHorizonController controller = controller_for(regulator());
  EXPECT_THROW(simulate_closed_loop(controller, plant, {}), DefinitionError);
  EXPECT_THROW((make_plant<1, 1, 1>(Drift{}, runge_kutta4(), VectorXd{{1.0}})), DefinitionError);
  EXPECT_THROW(make_plant(ball(), zero_order_hold(), VectorXd{{1.0, 0.0}}), DefinitionError);
}

}  // namespace
}  // namespace saltus
