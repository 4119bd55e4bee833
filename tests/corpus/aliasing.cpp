// Forcing whose period divides the grid's interval, and headings that turn many times within an
// interval. A scheme cannot detect either at the grid's nodes.
#include <cmath>
#include <numbers>

#include "saltus/integrators/runge_kutta.hpp"
#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

Instance forcing(Random& random) {
  const int n = random.chance(0.4) ? 30 : random.integer(5, 40);
  const double duration = random.log_uniform(0.3, 30.0), size = random.log_uniform(0.05, 5.0);
  // Periods of the square wave per interval. Integer numbers alias; the others are only fast.
  const double periods = random.chance(0.6) ? random.integer(1, 16) : random.uniform(0.3, 16.0);
  const double pulsation = std::numbers::pi * periods * n / duration;
  const double target = random.uniform(-2.0, 2.0);
  const double lag = random.chance(0.5) ? 0.0 : random.uniform(0.1, 1.0);
  Twin<1, 1> twin(
      "forced",
      [=](const auto& t, const auto& x, const auto& u) {
        using std::sin;
        const auto s = sin(pulsation * t);
        std::decay_t<decltype(x)> rate;
        rate[0] = u[0] + size * s * s - lag * x[0];
        return rate;
      },
      exactly(duration));
  twin.minimise("effort", Effort{1.0}).reach("there", Entry{0}, exactly(target));
  twin.outside.max_step = 0.3 / pulsation;
  Instance instance;
  instance.problem.start_at({0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = n;
  instance.phases = {twin.outside};
  instance.is_kkt_judged = false;  // follows from the end error, which is judged
  if (random.chance(0.3)) instance.options.integrator = runge_kutta8();
  return instance;
}

Instance heading(Random& random) {
  const double way = random.uniform(0.2, 0.9);
  Twin<2, 1> twin(
      "turn",
      [](const auto&, const auto& x, const auto& u) {
        using std::cos;
        using std::sin;
        std::decay_t<decltype(x)> rate;
        rate[0] = cos(u[0]);
        rate[1] = sin(u[0]);
        return rate;
      },
      exactly(1.0));
  twin.reach("there", WholeState{}, {exactly(way), exactly(random.uniform(-0.3, 0.3))})
      .minimise("turning", Effort{random.log_uniform(1e-8, 1e-3)});
  const double turns = random.log_uniform(1.0, 300.0) * (random.chance(0.5) ? 1.0 : -1.0);
  twin.phase.inputs(random.chance(0.5) ? InputParametrisation::piecewise_linear
                                       : InputParametrisation::piecewise_linear_continuous);
  twin.phase.guess_input(Guess::trajectory(
      [=](double f) { return VectorXd::Constant(1, 2.0 * std::numbers::pi * turns * f); }));
  twin.phase.guess_state(Guess::interpolate(VectorXd::Zero(2), VectorXd::Constant(2, way)));
  twin.outside.max_step = 1e-3;
  Instance instance;
  instance.problem.start_at({0.0, 0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options = {
      .intervals_per_phase = random.integer(3, 15),
      .integrator = random.chance(0.5) ? runge_kutta8() : runge_kutta4({.steps = 2})};
  instance.phases = {twin.outside};
  instance.is_kkt_judged = false;
  return instance;
}

}  // namespace

Instance aliasing(Random& random) { return random.chance(0.6) ? forcing(random) : heading(random); }

}  // namespace saltus::corpus
