// The sparse linear algebra against dense matrices, on programs with every kind of row and bound.
#include "saltus/qp/sparse_system.hpp"

#include <gtest/gtest.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "saltus/qp/kkt_system.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/random_qp.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus {
namespace {

using namespace testing;
static_assert(qp::KktSystem<qp::SparseSystem>);

// H, g, E, e, G and beta of a program whose fixed variables keep their columns.
struct Dense {
  explicit Dense(const qp::SparseQp& qp) {
    const int n = qp.variables();
    MatrixXd J = MatrixXd::Zero(qp.row_pattern.rows(), n);
    qp.row_pattern.for_each([&](int i, int j, int entry) { J(i, j) = qp.rows[entry]; });
    H = MatrixXd::Zero(n, n);
    qp.hessian_pattern.for_each(
        [&](int i, int j, int entry) { H(i, j) = H(j, i) = qp.hessian[entry]; });
    g = qp.gradient;
    for (int i = 0; i < n; ++i) {
      if (qp.lower[i] != qp.upper[i]) continue;
      fixed.push_back(i);
      const VectorXd column = H.col(i);
      g += column * qp.lower[i];
      offset = J * VectorXd::Unit(n, i) * qp.lower[i] + (offset.size() ? offset : J.col(i) * 0.0);
      H.row(i).setZero();
      H.col(i).setZero();
    }
    if (offset.size() == 0) offset = VectorXd::Zero(J.rows());
    for (const int i : fixed) {
      J.col(i).setZero();
      g[i] = 0.0;
    }
    for (int i = 0; i < J.rows(); ++i) {
      if (qp.row_lower[i] == qp.row_upper[i]) {
        add(E, e, J.row(i), qp.row_lower[i] - offset[i]);
        continue;
      }
      if (qp.row_lower[i] > -infinity) add(G, beta, J.row(i), qp.row_lower[i] - offset[i]);
      if (qp.row_upper[i] < infinity) add(G, beta, -J.row(i), offset[i] - qp.row_upper[i]);
    }
    for (int i = 0; i < n; ++i) {
      if (qp.lower[i] == qp.upper[i]) continue;
      const Eigen::RowVectorXd unit = VectorXd::Unit(n, i).transpose();
      if (qp.lower[i] > -infinity) add(G, beta, unit, qp.lower[i]);
      if (qp.upper[i] < infinity) add(G, beta, -unit, -qp.upper[i]);
    }
    if (E.cols() == 0) E.resize(0, n);
    if (G.cols() == 0) G.resize(0, n);
  }
  static void add(MatrixXd& rows, VectorXd& sides, const Eigen::RowVectorXd& row, double side) {
    rows.conservativeResize(rows.rows() + 1, row.size());
    rows.bottomRows(1) = row;
    sides.conservativeResize(sides.size() + 1);
    sides[sides.size() - 1] = side;
  }
  MatrixXd H, E, G;
  VectorXd g, e, beta, offset;
  std::vector<int> fixed;
};

// Arrays in the form that the interior-point method passes.
struct Arrays {
  explicit Arrays(const qp::SparseSystem& system)
      : v(system.max_variables()),
        dv(system.max_variables()),
        y(system.max_equalities()),
        dy(system.max_equalities()),
        lambda(system.max_sides()),
        side(system.max_sides()) {}
  qp::AlignedArray v, dv, y, dy, lambda, side;
};

VectorXd head(const qp::AlignedArray& a, Eigen::Index n) {
  return Eigen::Map<const VectorXd>(a.data(), n);
}
void fill(qp::AlignedArray& a, const VectorXd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) a[i] = values[i];
}
double difference(const VectorXd& a, const VectorXd& b) {
  return a.size() == 0 ? 0.0 : (a - b).lpNorm<Eigen::Infinity>();
}

// The data of the last solution are valid for its program only.
TEST(SparseSystem, RecomputesProductsForAnotherProgram) {
  const std::vector<std::pair<int, int>> squares{{0, 0}, {1, 1}}, entries{{0, 0}, {0, 1}};
  qp::SparseQp qp(SparsityPattern::from_pairs(2, 2, squares),
                  SparsityPattern::from_pairs(1, 2, entries));
  qp.hessian.setOnes();
  qp.rows << 1.0, 2.0;
  qp.row_lower << 5.0;
  qp.row_upper << 5.0;
  qp::SparseSystem system(qp.hessian_pattern, qp.row_pattern);
  ASSERT_TRUE(system.load(qp));
  Arrays a(system);
  ASSERT_TRUE(system.factor(a.side.data()));
  fill(a.y, VectorXd::Constant(1, -5.0));  // the residual of the row at zero
  system.solve(a.v.data(), a.y.data(), a.dv.data(), a.dy.data());
  ASSERT_NEAR(a.dv[0], 1.0, 1e-12);
  ASSERT_NEAR(a.dv[1], 2.0, 1e-12);
  qp.row_upper << infinity;
  ASSERT_TRUE(system.load(qp));
  system.multiply(a.dv.data(), a.side.data());
  EXPECT_NEAR(a.side[0], 5.0, 1e-12);
}

TEST(SparseSystem, AgreesWithDenseMatrices) {
  for (int seed = 1; seed <= 100; ++seed) {
    const qp::SparseQp qp = to_sparse(random_qp(seed, {.rank_deficient = 0.0}).qp);
    Dense dense(qp);
    qp::SparseSystem system(qp.hessian_pattern, qp.row_pattern);
    ASSERT_TRUE(system.load(qp));
    EXPECT_GE(system.cost_unit(), 1.0);
    dense.H /= system.cost_unit();
    dense.g /= system.cost_unit();
    const Eigen::Index n = qp.variables(), p = dense.e.size(), m = dense.beta.size();
    ASSERT_EQ(system.variables(), qp::padded(static_cast<int>(n)));
    ASSERT_EQ(system.equalities(), qp::padded(static_cast<int>(p)));
    ASSERT_EQ(system.sides(), qp::padded(static_cast<int>(m)));
    EXPECT_EQ(Eigen::Map<const VectorXd>(system.active(), system.sides()).sum(),
              static_cast<double>(m));
    EXPECT_LT(difference(Eigen::Map<const VectorXd>(system.beta(), m), dense.beta), 1e-13);

    Random random(seed);
    VectorXd v = random.vector(n);
    for (const int i : dense.fixed) v[i] = 0.0;
    const VectorXd y = random.vector(p), lambda = random.vector(m);
    Arrays a(system);
    fill(a.v, v);
    fill(a.y, y);
    fill(a.lambda, lambda);
    system.evaluate(a.v.data(), a.y.data(), a.lambda.data(), a.dv.data(), a.dy.data(),
                    a.side.data());
    const double rounding =
        1e-15 * (300.0 + dense.g.lpNorm<Eigen::Infinity>());  // about ten products
    EXPECT_LT(difference(head(a.dv, n), dense.H * v + dense.g + dense.E.transpose() * y -
                                            dense.G.transpose() * lambda),
              rounding);
    EXPECT_LT(difference(head(a.dy, p), dense.E * v - dense.e), rounding);
    EXPECT_LT(difference(head(a.side, m), dense.G * v), rounding);
    std::fill_n(a.dv.data(), system.variables(), 0.0);
    system.add_transposed(a.lambda.data(), a.dv.data());
    EXPECT_LT(difference(head(a.dv, n), dense.G.transpose() * lambda), rounding);

    // Weights of rows from far inside their bounds to directly on them.
    VectorXd w(m);
    for (Eigen::Index i = 0; i < m; ++i) w[i] = random.log_uniform(1e-10, 1e8);
    fill(a.side, w);
    ASSERT_TRUE(system.factor(a.side.data()));
    VectorXd rv = random.vector(n);
    for (const int i : dense.fixed) rv[i] = 0.0;
    const VectorXd ry = random.vector(p);
    fill(a.v, rv);
    fill(a.y, ry);
    system.solve(a.v.data(), a.y.data(), a.dv.data(), a.dy.data());
    const VectorXd dv = head(a.dv, n), dy = head(a.dy, p);
    for (const int i : dense.fixed) EXPECT_EQ(dv[i], 0.0);
    const VectorXd push = dense.G.transpose() * (w.asDiagonal() * (dense.G * dv));
    const double size = 1.0 + push.lpNorm<Eigen::Infinity>() + dv.lpNorm<Eigen::Infinity>() +
                        (p ? dy.lpNorm<Eigen::Infinity>() : 0.0);
    EXPECT_LT(difference(dense.H * dv + push + dense.E.transpose() * dy, -rv), 1e-6 * size) << seed;
    EXPECT_LT(difference(dense.E * dv, -ry), 1e-11 * size) << seed;
  }
}

TEST(SparseSystem, DoesNotAllocateAfterConstruction) {
  const RandomQp random = random_qp(7, {.equality_rows = 1.0, .soft_rows = 1.0});
  qp::SparseQp qp = to_sparse(random.qp);
  qp::SparseSystem system(qp.hessian_pattern, qp.row_pattern);
  Arrays a(system);
  PrimalDualPoint point{VectorXd::Zero(qp.variables()), VectorXd::Zero(qp.row_pattern.rows()),
                        VectorXd::Zero(qp.variables())};
  const AllocationCount count;
  for (int kind = 0; kind < 3; ++kind) {
    // Other finite sides, other equalities, other fixed variables.
    if (kind == 1) qp.row_lower = qp.row_upper.cwiseMin(1.0);
    if (kind == 2) qp.lower.setConstant(qp.upper[0] = -1.0);
    system.load(qp);
    system.load_point(point, a.v.data(), a.y.data(), a.lambda.data());
    system.evaluate(a.v.data(), a.y.data(), a.lambda.data(), a.dv.data(), a.dy.data(),
                    a.side.data());
    for (int i = 0; i < system.sides(); ++i) a.side[i] = 1.0 + i;
    system.factor(a.side.data());
    system.solve(a.v.data(), a.y.data(), a.dv.data(), a.dy.data());
    system.unload_point(qp, a.v.data(), a.y.data(), a.lambda.data(), point);
  }
  EXPECT_EQ(count.made(), 0);
}

// A very small cost. The first regularisation dominates it, and refinement does not recover enough
// accuracy. The solver must take the next regularisation and return its solution.
TEST(SparseSystem, ReplacesAPoorFactor) {
  constexpr double small = 4e-13;
  const SparsityPattern hessian = SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 1}});
  qp::SparseQp qp(hessian, SparsityPattern::from_pairs(0, 2, {}));
  qp.hessian << 1.0, small;
  qp::SparseSystem system(qp.hessian_pattern, qp.row_pattern);
  ASSERT_TRUE(system.load(qp));
  Arrays a(system);
  std::fill_n(a.side.data(), system.max_sides(), 0.0);
  ASSERT_TRUE(system.factor(a.side.data()));
  fill(a.v, Vec<double, 2>(1.0, -1.0));
  system.solve(a.v.data(), a.y.data(), a.dv.data(), a.dy.data());
  EXPECT_EQ(system.regularisation_changes(), 1);
  EXPECT_NEAR(a.dv[0], -1.0, 1e-12);
  // Refinement stops when the residual reaches the rounding of its terms.
  EXPECT_NEAR(a.dv[1] * small, 1.0, 1e-3);
}

#if defined(__GLIBC__)
// SparseLdl frees the memory of CHOLMOD. A leak of one factor each time would be 300 kB.
TEST(SparseLdl, FreesItsMemory) {
  constexpr int n = 200;
  std::vector<std::pair<int, int>> diagonal;
  for (int i = 0; i < n; ++i) diagonal.emplace_back(i, i);
  const SparsityPattern pattern = SparsityPattern::from_pairs(n, n, diagonal);
  const auto in_use = [&](int rounds) {
    for (int i = 0; i < rounds; ++i)
      const qp::SparseLdl ldl(pattern, std::vector<signed char>(n, 1));
    return mallinfo2().uordblks;
  };
  const std::size_t before = in_use(1);
  EXPECT_LT(in_use(50), before + 10000);
}
#endif

TEST(SparseLdl, ChecksSignsOfPivots) {
  qp::SparseLdl ldl(SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}}), {1, -1});
  const auto factor = [&](double a, double b, double c) {
    ldl.set(0, a);
    ldl.set(1, b);
    ldl.set(2, c);
    return ldl.factor();
  };
  EXPECT_TRUE(factor(2.0, 1.0, -3.0));
  VectorXd x = Vec<double, 2>{1.0, 2.0};  // [2 1; 1 -3] [5/7; -3/7] = [1; 2]
  ldl.solve(x.data());
  EXPECT_NEAR(x[0], 5.0 / 7.0, 1e-15);
  EXPECT_NEAR(x[1], -3.0 / 7.0, 1e-15);
  EXPECT_FALSE(factor(2.0, 1.0, 3.0));  // two positive pivots
  EXPECT_FALSE(factor(-2.0, 1.0, -3.0));
  EXPECT_FALSE(factor(0.0, 0.0, -3.0));  // singular
  EXPECT_TRUE(factor(2.0, 1.0, -3.0));   // the singular matrix leaves no state behind
}

}  // namespace
}  // namespace saltus
