#include "saltus/solver/kkt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace saltus {
namespace {

// A multiplier must push against the side that holds: positive at the upper, negative at the
// lower side; its product with the distance to that side must vanish.
double complementarity(double multiplier, double value, double lower, double upper) {
  if (multiplier == 0.0) return 0.0;
  const double distance = multiplier > 0.0 ? upper - value : value - lower;
  if (!std::isfinite(distance)) return std::abs(multiplier);  // pushes against nothing
  return std::abs(multiplier) * std::max(distance, 0.0);
}

double violation(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

}  // namespace

double KktResidual::scaled() const {
  return std::max(
      {stationarity / multiplier_scale, complementarity / multiplier_scale, feasibility});
}

KktResidual kkt_residual(NonlinearProgram& program, const NlpPoint& point) {
  const int n = program.variables();
  const int m = program.rows();
  KktResidual result;
  VectorXd stationarity(n), g(m);
  std::vector<double> entries(program.jacobian_pattern().entries());
  if (!program.gradient(point.w.data(), stationarity.data()) ||
      !program.constraints(point.w.data(), g.data()) ||
      !program.jacobian(point.w.data(), entries.data())) {
    result.stationarity = result.feasibility = result.complementarity =
        std::numeric_limits<double>::infinity();
    return result;
  }
  program.jacobian_pattern().for_each(
      [&](int row, int col, int e) { stationarity[col] += point.lambda[row] * entries[e]; });

  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    const double lower = program.lower()[i], upper = program.upper()[i];
    if (lower != upper) {
      result.stationarity = std::max(result.stationarity, std::abs(stationarity[i] + point.z[i]));
      result.complementarity =
          std::max(result.complementarity, complementarity(point.z[i], point.w[i], lower, upper));
    }
    const double v = violation(point.w[i], lower, upper);
    if (v > worst) {
      worst = v;
      result.worst_variable = i;
    }
  }
  for (int i = 0; i < m; ++i) {
    const double lower = program.row_lower()[i], upper = program.row_upper()[i];
    if (lower != upper)
      result.complementarity =
          std::max(result.complementarity, complementarity(point.lambda[i], g[i], lower, upper));
    const double v = violation(g[i], lower, upper);
    if (v > worst) {
      worst = v;
      result.worst_variable = -1;
      result.worst_row = i;
    }
  }
  result.feasibility = worst;
  const double sum = point.lambda.lpNorm<1>() + point.z.lpNorm<1>();
  constexpr double usual = 100.0;  // multipliers up to this size need no scaling
  result.multiplier_scale = std::max(usual, sum / std::max(1, n + m)) / usual;
  return result;
}

}  // namespace saltus
