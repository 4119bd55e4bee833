// The pivoted factorisation against dense algebra: solutions and inertia of random indefinite
// matrices, including those with equality rows and singular ones.
#include "saltus/qp/sparse_indefinite.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <utility>
#include <vector>

#include "saltus/core/random.hpp"

namespace saltus::qp {
namespace {

// [H J'; J 0] with a sparse indefinite H; every row has an entry at its own variable.
struct Saddle {
  Saddle(Random& random, int n, int m) {
    std::vector<std::pair<int, int>> entries;
    for (int i = 0; i < n + m; ++i) entries.emplace_back(i, i);
    for (int i = 1; i < n; ++i)
      if (random.chance(0.5)) entries.emplace_back(i, random.integer(0, i - 1));
    for (int i = 0; i < m; ++i) {
      entries.emplace_back(n + i, i);
      entries.emplace_back(n + i, random.integer(0, n - 1));
      pairs.emplace_back(i, n + i);
    }
    pattern = SparsityPattern::from_pairs(n + m, n + m, entries);
    dense = MatrixXd::Zero(n + m, n + m);
    pattern.for_each([&](int i, int j, int e) {
      const bool is_zero = i == j && i >= n;
      values.push_back(is_zero ? 0.0 : random.uniform(-1.0, 1.0) * random.log_uniform(1e-3, 1e3));
      dense(i, j) = dense(j, i) = values[e];
    });
  }
  SparseIndefinite factor() const {
    SparseIndefinite result(pattern, pairs);
    for (std::size_t e = 0; e < values.size(); ++e) result.set(static_cast<int>(e), values[e]);
    return result;
  }
  SparsityPattern pattern;
  std::vector<std::pair<int, int>> pairs;
  std::vector<double> values;
  MatrixXd dense;
};

TEST(SparseIndefinite, SolvesAndCountsNegativeEigenvalues) {
  Random random(20261122);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = random.integer(2, 40), m = random.integer(0, n / 2);
    const Saddle saddle(random, n, m);
    const VectorXd eigenvalues =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(saddle.dense).eigenvalues();
    const double size = eigenvalues.cwiseAbs().maxCoeff();
    if (eigenvalues.cwiseAbs().minCoeff() < 1e-10 * size) continue;  // with uncertain sign
    SparseIndefinite factor = saddle.factor();
    EXPECT_EQ(factor.rows(), n + m);
    ASSERT_TRUE(factor.factor(1e-2)) << trial;
    EXPECT_EQ(factor.negative(), (eigenvalues.array() < 0.0).count()) << trial;
    const VectorXd right = random.vector(n + m);
    VectorXd x = right;
    factor.solve(x.data());
    // Backward stable with a pivot threshold of 0.01: a few thousand roundings.
    EXPECT_LT((saddle.dense * x - right).norm(), 1e-12 * (size * x.norm() + 1.0)) << trial;
  }
}

// Pivots are measured relative to their rows and columns.
TEST(SparseIndefinite, SingularityIsIndependentOfUnits) {
  Random random(3);
  for (const double unit : {1e-20, 1.0, 1e20}) {
    Saddle saddle(random, 12, 4);
    const VectorXd right = random.vector(16);
    VectorXd expected = right, x = right;
    SparseIndefinite plain = saddle.factor();
    ASSERT_TRUE(plain.factor(1e-2));
    plain.solve(expected.data());
    for (double& value : saddle.values) value *= unit;
    SparseIndefinite factor = saddle.factor();
    ASSERT_TRUE(factor.factor(1e-2)) << unit;
    EXPECT_EQ(factor.negative(), plain.negative()) << unit;
    factor.solve(x.data());
    EXPECT_LT((unit * x - expected).norm(), 1e-9 * expected.norm()) << unit;
  }
}

TEST(SparseIndefinite, ReportsDependentRows) {
  // The row x0 + x1 occurs twice.
  const SparsityPattern pattern = SparsityPattern::from_pairs(
      4, 4, {{0, 0}, {1, 1}, {2, 0}, {2, 1}, {2, 2}, {3, 0}, {3, 1}, {3, 3}});
  SparseIndefinite factor(pattern, {{0, 2}, {1, 3}});
  pattern.for_each([&](int i, int j, int e) { factor.set(e, i == j && i >= 2 ? 0.0 : 1.0); });
  EXPECT_FALSE(factor.factor(1e-6));
  EXPECT_TRUE(factor.is_singular());
  factor.set(pattern.find(3, 1), 2.0);
  EXPECT_TRUE(factor.factor(1e-6));
  EXPECT_FALSE(factor.is_singular());
  EXPECT_EQ(factor.negative(), 2);
}

}  // namespace
}  // namespace saltus::qp
