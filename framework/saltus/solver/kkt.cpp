#include "saltus/solver/optimum_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace saltus {
namespace {

// A multiplier must push against the active side: positive at the upper, negative at the lower
// side. Its product with the distance to that side must vanish.
double complementarity(double multiplier, double value, double lower, double upper) {
  if (multiplier == 0.0) return 0.0;
  const double distance = multiplier > 0.0 ? upper - value : value - lower;
  if (!std::isfinite(distance)) return std::abs(multiplier);  // there is no side in its direction
  return std::abs(multiplier) * std::max(distance, 0.0);
}

// A multiplier of a slack is at most the weight of its penalty, which is not a magnitude: a huge
// one would hide the residuals of all other variables. From this size on, residuals of the slack
// are relative to it, and it does not count further.
constexpr double most_of_slack = 1e6;

double violation(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

}  // namespace

double KktCheck::Residual::scaled() const {
  return std::max(
      {stationarity / multiplier_scale, complementarity / multiplier_scale, feasibility});
}

KktCheck::KktCheck(const NonlinearProgram& program)
    : stationarity_(VectorXd::Zero(program.variables())),
      rows_(VectorXd::Zero(program.rows())),
      entries_(program.jacobian_pattern().entries()) {}

// For cost' = c cost, g' = D g and w' = S w the multipliers are lambda' = c lambda / D, z' = c z /
// S.
KktCheck::Residual KktCheck::check(NonlinearProgram& program, const NlpPoint& point,
                                   const ProgramScale* scale) {
  const int n = program.variables();
  const int m = program.rows();
  KktCheck::Residual result;
  const bool is_whole = point.w.size() == n && point.lambda.size() == m && point.z.size() == n;
  const bool is_known = is_whole && point.w.allFinite() && point.lambda.allFinite() &&
                        point.z.allFinite() &&
                        program.gradient(point.w.data(), stationarity_.data()) &&
                        program.constraints(point.w.data(), rows_.data()) &&
                        program.jacobian(point.w.data(), entries_.data());
  if (is_known)
    program.jacobian_pattern().for_each(
        [&](int row, int col, int e) { stationarity_[col] += point.lambda[row] * entries_[e]; });
  if (!is_known || !stationarity_.allFinite() || !rows_.allFinite()) {
    result.stationarity = result.feasibility = result.complementarity =
        std::numeric_limits<double>::infinity();
    return result;
  }

  const double cost = scale != nullptr ? scale->cost : 1.0;
  const bool has_units = scale != nullptr && scale->variables.size() > 0;
  double worst = 0.0;
  double sum = scale != nullptr ? cost * point.lambda.cwiseQuotient(scale->rows).lpNorm<1>()
                                : point.lambda.lpNorm<1>();
  int multipliers = m;
  for (int i = 0; i < n; ++i) {
    const double lower = program.lower()[i], upper = program.upper()[i];
    const double unit = has_units ? scale->variables[i] : 1.0;
    if (lower != upper) {
      const double multiplier = cost / unit * std::abs(point.z[i]);
      const double excess =
          i >= program.first_slack() ? std::max(1.0, multiplier / most_of_slack) : 1.0;
      result.stationarity = std::max(
          result.stationarity, cost / unit * std::abs(stationarity_[i] + point.z[i]) / excess);
      result.complementarity =
          std::max(result.complementarity,
                   cost * complementarity(point.z[i], point.w[i], lower, upper) / excess);
      sum += multiplier / excess;
      ++multipliers;
    }
    const double v = unit * violation(point.w[i], lower, upper);
    if (v > worst) {
      worst = v;
      result.worst_variable = i;
    }
  }
  for (int i = 0; i < m; ++i) {
    const double lower = program.row_lower()[i], upper = program.row_upper()[i];
    if (lower != upper)
      result.complementarity = std::max(
          result.complementarity, cost * complementarity(point.lambda[i], rows_[i], lower, upper));
    const double v = (scale != nullptr ? scale->rows[i] : 1.0) * violation(rows_[i], lower, upper);
    if (v > worst) {
      worst = v;
      result.worst_variable = -1;
      result.worst_row = i;
    }
  }
  result.feasibility = worst;
  constexpr double usual = 100.0;  // multipliers up to this size are not scaled
  result.multiplier_scale = std::max(usual, sum / std::max(1, multipliers)) / usual;
  return result;
}

KktCheck::Residual kkt_residual(NonlinearProgram& program, const NlpPoint& point) {
  return KktCheck(program)(program, point);
}

}  // namespace saltus
