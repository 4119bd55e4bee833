// The same small problems in units between 1e-6 and 1e8 for states, time, inputs and cost, without
// declared magnitudes.
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

// Numbers in the given units: units.time is in seconds per unit of time, and so on.
struct Units {
  double state, time, input, cost;
};
Units drawn(Random& random) {
  Units units{1.0, 1.0, 1.0, 1.0};
  for (double* u : {&units.state, &units.time, &units.input, &units.cost})
    if (random.chance(0.6)) *u = random.log_uniform(1e-6, 1e6);
  return units;
}

struct Scaled {
  Units units;
  double stiffness;
  // position in units.state, speed in units.state per units.time, force in units.input
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    const double t = units.time;
    return {x[1], S((u[0] * units.input * t * t / units.state) - stiffness * t * t * x[0])};
  }
};

}  // namespace

Instance scales(Random& random) {
  const Units units = drawn(random);
  const double force = random.uniform(0.5, 2.0), way = random.uniform(0.5, 2.0);
  const double largest = force / units.input;  // in the user's units
  Instance instance;
  instance.options.intervals_per_phase = 2 * random.integer(5, 15);
  const bool least_time = random.chance(0.5);
  const double seconds = least_time ? 2.0 * std::sqrt(way / force) : random.uniform(2.5, 5.0);
  const double duration = seconds / units.time;
  Twin<2, 1> twin("move", Scaled{units, least_time ? 0.0 : random.uniform(0.0, 2.0)},
                  least_time ? between(0.1 * duration, 10.0 * duration) : exactly(duration));
  twin.reach("there", WholeState{}, {exactly(way / units.state), exactly(0.0)});
  if (least_time) {
    twin.bound_input(0, between(-largest, largest));
    twin.phase.guess_duration(duration * random.uniform(0.5, 2.0));
    twin.minimise_at_end("time", [=](const auto& t, const auto&) {
      return std::decay_t<decltype(t)>(t / units.cost);
    });
    instance.optimum = duration / units.cost;
  } else {
    twin.minimise("effort", Effort{units.input * units.input * units.time / units.cost});
  }
  // The tolerance of a row has no unit: any plan satisfies a row whose values are far below 1e-6.
  if (way / units.state < 1e-4) instance.optimum.reset(), instance.is_kkt_judged = false;
  instance.problem.start_at({0.0, 0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.phases = {twin.outside};
  return instance;
}

}  // namespace saltus::corpus
