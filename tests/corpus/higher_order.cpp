// Costs that have a maximum or a saddle of second or higher order at the start. A plan that stays
// there is a KKT point and must not be certified as a minimum.
#include <algorithm>
#include <cmath>

#include "tests/corpus/claims.hpp"
#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

// size (a x^n + b y^m + c x^2 y + d (x^3 - 3 x y^2)). Powers are written as products.
struct Surface {
  double size = 1.0;
  int n = 4, m = 4;
  double a = -1.0, b = 0.0, c = 0.0, d = 0.0;
  template <class S, class X>
  S operator()(const S&, const X& x) const {
    S first = x[0], second = x[1];
    for (int k = 1; k < n; ++k) first = first * x[0];
    for (int k = 1; k < m; ++k) second = second * x[1];
    return size * (a * first + b * second + c * x[0] * x[0] * x[1] +
                   d * (x[0] * x[0] * x[0] - 3.0 * x[0] * x[1] * x[1]));
  }
};

}  // namespace

Instance higher_order(Random& random) {
  Surface f;
  f.size = random.log_uniform(1e-2, 1e2);
  switch (random.integer(0, 5)) {
    case 0:
      f.n = random.integer(2, 8);
      break;  // -x^n
    case 1:
      f.n = 2 * random.integer(1, 3), f.m = 2 * random.integer(1, 3), f.b = -1.0;
      break;
    case 2:
      f.n = 2 * random.integer(1, 3), f.m = 2 * random.integer(1, 3), f.b = 1.0;
      break;
    case 3:
      f.a = 0.0, f.c = 1.0;
      break;  // x^2 y
    case 4:
      f.a = 0.0, f.d = 1.0;
      break;  // a monkey saddle
    default:
      f.n = 3, f.m = 4, f.b = random.chance(0.5) ? 1.0 : -1.0;
      break;
  }
  const double duration = random.log_uniform(0.3, 3.0);
  Twin<2, 2> twin("leave", Integrators{}, exactly(duration));
  twin.bound_input(0, between(-1.0, 1.0)).bound_input(1, between(-1.0, 1.0));
  twin.minimise_at_end("surface", f);
  Instance instance;
  instance.problem.start_at({0.0, 0.0}).then(twin.phase).costs(CostRule::integrated);
  instance.options.intervals_per_phase = random.integer(1, 30);
  instance.phases = {twin.outside};
  // Largest change of the surface within reach.
  for (int k = 0; k < 16; ++k) {
    const double angle = 0.39269908169872414 * k;
    const Vec<double, 2> x{duration * std::cos(angle), duration * std::sin(angle)};
    instance.cost_scale = std::max(instance.cost_scale, std::abs(f(0.0, x)));
  }
  instance.may_be_either = true;  // a plan that stays at a maximum or saddle may be refused
  const double scale = instance.cost_scale;
  instance.further = [=](const Solution& solution) -> std::string {
    if (!claims_minimum(solution)) return {};
    const VectorXd end = solution.trajectory.final_state();
    const double here = f(0.0, end);
    // Searches within a tenth of the reach. Ranges of the surface below 1e-6 do not count.
    double least = here;
    for (int k = 0; k < 64; ++k)
      for (const double radius : {0.02, 0.1}) {
        const double angle = 0.0981747704246810387 * k;
        Vec<double, 2> x{end[0] + radius * duration * std::cos(angle),
                         end[1] + radius * duration * std::sin(angle)};
        for (int i = 0; i < 2; ++i) x[i] = std::clamp(x[i], -duration, duration);
        least = std::min(least, f(0.0, x));
      }
    return least < here - 1e-12 * scale ? "certificate: the curvature is reported as that of a "
                                          "minimum, but the cost decreases nearby"
                                        : std::string{};
  };
  return instance;
}

}  // namespace saltus::corpus
