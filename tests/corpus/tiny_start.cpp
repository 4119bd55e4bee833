// The start moves by 1e-12 to 1e-2. The systems are a car with two gears, whose least time is known
// by quadrature, and a pendulum.
#include <algorithm>
#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

constexpr double drag = 0.01, loss = 0.97;  // 1/m; factor on the speed at the clutch

struct Gear {
  double thrust, braking;  // m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], S(thrust * u[0] - braking * u[1] - drag * x[1] * x[1])};
  }
};

// Time and distance from speed v to w at full thrust a, and from w to rest at full braking b.
double time_up(double a, double v, double w) {
  const double top = std::sqrt(a / drag);
  return (std::atanh(w / top) - std::atanh(v / top)) / std::sqrt(a * drag);
}
double way_up(double a, double v, double w) {
  return std::log((a - drag * v * v) / (a - drag * w * w)) / (2.0 * drag);
}
double time_down(double b, double w) {
  return std::atan(w * std::sqrt(drag / b)) / std::sqrt(b * drag);
}
double way_down(double b, double w) { return std::log(1.0 + drag * w * w / b) / (2.0 * drag); }

struct Car {
  double first, second, braking, limit, distance;
  // Total time, s. The shift is at speed s.
  double time(double start, double s) const {
    const double after = loss * s, left = distance - way_up(first, start, s);
    double low = after, high = 0.999999 * std::sqrt(second / drag);
    if (way_down(braking, low) > left) return infinity;
    for (int k = 0; k < 80; ++k) {
      const double w = 0.5 * (low + high);
      (way_up(second, after, w) + way_down(braking, w) > left ? high : low) = w;
    }
    return time_up(first, start, s) + time_up(second, after, low) + time_down(braking, low);
  }
  double least_time(double start) const {
    double best = infinity;
    for (int k = 1; k <= 4000; ++k) {
      const double s = limit * k / 4000.0;
      if (s > start && time_up(first, start, s) >= 0.5) best = std::min(best, time(start, s));
    }
    return best;
  }
};

Instance car(Random& random, double moved) {
  const Car c{random.uniform(5.0, 7.0), random.uniform(2.5, 3.5), random.uniform(6.0, 10.0),
              random.uniform(10.0, 12.0), random.uniform(80.0, 200.0)};
  Twin<2, 2> first("first gear", Gear{c.first, c.braking}, between(0.5, 10.0));
  first.bound_input(0, between(0.0, 1.0)).bound_input(1, exactly(0.0));
  first.keep("rev limit", Entry{1}, at_most(c.limit));
  Twin<2, 2> second("second gear", Gear{c.second, c.braking}, between(0.5, 40.0));
  second.bound_input(0, between(0.0, 1.0)).bound_input(1, between(0.0, 1.0));
  second.reach("finish line", Entry{0}, exactly(c.distance))
      .reach("at rest", Entry{1}, exactly(0.0));
  second.minimise_at_end("time", Time{});
  const auto clutch = [](const auto&, const auto& x) {
    auto after = x;
    after[1] = loss * x[1];
    return after;
  };
  second.outside.entry = outside_formula<2, 0, 0>(clutch);
  Instance instance;
  instance.problem.start_at({0.0, moved})
      .then(first.phase)
      .then(second.phase, jump<2>("clutch", clutch));
  instance.phases = {first.outside, second.outside};
  instance.optimum = c.least_time(moved);
  instance.optimum_tolerance = 1e-2;  // pieces of the inputs do not end where the car should brake
  return instance;
}

Instance pendulum(Random& random, double moved) {
  Twin<2, 1> swing("swing", Pendulum{random.uniform(0.5, 4.0), random.uniform(0.0, 0.3)},
                   exactly(random.uniform(0.5, 3.0)));
  const double weight = random.log_uniform(0.1, 10.0);
  swing.minimise("effort", Effort{random.log_uniform(0.1, 10.0)})
      .minimise("way", [weight](const auto&, const auto& x, const auto&) {
        return std::decay_t<decltype(x[0])>(0.5 * weight * x[0] * x[0]);
      });
  if (random.chance(0.5)) swing.reach("there", Entry{0}, exactly(random.uniform(-1.0, 1.0)));
  Instance instance;
  instance.problem.start_at({random.chance(0.5) ? moved : 0.0, -moved});
  instance.problem.then(swing.phase).costs(CostRule::integrated);
  instance.phases = {swing.outside};
  instance.cost_scale = 0.1;  // the least cost can be zero or a square of the start
  return instance;
}

}  // namespace

Instance tiny_start(Random& random) {
  const double moved = random.chance(0.1) ? 0.0 : random.log_uniform(1e-12, 1e-2);
  return random.chance(0.6) ? car(random, moved) : pendulum(random, moved);
}

}  // namespace saltus::corpus
