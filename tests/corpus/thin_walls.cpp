// A wall of 5 to 12 mm half width across a path of 1 to 10 m: y >= height exp(-((x - place) / half
// width)^2).
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {

Instance thin_walls(Random& random) {
  const double way = random.log_uniform(1.0, 10.0), half = random.uniform(5e-3, 12e-3);
  const double height = random.uniform(0.05, 0.5), place = way * random.uniform(0.15, 0.85);
  const double duration = random.log_uniform(1.0, 10.0);
  Twin<2, 2> twin("drive", Integrators{}, exactly(duration));
  twin.minimise("effort", Effort{1.0}).reach("goal", WholeState{}, {exactly(way), exactly(0.0)});
  twin.keep(
      "wall",
      [=](const auto&, const auto& x) {
        using std::exp;
        const auto s = (x[0] - place) / half;
        return std::decay_t<decltype(x[0])>(x[1] - height * exp(-s * s));
      },
      at_least(0.0));
  twin.outside.max_step = 0.5 * half * duration / way;
  Instance instance;
  instance.problem.start_at({0.0, 0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = random.chance(0.5) ? 30 : random.integer(10, 50);
  instance.phases = {twin.outside};
  return instance;
}

}  // namespace saltus::corpus
