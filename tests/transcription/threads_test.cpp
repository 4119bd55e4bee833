// Threads that plan at the same time share only the formulas of one problem. Threads that evaluate
// one program do not change its numbers. Objects that docs/promise.md allows several threads to
// read give the same values in all of them. tests/mpc/control_threads_test.cpp covers controllers.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/core/thread_pool.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/model/algebraic.hpp"
#include "saltus/model/automaton.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return {x[1], u[0] - p[0] * sin(x[0])};
  }
};

// A pendulum swings up through an event. It contains every part that owns scratch memory after
// transcription: residuals, costs in an interval of unknown length, input changes, soft rows and
// parameters.
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
  const auto solver = by_stages ? make_native_solver({.qp = riccati_qp()}) : make_native_solver();
  return solve(shooting, *solver);
}

TEST(Threads, ConcurrentSolvesEqualSequentialSolves) {
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

// All evaluations that a solver can request from a program.
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

// One thread adds the contributions of several threads to the same entry at the end. The check
// covers that sum too.
TEST(Threads, NanCurvatureIsDetectedByAnyNumberOfThreads) {
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

TEST_P(SharedEvaluation, IsBitIdenticalForAnyNumberOfThreads) {
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

TEST(Threads, SolveIsBitIdenticalForAnyNumberOfThreads) {
  const auto solved_with = [](int threads) {
    MultipleShooting shooting(
        swing_up(),
        {.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 2}), .threads = threads});
    const auto solver = make_native_solver({.qp = riccati_qp()});
    return solve(shooting, *solver);
  };
  const Solution one = solved_with(1), two = solved_with(2);
  EXPECT_TRUE(one.ok()) << one.message;
  EXPECT_EQ(one.iterations, two.iterations);
  EXPECT_EQ(one.point.w, two.point.w);
  EXPECT_EQ(one.point.lambda, two.point.lambda);
  EXPECT_EQ(one.point.z, two.point.z);
}

// A formula that throws. The exception appears in the call of the program, for every thread that
// evaluates the formula.
struct Refusing {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    if (refuses.load()) throw std::runtime_error("no rates");
    return Vec<S, 1>(u[0] - x[0]);
  }
  static inline std::atomic<bool> refuses = false;
};

TEST(Threads, FormulaExceptionsReachTheCaller) {
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

// --- concurrent calls that docs/promise.md allows
// ------------------------------------------

// Calls work(i) in four threads at once, many times each.
template <class Work>
void by_four_threads(const Work& work) {
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&work, i] {
      for (int k = 0; k < 50; ++k) work(4 * k + i);
    });
}

// x' = z, 0 = z + z^3 / 10 - u + x. An iteration computes z.
OptimalControlProblem with_algebraic_state() {
  Phase<1, 1, 0, 1> phase{
      "algebraic",
      [](const auto&, const auto& x, const auto& z, const auto&) {
        return std::decay_t<decltype(x)>(z[0]);
      },
      [](const auto&, const auto& x, const auto& z, const auto& u) {
        return std::decay_t<decltype(x)>(z[0] + 0.1 * z[0] * z[0] * z[0] - u[0] + x[0]);
      },
      Vec<double, 1>{0.0}, exactly(1.0)};
  phase.bound_input(0, between(-2.0, 2.0))
      .minimise("effort", [](const auto&, const auto& x, const auto& z, const auto& u) {
        return x[0] * x[0] + 0.1 * z[0] * z[0] + 0.1 * u[0] * u[0];
      });
  OptimalControlProblem problem("algebraic");
  problem.costs(CostRule::integrated).start_at({1.0}).then(phase);
  return problem;
}

// A ball that bounces inside intervals, driven by a force. The cost rewards a large final height.
OptimalControlProblem with_events() {
  Automaton<2, 1> automaton;
  automaton
      .mode("flight",
            [](const auto&, const auto& x, const auto& u) {
              return std::decay_t<decltype(x)>{x[1], u[0] - 9.81};
            })
      .event(
          "bounce", "flight", "flight", [](const auto&, const auto& x) { return x[0]; },
          Crossing::falling,
          [](const auto&, const auto& x) {
            return std::decay_t<decltype(x)>{x[0], -0.8 * x[1]};
          });
  Phase<2, 1> phase{"ball", automaton, exactly(1.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .track(
          "push", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{0.1})
      .minimise_at_end("height", [](const auto&, const auto& x) { return -x[0]; });
  OptimalControlProblem problem("ball");
  problem.costs(CostRule::integrated).start_at({1.0, 0.0}).then(phase);
  return problem;
}

// Each composed function owns working memory. Its values do not depend on the number of threads.
TEST(Promise, SeveralThreadsEvaluateFunctions) {
  const OptimalControlProblem problem = with_algebraic_state();
  const PhaseDefinition& phase = problem.phases().front();
  const Function residual = make_function<1, 1, 0>([](const auto& t, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>(x[0] * u[0] + t);
  });
  const Function square = least_squares_cost(residual, MatrixXd::Identity(1, 1),
                                             Reference({0.0, 1.0}, MatrixXd{{0.0, 2.0}}));
  const std::vector<Function> functions{phase.dynamics,
                                        phase.terms.front().function,
                                        algebraic_states(phase.algebraic.equations),
                                        square,
                                        stack({square, phase.terms.front().function}),
                                        times_length(square)};
  for (const Function& f : functions) {
    EXPECT_TRUE(f.is_reentrant());
    const Function own = f.separate();
    ASSERT_TRUE(own);
    EXPECT_FALSE(own.is(f));
    const auto argument = [&](int k) -> VectorXd {
      return VectorXd::LinSpaced(f.inputs(), 0.1 + 0.01 * (k % 20), 0.9);
    };
    const VectorXd weights = VectorXd::Ones(f.outputs());
    std::vector<VectorXd> values(20);
    std::vector<MatrixXd> jacobians(20), hessians(20);
    for (int k = 0; k < 20; ++k) {
      values[k] = f(argument(k));
      jacobians[k] = f.dense_jacobian(argument(k));
      hessians[k] = f.dense_hessian(argument(k), weights);
      EXPECT_EQ(own(argument(k)), values[k]);
      EXPECT_EQ(own.dense_jacobian(argument(k)), jacobians[k]);
      EXPECT_EQ(own.dense_hessian(argument(k), weights), hessians[k]);
    }
    std::atomic<int> others = 0;
    by_four_threads([&](int k) {
      const VectorXd z = argument(k);
      others += f(z) == values[k % 20] && f.dense_jacobian(z) == jacobians[k % 20] &&
                        f.dense_hessian(z, weights) == hessians[k % 20]
                    ? 0
                    : 1;
    });
    EXPECT_EQ(others, 0);
  }
}

struct PlanCase {
  std::string name;
  OptimalControlProblem problem;
  IntegratorChoice scheme;
};

class PromiseOfPlans : public testing::TestWithParam<PlanCase> {
 protected:
  MultipleShooting shooting() const {
    return {GetParam().problem, {.intervals_per_phase = 6, .integrator = GetParam().scheme}};
  }
};

// State, input and algebraic state at 40 instants.
MatrixXd samples_of(const Trajectory& plan) {
  const double begin = plan.start_time(), length = plan.end_time() - begin;
  std::vector<VectorXd> columns;
  for (int i = 0; i < 40; ++i) {
    const double t = begin + length * (i + 0.3) / 40.0;
    const VectorXd x = plan.state(t), u = plan.input(t), z = plan.algebraic(t);
    VectorXd& column = columns.emplace_back(x.size() + u.size() + z.size());
    column << x, u, z;
  }
  MatrixXd all(columns.front().size(), 40);
  for (int i = 0; i < 40; ++i) all.col(i) = columns[i];
  return all;
}

TEST_P(PromiseOfPlans, FourThreadsReadAPlanDuringAnotherSolve) {
  MultipleShooting untouched = shooting(), read = shooting();
  const auto solver = make_native_solver(), other_solver = make_native_solver();
  const Solution first = solve(untouched, *solver);
  const Solution plan = solve(read, *other_solver);
  ASSERT_EQ(first.point.w, plan.point.w);
  const MatrixXd samples = samples_of(plan.trajectory);
  const VectorXd start = 1.1 * GetParam().problem.start_guess();
  untouched.start_at(0.0, start);
  read.start_at(0.0, start);
  const Solution expected = solve(untouched, *solver);
  std::atomic<int> others = 0;
  Solution again;
  {
    const std::jthread solving([&] { again = solve(read, *other_solver); });
    by_four_threads([&](int k) {
      const Solution copy = plan;
      if (k % 5 == 0)
        others += samples_of((k % 2 == 0 ? plan : copy).trajectory) == samples ? 0 : 1;
    });
  }
  EXPECT_EQ(others, 0);
  EXPECT_EQ(again.point.w, expected.point.w);
  EXPECT_EQ(again.iterations, expected.iterations);
}

TEST_P(PromiseOfPlans, SeveralThreadsShareAChoiceAndAProblem) {
  MultipleShooting alone = shooting();
  const Solution expected = solve(alone, *make_native_solver());
  std::atomic<int> others = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      MultipleShooting own = shooting();  // uses the shared problem and the shared choice
      others += solve(own, *make_native_solver()).point.w == expected.point.w ? 0 : 1;
      GetParam().problem.check();
      others += GetParam().problem.warnings().size() == expected.warnings.size() ? 0 : 1;
    });
  threads.clear();
  EXPECT_EQ(others, 0);
}

// One thread at a time, and a different one each time.
TEST_P(PromiseOfPlans, ProgramSolverAndIntegratorMoveBetweenThreads) {
  MultipleShooting alone = shooting();
  const Solution expected = solve(alone, *make_native_solver());
  std::unique_ptr<MultipleShooting> program;
  std::unique_ptr<Solver> solver;
  std::unique_ptr<Integrator> integrator;
  Solution found;
  std::thread([&] {
    program = std::make_unique<MultipleShooting>(shooting());
    solver = make_native_solver();
  }).join();
  std::thread([&] { found = solve(*program, *solver); }).join();
  EXPECT_EQ(found.point.w, expected.point.w);
  std::thread([&] {
    integrator = found.trajectory.phases().front().integrator->make();
    program.reset();
    solver.reset();
  }).join();
  const Trajectory::Piece& piece = found.trajectory.pieces().front();
  VectorXd w(integrator->arguments().size()), end(integrator->outputs());
  w << piece.state, piece.coefficients, piece.start, 0.5 * piece.length;
  std::thread([&] {
    EXPECT_EQ(integrator->value(w.data(), end.data()), IntegrationStatus::success);
    integrator.reset();
  }).join();
  // The plan outlives its program.
  EXPECT_EQ(VectorXd(end.head(piece.state.size())),
            found.trajectory.state(piece.start + 0.5 * piece.length));
}

INSTANTIATE_TEST_SUITE_P(
    Schemes, PromiseOfPlans,
    testing::Values(PlanCase{"RungeKutta", with_algebraic_state(), runge_kutta4({.steps = 2})},
                    PlanCase{"GaussLegendre", with_algebraic_state(),
                             gauss_legendre({.stages = 2, .steps = 2})},
                    PlanCase{"Idas", with_algebraic_state(), idas({.tolerance = 1e-8})},
                    PlanCase{"Cvodes", with_algebraic_state(), cvodes({.tolerance = 1e-8})},
                    PlanCase{"Events", with_events(), runge_kutta4({.steps = 4})},
                    PlanCase{"EventsByCvodes", with_events(), cvodes({.tolerance = 1e-8})}),
    [](const auto& c) { return c.param.name; });

TEST(Promise, SeveralThreadsReadReferencesAndSchedules) {
  const Reference reference({0.0, 1.0, 2.0}, MatrixXd{{0.0, 2.0, 1.0}});
  const Schedule schedule = Schedule({"a", "b", "a"}, {{"on", 0.5}, {"off", 1.5}}).reserve(5);
  std::atomic<int> others = 0;
  by_four_threads([&](int k) {
    const double t = 0.01 * (k % 200);
    const Schedule copy = schedule;
    Schedule edited = schedule;
    edited.retime("on", 0.1 + 1e-3 * k);
    const std::string mode = t < 0.5 || t >= 1.5 ? "a" : "b";
    others += reference.at(0.5, 0) == 1.0 && copy.mode_at(t) == mode &&
                      schedule.mode_at(t) == mode && schedule.time_of("on") == 0.5
                  ? 0
                  : 1;
  });
  EXPECT_EQ(others, 0);
}

TEST(ThreadPool, EachThreadRunsOnceAndTheFirstFailureIsThrown) {
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
