// Effect of threads: alternating evaluation with derivatives of a library problem on a long grid by
// one thread and by several, and a whole solve with each.
//
//     parallel_intervals [CASE] [INTERVALS] [THREADS]
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "problems/library/catalogue.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace {

using namespace saltus;

struct Evaluated {
  VectorXd gradient, rows, jacobian, hessian;
  friend bool operator==(const Evaluated&, const Evaluated&) = default;
};

// All evaluations of an iteration, s of wall-clock time.
double evaluate(NonlinearProgram& p, const VectorXd& w, const VectorXd& lambda, Evaluated& e) {
  const WallClock::time_point begin = WallClock::now();
  p.prepare_derivatives(w.data(), 1.0, lambda.data(), Curvature::exact);
  p.gradient(w.data(), e.gradient.data());
  p.jacobian(w.data(), e.jacobian.data());
  p.constraints(w.data(), e.rows.data());
  p.hessian(w.data(), 1.0, lambda.data(), e.hessian.data(), Curvature::exact);
  return seconds_since(begin);
}

int run(const std::string& name, int intervals, int threads) {
  constexpr int rounds = 15;
  const ReferenceCase& c = reference_case(name);
  const auto shooting_with = [&](int count) {
    return MultipleShooting(c.problem(), {.intervals_per_phase = intervals,
                                          .integrator = runge_kutta4({.steps = 1}),
                                          .threads = count});
  };
  MultipleShooting alone = shooting_with(1), together = shooting_with(threads);
  NonlinearProgram& p = alone.nlp();
  const auto sized = [&] {
    return Evaluated{VectorXd(p.variables()), VectorXd(p.rows()),
                     VectorXd(p.jacobian_pattern().entries()),
                     VectorXd(p.hessian_pattern().entries())};
  };
  Evaluated of_one = sized(), of_several = sized();
  double fastest_alone = infinity, fastest_together = infinity;
  bool is_same = true;
  Random random(1);
  const VectorXd lambda = random.vector(p.rows()), start = alone.initial_guess().w;
  for (int k = 0; k < rounds; ++k) {
    const VectorXd w = start + 1e-3 * random.vector(p.variables());
    fastest_alone = std::min(fastest_alone, evaluate(p, w, lambda, of_one));
    fastest_together = std::min(fastest_together, evaluate(together.nlp(), w, lambda, of_several));
    is_same = is_same && of_one == of_several;
  }
  fmt::print("{}, {} intervals, {} variables\n", c.name, intervals, p.variables());
  fmt::print(
      "evaluation with derivatives: {:.3f} ms ({:.3f} us per interval) by 1 thread, {:.3f} ms by "
      "{}: "
      "{:.2f}; {}\n",
      1e3 * fastest_alone, 1e6 * fastest_alone / intervals, 1e3 * fastest_together, threads,
      fastest_alone / fastest_together, is_same ? "identical" : "DIFFERENT");

  const auto solve_with = [&](MultipleShooting& shooting) {
    const auto solver = make_native_solver({.qp = riccati_qp()});
    return solver->solve(shooting.nlp(), shooting.initial_guess(), false);
  };
  const NlpResult one = solve_with(alone), several = solve_with(together);
  fmt::print(
      "solve: {:.3f} s by 1 thread, {:.3f} s by {}: {:.2f}; {} iterations, cost {:.9g}; {}\n",
      one.seconds, several.seconds, threads, one.seconds / several.seconds, one.iterations,
      one.objective, one.point.w == several.point.w ? "identical" : "DIFFERENT");
  return is_same && one.point.w == several.point.w ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) try {
  const std::vector<std::string> given(arguments + 1, arguments + count);
  return run(given.empty() ? "pendulum_on_cart" : given[0],
             given.size() > 1 ? std::stoi(given[1]) : 20000,
             given.size() > 2 ? std::stoi(given[2]) : 2);
} catch (const std::exception& e) {
  fmt::print(stderr, "parallel_intervals: {}\n", e.what());
  return 2;
}
