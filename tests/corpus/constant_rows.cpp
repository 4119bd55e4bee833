// Rows that depend on data or time only, satisfied or violated. The plan cannot change them, so the
// answer is known before the solve.
#include <algorithm>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

struct Drift {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    return {x[1], u[0]};
  }
};
// data + slope t
struct Constant {
  double of_data, of_time;
  template <class S>
  S operator()(const S& t, const Vec<S, 2>&, const Vec<S, 1>&, const Vec<S, 1>& p) const {
    return of_data * p[0] + of_time * t;
  }
};
// The same row together with a row that depends on the plan.
struct Beside {
  Constant constant;
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    return {x[0], constant(t, x, u, p)};
  }
};

}  // namespace

Instance constant_rows(Random& random) {
  const double duration = random.uniform(0.5, 3.0), datum = random.uniform(-3.0, 3.0);
  const int kind = random.integer(0, 2);  // reads data, time or both
  const Constant row{kind == 1 ? 0.0 : random.log_uniform(0.1, 10.0),
                     kind == 0 ? 0.0 : random.uniform(-2.0, 2.0)};
  const bool at_end = random.chance(0.4), is_equality = at_end && random.chance(0.4);
  const double first = row.of_data * datum, last = first + row.of_time * duration;
  const double low = at_end ? last : std::min(first, last),
               high = at_end ? last : std::max(first, last);
  // Satisfied with a margin, or violated by more than the tolerance.
  const double amount = random.log_uniform(1e-3, 1e3);
  const bool is_met = random.chance(0.5);
  Bounds bounds;
  if (is_equality)
    bounds = exactly(is_met ? last : last + amount);
  else if (random.chance(0.5))
    bounds = at_most(is_met ? high + amount : high - amount);
  else
    bounds = at_least(is_met ? low - amount : low + amount);

  Twin<2, 1, 1> twin("push", Drift{}, exactly(duration), {datum});
  twin.minimise("effort", [](const auto&, const auto&, const auto& u) {
    return std::decay_t<decltype(u[0])>(0.5 * u[0] * u[0]);
  });
  twin.reach("there", Entry{0}, exactly(random.uniform(-1.0, 1.0)));
  const bool is_beside = random.chance(0.3);
  if (is_beside && at_end)
    twin.reach("limits", Beside{row}, {between(-50.0, 50.0), bounds});
  else if (at_end)
    twin.reach("limit", row, bounds);
  else
    twin.keep("limit", row, bounds);
  Instance instance;
  instance.problem.start_at({0.0, 0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = random.integer(5, 30);
  instance.phases = {twin.outside};
  instance.is_solvable = is_met;
  if (random.chance(0.25)) {  // in closed loop: the first tick
    const OptimalControlProblem problem = instance.problem;
    const double start = random.uniform(-0.1, 0.1);
    instance.run = [=](SolverChoice) -> Verdict {
      RecedingHorizonController controller(
          MultipleShooting(problem, {.intervals_per_phase = 10, .integrator = runge_kutta4()}),
          {.period = 0.02});
      const auto tick = controller.tick(0.0, VectorXd::Constant(2, start));
      const bool said_optimal = tick.provenance == Provenance::optimal;
      if (said_optimal && !is_met)
        return {Outcome::wrong, "controller: optimal, although no plan satisfies the row"};
      if (!said_optimal && is_met)
        return {Outcome::unsolved, std::string("controller: ") + describe(tick.provenance)};
      return {is_met ? Outcome::right : Outcome::reported, {}};
    };
  }
  return instance;
}

}  // namespace saltus::corpus
