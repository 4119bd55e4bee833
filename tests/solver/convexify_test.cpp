// A convexified Hessian is positive definite and within its pattern, and a positive definite
// Hessian is unchanged.
#include "saltus/solver/convexify.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>
#include <vector>

namespace saltus {
namespace {

MatrixXd dense(const SparsityPattern& pattern, const VectorXd& entries) {
  MatrixXd m = MatrixXd::Zero(pattern.rows(), pattern.cols());
  pattern.for_each([&](int r, int c, int e) { m(r, c) = m(c, r) = entries[e]; });
  return m;
}
double lowest_eigenvalue(const MatrixXd& m) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(m).eigenvalues().minCoeff();
}

// Blocks of one to eight variables, with some of their entries missing.
SparsityPattern random_pattern(std::mt19937& random) {
  std::vector<std::pair<int, int>> pairs;
  int n = 0;
  for (int block = 0; block < 6; ++block) {
    const int size = std::uniform_int_distribution<int>(1, 8)(random);
    for (int i = 1; i < size; ++i)
      for (int j = 0; j < i; ++j)
        if (j + 1 == i || std::bernoulli_distribution(0.4)(random))
          pairs.emplace_back(n + i, n + j);
    n += size;
  }
  return with_diagonal(SparsityPattern::from_pairs(n, n, pairs));
}

// Twelve parts of seven variables, coupled by the last two variables like a phase by its duration.
constexpr int parts = 12, part_size = 7, coupling = 2, coupled = parts * part_size + coupling;
SparsityPattern coupled_pattern() {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < coupled; ++i)
    for (int j = 0; j <= i; ++j)
      if (i / part_size == j / part_size || i >= parts * part_size) pairs.emplace_back(i, j);
  return SparsityPattern::from_pairs(coupled, coupled, pairs);
}
// Adds root root' to the entries of a part and the coupling variables.
void add_convex(const SparsityPattern& pattern, int part, const MatrixXd& root, VectorXd& entries) {
  const auto variable = [&](int i) {
    return i < part_size ? part * part_size + i : parts * part_size + i - part_size;
  };
  const MatrixXd all = root * root.transpose();
  for (int i = 0; i < all.rows(); ++i)
    for (int j = 0; j <= i; ++j) entries[pattern.find(variable(i), variable(j))] += all(i, j);
}

TEST(Convexification, ConvexPartsThatShareVariablesAreUnchanged) {
  std::mt19937 random(3);
  std::normal_distribution<double> any;
  const SparsityPattern pattern = coupled_pattern();
  for (const int rank : {3, part_size + coupling}) {
    VectorXd entries = VectorXd::Zero(pattern.entries());
    for (int part = 0; part < parts; ++part) {
      MatrixXd root(part_size + coupling, rank);
      for (double& e : root.reshaped()) e = any(random);
      add_convex(pattern, part, root, entries);
    }
    const VectorXd before = entries;
    Convexification(pattern).apply(entries, 1e-6);
    EXPECT_EQ(entries, before) << rank;
  }
}

TEST(Convexification, NegativeCurvatureOfAPartLeavesTheOthersUnchanged) {
  const SparsityPattern pattern = coupled_pattern();
  VectorXd entries = VectorXd::Zero(pattern.entries());
  for (int part = 0; part < parts; ++part)
    add_convex(pattern, part, MatrixXd::Identity(part_size + coupling, part_size + coupling),
               entries);
  const int negative = pattern.find(2, 2), slope = pattern.find(parts * part_size, 2);
  entries[negative] = -1.0;
  entries[slope] = 0.5;
  const MatrixXd before = dense(pattern, entries);
  Convexification(pattern).apply(entries, 1e-6);
  const MatrixXd after = dense(pattern, entries);
  EXPECT_GT(lowest_eigenvalue(after), 0.5);
  EXPECT_LT(after.norm(), 1.1 * before.norm());
  for (int i = part_size; i < parts * part_size; ++i) EXPECT_EQ(after(i, i), before(i, i)) << i;
}

TEST(Convexification, LeavesNoNegativeCurvatureInCoupledParts) {
  std::mt19937 random(11);
  std::normal_distribution<double> any;
  const SparsityPattern pattern = coupled_pattern();
  for (const int largest_part : {64, 4})
    for (int trial = 0; trial < 50; ++trial) {
      VectorXd entries(pattern.entries());
      for (double& e : entries) e = any(random);
      Convexification(pattern, largest_part).apply(entries, 1e-6);
      ASSERT_GT(lowest_eigenvalue(dense(pattern, entries)), -1e-10) << trial;
    }
}

TEST(Convexification, LeavesNoNegativeCurvatureInAnyBlock) {
  for (const int largest_block : {64, 3}) {
    std::mt19937 random(5);
    std::normal_distribution<double> any;
    for (int trial = 0; trial < 200; ++trial) {
      const SparsityPattern pattern = random_pattern(random);
      Convexification convexification(pattern, largest_block);
      VectorXd entries(pattern.entries());
      for (double& e : entries) e = any(random);
      convexification.apply(entries, 1e-6);
      ASSERT_GT(lowest_eigenvalue(dense(pattern, entries)), -1e-12) << trial;
    }
  }
}

TEST(Convexification, FullBlocksKeepEigenvectorsAndAbsoluteEigenvalues) {
  const SparsityPattern pattern = SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}});
  VectorXd entries = Vec<double, 3>{0.0, 2.0, 3.0};  // eigenvalues -1 and 4
  Convexification(pattern).apply(entries, 1e-6);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(dense(pattern, entries));
  EXPECT_NEAR(eigen.eigenvalues()[0], 1.0, 1e-12);
  EXPECT_NEAR(eigen.eigenvalues()[1], 4.0, 1e-12);
}

TEST(Convexification, ConvexBlocksAreUnchanged) {
  std::mt19937 random(7);
  std::normal_distribution<double> any;
  for (const int rank : {2, 4}) {
    MatrixXd root(4, rank);
    for (double& e : root.reshaped()) e = any(random);
    const MatrixXd H = root * root.transpose();
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j <= i; ++j) pairs.emplace_back(i, j);
    const SparsityPattern pattern = SparsityPattern::from_pairs(4, 4, pairs);
    VectorXd entries(pattern.entries());
    pattern.for_each([&](int r, int c, int e) { entries[e] = H(r, c); });
    const VectorXd before = entries;
    Convexification(pattern).apply(entries, 1e-6);
    EXPECT_EQ(entries, before) << rank;
  }
}

}  // namespace
}  // namespace saltus
