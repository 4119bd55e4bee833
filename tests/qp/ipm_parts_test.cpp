// Separate tests of the parts of the interior-point method, on programs of one or two variables.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/qp/ipm_certificates.hpp"
#include "saltus/qp/ipm_convergence.hpp"
#include "saltus/qp/ipm_residuals.hpp"
#include "saltus/qp/ipm_start.hpp"
#include "saltus/qp/riccati_system.hpp"
#include "saltus/qp/sparse_system.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus::qp {
namespace {

constexpr double rounding = 1e-12;       // error of a few operations on numbers of order one
constexpr double regularisation = 1e-9;  // error of a sparse factor, after refinement

// min 1/2 hessian v'v + gradient'v with bounds; the variables are independent.
SparseQp bounds_alone(const VectorXd& hessian, const VectorXd& gradient) {
  std::vector<std::pair<int, int>> diagonal;
  for (int i = 0; i < hessian.size(); ++i) diagonal.emplace_back(i, i);
  const int n = static_cast<int>(hessian.size());
  SparseQp qp(SparsityPattern::from_pairs(n, n, diagonal), SparsityPattern::from_pairs(0, n, {}));
  qp.hessian = hessian;
  qp.gradient = gradient;
  return qp;
}

struct Loaded {
  explicit Loaded(const SparseQp& qp)
      : system(qp.hessian_pattern, qp.row_pattern),
        point(padded(qp.variables()), 0, system.max_sides()),
        work(system.max_sides()),
        gradient(system.max_variables()),
        equality(0) {
    EXPECT_TRUE(system.load(qp));
  }
  SparseSystem system;
  Iterate point;
  AlignedArray work, gradient, equality;
};

// First iterate of the method.
Iterate started(const SparseQp& qp) {
  Loaded at(qp);
  AlignedArray weights(at.system.max_sides());
  weigh_sides(at.system, weights);
  EXPECT_TRUE(at.system.factor(weights.data()));
  start_least_squares(at.system, weights, at.point, at.work, at.gradient, at.equality);
  return std::move(at.point);
}

// --- starting points ----------------------------------------------------------------------------

// min 1/2 v^2 with v >= 1. The intermediate v = 1/2 violates the bound by 1/2. Slacks are shifted
// by 3/4, then by half of the products divided by the multipliers, and multipliers likewise.
TEST(LeastSquaresStart, MatchesMehrotra) {
  SparseQp qp = bounds_alone(Vec<double, 1>(1.0), Vec<double, 1>(0.0));
  qp.lower[0] = 1.0;
  const Iterate point = started(qp);
  EXPECT_NEAR(point.v[0], 0.5, regularisation);
  EXPECT_NEAR(point.s[0], 0.25 + 0.125, regularisation);
  EXPECT_NEAR(point.lambda[0], 0.5 + 0.25, regularisation);
}

// A bound that is never active changes neither the point nor the slacks of the others.
TEST(LeastSquaresStart, IgnoresInactiveBounds) {
  SparseQp qp = bounds_alone(Vec<double, 1>(1.0), Vec<double, 1>(0.0));
  qp.lower[0] = 1.0;
  qp.upper[0] = 1e9;
  const Iterate point = started(qp);
  EXPECT_NEAR(point.v[0], 0.5, regularisation);
  EXPECT_NEAR(point.s[0], 0.25 + 0.125, regularisation);
  EXPECT_NEAR(point.lambda[0], 0.5 + 0.25, regularisation);
  EXPECT_NEAR(point.s[1], 1e9, 1.0);
  EXPECT_LT(point.lambda[1], 1e-9);
}

// v = 1/4 is inside its bound by 1/4: multipliers are shifted by 3/8.
TEST(LeastSquaresStart, InteriorPointShiftsMultipliers) {
  SparseQp qp = bounds_alone(Vec<double, 1>(1.0), Vec<double, 1>(-0.5));
  qp.lower[0] = 0.0;
  const Iterate point = started(qp);
  EXPECT_NEAR(point.v[0], 0.25, regularisation);
  const double products = 0.25 * 0.125;
  EXPECT_NEAR(point.s[0], 0.25 + 0.5 * products / 0.125, regularisation);
  EXPECT_NEAR(point.lambda[0], 0.125 + 0.5 * products / 0.25, regularisation);
}

// Slacks and multipliers stay positive even if all sides hold with equality.
TEST(LeastSquaresStart, PointOnABoundMovesInside) {
  SparseQp qp = bounds_alone(Vec<double, 1>(1.0), Vec<double, 1>(0.0));
  qp.lower[0] = 0.0;
  const Iterate point = started(qp);
  EXPECT_NEAR(point.s[0], 1e-2, rounding);
  EXPECT_NEAR(point.lambda[0], 1e-2, rounding);
}

// Products equal the barrier parameter. On soft sides, violation and slack account for the gap.
// Multipliers balance the slope of the penalty, or their own product is the barrier parameter.
TEST(StartAtGuess, IsNearTheCentralPath) {
  constexpr double barrier = 1e-2, least = 0.1;
  int balanced = 0, soft = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const auto random = saltus::testing::random_qp(seed, {.soft_rows = 1.0});
    RiccatiSystem system(random.qp, {});
    ASSERT_TRUE(system.pack(random.qp));
    Iterate p(system.variables(), system.equalities(), system.sides());
    AlignedArray work(system.sides()), values(system.sides());
    pack_point(random.qp, random.optimum, system.packed(), false, p.v.data(), nullptr, nullptr);
    start_at_guess(system, barrier, p, work);
    system.multiply(p.v.data(), values.data());
    for (int i = 0; i < system.sides(); ++i) {
      if (system.active()[i] == 0.0) {
        EXPECT_EQ(p.s[i], 1.0);
        EXPECT_EQ(p.lambda[i], 0.0);
        continue;
      }
      const double gap = values[i] - system.beta()[i];
      EXPECT_NEAR(p.s[i] * p.lambda[i], barrier, rounding);
      EXPECT_GE(p.s[i], least);
      if (i < system.first_soft()) {
        EXPECT_EQ(p.s[i], std::max(gap, least));
        continue;
      }
      ++soft;
      EXPECT_GE(p.t[i], least);
      EXPECT_NEAR(gap + p.t[i], p.s[i], rounding * (1.0 + std::abs(gap)));
      const double slope = system.l1()[i] + system.l2()[i] * p.t[i];
      if (slope - p.lambda[i] > barrier / p.t[i]) {
        ++balanced;
        EXPECT_NEAR(p.lambda[i] + p.tau[i], slope, rounding * (1.0 + slope));
      } else {
        EXPECT_NEAR(p.t[i] * p.tau[i], barrier, rounding);
      }
    }
  }
  EXPECT_GT(balanced, 20);
  EXPECT_GT(soft - balanced, 0);
}

// With a very small multiplier, the slack becomes a tenth of its row. With a large multiplier, it
// becomes three times the barrier parameter divided by the multiplier.
TEST(WarmStart, SlacksFollowBarrierAndRows) {
  for (const double row : {0.1, 1.0, 5.0}) {
    SparseQp qp(SparsityPattern::from_pairs(1, 1, {{0, 0}}),
                SparsityPattern::from_pairs(1, 1, {{0, 0}}));
    qp.hessian << 1.0;
    qp.rows << row;
    qp.row_lower << 2.0 * row;
    qp.row_upper << infinity;
    Loaded at(qp);
    AlignedArray values(at.system.sides()), size(at.system.sides());
    values[0] = 2.0 * row;
    constexpr double barrier = 1e-2;
    at.point.lambda[0] = 1e-9;
    start_warm(at.system, barrier, values, at.point, size);
    EXPECT_NEAR(at.point.s[0], 0.1 * row, rounding);
    EXPECT_NEAR(at.point.s[0] * at.point.lambda[0], barrier, rounding);
    at.point.lambda[0] = 10.0;
    start_warm(at.system, barrier, values, at.point, size);
    const double grown = std::max(barrier, 3e-4 * 10.0 * row);  // with the multiplier of the row
    EXPECT_NEAR(at.point.s[0], std::min(3.0 * grown / 10.0, 0.1 * row), rounding);
    EXPECT_EQ(at.point.lambda[0], 10.0);
    values[0] = 3.0 * row;  // a slack farther inside is unchanged
    start_warm(at.system, barrier, values, at.point, size);
    EXPECT_NEAR(at.point.s[0], row, rounding);
  }
}

// --- termination --------------------------------------------------------------------------------

// min 1/2 |v|^2 with v_i >= level - slack. The multiplier is `level`, and each side leaves a
// product. The sum of the products is measured relative to the cost if the cost is large.
bool is_reached(double level, double product) {
  constexpr int n = 100;
  SparseQp qp = bounds_alone(VectorXd::Ones(n), VectorXd::Zero(n));
  const double slack = product / level;
  qp.lower.setConstant(level - slack);
  Loaded at(qp);
  for (int i = 0; i < n; ++i) {
    at.point.v[i] = at.point.lambda[i] = level;
    at.point.s[i] = slack;
  }
  for (int i = n; i < at.system.sides(); ++i) at.point.s[i] = 1.0;
  for (int i = 0; i < at.system.sides(); ++i) at.point.t[i] = at.point.tau[i] = 1.0;
  ResidualTracker<SparseSystem> residuals(at.system.variables(), 0, at.system.sides());
  Convergence<SparseSystem> convergence(at.system.variables(), 0, at.system.sides());
  residuals.reset(at.system);
  convergence.reset(/*tolerance=*/1e-8);
  convergence.weigh_multipliers(at.system, at.point);
  residuals.evaluate(at.system, at.point);
  residuals.follow(at.system, at.point, 1.0, convergence.acceptable());
  return convergence.reached(at.system, at.point, residuals);
}

TEST(Convergence, GapIsRelativeToTheCost) {
  EXPECT_TRUE(is_reached(1.0, 9e-11));   // a gap of 9e-9 of a cost of 50
  EXPECT_FALSE(is_reached(0.1, 9e-11));  // and of a cost of 0.5
  EXPECT_TRUE(is_reached(0.1, 2e-11));
  EXPECT_FALSE(is_reached(1.0, 2e-10));  // each product alone is too large
}

// Violation of v <= 1e9 that the residuals show for a slack that is wrong by `error`.
double violation_of_far_side(double error) {
  SparseQp qp = bounds_alone(Vec<double, 1>(1.0), Vec<double, 1>(0.0));
  qp.upper[0] = 1e9;
  Loaded at(qp);
  for (int i = 0; i < at.system.sides(); ++i) {
    at.point.s[i] = at.system.active()[i] != 0.0 ? 1e9 + error : 1.0;
    at.point.lambda[i] = at.point.t[i] = at.point.tau[i] = 0.0;
  }
  ResidualTracker<SparseSystem> residuals(at.system.variables(), 0, at.system.sides());
  residuals.reset(at.system);
  residuals.evaluate(at.system, at.point);
  return residuals.at_point().feasibility;
}

// Numbers near 1e9 are 1.2e-7 apart, so that the residual of such a side need not reach 1e-8.
TEST(Residuals, FarSidesAreMeasuredUpToTheirRounding) {
  const double next = std::nextafter(1e9, 2e9) - 1e9;
  EXPECT_GT(next, 1e-7);
  EXPECT_EQ(violation_of_far_side(0.0), 0.0);
  EXPECT_EQ(violation_of_far_side(next), 0.0);
  EXPECT_GT(violation_of_far_side(20.0 * next), 10.0 * next);
  EXPECT_NEAR(violation_of_far_side(1e-3), 1e-3, 1e-6);
}

// --- certificates of infeasibility and unboundedness --------------------------------------------

// One variable between two contradictory sides, with any cost.
TEST(Certificates, CrossedBoundsAreACertificate) {
  for (const double cost : {0.0, 1.0, 1e3}) {
    SparseQp qp(SparsityPattern::from_pairs(1, 1, {{0, 0}}),
                SparsityPattern::from_pairs(2, 1, {{0, 0}, {1, 0}}));
    qp.hessian << 1.0;
    qp.gradient << cost;
    qp.rows << 1.0, 1.0;
    qp.row_lower << 1.0, -infinity;
    qp.row_upper << infinity, 0.5;
    Loaded at(qp);
    CertificateSpace space(at.system.variables(), 0, at.system.sides());
    AlignedArray v(at.system.variables()), y(0), lambda(at.system.sides());
    v[0] = 0.25;
    lambda[0] = lambda[1] = 2.0;
    EXPECT_TRUE(is_infeasible(at.system, v, y, lambda, space)) << cost;
    EXPECT_EQ(space.lambda[0], 2.0);
    // One side alone proves nothing, and neither does a multiplier of the wrong sign.
    lambda[1] = 0.0;
    EXPECT_FALSE(is_infeasible(at.system, v, y, lambda, space)) << cost;
    lambda[1] = -2.0;
    EXPECT_FALSE(is_infeasible(at.system, v, y, lambda, space)) << cost;
  }
}

TEST(Certificates, LinearDescentIsUnbounded) {
  const auto is_unbounded_at = [](double gradient, double hessian, double upper, double at_v) {
    SparseQp qp = bounds_alone(Vec<double, 1>(hessian), Vec<double, 1>(gradient));
    qp.upper[0] = upper;
    Loaded at(qp);
    CertificateSpace space(at.system.variables(), 0, at.system.sides());
    AlignedArray v(at.system.variables());
    v[0] = at_v;
    return is_unbounded(at.system, v, space);
  };
  EXPECT_TRUE(is_unbounded_at(-1.0, 0.0, infinity, 1e7));
  EXPECT_TRUE(is_unbounded_at(1.0, 0.0, 2.0, -1e7));
  EXPECT_FALSE(is_unbounded_at(-1.0, 0.0, infinity, 1e5));   // not far
  EXPECT_FALSE(is_unbounded_at(1.0, 0.0, infinity, 1e7));    // the cost increases
  EXPECT_FALSE(is_unbounded_at(-1.0, 1e-3, infinity, 1e7));  // the curvature is positive
  EXPECT_FALSE(is_unbounded_at(-1.0, 0.0, 2.0, 1e7));        // a side blocks the direction
}

}  // namespace
}  // namespace saltus::qp
