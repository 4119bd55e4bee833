// Named multipliers are derivatives of the optimal cost. The test compares each with solves for a
// moved bound. The problem has two phases, a jump, nominal magnitudes and a free duration.
#include "saltus/transcription/multipliers.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Cart {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.1 * x[1] * x[1]};
  }
};

// The bounds that the test moves.
struct Moved {
  double start = 0.0, speed_limit = 1.2, push = 1.5, softly = 1.8, end = 1.6, work = 0.3,
         total = 2.0;
};

Solution solve_with(const Moved& m) {
  const auto speed = [](const auto&, const auto& x) { return x[1]; };
  const auto place = [](const auto&, const auto& x) { return x[0]; };
  const auto effort = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
  Phase<2, 1> first{"first", Cart{}, between(0.2, 3.0)},
      second{"second", Cart{}, between(0.2, 3.0)};
  for (auto* phase : {&first, &second})
    phase->minimise("effort", effort)
        .guess_duration(1.0)
        .nominal(Vec<double, 2>{2.0, 0.5}, Vec<double, 1>{4.0});
  first.keep("limit", speed, at_most(m.speed_limit))
      .bound_input(0, at_most(m.push))
      .reach("middle", place, at_least(m.softly), soft("middle", 0.7, Penalty::L2));
  second.bound_state(1, at_least(-0.9))
      .reach("there", [](const auto&, const auto& x) { return x; }, {exactly(m.end), exactly(-0.2)})
      .bound_integral("work", effort, at_most(m.work), 3.0);
  OptimalControlProblem problem("cart");
  problem.start_at({m.start, 0.0})
      .then(first)
      .then(second, jump<2>("half",
                            [](const auto&, const auto& x) {
                              return std::decay_t<decltype(x)>{x[0] + 0.1, 0.5 * x[1]};
                            }))
      .total_time(exactly(m.total));
  MultipleShooting shooting(problem,
                            {.intervals_per_phase = 8, .integrator = runge_kutta4({.steps = 2})});
  return solve(shooting, *make_native_solver({.tolerance = 1e-10}));
}

TEST(Multipliers, AreDerivativesOfTheOptimalCost) {
  const Solution plan = solve_with({});
  ASSERT_TRUE(plan.ok()) << plan.message;
  std::map<std::pair<std::string, std::string>, double> total;  // of row 0, over time
  for (const Solution::Multiplier& m : plan.multipliers) {
    EXPECT_EQ(m.times.size(), m.values.size());
    EXPECT_TRUE(std::is_sorted(m.times.begin(), m.times.end())) << m.term;
    if (m.row == 0)
      total[{m.phase, m.term}] = std::accumulate(m.values.begin(), m.values.end(), 0.0);
  }
  const auto compare = [&](const char* phase, const char* term, double Moved::*bound) {
    constexpr double step = 1e-4;
    Moved less, more;
    less.*bound -= step;
    more.*bound += step;
    const double slope = (solve_with(more).cost - solve_with(less).cost) / (2.0 * step);
    ASSERT_TRUE(total.contains({phase, term})) << phase << ", " << term;
    EXPECT_NEAR((total[{phase, term}]), slope, 1e-5 * (1.0 + std::abs(slope))) << term;
    EXPECT_GT(std::abs(slope), 1e-3) << term << " is not active: the comparison shows nothing";
  };
  compare("first", "limit", &Moved::speed_limit);
  compare("first", "bounds of input 0", &Moved::push);
  compare("first", "middle", &Moved::softly);
  compare("second", "there", &Moved::end);
  compare("second", "work", &Moved::work);
  compare("", "total time", &Moved::total);
  // The first costate is the derivative with respect to the start. The costate of x[0] is constant
  // along the plan, because neither dynamics nor costs depend on x[0].
  for (const Solution::Multiplier& m : plan.multipliers)
    if (m.term == Solution::Multiplier::costate && m.row == 0) {
      EXPECT_NEAR(m.values.front(), m.values.back(), 1e-6);
      if (m.phase == "first") {
        EXPECT_NEAR(m.values.front(), plan.start_multipliers[0], 1e-12);
      }
    }
}

TEST(Multipliers, NeedAPointWithMultipliers) {
  Phase<2, 1> phase{"only", Cart{}, exactly(1.0)};
  OptimalControlProblem problem("cart");
  problem.start_at({0.0, 0.0}).then(phase);
  MultipleShooting shooting(problem, {.intervals_per_phase = 2, .integrator = runge_kutta4()});
  EXPECT_TRUE(multipliers_of(shooting.program(), shooting.initial_guess()).empty());
}

}  // namespace
}  // namespace saltus
