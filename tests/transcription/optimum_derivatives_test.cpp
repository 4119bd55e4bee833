// Derivatives of optima against repeated solves, closed forms and published results.
#include "saltus/transcription/optimum_derivatives.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/resolved_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;

const IpoptOptions tight{.tolerance = 1e-10};

// --- an event that moves through an interval ----------------------------------------------------

struct TwoThrusters {  // x = (position, speed), u = two forces; the second works after the event
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], u[0] + 2.0 * u[1] - 0.3 * x[1]};
  }
};

// Changes of inputs have a cost, a bound is active for a while, and a soft bound is violated.
OptimalControlProblem landing(double impact, Bounds first_force, CostRule rule) {
  Phase<2, 2> phase{"motion", TwoThrusters{}, exactly(1.0)};
  phase.bound_input(1, exactly(0.0), Window{.to = event("impact")})
      .bound_input(0, first_force)
      .penalise_change(Vec<double, 2>{0.02, 0.03})
      .track("state", state, Vec<double, 2>{3.0, 0.2})
      .track("effort", input, Vec<double, 2>{0.1, 0.05})
      .track_at_end("arrival", state, Vec<double, 2>{4.0, 4.0})
      .keep(
          "slow", [](auto, auto x) { return x[1]; }, at_least(-0.8),
          Window{.from = event("impact")},
          Penalty{.kind = Penalty::L2, .weight = 5.0, .name = "slow"});
  OptimalControlProblem ocp("landing");
  ocp.schedule(Schedule({"before", "after"}, {{"impact", impact}}))
      .start_at({1.0, 0.4})
      .costs(rule)
      .then(phase);
  return ocp;
}

TEST(OptimumDerivatives, FollowAnEventThatMovesThroughAnInterval) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated})
    for (const double impact : {0.43, 0.4004, 0.77}) {
      MultipleShooting shooting(landing(impact, at_least(-2.0), rule), ten);
      shooting.set_previous_input(Vec<double, 2>{-0.5, std::nan("")});
      const Solution s = solve(shooting, *make_ipopt(tight));
      ASSERT_TRUE(s.ok()) << s.message;
      OptimumDerivatives derivatives(shooting, s);
      const auto moved = [&](double d) -> MultipleShooting& {
        shooting.retime("impact", impact + d);
        return shooting;
      };
      const double h = impact == 0.4004 ? 3e-4 : 5e-3;
      // The derivative uses differences, which are not exact.
      EXPECT_GT(derivatives.wrt_event("impact").difference_error, 0.0);
      expect_agreement(derivatives.wrt_event("impact"), resolve(moved, h),
                       "impact at " + std::to_string(impact));
    }
}

TEST(OptimumDerivatives, FollowStartAndStartTime) {
  MultipleShooting shooting(landing(0.43, at_least(-2.0), CostRule::nodes), ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  expect_agreement(derivatives.wrt_start_time(),
                   resolve(
                       [&](double d) -> MultipleShooting& {
                         shooting.start_time(d);
                         return shooting;
                       },
                       5e-3),
                   "start time");
  for (int i = 0; i < 2; ++i) {
    const OptimumDerivatives::Derivative ours = derivatives.wrt_start(i);
    EXPECT_NEAR(ours.cost, s.start_multipliers[i], 1e-7);
    expect_agreement(ours,
                     resolve(
                         [&](double d) -> MultipleShooting& {
                           Vec<double, 2> x{1.0, 0.4};
                           x[i] += d;
                           shooting.start_at(0.0, x);
                           return shooting;
                         },
                         5e-3),
                     "start " + std::to_string(i));
  }
}

TEST(OptimumDerivatives, VanishForAnEventWithoutInfluence) {
  for (const double impact : {5.0, infinity}) {
    MultipleShooting shooting(landing(impact, unbounded(), CostRule::nodes), ten);
    OptimumDerivatives derivatives(shooting, solve(shooting, *make_ipopt(tight)));
    const OptimumDerivatives::Derivative d = derivatives.wrt_event("impact");
    EXPECT_TRUE(d.reliable) << d.message;
    EXPECT_EQ(d.cost, 0.0);
    EXPECT_EQ(d.w.norm(), 0.0);
  }
}

TEST(OptimumDerivatives, AreRejectedAtANode) {
  MultipleShooting shooting(landing(0.4, unbounded(), CostRule::nodes), ten);
  OptimumDerivatives derivatives(shooting, solve(shooting, *make_ipopt(tight)));
  EXPECT_TRUE(derivatives.reliable()) << derivatives.message();
  const OptimumDerivatives::Derivative d = derivatives.wrt_event("impact");
  EXPECT_FALSE(d.reliable);
  EXPECT_NE(d.message.find("event 'impact'"), std::string::npos) << d.message;
  EXPECT_TRUE(std::isnan(d.cost));
}

TEST(OptimumDerivatives, AreRejectedAtAKink) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .track("tent", state, Vec<double, 1>{3.0}, {},
             Reference({0.0, 0.5, 1.0}, Mat<double, 1, 3>{0.0, 2.0, 0.0}));
  OptimalControlProblem ocp("tent");
  MultipleShooting shooting(ocp.start_at({0}).then(phase), ten);
  const auto by_start_time = [&] {
    OptimumDerivatives derivatives(shooting, solve(shooting, *make_ipopt(tight)));
    return derivatives.wrt_start_time();
  };
  const OptimumDerivatives::Derivative d =
      by_start_time();  // a node is at the top of the tent function
  EXPECT_FALSE(d.reliable);
  EXPECT_NE(d.message.find("kink"), std::string::npos) << d.message;
  shooting.start_time(0.013);
  EXPECT_TRUE(by_start_time().reliable);
}

// Windows by mode: every event of the schedule is a node, even without a window that names it.
TEST(OptimumDerivatives, FollowModes) {
  Phase<2, 2> phase{"motion", TwoThrusters{}, exactly(1.0)};
  phase.bound_input(1, exactly(0.0), during("before"))
      .track("state", state, Vec<double, 2>{3.0, 0.2})
      .track("effort", input, Vec<double, 2>{0.1, 0.05});
  OptimalControlProblem ocp("modes");
  Schedule schedule({"before", "after", "before"}, {{"on", 0.23}, {"off", 0.77}});
  MultipleShooting shooting(ocp.schedule(schedule).start_at({1.0, 0.4}).then(phase), ten);
  OptimumDerivatives derivatives(shooting, solve(shooting, *make_ipopt(tight)));
  for (const char* name : {"on", "off"}) {
    const double time = schedule.time_of(name);
    expect_agreement(derivatives.wrt_event(name),
                     resolve(
                         [&](double d) -> MultipleShooting& {
                           shooting.retime(name, time + d);
                           return shooting;
                         },
                         5e-3),
                     name);
  }
}

TEST(OptimumDerivatives, LeaveTheProgramUnchanged) {
  MultipleShooting shooting(landing(0.43, at_least(-2.0), CostRule::nodes), ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  OptimumDerivatives derivatives(shooting, s);
  NonlinearProgram& nlp = shooting.nlp();
  struct Picture {
    double cost = 0.0;
    VectorXd gradient, rows, lower, upper, row_lower, row_upper;
    bool operator==(const Picture&) const = default;
  };
  const auto picture = [&] {
    Picture p{0.0,         VectorXd(nlp.variables()), VectorXd(nlp.rows()), nlp.lower(),
              nlp.upper(), nlp.row_lower(),           nlp.row_upper()};
    EXPECT_TRUE(nlp.objective(s.point.w.data(), p.cost));
    EXPECT_TRUE(nlp.gradient(s.point.w.data(), p.gradient.data()));
    EXPECT_TRUE(nlp.constraints(s.point.w.data(), p.rows.data()));
    return p;
  };
  const Picture before = picture();
  derivatives.wrt_event("impact");
  derivatives.wrt_start_time();
  derivatives.wrt_start(1);
  derivatives.wrt_duration(0);
  EXPECT_TRUE(picture() == before);
  EXPECT_EQ(shooting.data().schedule.time_of("impact"), 0.43);
  EXPECT_EQ(shooting.grid().reference_duration(0), 1.0);
}

// --- phases -------------------------------------------------------------------------------------

struct Pendulum {  // x = (angle, rate), p = (damping, load)
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 2>& p) const {
    using std::sin;
    return {x[1], u[0] - (1.0 + p[1]) * sin(x[0]) - p[0] * x[1] + 0.1 * sin(3.0 * t)};
  }
};

struct Durations {
  Bounds first = exactly(1.3), second = exactly(0.9);
};

// Nonlinear, with a jump, an active constraint, and a parameter in dynamics, cost, jump and
// constraint. The bound on the input is active in the first phase.
OptimalControlProblem swing(const Durations& T, const Vec<double, 2>& p, double load_unknown) {
  const auto rate_limit = [](auto, auto x, auto, auto q) { return x[1] - 1.1 * q[0]; };
  const auto angle = [](auto, auto x) { return x[0]; };
  const auto weighted = [](auto, auto x, auto, auto q) {
    return (1.0 + q[0]) * (x[0] - 0.3) * (x[0] - 0.3);
  };
  Phase<2, 1, 2> first{"first", Pendulum{}, T.first}, second{"second", Pendulum{}, T.second};
  for (auto* phase : {&first, &second}) {
    phase->track("effort", input, Vec<double, 1>{0.4}).minimise("weighted", weighted);
    if (std::isnan(load_unknown))
      phase->data("p", p);
    else
      phase->data("damping", p.head<1>()).unknown("load", p.tail<1>(), exactly(load_unknown), 3.0);
    phase->nominal(Vec<double, 2>{2.0, 0.5}, Vec<double, 1>{1.5}).nominal_duration(0.8);
  }
  first.bound_input(0, at_most(0.8)).guess_duration(1.3);
  second.keep("rate", rate_limit, at_most(0.0))
      .guess_duration(0.9)
      .reach("angle", angle, exactly(0.9));
  OptimalControlProblem ocp("swing");
  ocp.start_at({-0.2, 0.1})
      .costs(CostRule::integrated)
      .then(first)
      .then(second, jump<2, 2>("knock", [](auto, auto x, auto, auto q) {
              return decltype(x){x[0], (0.8 - 0.1 * q[1]) * x[1]};
            }));
  return ocp;
}

// The derivatives are those of the program, so the grid may be coarse.
const ShootingOptions eight{
    .intervals_per_phase = 8, .integrator = runge_kutta4(), .accuracy = {.verify = false}};
const Vec<double, 2> load{0.5, 0.3};
// Step of the repeated solves. The same constraints stay active within it; with 5e-3 the active set
// sometimes changes.
constexpr double small = 4e-4;

// A problem that is built again for every value.
class Anew {
 public:
  template <class Make>
  explicit Anew(Make make) : make_(make) {}
  MultipleShooting& operator()(double d) {
    shooting_ = std::make_shared<MultipleShooting>(make_(d), eight);
    return *shooting_;
  }

 private:
  std::function<OptimalControlProblem(double)> make_;
  std::shared_ptr<MultipleShooting> shooting_;
};

TEST(OptimumDerivatives, FollowFixedDurationsAndData) {
  MultipleShooting shooting(swing({}, load, std::nan("")), eight);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  EXPECT_EQ(derivatives.hessian(), "exact");
  // The example must have an active bound and an active row.
  const NlpPoint& point = derivatives.point();
  EXPECT_GT(point.z.cwiseAbs().maxCoeff(), 1e-3);
  double rate = 0.0;
  for (int r = 0; r < shooting.nlp().rows(); ++r)
    if (shooting.nlp().describe_row(r).find("'rate'") != std::string::npos)
      rate = std::max(rate, point.lambda[r]);
  EXPECT_GT(rate, 1e-3);
  for (int j = 0; j < 2; ++j) {
    Anew anew([&](double d) {
      return swing(j == 0 ? Durations{exactly(1.3 + d), exactly(0.9)}
                          : Durations{exactly(1.3), exactly(0.9 + d)},
                   load, std::nan(""));
    });
    expect_agreement(derivatives.wrt_duration(j), resolve(anew, small),
                     "duration " + std::to_string(j));
  }
  for (int i = 0; i < 2; ++i)
    expect_agreement(derivatives.wrt_parameter("p", i),
                     resolve(
                         [&](double d) -> MultipleShooting& {
                           Vec<double, 2> p = load;
                           p[i] += d;
                           shooting.set_data("p", p);
                           return shooting;
                         },
                         small),
                     "parameter " + std::to_string(i));
}

// A length in other units. Small numbers do not cause kinks.
TEST(OptimumDerivatives, FollowDataOfAnyMagnitude) {
  double expected = 0.0;
  for (const double unit : {1.0, 1e-3, 1e-6}) {
    Phase<2, 1, 1> phase{
        "go",
        [](auto, auto x, auto u, auto p) {
          return decltype(x){x[1], u[0] - x[0] * x[1] * x[1] / (p[0] * p[0]) - 0.3 * x[1]};
        },
        exactly(1.7)};
    phase.data("length", Vec<double, 1>{0.7 * unit})
        .nominal(Vec<double, 2>{unit, unit}, Vec<double, 1>{unit})
        .minimise("effort", [unit](auto, auto, auto u, auto) { return u[0] * u[0] / unit / unit; })
        .reach(
            "there", [unit](auto, auto x, auto, auto) { return x[0] / unit; }, exactly(1.0));
    OptimalControlProblem ocp("go");
    MultipleShooting shooting(ocp.start_at({0.05 * unit, 0.1 * unit}).then(phase), eight);
    const Solution s = solve(shooting, *make_ipopt(tight));
    ASSERT_TRUE(s.ok()) << s.message;
    OptimumDerivatives derivatives(shooting, s);
    const OptimumDerivatives::Derivative length = derivatives.wrt_parameter("length");
    EXPECT_TRUE(length.reliable) << unit << ": " << length.message;
    if (unit == 1.0) expected = length.cost;
    EXPECT_NEAR(unit * length.cost, expected, 1e-6 * std::abs(expected)) << unit;
  }
  EXPECT_GT(std::abs(expected), 1e-3);
}

TEST(OptimumDerivatives, FollowFreeQuantities) {
  const Durations open{between(0.3, 2.0), between(0.3, 0.9)};
  MultipleShooting shooting(swing(open, load, 0.3), eight);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  const double T1 = s.durations[0], T2 = s.durations[1];
  ASSERT_GT(T1, 0.31);
  // An optimal duration in the interior: its derivative vanishes, and the derivative of the plan
  // does not.
  const OptimumDerivatives::Derivative first = derivatives.wrt_duration(0);
  EXPECT_NEAR(first.cost, 0.0, 1e-9);
  for (int j = 0; j < 2; ++j) {
    Anew anew([&](double d) {
      return swing(
          j == 0 ? Durations{exactly(T1 + d), open.second} : Durations{open.first, exactly(T2 + d)},
          load, 0.3);
    });
    Resolved resolved = resolve(anew, small);
    if (j == 0) resolved.cost = 0.0;
    expect_agreement(derivatives.wrt_duration(j), resolved, "duration " + std::to_string(j));
  }
  Anew loaded([&](double d) { return swing(open, load, 0.3 + d); });
  expect_agreement(derivatives.wrt_parameter("load"), resolve(loaded, small), "unknown load");
  Anew damped([&](double d) { return swing(open, load + Vec<double, 2>{d, 0.0}, 0.3); });
  expect_agreement(derivatives.wrt_parameter("damping"), resolve(damped, small), "data");
}

// --- published oracles --------------------------------------------------------------------------

struct Mode {  // x' = A x
  Mat<double, 2, 2> A;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {A(0, 0) * x[0] + A(0, 1) * x[1] + 0.0 * u[0], A(1, 0) * x[0] + A(1, 1) * x[1]};
  }
};

// Egerstedt, Wardi and Axelsson, IEEE TAC 51, 2006: x'x integrated over a switched linear system.
// With costate p, dJ/dtau = p(tau)'(A1 - A2) x(tau).
TEST(OptimumDerivatives, MatchTheHamiltonianAtASwitchingTime) {
  const Mat<double, 2, 2> A1{{-1.0, 0.0}, {1.0, 2.0}}, A2{{1.0, 1.0}, {1.0, -2.0}};
  const auto square = [](auto, auto x) { return x.squaredNorm(); };
  Phase<2, 1> first{"first", Mode{A1}, exactly(0.5)}, second{"second", Mode{A2}, exactly(0.5)};
  for (auto* phase : {&first, &second})
    phase->minimise("square", square).bound_input(0, exactly(0.0));
  OptimalControlProblem ocp("switched");
  ocp.start_at({1, 1}).costs(CostRule::integrated).then(first).then(second);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = zero_order_hold()});
  const Solution s = solve(shooting, *make_ipopt(tight));
  EXPECT_NEAR(s.cost, 7.0335958076682, 1e-12);
  OptimumDerivatives derivatives(shooting, s);
  const double slope = derivatives.wrt_duration(0).cost - derivatives.wrt_duration(1).cost;
  EXPECT_NEAR(slope, 15.9805362377523, 1e-9);
}

// --- unreliable derivatives ---------------------------------------------------------------------

OptimalControlProblem drive(Bounds last, double effort, const std::vector<Bounds>& ends) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("state", state, Vec<double, 1>{1.0});
  if (effort > 0.0) phase.track("effort", input, Vec<double, 1>{effort});
  phase.bound_input(0, last);
  for (const Bounds& b : ends) phase.reach("end " + std::to_string(b.lower), state, b);
  OptimalControlProblem ocp("drive");
  ocp.start_at({1}).then(phase);
  return ocp;
}

std::string why_not(const OptimalControlProblem& ocp) {
  MultipleShooting shooting(ocp, ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  EXPECT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  const OptimumDerivatives::Derivative d = derivatives.wrt_start(0);
  EXPECT_FALSE(d.reliable);
  return d.message;
}

// Presolve keeps one of two equal constraints, so no dependent rows remain.
TEST(OptimumDerivatives, DuplicateConstraintsCountOnce) {
  MultipleShooting shooting(drive(unbounded(), 1.0, {exactly(0.3), at_most(0.3)}), ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_TRUE(OptimumDerivatives(shooting, s).wrt_start(0).reliable);
}

TEST(OptimumDerivatives, NameUndeterminedQuantities) {
  // With costs summed at the nodes, the last input changes only the end, which has no cost.
  OptimalControlProblem ocp = drive(between(-9.0, 9.0), 0.0, {});
  const std::string message = why_not(ocp.costs(CostRule::nodes));
  EXPECT_NE(message.find("interval 9, input"), std::string::npos) << message;
}

TEST(OptimumDerivatives, NameAnActiveBoundWithoutMultiplier) {
  // The end that the optimum reaches without a constraint, used as a limit.
  MultipleShooting free(drive(unbounded(), 1.0, {}), ten);
  const Solution s = solve(free, *make_ipopt(tight));
  const double end = s.trajectory.state_before(1.0)[0];
  const std::string message = why_not(drive(unbounded(), 1.0, {at_most(end)}));
  EXPECT_NE(message.find("has no multiplier"), std::string::npos) << message;
  EXPECT_NE(message.find("term 'end"), std::string::npos) << message;
}

struct Cart {  // x = (position, speed)
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.2 * x[0] * x[1]};
  }
};

// The first duration is at its bound, and the limit of the total time determines the second.
TEST(OptimumDerivatives, RejectADurationDeterminedByRows) {
  Phase<2, 1> a{"a", Cart{}, between(0.3, 0.5)}, b{"b", Cart{}, between(0.3, 3.0)};
  for (auto* phase : {&a, &b})
    phase->guess_duration(0.4)
        .bound_input(0, between(-9.0, 9.0))
        .track("effort", input, Vec<double, 1>{1.0});
  a.reach(
      "gate", [](auto, auto x) { return x[0]; }, exactly(0.3));
  b.reach("there", state, {exactly(1.0), exactly(0.0)});
  OptimalControlProblem ocp("two");
  ocp.start_at({0, 0}).then(a).then(b).total_time(at_most(1.5));
  MultipleShooting shooting(ocp, ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  ASSERT_NEAR(s.durations[0], 0.5, 1e-8);
  ASSERT_NEAR(s.durations[1], 1.0, 1e-8);
  OptimumDerivatives derivatives(shooting, s);
  const OptimumDerivatives::Derivative second = derivatives.wrt_duration(1);
  EXPECT_FALSE(second.reliable);
  EXPECT_NE(second.message.find("cannot change"), std::string::npos) << second.message;
  EXPECT_TRUE(std::isnan(second.cost));
  EXPECT_TRUE(second.w.array().isNaN().all());
}

TEST(OptimumDerivatives, RejectAnUnknownDeterminedByRows) {
  Phase<1, 1, 1> phase{"motion", [](auto, auto x, auto u, auto) { return decltype(x){u[0]}; },
                       exactly(1.0)};
  phase.unknown("place", Vec<double, 1>{0.3}, between(-9.0, 9.0))
      .track(
          "effort", [](auto, auto, auto u, auto) { return u; }, Vec<double, 1>{1.0})
      .reach(
          "there", [](auto, auto x, auto, auto p) { return x[0] - p[0]; }, exactly(0.0))
      .reach(
          "sum", [](auto, auto x, auto, auto p) { return p[0] + 0.1 * x[0]; }, exactly(0.7));
  OptimalControlProblem ocp("decided");
  MultipleShooting shooting(ocp.start_at({0}).then(phase), ten);
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  const OptimumDerivatives::Derivative place = derivatives.wrt_parameter("place");
  EXPECT_FALSE(place.reliable);
  EXPECT_NE(place.message.find("cannot change"), std::string::npos) << place.message;
  EXPECT_TRUE(std::isnan(place.cost));
}

TEST(OptimumDerivatives, RejectANonOptimalPoint) {
  MultipleShooting shooting(swing({}, load, std::nan("")), eight);
  Solution s = solve(shooting, *make_ipopt(tight));
  s.point.w.setZero();
  s.point.lambda.setZero();
  s.point.z.setZero();
  OptimumDerivatives derivatives(shooting, s);
  EXPECT_FALSE(derivatives.reliable());
  s.point.w.resize(3);
  EXPECT_THROW(OptimumDerivatives(shooting, s), DefinitionError);
}

TEST(OptimumDerivatives, RejectMissingQuantities) {
  MultipleShooting shooting(swing({}, load, std::nan("")), eight);
  OptimumDerivatives derivatives(shooting, solve(shooting, *make_ipopt(tight)));
  EXPECT_THROW(derivatives.wrt_event("impact"), DefinitionError);
  EXPECT_THROW(derivatives.wrt_duration(2), DefinitionError);
  EXPECT_THROW(derivatives.wrt_parameter("q"), DefinitionError);
  EXPECT_THROW(derivatives.wrt_parameter("p", 2), DefinitionError);
  EXPECT_THROW(derivatives.wrt_start(2), DefinitionError);
}

}  // namespace
}  // namespace saltus
