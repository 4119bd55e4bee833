#include "saltus/transcription/parametric_sensitivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

constexpr int levels = 8;
constexpr double shrink = 0.5;    // factor of the step between levels
constexpr double enough = 1e-14;  // relative error that ends the extrapolation
// One-sided slopes with a larger relative difference indicate a kink.
constexpr double kinked = 1e-6;
constexpr double after_failure = 1.0 / 3;  // factor of the step after a failed evaluation

// The set of active terms, which must be the same for all samples of a difference.
std::vector<char> structure(ShootingProgram& program) {
  std::vector<char> signs;
  const Grid& grid = program.grid();
  for (int j = 0; j < grid.phases(); ++j)
    for (int k = 0; k < grid.intervals(j); ++k) {
      signs.push_back(grid.interval(j, k).is_empty() ? 1 : 0);
      signs.push_back(grid.is_event(j, k) ? 1 : 0);
    }
  const auto add = [&](const VectorXd& lower, const VectorXd& upper) {
    for (int i = 0; i < lower.size(); ++i)
      signs.push_back(static_cast<char>((std::isfinite(lower[i]) ? 1 : 0) +
                                        (std::isfinite(upper[i]) ? 2 : 0) +
                                        (lower[i] == upper[i] ? 4 : 0)));
  };
  add(program.lower(), program.upper());
  add(program.row_lower(), program.row_upper());
  for (const shooting::CostInstance& instance : program.cost_instances())
    signs.push_back(program.weight(instance.block, instance.output) != 0.0 ? 1 : 0);
  for (const shooting::ChangeInstance& instance : program.change_instances())
    for (int i = 0; i < program.block_outputs(instance.block); ++i)
      signs.push_back(program.weight(instance.block, i) != 0.0 ? 1 : 0);
  return signs;
}

// Samples (f | grad f + J' lambda | g - side | side of bounds). Each part has a separate error.
class Sampler {
 public:
  Sampler(ShootingProgram& program, const OptimumSystem& optimum)
      : program_(program),
        optimum_(optimum),
        jacobian_(program.jacobian_pattern().entries()),
        rows_(program.rows()) {
    const int n = program.variables(), m = program.rows();
    starts = {0, 1, 1 + n, 1 + n + m, 1 + 2 * n + m};
  }

  bool operator()(VectorXd& values) {
    const NlpPoint& point = optimum_.point();
    const int n = program_.variables(), m = program_.rows();
    values.setZero(starts.back());
    auto gradient = values.segment(starts[1], n);
    if (!program_.objective(point.w.data(), values[0]) ||
        !program_.gradient(point.w.data(), gradient.data()) ||
        !program_.constraints(point.w.data(), rows_.data()) ||
        !program_.jacobian(point.w.data(), jacobian_.data()))
      return false;
    program_.jacobian_pattern().for_each(
        [&](int r, int c, int e) { gradient[c] += point.lambda[r] * jacobian_[e]; });
    for (int r = 0; r < m; ++r) {
      const int side = optimum_.row_side(r);
      const double from =
          side == 0 ? 0.0 : (side > 0 ? program_.row_upper() : program_.row_lower())[r];
      values[starts[2] + r] = rows_[r] - from;
    }
    for (int i = 0; i < n; ++i)
      if (const int side = optimum_.bound_side(i); side != 0)
        values[starts[3] + i] = (side > 0 ? program_.upper() : program_.lower())[i];
    return values.allFinite();
  }

  std::array<int, 5> starts{};

 private:
  ShootingProgram& program_;
  const OptimumSystem& optimum_;
  std::vector<double> jacobian_;
  VectorXd rows_;
};

double largest(const Eigen::Ref<const VectorXd>& v) {
  return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0;
}

// Central differences of the samples. Between calls the program is at theta.
class Slopes {
 public:
  Slopes(ShootingProgram& program, const OptimumSystem& optimum,
         const std::function<void(double)>& move)
      : sample(program, optimum), program_(program), move_(move), here_(structure(program)) {
    can_start_ = sample(middle_);
  }

  /// False if the two sides cannot be compared.
  bool at(double h, VectorXd& slope) {
    const bool valid = can_start_ && visit(h, above_) && visit(-h, below_);
    move_(0.0);
    if (!valid) return false;
    slope = (above_ - below_) / (2.0 * h);
    bend = largest(above_ - 2.0 * middle_ + below_) / h / (1.0 + largest(slope));
    return true;
  }

  Sampler sample;
  double bend = 0.0;  ///< relative difference of the one-sided slopes

 private:
  bool visit(double d, VectorXd& values) {
    try {
      move_(d);
      return structure(program_) == here_ && sample(values);
    } catch (const DefinitionError&) {  // events change order, or bounds contradict each other
      return false;
    }
  }

  ShootingProgram& program_;
  const std::function<void(double)>& move_;
  std::vector<char> here_;
  VectorXd above_, middle_, below_;
  bool can_start_ = false;
};

constexpr int parts = 4;

struct Extrapolation {
  VectorXd best;
  std::array<double, parts> error{};
  bool has_kink = false;
};

// Returns false if a step is impossible.
bool extrapolate(Slopes& slopes, double first_step, Extrapolation& result) {
  const auto& starts = slopes.sample.starts;
  result.error.fill(infinity);
  std::vector<VectorXd> before, now;  // rows of the tableau
  double step = first_step, bend_before = 0.0;
  for (int level = 0; level < levels; ++level, step *= shrink) {
    now.assign(1, VectorXd());
    if (!slopes.at(step, now[0])) return false;
    if (level == 0) result.best = now[0];
    // For a smooth function, the difference of slopes halves with the step.
    if (level == 1) result.has_kink = slopes.bend > kinked && slopes.bend > 0.75 * bend_before;
    bend_before = slopes.bend;
    bool better = level == 0;
    double weight = 1.0;
    for (int k = 1; k <= level; ++k) {
      weight /= shrink * shrink;
      now.push_back(now[k - 1] + (now[k - 1] - before[k - 1]) / (weight - 1.0));
      for (int p = 0; p < parts; ++p) {
        const int first = starts[p], count = starts[p + 1] - first;
        const auto part = [&](const VectorXd& v) { return v.segment(first, count); };
        const double change = std::max(largest(part(now[k]) - part(now[k - 1])),
                                       largest(part(now[k]) - part(before[k - 1])));
        if (!(change < result.error[p])) continue;
        result.error[p] = change;
        result.best.segment(first, count) = part(now[k]);
        better = better || change > enough * (1.0 + largest(part(now[k])));
      }
    }
    before = now;
    if (level > 1 && !better) break;
  }
  return true;
}

}  // namespace

DifferenceStatus difference(ShootingProgram& program, const OptimumSystem& optimum, StepRange steps,
                            const std::function<void(double)>& move, ParametricRates& rates) {
  Slopes slopes(program, optimum, move);
  Extrapolation result;
  double h = steps.first;
  while (h >= steps.smallest && !extrapolate(slopes, h, result)) h *= after_failure;
  if (h < steps.smallest) return DifferenceStatus::other_terms;
  if (result.has_kink) return DifferenceStatus::kink;

  const auto& starts = slopes.sample.starts;
  const auto part = [&](int p) {
    return result.best.segment(starts[p], starts[p + 1] - starts[p]);
  };
  rates.objective = result.best[0];
  rates.gradient = part(1);
  rates.rows = part(2);
  rates.bounds = part(3);
  rates.error = 0.0;
  for (int p = 0; p < parts; ++p)
    rates.error = std::max(rates.error, result.error[p] / (1.0 + largest(part(p))));
  return DifferenceStatus::success;
}

}  // namespace saltus
