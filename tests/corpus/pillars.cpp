// One to four pillars along a path of 1 to 1000 m. Their radius is 0.3 to 15 % of its length. They
// lie on the straight line or next to it.
#include <algorithm>
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

// Position and velocity in two dimensions.
struct PointMass {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {x[2], x[3], u[0], u[1]};
  }
};

template <int nx>
void add_pillars(Random& random, Twin<nx, 2>& twin, double way) {
  const int count = random.integer(1, 4);
  for (int k = 0; k < count; ++k) {
    const double radius = way * random.log_uniform(3e-3, 0.15) / count;
    const double x = way * (k + random.uniform(0.3, 0.7)) / count;
    const double y = radius * random.uniform(-1.6, 1.6);
    twin.keep(
        "pillar " + std::to_string(k + 1),
        [=](const auto&, const auto& p) {
          const auto dx = p[0] - x, dy = p[1] - y;
          return std::decay_t<decltype(p[0])>(dx * dx + dy * dy);
        },
        at_least(radius * radius));
    twin.outside.max_step = std::min(twin.outside.max_step, 10.0 * 0.2 * radius / way);
  }
}

}  // namespace

Instance pillars(Random& random) {
  const double way = random.log_uniform(1.0, 1000.0);
  Instance instance;
  instance.options.intervals_per_phase = random.chance(0.5) ? 30 : random.integer(10, 60);
  const auto finish = [&](auto& twin, const VectorXd& start) {
    // Most guesses start on the straight line or next to it. Without a guess, the solver starts
    // with the initial state at every node.
    if (random.chance(0.75)) {
      const double aside = random.chance(0.5) ? 0.0 : way * random.uniform(-0.2, 0.2);
      twin.phase.guess_state(Guess::trajectory([=](double f) {
        VectorXd x = start;
        x[0] = way * f;
        x[1] = aside * 4.0 * f * (1.0 - f);
        return x;
      }));
    }
    instance.problem.start_at(start).then(twin.phase).costs(CostRule::integrated);
    instance.phases = {twin.outside};
  };
  if (random.chance(0.6)) {
    Twin<2, 2> twin("drive", Integrators{}, exactly(10.0));
    twin.minimise("effort", Effort{1.0}).reach("goal", WholeState{}, {exactly(way), exactly(0.0)});
    add_pillars(random, twin, way);
    finish(twin, VectorXd::Zero(2));
  } else {
    Twin<4, 2> twin("glide", PointMass{}, exactly(10.0));
    twin.minimise("effort", Effort{1.0})
        .reach("goal", WholeState{}, {exactly(way), exactly(0.0), exactly(0.0), exactly(0.0)});
    add_pillars(random, twin, way);
    finish(twin, VectorXd::Zero(4));
  }
  return instance;
}

}  // namespace saltus::corpus
