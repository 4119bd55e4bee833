// Sparse programs with random stages, couplings, slacks and globals, of which variables and rows
// come and go: are their stages equivalent, and do points go there and back?
#include "saltus/qp/stage_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/qp/sparse_by_stages.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/dense_qp_solver.hpp"
#include "tests/support/stage_checks.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus {
namespace {

using namespace testing_support;

class RandomStaged {
 public:
  explicit RandomStaged(unsigned seed) : random_(seed) {
    make_variables();
    make_rows();
    make_hessian();
    qp = SparseQp(SparsityPattern::from_pairs(variables_, variables_, hessian_),
                  SparsityPattern::from_pairs(rows_, variables_, entries_));
    draw();
  }

  /// New numbers, and what is fixed, bounded or off is drawn anew.
  void draw() {
    w = VectorXd(variables_);
    for (double& entry : w) entry = number();
    for (double& entry : qp.gradient) entry = number();
    qp.constant = number();
    qp.lower.setConstant(-infinity);
    qp.upper.setConstant(infinity);
    for (int v = 0; v < first_slack_; ++v) {
      const bool may_vanish = !is_state_[v];
      if (may_vanish && chance(0.25)) {
        if (chance(0.3)) w[v] = 0.0;
        qp.lower[v] = qp.upper[v] = w[v];
      } else if (chance(0.4)) {
        qp.lower[v] = w[v] - uniform(random_, 0.1, 1.0);
        if (chance(0.5)) qp.upper[v] = w[v] + uniform(random_, 0.1, 1.0);
      }
    }
    const VectorXd scale = VectorXd::Constant(variables_, 1.0) + VectorXd(w.cwiseAbs());
    qp.hessian_pattern.for_each([&](int a, int b, int e) {
      // Dominated by the diagonal; some entries are exactly zero, so that nothing is carried.
      qp.hessian[e] = a == b ? scale[a] : chance(0.3) ? 0.0 : number() / variables_;
    });
    qp.row_pattern.for_each(
        [&](int, int, int e) { qp.rows[e] = std::copysign(uniform(random_, 0.2, 1.2), number()); });
    for (const auto& [row, slack, sign] : slacks_) {
      qp.rows[qp.row_pattern.find(row, slack)] = sign * uniform(random_, 0.5, 2.0);
      const double low = chance(0.5) ? 0.0 : number();
      qp.lower[slack] = w[slack] = low;
      const int h = qp.hessian_pattern.find(slack, slack);
      if (h >= 0) qp.hessian[h] = uniform(random_, 0.5, 2.0);
      // In the slack above its least value the penalty rises from a slope that is not negative.
      qp.gradient[slack] = (h >= 0 && chance(0.5) ? 0.0 : uniform(random_, 0.1, 1.0)) -
                           (h >= 0 ? qp.hessian[h] : 0.0) * low;
    }
    const bool given_start = chance(0.6);
    VectorXd value = VectorXd::Zero(rows_);
    qp.row_pattern.for_each([&](int r, int v, int e) { value[r] += qp.rows[e] * w[v]; });
    for (int r = 0; r < rows_; ++r) {
      const bool start = kind_[r] == Kind::start;
      if (kind_[r] == Kind::dynamics || (start && (given_start || chance(0.3)))) {
        qp.row_lower[r] = qp.row_upper[r] = value[r];
        continue;
      }
      qp.row_lower[r] = -infinity;
      qp.row_upper[r] = infinity;
      if (chance(0.2)) continue;
      const double miss = kind_[r] == Kind::soft && chance(0.5) ? 1.0 : 0.0;
      if (has_lower_[r]) qp.row_lower[r] = value[r] - uniform(random_, 0.05, 0.5) + miss;
      if (has_upper_[r])
        qp.row_upper[r] = std::max(value[r] + uniform(random_, 0.05, 0.5) - miss, qp.row_lower[r]);
    }
  }

  SparseQp qp;
  StageStructure structure;
  VectorXd w;  ///< satisfies everything that is hard

 private:
  enum class Kind { start, dynamics, hard, soft };

  double number() { return uniform(random_, -1.0, 1.0); }
  bool chance(double probability) { return uniform(random_, 0.0, 1.0) < probability; }
  int integer(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  int new_variable(bool is_state) {
    is_state_.push_back(is_state);
    return variables_++;
  }
  int new_row(Kind kind, bool lower, bool upper) {
    kind_.push_back(kind);
    has_lower_.push_back(lower);
    has_upper_.push_back(upper);
    return rows_++;
  }

  void make_variables() {
    const int N = integer(0, 5);
    structure.stages.resize(N + 1);
    for (StageStructure::Stage& s : structure.stages) {
      for (int i = integer(1, 3); i > 0; --i) s.states.push_back(new_variable(true));
      for (int i = integer(0, 3); i > 0; --i) s.inputs.push_back(new_variable(false));
    }
    for (int i = integer(0, 2); i > 0; --i) structure.globals.push_back(new_variable(false));
  }

  // Variables that a row of a stage may contain: mostly its own.
  std::vector<int> draw_columns(int stage) {
    std::vector<int> columns;
    for (int k = 0; k <= stage; ++k)
      for (const std::vector<int>* list :
           {&structure.stages[k].states, &structure.stages[k].inputs})
        for (const int v : *list)
          if (chance(k == stage ? 0.7 : 0.04)) columns.push_back(v);
    for (const int v : structure.globals)
      if (chance(0.15)) columns.push_back(v);
    return columns;
  }

  void make_rows() {
    for (const int v : structure.stages.front().states) {
      structure.start_rows.push_back(new_row(Kind::start, true, chance(0.5)));
      entries_.emplace_back(structure.start_rows.back(), v);
    }
    const int N = static_cast<int>(structure.stages.size()) - 1;
    for (int k = 0; k < N; ++k)
      for (const int v : structure.stages[k + 1].states) {
        structure.stages[k].dynamics.push_back(new_row(Kind::dynamics, true, true));
        entries_.emplace_back(rows_ - 1, v);
        for (const int column : draw_columns(k)) entries_.emplace_back(rows_ - 1, column);
      }
    std::vector<int> soft;
    for (int k = 0; k <= N; ++k)
      for (int g = integer(0, 2); g > 0; --g) {
        std::vector<int>& group = structure.stages[k].groups.emplace_back();
        for (int i = integer(1, 3); i > 0; --i) {
          const bool is_soft = chance(0.4), lower = chance(0.6);
          const int row = new_row(is_soft ? Kind::soft : Kind::hard, lower, !lower || chance(0.5));
          group.push_back(row);
          if (is_soft) soft.push_back(row);
          for (const int column : draw_columns(k)) entries_.emplace_back(row, column);
        }
      }
    first_slack_ = variables_;
    for (const int row : soft) {
      StageStructure::SoftRow s{row, -1, -1};
      const auto slack = [&](double sign) {
        const int v = new_variable(false);
        entries_.emplace_back(row, v);
        slacks_.push_back({row, v, sign});
        if (chance(0.5)) hessian_.emplace_back(v, v);
        return v;
      };
      if (has_lower_[row]) s.below = slack(1.0);
      if (has_upper_[row]) s.above = slack(-1.0);
      structure.soft_rows.push_back(s);
    }
  }

  void make_hessian() {
    for (int a = 0; a < first_slack_; ++a) {
      hessian_.emplace_back(a, a);
      for (int b = 0; b < a; ++b)
        if (chance(a - b < 4 ? 0.3 : 0.03)) hessian_.emplace_back(a, b);
    }
  }

  std::mt19937 random_;
  int variables_ = 0, rows_ = 0, first_slack_ = 0;
  std::vector<std::pair<int, int>> hessian_, entries_;
  std::vector<char> is_state_, has_lower_, has_upper_;
  std::vector<Kind> kind_;
  struct SlackEntry {
    int row, variable;
    double sign;
  };
  std::vector<SlackEntry> slacks_;
};

class RandomStages : public ::testing::TestWithParam<unsigned> {};

TEST_P(RandomStages, AreEquivalentAndPointsGoThereAndBack) {
  RandomStaged staged(GetParam());
  StageMap map(staged.qp, staged.structure);
  std::mt19937 random(GetParam());
  for (int draw = 0; draw < 4; ++draw) {
    if (draw > 0) staged.draw();
    ASSERT_EQ(map.fill(staged.qp), StageFill::filled) << draw;
    expect_equivalent(staged.qp, map, random);
    expect_same_optimum(staged.qp, map);
    // Lists that were changed are those that would be made anew.
    StageMap fresh(staged.qp, staged.structure);
    ASSERT_EQ(fresh.fill(staged.qp), StageFill::filled);
    expect_equal(map.stages(), fresh.stages());
    if (HasFailure()) FAIL() << "seed " << GetParam() << ", draw " << draw;
  }
}

TEST_P(RandomStages, AreFilledAndReadWithoutAllocation) {
  RandomStaged first(GetParam());
  std::vector<SparseQp> draws{first.qp};
  for (int i = 0; i < 3; ++i) {
    first.draw();
    draws.push_back(first.qp);
  }
  StageMap map(first.qp, first.structure);
  StagePoint point(map.stages());
  PrimalDualPoint sparse;
  map.fill(first.qp);
  map.convert(first.qp, point, sparse);
  const testing::AllocationCount count;
  for (const SparseQp& qp : draws) {
    map.fill(qp);
    map.convert(qp, point, sparse);
    map.convert(qp, sparse, point);
  }
  EXPECT_EQ(count.made(), 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomStages, ::testing::Range(1u, 101u));

// --- what cannot be staged ----------------------------------------------------------------------

// x1 = x0 + u, both bounded; one row on u.
struct Small {
  Small() {
    structure.stages = {{.states = {0}, .inputs = {1}, .dynamics = {1}, .groups = {{2}}},
                        {.states = {2}}};
    structure.start_rows = {0};
    qp = SparseQp(SparsityPattern::from_pairs(3, 3, {{1, 1}, {2, 2}}),
                  SparsityPattern::from_pairs(3, 3, {{0, 0}, {1, 0}, {1, 1}, {1, 2}, {2, 1}}));
    qp.hessian << 1.0, 1.0;
    qp.rows << 1.0, -1.0, -1.0, 1.0, 1.0;
    qp.row_lower << 0.5, 0.0, -1.0;
    qp.row_upper << 0.5, 0.0, 1.0;
  }
  SparseQp qp;
  StageStructure structure;
};

std::string refusal(const Small& small) {
  try {
    StageMap map(small.qp, small.structure);
    return "accepted";
  } catch (const DefinitionError& e) {
    return e.what();
  }
}

TEST(StageMap, NamesWhatDoesNotFit) {
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
  Small early;  // the row on u stands before u does
  early.structure.stages[1].inputs = {1};
  early.structure.stages[0].inputs.clear();
  EXPECT_NE(refusal(early).find("contains variable 1 of stage 1"), std::string::npos);
}

TEST(StageMap, RowOfVanishedVariablesIsCheckedAndLeftOut) {
  Small small;
  StageMap map(small.qp, small.structure);
  small.qp.lower[1] = small.qp.upper[1] = 0.5;
  EXPECT_EQ(map.fill(small.qp), StageFill::filled);
  EXPECT_EQ(map.stages().stages[0].nu, 0);
  EXPECT_EQ(map.stages().stages[0].groups[0].rows, 0);
  EXPECT_EQ(map.stages().stages[0].b[0], 0.5);
  small.qp.lower[1] = small.qp.upper[1] = 1.5;
  EXPECT_EQ(map.fill(small.qp), StageFill::infeasible);
}

TEST(StageMap, TwoVariablesCarriedAsOneStateAreRefusedWhileBothAre) {
  Small small;  // x0 and u meet x1, and share a state
  small.structure.carried = {{0, 1}};
  small.qp = SparseQp(SparsityPattern::from_pairs(3, 3, {{1, 1}, {2, 2}, {2, 0}, {2, 1}}),
                      small.qp.row_pattern);
  small.qp.rows << 1.0, -1.0, -1.0, 1.0, 1.0;
  small.qp.row_lower << 0.5, 0.0, -1.0;
  small.qp.row_upper << 0.5, 0.0, 1.0;
  const auto entry = [&](int row, int col) -> double& {
    return small.qp.hessian[small.qp.hessian_pattern.find(row, col)];
  };
  entry(1, 1) = entry(2, 2) = 1.0;
  entry(2, 0) = entry(2, 1) = 0.1;
  StageMap map(small.qp, small.structure);
  EXPECT_EQ(map.fill(small.qp), StageFill::not_staged);
  entry(2, 0) = 0.0;
  EXPECT_EQ(map.fill(small.qp), StageFill::filled);
  EXPECT_EQ(map.stages().stages[1].nx, 2);
  entry(2, 1) = 0.0;
  EXPECT_EQ(map.fill(small.qp), StageFill::filled);
  EXPECT_EQ(map.stages().stages[1].nx, 1);
}

TEST(StageMap, DynamicsThatAreNoEqualityAreRefused) {
  Small small;
  StageMap map(small.qp, small.structure);
  small.qp.row_upper[1] = 1.0;
  EXPECT_EQ(map.fill(small.qp), StageFill::not_staged);
  small.qp.row_upper[1] = 0.0;
  EXPECT_EQ(map.fill(small.qp), StageFill::filled);
}

// --- the solver behind the seam of sparse programs ----------------------------------------------

class DenseStages final : public StageQpSolver {
 public:
  QpResult solve(const StageQp& qp, StagePoint& point, bool) noexcept override {
    const StageConversion conversion(qp);
    PrimalDualPoint sparse;
    conversion.convert(qp, point, sparse);
    const QpResult result = make_dense_qp_solver(conversion.sparse().hessian_pattern,
                                                 conversion.sparse().row_pattern, {})
                                ->solve(conversion.sparse(), sparse, false);
    conversion.convert(sparse, point);
    return result;
  }
  void set_deadline(WallClock::time_point) override {}
};

TEST(StagedSolver, SolvesSparseProgramsByTheirStages) {
  const Small small;
  const auto solver = make_sparse_solver_by_stages(
      small.qp, small.structure, [](const StageQp&) { return std::make_unique<DenseStages>(); });
  PrimalDualPoint point{VectorXd::Zero(3), {}, {}};
  EXPECT_EQ(solver->solve(small.qp, point, false).status, QpStatus::optimal);
  // min 1/2 (u^2 + x1^2) with x1 = 1/2 + u
  EXPECT_NEAR(point.w[1], -0.25, 1e-8);
  EXPECT_NEAR(point.w[2], 0.25, 1e-8);
  EXPECT_LE(kkt_residual(small.qp, point).largest(), 1e-8);

  SparseQp other = small.qp;
  other.lower[1] = other.upper[1] = 1.5;  // outside its row
  EXPECT_EQ(solver->solve(other, point, true).status, QpStatus::infeasible);
  other = small.qp;
  other.row_upper[1] = 1.0;
  EXPECT_EQ(solver->solve(other, point, true).status, QpStatus::invalid_problem);
}

}  // namespace
}  // namespace saltus
