// Parameters as data or unknowns, references that vary with time, and multipliers of the start.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;

struct Drift {  // x' = u + p
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return u + p;
  }
};

// Two phases of one second share the drift p. The drift has no cost, so it replaces the input as
// far as possible: from 0 to 6 in two seconds with p at most `limit`.
OptimalControlProblem shared_drift(Bounds first_bounds, Bounds second_bounds, double magnitude) {
  Phase<1, 1, 1> first{"first", Drift{}, exactly(1.0)}, second{"second", Drift{}, exactly(1.0)};
  first.unknown("drift", Vec<double, 1>{0.5}, first_bounds, magnitude);
  second.unknown("drift", Vec<double, 1>{0.5}, second_bounds, magnitude)
      .reach("end", state, exactly(6.0));
  for (auto* phase : {&first, &second}) phase->track("effort", input, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("shared");
  ocp.start_at({0}).then(first).then(second);
  return ocp;
}

TEST(Unknown, IsOneVariableIfTwoPhasesShareIt) {
  for (const double magnitude : {1.0, 40.0}) {
    MultipleShooting shooting(shared_drift(unbounded(), unbounded(), magnitude), ten);
    EXPECT_EQ(shooting.layout().parameter(0, 0), shooting.layout().parameter(1, 0));
    const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.trajectory.phases()[0].parameters[0], 3.0, 1e-7);
    EXPECT_NEAR(s.trajectory.phases()[1].parameters[0], 3.0, 1e-7);
    EXPECT_NEAR(s.cost, 0.0, 1e-9);
  }
}

TEST(Unknown, ObeysTheBoundsOfAllPhasesThatShareIt) {
  // u = (6 - 2 p) / 2 in both seconds. The first phase requires p <= 2, the second p >= 1.
  MultipleShooting shooting(shared_drift(at_most(2.0), at_least(1.0), 4.0), ten);
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.trajectory.phases()[1].parameters[0], 2.0, 1e-6);
  EXPECT_NEAR(s.cost, 1.0, 1e-6);
}

TEST(Unknown, RejectsContradictoryBounds) {
  expect_error<DefinitionError>(
      [] { MultipleShooting shooting(shared_drift(at_most(1.0), at_least(2.0), 1.0), ten); },
      {"parameter 'drift'"});
}

TEST(Unknown, DerivativesAreExact) {
  MultipleShooting shooting(shared_drift(unbounded(), unbounded(), 40.0), ten);
  const auto errors =
      derivative_errors(shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, 2));
  EXPECT_LT(errors.jacobian, 1e-8);
  EXPECT_LT(errors.hessian, 1e-8);
}

TEST(Data, IsSetByNameAndMovesTheSolution) {
  Phase<1, 1, 1> phase{"motion", Drift{}, exactly(1.0)};
  phase.data("drift", Vec<double, 1>{0.0})
      .track("effort", input, Vec<double, 1>{1.0})
      .reach("end", state, exactly(2.0));
  OptimalControlProblem ocp("data");
  MultipleShooting shooting(ocp.start_at({0}).then(phase), ten);
  const auto solver = make_ipopt({.tolerance = 1e-10});
  for (const double drift : {0.0, 0.5, 3.0}) {
    shooting.set_data("drift", Vec<double, 1>{drift});
    const Solution s = solve(shooting, *solver);
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.trajectory.input(0.5)[0], 2.0 - drift, 1e-8);
    EXPECT_NEAR(s.cost, 0.5 * (2.0 - drift) * (2.0 - drift), 1e-8);
  }
  EXPECT_THROW(shooting.set_data("drift", Vec<double, 2>{1.0, 2.0}), DefinitionError);
  EXPECT_THROW(shooting.set_data("drift", Vec<double, 1>{std::nan("")}), DefinitionError);
  expect_error<DefinitionError>([&] { shooting.set_data("drfit", Vec<double, 1>{1.0}); },
                                {"did you mean 'drift'"});
}

// --- named entries ------------------------------------------------------------------------------

template <class S>
struct Wind {
  S gust = 0.0;
  Vec<S, 2> breeze = Vec<S, 2>::Zero();
  Mat<S, 2, 2> table = Mat<S, 2, 2>::Zero();

  using Entries = ParameterEntries<&Wind::gust, &Wind::breeze, &Wind::table>;
};
template <class S>
struct Tide {
  S height = 0.0;
  Vec<S, 6> rest = Vec<S, 6>::Zero();
  using Entries = ParameterEntries<&Tide::height, &Tide::rest>;
};

// x' = u + gust + table(0, 1), from 0 to 2 in one second with minimum u.
MultipleShooting in_the_wind() {
  Phase<1, 1, size_of<Wind>> phase{"motion",
                                   [](const auto&, const auto&, const auto& u, const auto& p) {
                                     const auto wind = view_as<Wind>(p);
                                     return (u[0] + wind.gust + wind.table(0, 1));
                                   },
                                   exactly(1.0)};
  phase.data("wind", Wind<double>{})
      .track("effort", input, Vec<double, 1>{1.0})
      .reach("end", state, exactly(2.0));
  OptimalControlProblem ocp("windy");
  return MultipleShooting(ocp.start_at({0}).then(phase), ten);
}

double least_input(MultipleShooting& shooting) {
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  EXPECT_TRUE(s.ok()) << s.message;
  return s.trajectory.input(0.5)[0];
}

TEST(NamedData, IsSetAsAWholeAndByEntry) {
  MultipleShooting shooting = in_the_wind();
  EXPECT_NEAR(least_input(shooting), 2.0, 1e-8);
  shooting.set_data("wind", Wind<double>{.gust = 0.5});
  EXPECT_NEAR(least_input(shooting), 1.5, 1e-8);
  shooting.set_data("wind.table", Mat<double, 2, 2>{{0.0, 0.25}, {7.0, 9.0}});
  EXPECT_NEAR(least_input(shooting), 1.25, 1e-8);
  shooting.set_data("wind.gust", 1.0);
  EXPECT_NEAR(least_input(shooting), 0.75, 1e-8);
  shooting.set_data("wind.breeze", Vec<double, 2>{5.0, 6.0});  // no formula uses it
  EXPECT_NEAR(least_input(shooting), 0.75, 1e-8);
  const Solution s = solve(shooting, *make_ipopt());
  const auto wind = view_as<Wind>(s.trajectory.phases()[0].parameters);
  EXPECT_EQ(wind.gust, 1.0);
  EXPECT_EQ(wind.breeze[1], 6.0);
  EXPECT_EQ(wind.table(1, 0), 7.0);
}

TEST(NamedData, DoesNotAllocate) {
  MultipleShooting shooting = in_the_wind();
  Wind<double> wind;
  const testing::AllocationCount count;
  for (int i = 0; i < 10; ++i) {
    wind.gust = i;
    shooting.set_data("wind", wind);
    shooting.set_data("wind.gust", 2.0);
    shooting.set_data("wind.breeze", wind.breeze);
    shooting.set_data("wind.table", wind.table);
  }
  EXPECT_EQ(count.made(), 0);
}

TEST(NamedData, WrongNamesAndSizesListTheData) {
  MultipleShooting shooting = in_the_wind();
  const auto complaint = [&](auto&& name, auto&& value) {
    return error_of<DefinitionError>([&] { shooting.set_data(name, value); }, "accepted");
  };
  EXPECT_EQ(complaint("wind.gsut", 1.0),
            "parameter 'wind' has no entry 'gsut', it has gust, breeze and table; did you mean "
            "'gust'?");
  EXPECT_EQ(complaint("wimd", Wind<double>{}),
            "problem 'windy' has no data parameter 'wimd', it has wind; did you mean 'wind'?");
  EXPECT_EQ(complaint("wind.breeze", 1.0),
            "parameter 'wind.breeze' has 2 entries, but 1 were given");
  EXPECT_EQ(complaint("wind", Tide<double>{}),
            "parameter 'wind' has the entries gust, breeze and table, but height and rest were "
            "given");
  EXPECT_EQ(complaint("wind.gust", std::nan("")), "parameter 'wind.gust': entry 0 is nan");
}

TEST(NamedUnknown, IsAccessibleByName) {
  // u has no cost within its bounds, and the gust supplies the remainder.
  Phase<1, 1, size_of<Wind>> phase{"motion",
                                   [](const auto&, const auto&, const auto& u, const auto& p) {
                                     return (u[0] + view_as<Wind>(p).gust);
                                   },
                                   exactly(1.0)};
  phase.unknown("wind", Wind<double>{.gust = 0.5}, between(-3.0, 3.0))
      .track("effort", input, Vec<double, 1>{1.0})
      .track(
          "still air",
          [](const auto&, const auto&, const auto&, const auto& p) {
            const auto wind = view_as<Wind>(p);
            Vec<std::decay_t<decltype(wind.gust)>, 6> all;
            all << wind.breeze, wind.table.row(0).transpose(), wind.table.row(1).transpose();
            return all;
          },
          VectorXd::Ones(6))
      .reach("end", state, exactly(2.0));
  OptimalControlProblem ocp("windy");
  MultipleShooting shooting(ocp.start_at({0}).then(phase), ten);
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(view_as<Wind>(s.trajectory.phases()[0].parameters).gust, 2.0, 1e-6);
  EXPECT_THROW(shooting.set_data("wind.gust", 1.0), DefinitionError);
}

// --- references
// -------------------------------------------------------------------------------------

TEST(Reference, VaryingReferenceIsTracked) {
  // min 1/2 (u - r)^2 with r a tent function and no other cost. u is the mean of r over the
  // interval, or r at its start if the cost is summed at the nodes.
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  const Reference tent({0.0, 0.5, 1.0}, Mat<double, 1, 3>{0.0, 2.0, 0.0});
  phase.track("tent", input, Vec<double, 1>{1.0}, {}, tent);
  OptimalControlProblem ocp("reference");
  ocp.start_at({0}).then(phase);
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    MultipleShooting shooting(ocp.costs(rule), ten);
    const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
    ASSERT_TRUE(s.ok()) << s.message;
    const double later = rule == CostRule::nodes ? 0.0 : 0.5;  // intervals
    for (int k = 0; k < 10; ++k)
      EXPECT_NEAR(s.trajectory.input(0.1 * k + 0.05)[0], 2.0 - std::abs(0.4 * (k + later) - 2.0),
                  1e-8)
          << k;
  }
}

TEST(Reference, IsAFunctionOfAbsoluteTime) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("ramp", input, Vec<double, 1>{1.0}, {},
              Reference({0.0, 10.0}, Mat<double, 1, 2>{0.0, 10.0}));
  OptimalControlProblem ocp("reference");
  MultipleShooting shooting(ocp.start_at({0}).then(phase), ten);
  shooting.start_at(4.0, Vec<double, 1>{0.0});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.trajectory.input(4.31)[0], 4.35, 1e-8);  // the mean over the interval
}

TEST(Reference, VaryingReferenceHasExactDerivativesWithFreeTime) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    Phase<1, 1> phase{"motion", Velocity{}, between(0.5, 2.0)};
    phase.guess_duration(1.0).track(
        "ramp", [](const auto&, const auto& x) { return x[0] * x[0]; }, Vec<double, 1>{1.0}, {},
        Reference({0.0, 10.0}, Mat<double, 1, 2>{0.0, 7.0}));
    OptimalControlProblem ocp("reference");
    ocp.start_at({1}).then(phase).costs(rule);
    MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
    const auto errors = derivative_errors(
        shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, 4, 0.2));
    EXPECT_LT(errors.gradient, 1e-8);
    EXPECT_LT(errors.hessian, 1e-8);
  }
}

// --- the start
// --------------------------------------------------------------------------------------

TEST(StartMultipliers, AreTheSlopeOfTheOptimalCost) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.track("effort", input, Vec<double, 1>{1.0})
      .track("state", state, Vec<double, 1>{3.0})
      .nominal(Vec<double, 1>{4.0}, Vec<double, 1>{2.0});
  OptimalControlProblem ocp("slope");
  MultipleShooting shooting(ocp.start_at({1}).then(phase), ten);
  const auto solver = make_ipopt({.tolerance = 1e-10});
  const auto cost = [&](double x) {
    shooting.start_at(0.0, Vec<double, 1>{x});
    return solve(shooting, *solver);
  };
  const double slope = (cost(1.01).cost - cost(0.99).cost) / 0.02;  // exact for a quadratic
  EXPECT_NEAR(cost(1.0).start_multipliers[0], slope, 1e-6);
}

}  // namespace
}  // namespace saltus
