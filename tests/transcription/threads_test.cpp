// Threads that plan at the same time share the formulas of one problem and nothing else; threads
// that evaluate one program leave no trace in its numbers.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/core/thread_pool.hpp"
#include "saltus/integrators/cvodes.hpp"
#include "saltus/integrators/implicit_runge_kutta.hpp"
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

// Everything that a solver can ask of a program.
struct Evaluation {
  double cost = 0.0;
  VectorXd gradient, rows, jacobian, hessian;
};
Evaluation evaluate(NonlinearProgram& p, const VectorXd& w, const VectorXd& lambda, bool prepare) {
  Evaluation e{0.0, VectorXd(p.variables()), VectorXd(p.rows()),
               VectorXd(p.jacobian_pattern().entries()), VectorXd(p.hessian_pattern().entries())};
  if (prepare) p.prepare_derivatives(w.data(), 1.0, lambda.data(), Curvature::exact);
  EXPECT_TRUE(p.objective(w.data(), e.cost) && p.gradient(w.data(), e.gradient.data()) &&
              p.constraints(w.data(), e.rows.data()) && p.jacobian(w.data(), e.jacobian.data()));
  if (p.supports(Curvature::exact)) {
    EXPECT_TRUE(p.hessian(w.data(), 1.0, lambda.data(), e.hessian.data(), Curvature::exact));
  } else {
    e.hessian.setZero();
  }
  return e;
}

void expect_same(const Evaluation& a, const Evaluation& b) {
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.jacobian, b.jacobian);
  EXPECT_EQ(a.hessian, b.hessian);
}

// What several threads add to the same entry is added by one of them at the end: it is looked at
// too.
TEST(Threads, CurvatureThatIsNoNumberIsNoticedByAnyNumberOfThem) {
  const auto is_finite = [](double instant, int threads) {
    Phase<1, 1> drive{"drive",
                      [](const auto&, const auto& x, const auto& u) { return u[0] - sin(x[0]); },
                      between(0.5, 2.0)};
    drive.minimise_at_end("late", [instant](auto t, auto) { return sqrt(t - instant); });
    OptimalControlProblem problem("drive");
    problem.start_at(Vec<double, 1>{0.3}).then(drive);
    MultipleShooting shooting(
        problem, {.intervals_per_phase = 8, .integrator = runge_kutta4(), .threads = threads});
    NonlinearProgram& p = shooting.nlp();
    VectorXd entries(p.hessian_pattern().entries());
    const VectorXd w = shooting.initial_guess().w, lambda = VectorXd::Ones(p.rows());
    return p.hessian(w.data(), 1.0, lambda.data(), entries.data(), Curvature::exact);
  };
  for (const int threads : {1, 2, 3}) {
    EXPECT_TRUE(is_finite(-1.0, threads)) << threads;
    EXPECT_FALSE(is_finite(5.0, threads)) << threads;
  }
}

class SharedEvaluation : public testing::TestWithParam<std::pair<std::string, IntegratorChoice>> {};

TEST_P(SharedEvaluation, IsTheSameToTheBitWithAnyNumberOfThreads) {
  const auto shooting_with = [&](int threads) {
    return MultipleShooting(
        swing_up(),
        {.intervals_per_phase = 23, .integrator = GetParam().second, .threads = threads});
  };
  MultipleShooting one = shooting_with(1);
  const unsigned seed = 7;
  SCOPED_TRACE(seed);
  Random random(seed);
  const VectorXd start = one.initial_guess().w;
  for (const int threads : {2, 3}) {
    MultipleShooting several = shooting_with(threads);
    for (int k = 0; k < 3; ++k) {
      VectorXd w = start, lambda(one.nlp().rows());
      for (double& value : w) value += random.uniform(-0.2, 0.2);
      for (double& value : lambda) value = random.uniform(-1.0, 1.0);
      w = w.cwiseMax(one.nlp().lower()).cwiseMin(one.nlp().upper());
      const Evaluation alone = evaluate(one.nlp(), w, lambda, false);
      expect_same(alone, evaluate(several.nlp(), w, lambda, k == 1));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, SharedEvaluation,
                         testing::Values(std::pair{"RungeKutta", runge_kutta4({.steps = 2})},
                                         std::pair{"GaussLegendre",
                                                   gauss_legendre({.stages = 2, .steps = 2})},
                                         std::pair{"Cvodes", cvodes({.tolerance = 1e-8})}),
                         [](const auto& scheme) { return scheme.param.first; });

TEST(Threads, ASolveIsTheSameToTheBitWithAnyNumberOfThreads) {
  const auto solved_with = [](int threads) {
    MultipleShooting shooting(
        swing_up(),
        {.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 2}), .threads = threads});
    const auto solver = make_sqp({.qp = riccati_qp()});
    return solve(shooting, *solver);
  };
  const Solution one = solved_with(1), two = solved_with(2);
  EXPECT_TRUE(one.ok()) << one.message;
  EXPECT_EQ(one.iterations, two.iterations);
  EXPECT_EQ(one.point.w, two.point.w);
  EXPECT_EQ(one.point.lambda, two.point.lambda);
  EXPECT_EQ(one.point.z, two.point.z);
}

// A formula that throws does so where the program is asked, whichever thread evaluates it.
struct Refusing {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    if (refuses.load()) throw std::runtime_error("no rates");
    return Vec<S, 1>(u[0] - x[0]);
  }
  static inline std::atomic<bool> refuses = false;
};

TEST(Threads, WhatAFormulaThrowsReachesTheCaller) {
  Phase<1, 1> phase{"phase", Refusing{}, exactly(1.0)};
  phase.minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  OptimalControlProblem problem("refusing");
  problem.start_at({1.0}).then(phase);
  MultipleShooting shooting(problem, {.integrator = runge_kutta4({.steps = 1}), .threads = 2});
  const VectorXd w = shooting.initial_guess().w;
  VectorXd rows(shooting.nlp().rows());
  Refusing::refuses = true;
  EXPECT_THROW(shooting.nlp().constraints(w.data(), rows.data()), std::runtime_error);
  Refusing::refuses = false;
  EXPECT_TRUE(shooting.nlp().constraints(w.data(), rows.data()));
}

TEST(ThreadPool, EachThreadTakesPartOnceAndTheFirstFailureIsThrown) {
  ThreadPool pool(3);
  std::vector<int> parts(3, 0);
  for (int piece = 0; piece < 100; ++piece) pool.run([&](int k) { parts[k] += k + 1; });
  EXPECT_EQ(parts, (std::vector<int>{100, 200, 300}));
  const auto refuse = [](int k) {
    if (k > 0) throw std::runtime_error(std::to_string(k));
  };
  try {
    pool.run(refuse);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "1");
  }
  pool.run([&](int k) { parts[k] = 0; });
  EXPECT_EQ(parts, std::vector<int>(3, 0));
  EXPECT_THROW(ThreadPool(0), DefinitionError);
}

}  // namespace
}  // namespace saltus
