// Sparse programs with random stages, couplings, slacks and globals, in which variables and rows
// appear and disappear. Their stages are equivalent, and points convert in both directions.
#include "saltus/qp/stage_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>

#include "saltus/core/error.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "tests/qp/random_staged.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/dense_qp_solver.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/stage_checks.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus {
namespace {

using testing::RandomStaged;

using namespace testing_support;

class RandomStages : public ::testing::TestWithParam<unsigned> {};

TEST_P(RandomStages, AreEquivalentAndPointsRoundTrip) {
  RandomStaged staged(GetParam());
  qp::StageMap map(staged.qp, staged.structure);
  std::mt19937 random(GetParam());
  for (int draw = 0; draw < 4; ++draw) {
    if (draw > 0) staged.draw();
    ASSERT_EQ(map.fill(staged.qp), qp::StageFill::filled) << draw;
    expect_equivalent(staged.qp, map, random);
    expect_same_optimum(staged.qp, map);
    // Updated lists equal lists that are built from scratch.
    qp::StageMap fresh(staged.qp, staged.structure);
    ASSERT_EQ(fresh.fill(staged.qp), qp::StageFill::filled);
    expect_equal(map.stages(), fresh.stages());
    if (HasFailure()) FAIL() << "seed " << GetParam() << ", draw " << draw;
  }
}

TEST_P(RandomStages, DoNotAllocate) {
  RandomStaged first(GetParam());
  std::vector<qp::SparseQp> draws{first.qp};
  for (int i = 0; i < 3; ++i) {
    first.draw();
    draws.push_back(first.qp);
  }
  qp::StageMap map(first.qp, first.structure);
  qp::StagePoint point(map.stages());
  PrimalDualPoint sparse;
  map.fill(first.qp);
  map.convert(first.qp, point, sparse);
  const testing::AllocationCount count;
  for (const qp::SparseQp& qp : draws) {
    map.fill(qp);
    map.convert(qp, point, sparse);
    map.convert(qp, sparse, point);
  }
  EXPECT_EQ(count.made(), 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomStages, ::testing::Range(1u, 101u));

// --- rows written directly into the stages -------------------------------------------------------

// Writes the rows of a sparse program.
struct Written final : qp::DirectRows {
  explicit Written(const qp::SparseQp& rows) : qp(rows) {}
  bool write(std::span<const detail::EntryTarget> targets) noexcept override {
    qp.row_pattern.for_each([&](int r, int, int e) {
      if (qp.row_lower[r] > -infinity || qp.row_upper[r] < infinity)
        *targets[e].to = targets[e].scale * qp.rows[e];
    });
    return true;
  }
  void multiply(const VectorXd& w, VectorXd& rows) const noexcept override {
    rows.setZero();
    qp.row_pattern.for_each([&](int r, int v, int e) { rows[r] += qp.rows[e] * w[v]; });
  }
  void add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept override {
    qp.row_pattern.for_each([&](int r, int v, int e) { gradient[v] += qp.rows[e] * lambda[r]; });
  }
  const qp::SparseQp& qp;
};

// Factor of the dynamics: 1, -1 or another number.
TEST(DirectRows, MatchStagesFilledFromSparseRows) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomStaged staged(seed);
    qp::SparseQp& qp = staged.qp;
    for (std::size_t k = 0; k + 1 < staged.structure.stages.size() && seed % 3 != 0; ++k)
      for (std::size_t i = 0; i < staged.structure.stages[k].dynamics.size(); ++i)
        qp.rows[qp.row_pattern.find(staged.structure.stages[k].dynamics[i],
                                    staged.structure.stages[k + 1].states[i])] =
            seed % 3 == 1 ? 1.0 : -1.0;
    qp::StageMap expected(qp, staged.structure);
    ASSERT_EQ(expected.fill(qp), qp::StageFill::filled);
    const qp::SparseQp source = qp;
    Written rows(source);
    qp::StageMap map(qp, staged.structure);
    qp.rows.setConstant(std::numeric_limits<double>::quiet_NaN());  // only `rows` contains them
    map.write_directly(qp, rows);
    ASSERT_EQ(map.fill(qp, true), qp::StageFill::filled);
    const qp::StageQp &a = map.stages(), &b = expected.stages();
    for (std::size_t k = 0; k < b.stages.size(); ++k) {
      const qp::Stage &s = a.stages[k], &t = b.stages[k];
      ASSERT_EQ(s.nx, t.nx);
      ASSERT_EQ(s.nu, t.nu);
      const int next = k + 1 < b.stages.size() ? b.stages[k + 1].nx : 0;
      const auto expect_near = [&](const auto& x, const auto& y) {
        if (x.size() > 0) {
          EXPECT_LT((x - y).cwiseAbs().maxCoeff(), 1e-14) << "stage " << k;
        }
      };
      expect_near(s.A.topLeftCorner(next, s.nx), t.A.topLeftCorner(next, s.nx));
      expect_near(s.B.topLeftCorner(next, s.nu), t.B.topLeftCorner(next, s.nu));
      expect_near(s.b.head(next), t.b.head(next));
      for (std::size_t g = 0; g < t.groups.size(); ++g) {
        const int rows_of = t.groups[g].rows,
                  columns = static_cast<int>(t.groups[g].columns.size());
        ASSERT_EQ(s.groups[g].rows, rows_of);
        expect_near(s.groups[g].M.topLeftCorner(rows_of, columns),
                    t.groups[g].M.topLeftCorner(rows_of, columns));
      }
    }
  }
}

// --- structures that cannot be staged -----------------------------------------------------------

// x1 = x0 + u with bounds on both, and one row on u.
struct Small {
  Small() {
    structure.stages = {{.states = {0}, .inputs = {1}, .dynamics = {1}, .groups = {{2}}},
                        {.states = {2}}};
    structure.start_rows = {0};
    qp = qp::SparseQp(SparsityPattern::from_pairs(3, 3, {{1, 1}, {2, 2}}),
                      SparsityPattern::from_pairs(3, 3, {{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 1}}));
    qp.hessian << 1.0, 1.0;
    qp.rows << 1.0, -1.0, -1.0, 1.0, 1.0;
    qp.row_lower << 0.5, 0.0, -1.0;
    qp.row_upper << 0.5, 0.0, 1.0;
  }
  qp::SparseQp qp;
  qp::StageStructure structure;
};

std::string refusal(const Small& small) {
  return error_of<DefinitionError>([&] { qp::StageMap map(small.qp, small.structure); },
                                   "accepted");
}

TEST(StageMap, NamesMismatches) {
  EXPECT_EQ(refusal(Small()), "accepted");
  Small without_row;
  without_row.structure.stages[0].groups.clear();
  EXPECT_NE(refusal(without_row).find("row 2 belongs to no stage"), std::string::npos);
  Small without_variable;
  without_variable.structure.stages[0].inputs.clear();
  EXPECT_NE(refusal(without_variable).find("variable 1 belongs to no stage"), std::string::npos);
  Small twice;
  twice.structure.globals = {1};
  EXPECT_NE(refusal(twice).find("variable 1 is named twice"), std::string::npos);
  Small resultants;
  const auto refuses = [&](int first, int size) {
    resultants.structure.stages[0].resultants = {first};
    resultants.structure.stages[0].resultant_size = size;
    return refusal(resultants).find("names inputs that do not exist") != std::string::npos;
  };
  EXPECT_FALSE(refuses(0, 1));
  EXPECT_TRUE(refuses(0, 0));
  EXPECT_TRUE(refuses(-1, 1));
  EXPECT_TRUE(refuses(1, 1));
  Small early;  // the row on u precedes u
  early.structure.stages[1].inputs = {1};
  early.structure.stages[0].inputs.clear();
  EXPECT_NE(refusal(early).find("contains variable 1 of stage 1"), std::string::npos);
}

TEST(StageMap, ChecksAndDropsARowOfVanishedVariables) {
  Small small;
  qp::StageMap map(small.qp, small.structure);
  small.qp.lower[1] = small.qp.upper[1] = 0.5;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
  EXPECT_EQ(map.stages().stages[0].nu, 0);
  EXPECT_EQ(map.stages().stages[0].groups[0].rows, 0);
  EXPECT_EQ(map.stages().stages[0].b[0], 0.5);
  small.qp.lower[1] = small.qp.upper[1] = 1.5;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::infeasible);
}

TEST(StageMap, RejectsTwoVariablesCarriedAsOneState) {
  Small small;  // x0 and u couple with x1 and share a state
  small.structure.carried = {{0, 1}};
  small.qp = qp::SparseQp(SparsityPattern::from_pairs(3, 3, {{1, 1}, {2, 2}, {2, 0}, {2, 1}}),
                          small.qp.row_pattern);
  small.qp.rows << 1.0, -1.0, -1.0, 1.0, 1.0;
  small.qp.row_lower << 0.5, 0.0, -1.0;
  small.qp.row_upper << 0.5, 0.0, 1.0;
  const auto entry = [&](int row, int col) -> double& {
    return small.qp.hessian[small.qp.hessian_pattern.find(row, col)];
  };
  entry(1, 1) = entry(2, 2) = 1.0;
  entry(2, 0) = entry(2, 1) = 0.1;
  qp::StageMap map(small.qp, small.structure);
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::not_staged);
  entry(2, 0) = 0.0;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
  EXPECT_EQ(map.stages().stages[1].nx, 2);
  entry(2, 1) = 0.0;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
  EXPECT_EQ(map.stages().stages[1].nx, 1);
}

// This also holds if the cost is the first entry of the Hessian.
TEST(StageMap, CarriesAStateUntilItsLastCost) {
  Small small;
  small.qp =
      qp::SparseQp(SparsityPattern::from_pairs(3, 3, {{2, 0}, {2, 2}}), small.qp.row_pattern);
  small.qp.rows << 1.0, -1.0, -1.0, 1.0, 1.0;
  small.qp.row_lower << 0.5, 0.0, -1.0;
  small.qp.row_upper << 0.5, 0.0, 1.0;
  qp::StageMap map(small.qp, small.structure);
  for (const double entry : {0.1, 0.0, 0.2}) {
    small.qp.hessian << entry, 1.0;
    EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
    EXPECT_EQ(map.stages().stages[1].nx, entry == 0.0 ? 1 : 2);
  }
}

TEST(StageMap, RejectsDynamicsWithoutEquality) {
  Small small;
  qp::StageMap map(small.qp, small.structure);
  small.qp.row_upper[1] = 1.0;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::not_staged);
  small.qp.row_upper[1] = 0.0;
  EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
}

// A soft row of the second stage depends on the input of the first: x1 = 1/2 + u, 1 <= u + x1 <= 5.
// The input is carried as long as one of its sides exists.
TEST(StageMap, SoftRowWithoutABoundKeepsItsColumns) {
  const auto pattern = SparsityPattern::from_pairs;
  const std::vector<std::pair<int, int>> squares{{1, 1}, {2, 2}},
      entries{{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 1}, {2, 2}, {2, 3}, {2, 4}};
  qp::SparseQp qp(pattern(5, 5, squares), pattern(3, 5, entries));
  qp.hessian << 1.0, 1.0;
  qp.gradient << 0.0, 0.0, 0.0, 10.0, 10.0;
  const auto set = [&](int row, int column, double value) {
    qp.rows[qp.row_pattern.find(row, column)] = value;
  };
  set(0, 0, 1.0);  // x0 = 1/2
  set(1, 0, -1.0), set(1, 1, -1.0), set(1, 2, 1.0);
  set(2, 1, 1.0), set(2, 2, 1.0), set(2, 3, 1.0), set(2, 4, -1.0);
  qp.lower << -infinity, -infinity, -infinity, 0.0, 0.0;
  qp.upper.setConstant(infinity);
  qp.row_lower << 0.5, 0.0, 1.0;
  qp.row_upper << 0.5, 0.0, 5.0;
  qp::StageStructure structure;
  structure.stages.resize(2);
  structure.stages[0] = {.states = {0}, .inputs = {1}, .dynamics = {1}};
  structure.stages[1] = {.states = {2}, .groups = {{2}}};
  structure.start_rows = {0};
  structure.soft_rows = {{2, 3, 4}};
  qp::StageMap map(qp, structure);
  for (const double upper : {5.0, infinity, 5.0}) {
    qp.row_upper[2] = upper;
    ASSERT_EQ(map.fill(qp), qp::StageFill::filled);
    EXPECT_EQ(map.stages().stages[1].nx, 2) << upper;
    expect_same_optimum(qp, map);
  }
}

// --- the solver behind the interface of sparse programs
// ----------------------------------------------

class DenseStages final : public qp::StageQpSolver {
 public:
  qp::QpResult solve(const qp::StageQp& qp, qp::StagePoint& point, bool) noexcept override {
    const StageConversion conversion(qp);
    PrimalDualPoint sparse;
    conversion.convert(qp, point, sparse);
    const qp::QpResult result = make_dense_qp_solver(conversion.sparse().hessian_pattern,
                                                     conversion.sparse().row_pattern, {})
                                    ->solve(conversion.sparse(), sparse, false);
    conversion.convert(sparse, point);
    return result;
  }
  void set_deadline(WallClock::time_point) override {}
};

TEST(StagedSolver, SolvesSparseProgramsByStages) {
  const Small small;
  const auto solver = qp::make_sparse_solver_by_stages(
      small.qp, small.structure,
      [](const qp::StageQp&) { return std::make_unique<DenseStages>(); });
  PrimalDualPoint point{VectorXd::Zero(3), {}, {}};
  EXPECT_EQ(solver->solve(small.qp, point, false).status, qp::QpStatus::optimal);
  // min 1/2 (u^2 + x1^2) with x1 = 1/2 + u
  EXPECT_NEAR(point.w[1], -0.25, 1e-8);
  EXPECT_NEAR(point.w[2], 0.25, 1e-8);
  EXPECT_LE(kkt_residual(small.qp, point).largest(), 1e-8);

  qp::SparseQp other = small.qp;
  other.lower[1] = other.upper[1] = 1.5;  // outside its row
  EXPECT_EQ(solver->solve(other, point, true).status, qp::QpStatus::infeasible);
  other = small.qp;
  other.row_upper[1] = 1.0;
  EXPECT_EQ(solver->solve(other, point, true).status, qp::QpStatus::invalid_problem);
}

TEST(StageMap, GivenStartOutsideItsBoundsIsInfeasible) {
  for (const double sign : {1.0, -1.0}) {
    Small small;  // x0 = 1/2
    small.qp.rows[0] = sign;
    small.qp.row_lower[0] = small.qp.row_upper[0] = 0.5 * sign;
    qp::StageMap map(small.qp, small.structure);
    small.qp.upper[0] = 0.5;
    EXPECT_EQ(map.fill(small.qp), qp::StageFill::filled);
    small.qp.upper[0] = 0.4;
    EXPECT_EQ(map.fill(small.qp), qp::StageFill::infeasible);
    small.qp.upper[0] = infinity;
    small.qp.lower[0] = 0.6;
    EXPECT_EQ(map.fill(small.qp), qp::StageFill::infeasible);
  }
}

}  // namespace
}  // namespace saltus
