// A problem in one to five phases, with state limits in adjacent phases and fixed or free
// durations. The plan must be a KKT point for every division into phases.
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {

Instance split_phases(Random& random) {
  const int parts = random.integer(1, 5);
  const double duration = random.uniform(0.8, 3.0), stiffness = random.uniform(0.0, 3.0);
  const bool least_time = random.chance(0.3), has_limit = random.chance(0.6);
  const double limit = random.uniform(0.6, 2.0), way = random.uniform(0.3, 1.0);
  Instance instance;
  instance.problem.start_at({0.0, 0.0}).costs(CostRule::integrated);
  instance.options.intervals_per_phase = random.integer(2, 30 / parts);
  const double force = random.uniform(4.0, 20.0);
  for (int k = 0; k < parts; ++k) {
    const Bounds length = least_time ? between(0.01, 5.0) : exactly(duration / parts);
    Twin<2, 1> twin("part " + std::to_string(k + 1), Pendulum{stiffness}, length);
    twin.bound_input(0, between(-force, force));
    if (has_limit)
      twin.keep("speed limit", Entry{1}, between(-limit, limit * way / duration * 2.0));
    if (least_time) twin.phase.guess_duration(duration / parts);
    twin.minimise("effort", Effort{least_time ? 1e-3 : 1.0});
    if (k + 1 == parts) {
      twin.reach("there", WholeState{}, {exactly(way), exactly(0.0)});
      if (least_time) twin.minimise_at_end("time", Time{});
    }
    instance.problem.then(twin.phase);
    instance.phases.push_back(twin.outside);
  }
  // With few intervals between the limits, the problem can be infeasible.
  instance.may_be_either = has_limit || instance.options.intervals_per_phase * parts < 6;
  return instance;
}

}  // namespace saltus::corpus
