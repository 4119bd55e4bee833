// Targets inside and outside the reachable set, by a relative distance of 1e-9 to 1e-1.
#include <algorithm>
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {

Instance near_infeasible(Random& random) {
  const double duration = random.log_uniform(0.3, 10.0), largest = random.log_uniform(0.1, 10.0);
  const double margin = random.log_uniform(1e-9, 1e-1) * (random.chance(0.5) ? 1.0 : -1.0);
  const bool is_rest_to_rest = random.chance(0.6);
  Instance instance;
  instance.options.intervals_per_phase = 2 * random.integer(3, 15);
  double beyond = 0.0;
  const auto finish = [&](auto& twin, int nx) {
    twin.minimise("effort", Effort{1.0}).bound_input(0, between(-largest, largest));
    instance.problem.start_at(VectorXd::Zero(nx)).then(twin.phase).costs(CostRule::integrated);
    instance.phases = {twin.outside};
  };
  if (is_rest_to_rest) {
    const double way = largest * duration * duration / 4.0 * (1.0 - margin);
    beyond = -margin * largest * duration * duration / 4.0;
    Twin<2, 1> twin("move", DoubleIntegrator{}, exactly(duration));
    twin.reach("there", WholeState{}, {exactly(way), exactly(0.0)});
    finish(twin, 2);
  } else {
    const double way = largest * duration * (1.0 - margin);
    beyond = -margin * largest * duration;
    Twin<1, 1> twin("run", Integrators{}, exactly(duration));
    twin.reach("there", Entry{0}, exactly(way));
    finish(twin, 1);
  }
  instance.is_kkt_judged = false;  // the set of feasible plans is a point or nearly one
  // Within the tolerances, either answer is right.
  const double scale = 1e-5 * std::max(1.0, std::max(largest, largest * duration * duration));
  instance.is_solvable = beyond < 0.0;
  if (std::abs(beyond) < scale) instance.is_solvable = true, instance.may_be_either = true;
  return instance;
}

}  // namespace saltus::corpus
