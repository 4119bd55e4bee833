#include "saltus/sequences/dual_bound.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// Largest accepted contributions of gradients over the boxes of their variables, in units of the
// cost. A larger contribution of a state is moved to the costate. This moves noise over wide boxes,
// but not multipliers of bounds. For a larger contribution of an input, curvature is tried as a
// tighter limit. All combinations are tried until the bound is sufficient.
struct Allowance {
  double moving, holding;
};
constexpr Allowance allowances[] = {{1e-7, 1e-6}, {1e-10, 1e-12}, {1e-4, 1e-12}};
// Relative curvature below which a direction is flat.
constexpr double flat = 1e-12;
// Assumed limit of an input without bounds and curvature: this multiple of its size at the point.
// Proofs, where sizes are unknown, use the second value.
constexpr double far = 1e3, farthest = 1e8;
// Rounding of a sum, relative to the magnitudes of its terms.
constexpr double ulps = 1e-15;
// A proof must exceed this fraction of the terms that it adds.
constexpr double rounding = 1e-9;

// min r d over -down <= d <= up.
double min_over_box(double r, double down, double up) {
  if (r == 0.0) return 0.0;
  return r > 0.0 ? -r * down : r * up;
}

// min over d of r'd + 1/2 d'H d, with |d| <= `reach` in directions where H is flat.
double min_over_curvature(const qp::Stage& s, InputHold& hold, const VectorXd& r, double reach) {
  if (hold.curvature.size() == 0) {
    MatrixXd H(s.nx + s.nu, s.nx + s.nu);
    H << s.Q.topLeftCorner(s.nx, s.nx), s.S.topLeftCorner(s.nu, s.nx).transpose(),
        s.S.topLeftCorner(s.nu, s.nx), s.R.topLeftCorner(s.nu, s.nu);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(H);
    hold.directions = eigen.eigenvectors();
    hold.curvature = eigen.eigenvalues();
  }
  const VectorXd along = hold.directions.transpose() * r;
  const double largest = hold.curvature.cwiseAbs().maxCoeff();
  double least = 0.0;
  for (int i = 0; i < along.size(); ++i)
    least -= hold.curvature[i] > flat * largest ? 0.5 * along[i] * along[i] / hold.curvature[i]
                                                : std::abs(along[i]) * reach;
  return least;
}

struct DualBound {
  double value = 0.0;
  double size = 0.0;  // sum of magnitudes of the terms of `value`, for its rounding error
};

DualBound evaluate(const qp::StageQp& qp, const qp::StagePoint& point,
                   const std::vector<InputHold*>& holds, bool with_costs,
                   const Allowance& allowed) {
  DualBound bound;
  const auto add = [&](double term) {
    bound.value += term;
    bound.size += std::abs(term);
  };
  const int N = qp.intervals();
  VectorXd ahead, behind;  // costates of the next and of the current state
  VectorXd rx, ru, part, value, multiplier, led, loose;
  for (int k = N; k >= 0; --k) {
    const qp::Stage& s = qp.stages[k];
    const qp::StagePoint::AtStage& p = point.stages[k];
    const auto x = p.x.head(s.nx);
    const auto u = p.u.head(s.nu);
    rx.setZero(s.nx);
    ru.setZero(s.nu);
    if (with_costs) {
      const auto Q = s.Q.topLeftCorner(s.nx, s.nx);
      const auto S = s.S.topLeftCorner(s.nu, s.nx);
      const auto R = s.R.topLeftCorner(s.nu, s.nu);
      rx.noalias() += Q * x;
      rx.noalias() += S.transpose() * u;
      ru.noalias() += S * x;
      ru.noalias() += R * u;
      rx += s.q.head(s.nx);
      ru += s.r.head(s.nu);
      add(s.constant);
      add(0.5 * x.dot(rx + s.q.head(s.nx)) + 0.5 * u.dot(ru + s.r.head(s.nu)));
    }
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      const qp::RowGroup& group = s.groups[g];
      const int columns = static_cast<int>(group.columns.size());
      if (group.rows == 0 || (group.soft && !with_costs)) continue;
      const auto M = group.M.topLeftCorner(group.rows, columns);
      part.resize(columns);
      for (int c = 0; c < columns; ++c) {
        const int j = group.columns[c];
        part[c] = j < s.nx ? x[j] : u[j - s.nx];
      }
      value.noalias() = M * part;
      multiplier = p.group[g].head(group.rows);
      for (int i = 0; i < group.rows; ++i) {
        double& m = multiplier[i];
        const double free = group.soft ? group.l1[i] : 0.0;
        if (group.soft && group.l2[i] == 0.0) m = std::clamp(m, -free, free);
        const double side = m > 0.0 ? group.upper[i] : group.lower[i];
        if (std::isinf(side)) m = 0.0;
        if (m == 0.0) continue;
        bound.value += m * (value[i] - side);
        bound.size += std::abs(m * value[i]) + std::abs(m * side);
        // The minimum of l1 s + l2/2 s^2 - |m| s over s >= 0.
        const double over = std::abs(m) - free;
        if (group.soft && over > 0.0) add(-0.5 * over * over / group.l2[i]);
      }
      part.noalias() = M.transpose() * multiplier;
      for (int c = 0; c < columns; ++c) {
        const int j = group.columns[c];
        (j < s.nx ? rx[j] : ru[j - s.nx]) += part[c];
      }
    }
    if (k < N) {
      const int next = qp.stages[k + 1].nx;
      const auto A = s.A.topLeftCorner(next, s.nx);
      const auto B = s.B.topLeftCorner(next, s.nu);
      rx.noalias() += A.transpose() * ahead;
      ru.noalias() += B.transpose() * ahead;
      led = s.b.head(next);
      led.noalias() += A * x;
      led.noalias() += B * u;
      bound.value += ahead.dot(led);
      bound.size += (ahead.array() * led.array()).abs().sum();
    }
    // The state is fixed or within its box. Its costate absorbs what the box does not limit.
    if (k == 0 && qp.fixed_start) {
      add(rx.dot(qp.start.head(s.nx) - x));
    } else {
      behind.setZero(s.nx);
      if (k > 0) behind = point.stages[k - 1].costate.head(s.nx);
      for (int j = 0; j < s.nx; ++j) {
        const double left = rx[j] - behind[j];
        const double least = min_over_box(left, x[j] - s.x_lower[j], s.x_upper[j] - x[j]);
        if (k > 0 && least < -allowed.moving)
          behind[j] = rx[j];
        else
          add(least);
      }
      add(-behind.dot(x));
      ahead.swap(behind);
    }
    // Inputs are limited by their boxes or by curvature.
    loose.setZero(s.nx + s.nu);
    double size = 1.0, over_boxes = 0.0;
    for (int j = 0; j < s.nu; ++j) {
      const double reach = holds[k]->radius[j];
      const double least = min_over_box(ru[j], u[j] - std::max(s.u_lower[j], -reach),
                                        std::min(s.u_upper[j], reach) - u[j]);
      if (with_costs ? least >= -allowed.holding : std::isfinite(least)) {
        add(least);
        continue;
      }
      loose[s.nx + j] = ru[j];
      over_boxes += least;
      size = std::max(size, std::abs(u[j]));
    }
    if (over_boxes == 0.0) continue;
    if (!with_costs) {
      add(-loose.lpNorm<1>() * farthest * size);
      continue;
    }
    add(std::max(over_boxes, min_over_curvature(s, *holds[k], loose, far * size)));
  }
  return bound;
}

}  // namespace

double dual_bound(const qp::StageQp& qp, const qp::StagePoint& point,
                  const std::vector<InputHold*>& holds, double enough) {
  double best = -infinity;
  for (const Allowance& allowed : allowances) {
    const DualBound bound = evaluate(qp, point, holds, true, allowed);
    if (!std::isnan(bound.value)) best = std::max(best, bound.value - ulps * bound.size);
    if (best >= enough) break;
  }
  return best;
}

bool proves_infeasible(const qp::StageQp& qp, const qp::StagePoint& point,
                       const std::vector<InputHold*>& holds) {
  // The first pass uses the given costates, the second pass costates that remove the gradient of
  // the states.
  for (const double moving : {infinity, 0.0}) {
    const DualBound bound = evaluate(qp, point, holds, false, {moving, 0.0});
    if (bound.value > rounding * bound.size) return true;
  }
  return false;
}

VectorXd eigenvalues_of(const MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric).eigenvalues();
}

}  // namespace saltus
