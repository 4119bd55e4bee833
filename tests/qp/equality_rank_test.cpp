// Dependent and contradictory equality rows are found, and no others are.
#include "tests/support/equality_rank.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "tests/support/random_qp.hpp"
#include "tests/support/stage_conversion.hpp"
#include "tests/support/unsolvable_qp.hpp"

namespace saltus {
namespace {

using namespace testing;

int count(const std::vector<EqualityRow>& rows, RowRank rank) {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [&](const auto& r) { return r.rank == rank; }));
}

// Rank of all equations of the sparse form: dynamics, start, and rows and bounds with equal sides.
int rank_of_all(const qp::SparseQp& qp, int& equations) {
  const int n = qp.variables(), m = qp.row_pattern.rows();
  MatrixXd rows = MatrixXd::Zero(m + n, n);
  equations = 0;
  for (int i = 0; i < m; ++i) {
    if (qp.row_lower[i] != qp.row_upper[i]) continue;
    for (int e = qp.row_pattern.row_begin(i); e < qp.row_pattern.row_end(i); ++e)
      rows(equations, qp.row_pattern.col(e)) = qp.rows[e];
    ++equations;
  }
  for (int i = 0; i < n; ++i)
    if (qp.lower[i] == qp.upper[i]) rows(equations++, i) = 1.0;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.topRows(equations).transpose());
  qr.setThreshold(1e-10);  // relative to the largest pivot; entries are of order 1
  return static_cast<int>(qr.rank());
}

TEST(EqualityRank, AgreesWithADenseRank) {
  int dependent = 0;
  for (int seed = 1; seed <= 300; ++seed) {
    const RandomQp random = random_qp(
        seed, {.equality_rows = 0.8, .soft_rows = 0.0, .rank_deficient = 0.5, .tight = 0.0});
    const std::vector<EqualityRow> rows = rank_equality_rows(random.qp);
    int equations = 0;
    const int rank = rank_of_all(to_sparse(random.qp), equations);
    EXPECT_EQ(count(rows, RowRank::dependent), equations - rank) << seed << random.describe();
    EXPECT_EQ(count(rows, RowRank::contradictory), 0) << seed << random.describe();
    dependent += equations - rank;
  }
  EXPECT_GT(dependent, 100);
}

TEST(EqualityRank, FindsContradictions) {
  int tried = 0;
  for (int seed = 1; seed <= 300; ++seed) {
    const InfeasibleQp random = infeasible_qp(seed, {.equality_rows = 0.5, .rank_deficient = 0.0});
    if (random.proof.find("contradictory equalities") == std::string::npos) continue;
    ++tried;
    EXPECT_GE(count(rank_equality_rows(random.qp), RowRank::contradictory), 1)
        << seed << ", gap " << random.gap;
  }
  EXPECT_GT(tried, 30);
}

// x_1 = x_0 + u_0, x_2 = x_1 + u_1: with a row on each state and input, one row is redundant.
TEST(EqualityRank, NamesRows) {
  qp::StageQp qp({{1, 1, {{1, 2, false}}}, {1, 1, {{2, 2, false}}}, {1, 0, {{1, 1, false}}}});
  for (int k = 0; k < 2; ++k) qp.stages[k].A(0, 0) = qp.stages[k].B(0, 0) = 1.0;
  const auto demand = [&](int k, int row, double on_x, double on_u, double value) {
    qp::RowGroup& g = qp.stages[k].groups[0];
    g.rows = std::max(g.rows, row + 1);
    g.columns = k < 2 ? std::vector<int>{0, 1} : std::vector<int>{0};
    g.M(row, 0) = on_x;
    if (k < 2) g.M(row, 1) = on_u;
    g.lower[row] = g.upper[row] = value;
  };
  qp.start[0] = 1.0;
  demand(0, 0, 0.0, 2.0, 2.0);   // u_0 = 1
  demand(2, 0, 5.0, 0.0, 10.0);  // x_2 = 2
  EXPECT_EQ(count(rank_equality_rows(qp), RowRank::independent), 2);
  demand(1, 0, 0.0, 1.0, 0.0);  // u_1 = 0 follows
  std::vector<EqualityRow> rows = rank_equality_rows(qp);
  EXPECT_EQ(count(rows, RowRank::dependent), 1);
  EXPECT_EQ(count(rows, RowRank::independent), 2);
  demand(1, 0, 0.0, 1.0, 0.001);
  rows = rank_equality_rows(qp);
  ASSERT_EQ(count(rows, RowRank::contradictory), 1);
  // With a free start the row can be met, and another row is needed to fix the start.
  qp.fixed_start = false;
  EXPECT_EQ(count(rank_equality_rows(qp), RowRank::independent), 3);
  qp.stages[0].x_lower[0] = qp.stages[0].x_upper[0] = 1.0;
  EXPECT_EQ(count(rank_equality_rows(qp), RowRank::contradictory), 1);
  EXPECT_EQ(describe({3, 0, 2, RowRank::contradictory}),
            "row 2 of group 0 of stage 3 contradicts other equality rows");
}

}  // namespace
}  // namespace saltus
