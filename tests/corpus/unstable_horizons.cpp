// x' = a x + u over a horizon T of 1 to 60. The optimum and the open-loop effect of the plan's
// inputs are known.
#include <algorithm>
#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

struct Growth {
  double rate;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return Vec<S, 1>(rate * x[0] + u[0]);
  }
};
// A stable second state.
struct Mixed {
  double rate;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {S(rate * x[0] + u[0]), S(x[0] - x[1])};
  }
};

}  // namespace

Instance unstable_horizons(Random& random) {
  const double horizon = random.log_uniform(1.0, 60.0), rate = random.log_uniform(0.2, 5.0);
  const double duration = horizon / rate,
               target = random.chance(0.5) ? 0.0 : random.uniform(-1.0, 1.0);
  const int n = std::max(10, static_cast<int>(std::ceil(random.uniform(1.0, 3.0) * horizon)));
  const double h = duration / n, start = random.chance(0.5) ? 1.0 : random.uniform(-2.0, 2.0);
  double gramian = 0.0;  // divided by exp(2 a T)
  for (int k = 0; k < n; ++k) {
    const double c = (std::exp(-rate * k * h) - std::exp(-rate * (k + 1) * h)) / rate;
    gramian += c * c / h;
  }
  const double miss = target * std::exp(-horizon) - start;
  Instance instance;
  instance.options = {.intervals_per_phase = n, .integrator = runge_kutta8({.steps = 2})};
  const auto finish = [&](auto& twin, const VectorXd& first) {
    twin.minimise("effort", Effort{1.0}).reach("there", Entry{0}, exactly(target));
    instance.problem.start_at(first).then(twin.phase).costs(CostRule::integrated);
    instance.phases = {twin.outside};
  };
  if (random.chance(0.6)) {
    Twin<1, 1> twin("fall", Growth{rate}, exactly(duration));
    finish(twin, VectorXd::Constant(1, start));
  } else {
    Twin<2, 1> twin("fall", Mixed{rate}, exactly(duration));
    finish(twin, VectorXd::Constant(2, start));
  }
  instance.optimum = 0.5 * miss * miss / gramian;
  instance.is_kkt_judged = false;
  instance.amplification = std::exp(horizon);
  return instance;
}

}  // namespace saltus::corpus
