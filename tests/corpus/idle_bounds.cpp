// Bounds of 1e3 to 1e30 that are never active, on inputs, states, rows and durations, with or
// without declared nominal magnitudes.
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

Bounds idle(Random& random) {
  constexpr double usual[] = {1e10, 1e19, 1e20, 1e30};
  const double size =
      random.chance(0.3) ? usual[random.integer(0, 3)] : random.log_uniform(1e3, 1e30);
  const int side = random.integer(0, 3);
  return side == 0 ? at_least(-size) : side == 1 ? at_most(size) : between(-size, size);
}

template <int nx, int nu>
void add_idle(Random& random, Twin<nx, nu>& twin) {
  const int which = random.integer(1, 7);
  if (which & 1) twin.bound_input(random.integer(0, nu - 1), idle(random));
  if (which & 2) twin.bound_state(random.integer(0, nx - 1), idle(random));
  if (which & 4) twin.keep("idle", Entry{random.integer(0, nx - 1)}, idle(random));
  if (random.chance(0.3)) twin.reach("idle end", Entry{0}, idle(random));
  if (random.chance(0.3)) twin.phase.nominal(VectorXd::Ones(nx), VectorXd::Ones(nu));
  // An inactive row must not determine the tolerance of the judge.
  for (auto* rows : {&twin.outside.path, &twin.outside.ends})
    std::erase_if(*rows, [](const OutsideRow& row) {
      return row.name.starts_with("idle") || row.name.starts_with("state");
    });
  twin.outside.input_bounds.assign(nu, unbounded());
}

template <int nx, int nu>
Instance finished(Twin<nx, nu>& twin, const VectorXd& start) {
  Instance instance;
  instance.problem.start_at(start).then(twin.phase).costs(CostRule::integrated);
  instance.phases = {twin.outside};
  return instance;
}

}  // namespace

Instance idle_bounds(Random& random) {
  switch (random.integer(0, 3)) {
    case 0: {
      Twin<2, 1> twin("push", DoubleIntegrator{random.log_uniform(0.1, 10.0)},
                      exactly(random.uniform(0.5, 3.0)));
      twin.minimise("effort", Effort{random.log_uniform(0.1, 10.0)})
          .reach("there", Entry{0}, exactly(random.uniform(-2.0, 2.0)));
      add_idle(random, twin);
      return finished(twin, VectorXd::Zero(2));
    }
    case 1: {
      Twin<2, 1> twin("swing", Pendulum{random.uniform(0.5, 4.0)},
                      exactly(random.uniform(0.5, 2.0)));
      twin.minimise("effort", Effort{1.0})
          .reach("there", WholeState{}, {exactly(random.uniform(-1.0, 1.0)), exactly(0.0)});
      add_idle(random, twin);
      return finished(twin, random.vector(2));
    }
    case 2: {
      Twin<3, 3> twin("drift", Integrators{}, exactly(random.uniform(0.5, 2.0)));
      twin.minimise("effort", Effort{1.0})
          .reach(
              "plane",
              [](const auto&, const auto& x) {
                return std::decay_t<decltype(x[0])>(x[0] + 2.0 * x[1] - x[2]);
              },
              exactly(random.uniform(-2.0, 2.0)));
      add_idle(random, twin);
      return finished(twin, random.vector(3));
    }
    default: {
      const double way = random.log_uniform(0.1, 10.0);
      const double longest = random.log_uniform(1e3, 1e30);
      const double least = 2.0 * std::sqrt(way);
      Twin<2, 1> twin("sprint", DoubleIntegrator{}, between(0.01, longest));
      add_idle(random, twin);
      twin.bound_input(0, between(-1.0, 1.0));
      twin.reach("there", WholeState{}, {exactly(way), exactly(0.0)})
          .minimise_at_end("time", Time{});
      twin.phase.guess_duration(least * random.uniform(0.5, 2.0));
      Instance instance = finished(twin, VectorXd::Zero(2));
      instance.optimum = least;
      return instance;
    }
  }
}

}  // namespace saltus::corpus
