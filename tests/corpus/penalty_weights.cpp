// Penalty weights of 1e-2 to 1e14 on reachable and unreachable ends, and on ceilings.
//
// With x(T) = c'u + free and costs r/2 int u^2, G = sum c_k^2 / (r h): the end's multiplier for a
// miss d of the free response is d / G. An L1 weight w gives min(w, d / G), an L2 weight d / (G + 1
// / w).
#include <algorithm>
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

double weight_of(Random& random) { return random.log_uniform(1e-2, 1e14); }

struct Lag {
  double rate;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0] - rate * x[0]);
  }
};

Instance reachable_end(Random& random) {
  const double rate = random.uniform(0.1, 2.0), r = random.log_uniform(1e-2, 1e2);
  const double duration = random.uniform(0.3, 3.0), target = random.log_uniform(0.1, 10.0);
  const double w = weight_of(random);
  const Penalty::Kind kind = random.chance(0.5) ? Penalty::L1 : Penalty::L2;
  const int n = random.integer(10, 30);
  Twin<1, 1> twin("lag", Lag{rate}, exactly(duration));
  twin.minimise("effort", Effort{r});
  if (random.chance(0.5)) twin.phase.bound_input(0, between(-1e3, 1e3));
  twin.phase.reach("there", Entry{0}, exactly(target), soft("w", w, kind));
  double gramian = 0.0;
  const double h = duration / n;
  for (int k = 0; k < n; ++k) {
    const double c =
        (std::exp(-rate * (duration - (k + 1) * h)) - std::exp(-rate * (duration - k * h))) / rate;
    gramian += c * c / (r * h);
  }
  Instance instance;
  instance.problem.start_at({0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = n;
  instance.phases = {twin.outside};
  instance.is_kkt_judged = false;  // the known optimum is compared instead
  const double multiplier = target / gramian;
  if (kind == Penalty::L1) {
    instance.optimum =
        w >= multiplier ? 0.5 * target * multiplier : w * target - 0.5 * w * w * gramian;
  } else {
    instance.optimum = 0.5 * target * target / (gramian + 1.0 / w);
  }
  instance.optimum_tolerance = 1e-4;
  return instance;
}

Instance unreachable_end(Random& random) {
  const double duration = random.uniform(0.3, 3.0), r = random.log_uniform(1e-2, 1.0);
  const double largest = random.log_uniform(0.1, 10.0);
  const double beyond = random.log_uniform(1e-3, 10.0);
  const Penalty::Kind kind = random.chance(0.5) ? Penalty::L1 : Penalty::L2;
  // The weight is large enough to keep the input at its bound.
  const double enough = kind == Penalty::L1 ? r * largest : r * largest / beyond;
  const double w = random.log_uniform(2.0 * enough, std::max(1e14, 4.0 * enough));
  Twin<1, 1> twin("run", Integrators{}, exactly(duration));
  twin.minimise("effort", Effort{r}).bound_input(0, between(-largest, largest));
  twin.phase.reach("there", Entry{0}, at_least(largest * duration + beyond), soft("w", w, kind));
  Instance instance;
  instance.problem.start_at({0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.phases = {twin.outside};
  instance.is_kkt_judged = false;
  instance.optimum = 0.5 * r * largest * largest * duration +
                     (kind == Penalty::L1 ? w * beyond : 0.5 * w * beyond * beyond);
  instance.optimum_tolerance = 1e-4;
  instance.further = [=](const Solution& solution) -> std::string {
    const double end = solution.trajectory.final_state()[0];
    return std::abs(end - largest * duration) <= 1e-4 * largest * duration
               ? ""
               : "the end is not as close to the target as possible";
  };
  return instance;
}

// An L1 weight above the exact one gives the plan of the hard ceiling.
Instance ceiling(Random& random) {
  const double height = random.uniform(0.08, 0.16);
  Twin<2, 1> twin("throw", DoubleIntegrator{}, exactly(1.0));
  twin.minimise("effort", Effort{1.0})
      .reach("ground", WholeState{}, {exactly(0.0), exactly(-1.0)})
      .keep_softly("ceiling", Entry{0}, at_most(height),
                   soft("w", random.log_uniform(1e6, 1e14), Penalty::L1));
  Instance instance;
  instance.problem.start_at({0.0, 1.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = random.integer(10, 40);
  instance.phases = {twin.outside};
  return instance;
}

}  // namespace

Instance penalty_weights(Random& random) {
  const double draw = random.uniform(0.0, 1.0);
  return draw < 0.5   ? reachable_end(random)
         : draw < 0.8 ? unreachable_end(random)
                      : ceiling(random);
}

}  // namespace saltus::corpus
