// Threads that plan at the same time share the formulas of one problem and nothing else.
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return {x[1], u[0] - p[0] * sin(x[0])};
  }
};

// A pendulum swung up through an event, with everything that owns scratch memory when transcribed:
// residuals, costs in an interval of unknown length, input changes, soft rows, parameters.
OptimalControlProblem swing_up() {
  const auto error = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0] - 3.0, x[1]};
  };
  const auto rate = [](const auto&, const auto& x) { return x[1]; };
  const auto power = [](const auto&, const auto& x, const auto& u) {
    return 1e-2 * u[0] * u[0] * (1.0 + x[1] * x[1]);
  };
  Phase<2, 1, 1> first{"first", Pendulum{}, between(0.3, 2.0)};
  first.data("gravity", Vec<double, 1>{3.0})
      .bound_input(0, between(-2.0, 2.0))
      .minimise("power", power)
      .keep("slow", rate, at_most(1.5), Window{}, soft("slow", 5.0))
      .track_at_end("half way", error, Vec<double, 2>{0.1, 0.1});
  Phase<2, 1, 1> second{"second", Pendulum{}, exactly(1.5)};
  second.data("gravity", Vec<double, 1>{3.0})
      .bound_input(0, between(-4.0, 4.0))
      .minimise("power", power)
      .track("upright", error, Vec<double, 2>{1.0, 0.1})
      .keep("slow", rate, at_most(2.0), Window{}, soft("slow", 5.0, Penalty::L2));
  OptimalControlProblem problem("swing up");
  problem.start_at({0.0, 0.0}).then(first).then(second);
  return problem;
}

Solution plan(const OptimalControlProblem& problem, const IntegratorChoice& scheme, bool by_stages,
              double gravity) {
  MultipleShooting shooting{problem, {.intervals_per_phase = 12, .integrator = scheme}};
  shooting.set_data("gravity", Vec<double, 1>{gravity});
  const auto solver = by_stages ? make_sqp({.qp = riccati_qp()}) : make_sqp();
  return solve(shooting, *solver);
}

TEST(Threads, PlansMadeAtTheSameTimeAreThoseMadeOneAfterTheOther) {
  const OptimalControlProblem problem = swing_up();
  const IntegratorChoice scheme = runge_kutta4({.steps = 2});
  constexpr int count = 6;
  const auto plan_of = [&](int i) { return plan(problem, scheme, i % 2 == 0, 2.0 + 0.2 * i); };
  std::vector<Solution> alone, together(count);
  for (int i = 0; i < count; ++i) alone.push_back(plan_of(i));
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < count; ++i) threads.emplace_back([&, i] { together[i] = plan_of(i); });
  }
  for (int i = 0; i < count; ++i) {
    EXPECT_TRUE(alone[i].ok()) << alone[i].message;
    EXPECT_EQ(alone[i].iterations, together[i].iterations);
    EXPECT_EQ(alone[i].point.w, together[i].point.w);
    EXPECT_EQ(alone[i].point.lambda, together[i].point.lambda);
  }
}

}  // namespace
}  // namespace saltus
