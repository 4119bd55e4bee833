// Sparse programs with random stages, couplings, slacks and globals. Variables and rows appear and
// disappear.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "tests/support/stage_checks.hpp"

namespace saltus::testing {

class RandomStaged {
 public:
  /// With `whole_diagonal` every variable has an entry on the diagonal of the Hessian.
  explicit RandomStaged(unsigned seed, bool whole_diagonal = false)
      : random_(seed), whole_diagonal_(whole_diagonal) {
    make_variables();
    make_rows();
    make_hessian();
    qp = qp::SparseQp(SparsityPattern::from_pairs(variables_, variables_, hessian_),
                      SparsityPattern::from_pairs(rows_, variables_, entries_));
    draw();
  }

  /// Draws new numbers, and a new selection of fixed variables, bounds and inactive rows.
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
        qp.lower[v] = w[v] - testing_support::uniform(random_, 0.1, 1.0);
        if (chance(0.5)) qp.upper[v] = w[v] + testing_support::uniform(random_, 0.1, 1.0);
      }
    }
    const VectorXd scale = VectorXd::Constant(variables_, 1.0) + VectorXd(w.cwiseAbs());
    qp.hessian_pattern.for_each([&](int a, int b, int e) {
      // The diagonal dominates. Some entries are exactly zero, so that no variable is carried.
      qp.hessian[e] = a == b ? scale[a] : chance(0.3) ? 0.0 : number() / variables_;
    });
    qp.row_pattern.for_each([&](int, int, int e) {
      qp.rows[e] = std::copysign(testing_support::uniform(random_, 0.2, 1.2), number());
    });
    for (const auto& [row, slack, sign] : slacks_) {
      qp.rows[qp.row_pattern.find(row, slack)] = sign * testing_support::uniform(random_, 0.5, 2.0);
      const double low = chance(0.5) ? 0.0 : number();
      qp.lower[slack] = w[slack] = low;
      const int h = qp.hessian_pattern.find(slack, slack);
      if (h >= 0) qp.hessian[h] = testing_support::uniform(random_, 0.5, 2.0);
      // The penalty increases in the slack above its least value, with a nonnegative slope.
      qp.gradient[slack] =
          (h >= 0 && chance(0.5) ? 0.0 : testing_support::uniform(random_, 0.1, 1.0)) -
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
      const bool is_two_sided = has_lower_[r] && has_upper_[r];
      const bool loses_lower = is_two_sided && chance(0.2),
                 loses_upper = is_two_sided && !loses_lower && chance(0.2);
      if (has_lower_[r] && !loses_lower)
        qp.row_lower[r] = value[r] - testing_support::uniform(random_, 0.05, 0.5) + miss;
      if (has_upper_[r] && !loses_upper)
        qp.row_upper[r] = std::max(value[r] + testing_support::uniform(random_, 0.05, 0.5) - miss,
                                   qp.row_lower[r]);
    }
  }

  qp::SparseQp qp;
  qp::StageStructure structure;
  VectorXd w;  ///< satisfies all hard constraints

 private:
  enum class Kind { start, dynamics, hard, soft };

  double number() { return testing_support::uniform(random_, -1.0, 1.0); }
  bool chance(double probability) {
    return testing_support::uniform(random_, 0.0, 1.0) < probability;
  }
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
    for (qp::StageStructure::Stage& s : structure.stages) {
      for (int i = integer(1, 3); i > 0; --i) s.states.push_back(new_variable(true));
      for (int i = integer(0, 3); i > 0; --i) s.inputs.push_back(new_variable(false));
    }
    for (int i = integer(0, 2); i > 0; --i) structure.globals.push_back(new_variable(false));
  }

  // Variables that a row of a stage may contain, mostly those of the same stage.
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
      qp::StageStructure::SoftRow s{row, -1, -1};
      const auto slack = [&](double sign) {
        const int v = new_variable(false);
        entries_.emplace_back(row, v);
        slacks_.push_back({row, v, sign});
        if (whole_diagonal_ || chance(0.5)) hessian_.emplace_back(v, v);
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
  bool whole_diagonal_;
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

}  // namespace saltus::testing
