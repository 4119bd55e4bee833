// Each entry is read exactly once, and no other entry shares its lane in that pass.
#include "saltus/model/make_function.hpp"

#include <gtest/gtest.h>

#include <random>

#include "saltus/core/types.hpp"

namespace saltus {
namespace {

SparsityPattern random_pattern(int rows, int cols, double density, bool lower, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < cols; ++j)
      if ((!lower || j <= i) && random() < density * 4294967296.0) pairs.emplace_back(i, j);
  return SparsityPattern::from_pairs(rows, cols, pairs);
}

// A matrix with this pattern whose entries are 1, 2, 3, ...
MatrixXd numbered(const SparsityPattern& pattern) {
  MatrixXd m = MatrixXd::Zero(pattern.rows(), pattern.cols());
  pattern.for_each([&](int r, int c, int e) { m(r, c) = e + 1; });
  return m;
}

TEST(Seeding, JacobianEntriesAreRecovered) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const auto pattern = random_pattern(7, 13, 0.05 + 0.02 * seed, false, seed);
    const MatrixXd m = numbered(pattern);
    VectorXd entries = VectorXd::Zero(pattern.entries());
    for (const detail::JacobianPass& pass : detail::jacobian_passes(pattern, 4)) {
      MatrixXd directions = MatrixXd::Zero(13, 4);
      for (const detail::Seed& s : pass.seeds) directions(s.input, s.lane) = 1.0;
      const MatrixXd answer = m * directions;
      for (const detail::Reading& r : pass.readings) entries[r.entry] += answer(r.row, r.lane);
    }
    EXPECT_EQ(entries, VectorXd::LinSpaced(pattern.entries(), 1.0, pattern.entries()));
  }
}

TEST(Seeding, HessianEntriesAreRecovered) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const auto pattern = random_pattern(11, 11, 0.05 + 0.02 * seed, true, seed);
    const MatrixXd lower = numbered(pattern);
    MatrixXd m = lower + lower.transpose();
    m.diagonal() = lower.diagonal();
    VectorXd entries = VectorXd::Zero(pattern.entries());
    for (const detail::HessianPass& pass : detail::hessian_passes(pattern, 4)) {
      VectorXd outer = VectorXd::Zero(11);
      MatrixXd inner = MatrixXd::Zero(11, 4);
      for (int j : pass.outer) outer[j] = 1.0;
      for (const detail::Seed& s : pass.seeds) inner(s.input, s.lane) = 1.0;
      const VectorXd answer = (m * inner).transpose() * outer;
      for (const detail::Reading& r : pass.readings) entries[r.entry] += answer[r.lane];
    }
    EXPECT_EQ(entries, VectorXd::LinSpaced(pattern.entries(), 1.0, pattern.entries()));
  }
}

TEST(Seeding, StructureSavesPasses) {
  std::vector<std::pair<int, int>> diagonal, arrow;
  for (int i = 0; i < 32; ++i) diagonal.emplace_back(i, i);
  for (int i = 0; i < 32; ++i) arrow.emplace_back(31, i);
  EXPECT_EQ(detail::jacobian_passes(SparsityPattern::from_pairs(32, 32, diagonal), 4).size(), 1u);
  EXPECT_EQ(detail::hessian_passes(SparsityPattern::from_pairs(32, 32, diagonal), 4).size(), 8u);
  EXPECT_EQ(detail::hessian_passes(SparsityPattern::from_pairs(32, 32, arrow), 4).size(), 8u);
  EXPECT_TRUE(detail::hessian_passes(SparsityPattern(5, 5), 4).empty());
}

}  // namespace
}  // namespace saltus
