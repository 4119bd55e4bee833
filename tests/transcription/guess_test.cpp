// Initial guesses: constant, interpolated, simulated, and none. Also guesses from another solution.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/solver/ipopt.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

struct Decay {  // x' = -x + u
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return u - x;
  }
};

double guessed_state(const MultipleShooting& shooting, int phase, int node) {
  return shooting.initial_guess().w[shooting.layout().state(phase, node)] *
         shooting.problem().phases()[phase].nominal_state[0];
}

MultipleShooting with_guess(Guess state_guess, Guess input_guess = {}) {
  Phase<1, 1> phase{"decay", Decay{}, exactly(1.0)};
  phase.guess_state(std::move(state_guess))
      .guess_input(std::move(input_guess))
      .nominal(Vec<double, 1>{5.0}, Vec<double, 1>{2.0});
  OptimalControlProblem ocp("guess");
  ocp.start_at({3}).then(phase);
  return MultipleShooting(ocp, ten);
}

TEST(Guess, DefaultIsTheStartAndZeroInput) {
  const MultipleShooting shooting = with_guess({});
  for (int k = 0; k <= 10; ++k) EXPECT_NEAR(guessed_state(shooting, 0, k), 3.0, 1e-15);
  EXPECT_EQ(shooting.initial_guess().w[shooting.layout().input(0, 4)], 0.0);
}

TEST(Guess, ConstantIsTheSameAtEveryNode) {
  const MultipleShooting shooting =
      with_guess(Guess::constant(Vec<double, 1>{7.0}), Guess::constant(Vec<double, 1>{-1.0}));
  for (int k = 0; k <= 10; ++k) EXPECT_NEAR(guessed_state(shooting, 0, k), 7.0, 1e-14);
  EXPECT_NEAR(shooting.initial_guess().w[shooting.layout().input(0, 4)], -0.5, 1e-15);
}

TEST(Guess, InterpolatedIsLinearOverThePhase) {
  const MultipleShooting shooting =
      with_guess(Guess::interpolate(Vec<double, 1>{3.0}, Vec<double, 1>{-1.0}));
  for (int k = 0; k <= 10; ++k) EXPECT_NEAR(guessed_state(shooting, 0, k), 3.0 - 0.4 * k, 1e-14);
}

TEST(Guess, SimulatedHasNoGaps) {
  MultipleShooting shooting = with_guess(Guess::simulate(), Guess::constant(Vec<double, 1>{1.0}));
  // x(t) = 1 + 2 exp(-t); steps of 0.1 of order four
  for (int k = 0; k <= 10; ++k)
    EXPECT_NEAR(guessed_state(shooting, 0, k), 1.0 + 2.0 * std::exp(-0.1 * k), 1e-6);
  VectorXd g(shooting.nlp().rows());
  ASSERT_TRUE(shooting.nlp().constraints(shooting.initial_guess().w.data(), g.data()));
  for (int r = 0; r < g.size(); ++r)
    EXPECT_LE(std::abs(g[r] - std::clamp(g[r], shooting.nlp().row_lower()[r],
                                         shooting.nlp().row_upper()[r])),
              1e-14);
}

TEST(Guess, SimulatedGoesThroughJumps) {
  Phase<1, 1> first{"first", Decay{}, exactly(1.0)}, next{"next", Decay{}, exactly(1.0)};
  first.guess_state(Guess::simulate());
  next.guess_state(Guess::simulate());
  OptimalControlProblem ocp("guess");
  ocp.start_at({2}).then(first).then(
      next, jump<1>("kick", [](const auto&, const auto& x) { return x[0] + 10.0; }));
  const MultipleShooting shooting(ocp, ten);
  EXPECT_NEAR(guessed_state(shooting, 1, 0), 2.0 * std::exp(-1.0) + 10.0, 1e-5);
}

TEST(Guess, RespectsInputBounds) {
  for (const double sign : {1.0, -1.0}) {
    Phase<1, 1> phase{"decay", Decay{}, exactly(1.0)};
    phase.guess_input(Guess::constant(Vec<double, 1>{9.0 * sign}))
        .bound_input(0, between(-1.0, 1.0))
        .bound_input(0, exactly(0.0), Window{.to = 0.5});
    OptimalControlProblem ocp("guess");
    ocp.start_at({3}).then(phase);
    const MultipleShooting shooting(ocp, ten);
    EXPECT_EQ(shooting.initial_guess().w[shooting.layout().input(0, 0)], 0.0);
    EXPECT_EQ(shooting.initial_guess().w[shooting.layout().input(0, 9)], sign);
  }
}

OptimalControlProblem bouncing() {
  Phase<1, 1> first{"down", Velocity{}, exactly(0.5)}, next{"up", Velocity{}, exactly(0.5)};
  for (auto* phase : {&first, &next})
    phase->track("effort", input, Vec<double, 1>{1.0}).track("state", state, Vec<double, 1>{1.0});
  next.reach("end", state, exactly(1.0));
  OptimalControlProblem ocp("bounce");
  ocp.start_at({1}).then(first).then(
      next, jump<1>("flip", [](const auto&, const auto& x) { return -0.5 * x[0]; }));
  return ocp;
}

TEST(GuessFromTrajectory, ReproducesTheSolutionOfTheSameProblem) {
  MultipleShooting shooting(bouncing(), ten);
  const Solution solution = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(solution.ok()) << solution.message;
  const NlpPoint guess = shooting.guess_from(solution.trajectory);
  // The end of the first phase contains x-, and the start of the second contains x+.
  EXPECT_LT((guess.w - solution.point.w).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(GuessFromTrajectory, KeepsDurationsAndUnknowns) {
  Phase<1, 1, 1> first{"first", Decay{}, between(0.2, 3.0)}, next{"next", Decay{}, exactly(0.5)};
  for (auto* phase : {&first, &next})
    phase->unknown("target", Vec<double, 1>{0.0}, between(-4.0, 4.0), 2.0)
        .track("effort", input, Vec<double, 1>{1.0});
  const auto off_target = [](const auto&, const auto& x, const auto&, const auto& p) {
    return x[0] - p[0];
  };
  first.reach("target", off_target, exactly(0.0))
      .minimise_at_end("late", [](const auto& t, const auto& x) {
        return (t - 1.3) * (t - 1.3) + (x[0] - 1.5) * (x[0] - 1.5);
      });
  OptimalControlProblem ocp("free");
  ocp.start_at({1}).then(first).then(
      next, jump<1, 1>("drop", [](const auto&, const auto& x) { return x[0] - 1.0; }));
  MultipleShooting shooting(ocp, ten);
  const Solution solution = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(solution.ok()) << solution.message;
  EXPECT_GT(std::abs(solution.durations[0] - 1.6), 0.05);  // the optimum differs from the guess
  const NlpPoint guess = shooting.guess_from(solution.trajectory);
  EXPECT_LT((guess.w - solution.point.w).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Guess, RejectsOtherSizesAndNumbersInsideThePhase) {
  const auto at_the_middle = [](VectorXd value) {
    return Guess::trajectory([value](double fraction) {
      return fraction > 0.3 && fraction < 0.7 ? value : VectorXd(VectorXd::Zero(1));
    });
  };
  for (const VectorXd& value :
       {VectorXd(), VectorXd(VectorXd::Zero(2)), VectorXd(VectorXd::Constant(1, std::nan("")))}) {
    expect_error<DefinitionError>([&] { with_guess(at_the_middle(value)).initial_guess(); },
                                  {"phase 'decay'", "guess of the state", "fraction"});
    expect_error<DefinitionError>([&] { with_guess({}, at_the_middle(value)).initial_guess(); },
                                  {"phase 'decay'", "guess of the input", "fraction"});
  }
  expect_error<DefinitionError>([] { Guess::trajectory({}); }, {"guess", "empty"});
  expect_error<DefinitionError>([] { with_guess(Guess::constant(VectorXd())); },
                                {"phase 'decay'", "0 entries, expected 1"});
}

TEST(GuessFromTrajectory, RejectsAnEmptyOneAndOtherSizes) {
  MultipleShooting shooting(bouncing(), ten);
  expect_error<DefinitionError>([&] { shooting.guess_from(Trajectory()); },
                                {"problem 'bounce'", "empty trajectory"});
  for (const char* name : {"down", "other"}) {
    Phase<2, 1> cart{name, Cart{}, exactly(1.0)};
    cart.track("effort", input, Vec<double, 1>{1.0});
    OptimalControlProblem other("cart");
    other.start_at({0, 0}).then(cart);
    MultipleShooting of_cart(other, ten);
    const Trajectory guess = of_cart.trajectory(of_cart.initial_guess().w);
    expect_error<DefinitionError>([&] { shooting.guess_from(guess); },
                                  {"problem 'bounce'", "2 states"});
  }
  const auto solver = make_ipopt();
  expect_error<DefinitionError>([&] { solve(shooting, *solver, NlpPoint{}); },
                                {"problem 'bounce'", "0 values"});
  NlpPoint guess = shooting.initial_guess();
  guess.w[shooting.layout().state(1, 3)] = std::nan("");
  expect_error<DefinitionError>([&] { solve(shooting, *solver, guess); },
                                {"problem 'bounce'", "phase 'up', node 3, state 0"});
}

TEST(GuessFromTrajectory, HoldsTheLastStateBeyondItsEnd) {
  MultipleShooting shooting(bouncing(), ten);
  const Solution solution = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  shooting.start_at(0.2, Vec<double, 1>{1.0});
  const NlpPoint guess = shooting.guess_from(solution.trajectory);
  EXPECT_NEAR(guess.w[shooting.layout().state(1, 10)], solution.trajectory.final_state()[0], 1e-9);
  EXPECT_NEAR(guess.w[shooting.layout().state(0, 1)], solution.trajectory.state(0.25)[0], 1e-9);
}

}  // namespace
}  // namespace saltus
