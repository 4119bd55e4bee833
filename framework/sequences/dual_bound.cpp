#include "saltus/sequences/dual_bound.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

// What the gradient of a state may cost over its box before it goes into the costate instead, in
// units of the cost: multipliers of bounds stay, noise along wide boxes moves. All are tried.
constexpr double worth_moving[] = {1e-7, 1e-10, 1e-4};
// The same for inputs that curvature may hold better than their boxes do.
constexpr double worth_holding = 1e-10;
// Curvature below this part of the largest counts as none.
constexpr double flat = 1e-12;
// An input without bounds and curvature is no larger than so many times its size at the point; in
// a proof, where sizes are not known, than the second.
constexpr double far = 1e3, farthest = 1e8;
// Rounding of a sum, relative to the magnitudes of its parts.
constexpr double ulps = 1e-15;
// A proof has to exceed this part of the numbers that it adds up.
constexpr double rounding = 1e-9;

// min r d with d from -down to up.
double least_over_box(double r, double down, double up) {
  if (r == 0.0) return 0.0;
  return r > 0.0 ? -r * down : r * up;
}

// min over all d of r'd + 1/2 d'H d, where d is no larger than `reach` along directions in which H
// is flat.
double least_over_curvature(const MatrixXd& H, const VectorXd& r, double reach) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(H);
  const VectorXd along = eigen.eigenvectors().transpose() * r;
  const double largest = std::max(eigen.eigenvalues().cwiseAbs().maxCoeff(), 1e-300);
  double least = 0.0;
  for (int i = 0; i < along.size(); ++i) {
    const double curvature = eigen.eigenvalues()[i];
    const double over_reach = -std::abs(along[i]) * reach;
    least += curvature > flat * largest
                 ? std::max(over_reach, -0.5 * along[i] * along[i] / curvature)
                 : over_reach;
  }
  return least;
}

struct DualBound {
  double value = 0.0;
  double size = 0.0;  // sum of the magnitudes that add up to `value`: its rounding is relative
};

DualBound evaluate(const StageQp& qp, const StagePoint& point,
                   const std::vector<const VectorXd*>& radius, bool with_costs, double moving) {
  DualBound bound;
  const auto add = [&](double term) {
    bound.value += term;
    bound.size += std::abs(term);
  };
  const int N = qp.intervals();
  VectorXd ahead, behind;  // costates of the state to which a stage leads, and of its own
  for (int k = N; k >= 0; --k) {
    const Stage& s = qp.stages[k];
    const StagePoint::AtStage& p = point.stages[k];
    const auto x = p.x.head(s.nx);
    const auto u = p.u.head(s.nu);
    VectorXd rx = VectorXd::Zero(s.nx), ru = VectorXd::Zero(s.nu);
    if (with_costs) {
      const auto Q = s.Q.topLeftCorner(s.nx, s.nx);
      const auto S = s.S.topLeftCorner(s.nu, s.nx);
      const auto R = s.R.topLeftCorner(s.nu, s.nu);
      rx = Q * x + S.transpose() * u + s.q.head(s.nx);
      ru = S * x + R * u + s.r.head(s.nu);
      add(s.constant);
      add(0.5 * x.dot(rx + s.q.head(s.nx)) + 0.5 * u.dot(ru + s.r.head(s.nu)));
    }
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      const RowGroup& group = s.groups[g];
      if (group.soft && !with_costs) continue;
      for (int i = 0; i < group.rows; ++i) {
        double m = p.group[g][i];
        const double free = group.soft ? group.l1[i] : 0.0;
        if (group.soft && group.l2[i] == 0.0) m = std::clamp(m, -free, free);
        const double side = m > 0.0 ? group.upper[i] : group.lower[i];
        if (m == 0.0 || std::isinf(side)) continue;
        double value = 0.0;
        for (std::size_t c = 0; c < group.columns.size(); ++c) {
          const int j = group.columns[c];
          const double entry = group.M(i, static_cast<int>(c));
          value += entry * (j < s.nx ? x[j] : u[j - s.nx]);
          (j < s.nx ? rx[j] : ru[j - s.nx]) += m * entry;
        }
        bound.value += m * (value - side);
        bound.size += std::abs(m * value) + std::abs(m * side);
        // Of the penalty l1 s + l2/2 s^2 the least that |m| s can be below.
        const double over = std::abs(m) - free;
        if (group.soft && over > 0.0) add(-0.5 * over * over / group.l2[i]);
      }
    }
    if (k < N) {
      const int next = qp.stages[k + 1].nx;
      const auto A = s.A.topLeftCorner(next, s.nx);
      const auto B = s.B.topLeftCorner(next, s.nu);
      rx += A.transpose() * ahead;
      ru += B.transpose() * ahead;
      const VectorXd led = A * x + B * u + s.b.head(next);
      bound.value += ahead.dot(led);
      bound.size += (ahead.array() * led.array()).abs().sum();
    }
    // The state: given, or within its box; what the box does not hold its costate takes.
    if (k == 0 && qp.fixed_start) {
      add(rx.dot(qp.start.head(s.nx) - x));
    } else {
      behind = k > 0 ? VectorXd(point.stages[k - 1].costate.head(s.nx)) : VectorXd::Zero(s.nx);
      for (int j = 0; j < s.nx; ++j) {
        const double left = rx[j] - behind[j];
        const double least = least_over_box(left, x[j] - s.x_lower[j], s.x_upper[j] - x[j]);
        if (k > 0 && least < -moving)
          behind[j] = rx[j];
        else
          add(least);
      }
      add(-behind.dot(x));
      ahead = behind;
    }
    // Inputs: within their boxes, or held by curvature.
    VectorXd loose = VectorXd::Zero(s.nx + s.nu);
    double size = 1.0, over_boxes = 0.0;
    for (int j = 0; j < s.nu; ++j) {
      const double reach = (*radius[k])[j];
      const double least = least_over_box(ru[j], u[j] - std::max(s.u_lower[j], -reach),
                                          std::min(s.u_upper[j], reach) - u[j]);
      if (with_costs ? least >= -worth_holding : std::isfinite(least)) {
        add(least);
        continue;
      }
      loose[s.nx + j] = ru[j];
      over_boxes += least;
      size = std::max(size, std::abs(u[j]));
    }
    if (loose.isZero(0.0)) continue;
    if (!with_costs) {
      add(-loose.lpNorm<1>() * farthest * size);
      continue;
    }
    MatrixXd H(s.nx + s.nu, s.nx + s.nu);
    H << s.Q.topLeftCorner(s.nx, s.nx), s.S.topLeftCorner(s.nu, s.nx).transpose(),
        s.S.topLeftCorner(s.nu, s.nx), s.R.topLeftCorner(s.nu, s.nu);
    add(std::max(over_boxes, least_over_curvature(H, loose, far * size)));
  }
  return bound;
}

}  // namespace

double dual_bound(const StageQp& qp, const StagePoint& point,
                  const std::vector<const VectorXd*>& radius, double enough) {
  double best = -infinity;
  for (const double moving : worth_moving) {
    const DualBound bound = evaluate(qp, point, radius, true, moving);
    if (!std::isnan(bound.value)) best = std::max(best, bound.value - ulps * bound.size);
    if (best >= enough) break;
  }
  return best;
}

bool proves_infeasible(const StageQp& qp, const StagePoint& point,
                       const std::vector<const VectorXd*>& radius) {
  // Once with the costates as they are, once with those that leave nothing of the states' gradient.
  for (const double moving : {infinity, 0.0}) {
    const DualBound bound = evaluate(qp, point, radius, false, moving);
    if (bound.value > rounding * bound.size) return true;
  }
  return false;
}

}  // namespace saltus
