#include "tests/support/equality_rank.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {
namespace {

// Rows have a largest entry of 1. Rounding leaves entries below this tolerance in place of zeros
// after a few hundred operations. The margin allows for data of nine digits.
constexpr double rank_tolerance = 1e-9;

// Rows over (x, u) with their right-hand sides.
class Demands {
 public:
  Demands(int nx, int nu) : nx_(nx), nu_(nu) {}

  // `terms` and `side` are the sizes of the summands of an entry and of its right-hand side. They
  // show how much of the result is rounding.
  void add(VectorXd row, double terms, double side, double size, int label) {
    // Divide by the size of the row, so that entries of different rows are comparable.
    const double unit = row.size() > 0 ? row.lpNorm<Eigen::Infinity>() : 0.0;
    if (unit <= rank_tolerance * terms) {
      row.setZero();
    } else {
      row /= unit;
      side /= unit;
      size /= unit;
    }
    rows_.push_back({std::move(row), side, std::max(size, std::abs(side)), label});
  }
  void demand_of_next(const qp::Stage& s, const Demands& next) {
    const auto A = s.A.topLeftCorner(next.nx_, nx_);
    const auto B = s.B.topLeftCorner(next.nx_, nu_);
    for (const Row& r : next.rows_) {
      const auto c = r.entries.head(next.nx_);
      VectorXd row(nx_ + nu_);
      row << A.transpose() * c, B.transpose() * c;
      VectorXd terms(nx_ + nu_);
      terms << A.cwiseAbs().transpose() * c.cwiseAbs(), B.cwiseAbs().transpose() * c.cwiseAbs();
      const auto b = s.b.head(next.nx_);
      add(std::move(row), terms.size() > 0 ? terms.maxCoeff() : 0.0, r.side - c.dot(b),
          r.size + c.cwiseAbs().dot(b.cwiseAbs()), r.label);
    }
  }
  void eliminate_inputs() { drop(eliminate(nx_, nu_)); }
  void insert_state(const VectorXd& x) {
    for (Row& r : rows_) {
      const auto c = r.entries.head(nx_);
      r.side -= c.dot(x.head(nx_));
      r.size += c.cwiseAbs().dot(x.head(nx_).cwiseAbs());
      r.entries.setZero();
    }
  }
  // Passes rows without entries to `judge` and removes them.
  template <class Judge>
  void judge_empty(Judge&& judge) {
    // Rows with equal parts in x appear after x is eliminated from all but one of them.
    const std::vector<char> pivots = eliminate(0, nx_);
    for (std::size_t i = rows_.size(); i-- > 0;) {
      const Row& r = rows_[i];
      if (pivots[i]) continue;
      judge(r.label, std::abs(r.side) <= rank_tolerance * (1.0 + r.size));
      rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

 private:
  struct Row {
    VectorXd entries;
    double side, size;
    int label;
  };

  // Marks the pivot rows. The other rows have no entries left in these columns.
  std::vector<char> eliminate(int first, int columns) {
    std::vector<char> is_pivot(rows_.size(), 0);
    for (int step = 0; step < columns; ++step) {
      std::size_t best = 0;
      int column = -1;
      double largest = rank_tolerance;
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (is_pivot[i]) continue;
        for (int j = first; j < first + columns; ++j) {
          if (std::abs(rows_[i].entries[j]) <= largest) continue;
          largest = std::abs(rows_[i].entries[j]);
          best = i;
          column = j;
        }
      }
      if (column < 0) break;
      is_pivot[best] = 1;
      const Row& pivot = rows_[best];
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (is_pivot[i]) continue;
        const double factor = rows_[i].entries[column] / pivot.entries[column];
        rows_[i].entries -= factor * pivot.entries;
        rows_[i].entries[column] = 0.0;
        rows_[i].side -= factor * pivot.side;
        rows_[i].size += std::abs(factor) * pivot.size;
      }
    }
    for (std::size_t i = 0; i < rows_.size(); ++i)
      if (!is_pivot[i]) rows_[i].entries.segment(first, columns).setZero();
    return is_pivot;
  }
  void drop(const std::vector<char>& which) {
    for (std::size_t i = rows_.size(); i-- > 0;)
      if (which[i]) rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  int nx_, nu_;
  std::vector<Row> rows_;
};

void add_rows_of_stage(const qp::StageQp& qp, int k, Demands& demands,
                       std::vector<EqualityRow>& found) {
  const qp::Stage& s = qp.stages[k];
  const auto add = [&](VectorXd row, double side, int group, int index) {
    demands.add(std::move(row), 0.0, side, 0.0, static_cast<int>(found.size()));
    found.push_back({k, group, index, RowRank::independent});
  };
  const int n = s.nx + s.nu;
  for (int i = k == 0 && qp.fixed_start ? s.nx : 0; i < n; ++i) {
    const double lower = i < s.nx ? s.x_lower[i] : s.u_lower[i - s.nx];
    const double upper = i < s.nx ? s.x_upper[i] : s.u_upper[i - s.nx];
    if (lower == upper) add(VectorXd::Unit(n, i), lower, -1, i);
  }
  for (std::size_t j = 0; j < s.groups.size(); ++j) {
    const qp::RowGroup& g = s.groups[j];
    for (int i = 0; i < (g.soft ? 0 : g.rows); ++i) {
      if (g.lower[i] != g.upper[i]) continue;
      VectorXd row = VectorXd::Zero(n);
      for (std::size_t c = 0; c < g.columns.size(); ++c) row[g.columns[c]] = g.M(i, c);
      add(std::move(row), g.lower[i], static_cast<int>(j), i);
    }
  }
}

}  // namespace

std::string describe(const EqualityRow& row) {
  const std::string name =
      row.group < 0 ? fmt::format("the bound of entry {} of stage {}", row.row, row.stage)
                    : fmt::format("row {} of group {} of stage {}", row.row, row.group, row.stage);
  switch (row.rank) {
    case RowRank::independent:
      return name + " is independent of other equality rows";
    case RowRank::dependent:
      return name + " follows from other equality rows";
    case RowRank::contradictory:
      return name + " contradicts other equality rows";
  }
  return name;
}

std::vector<EqualityRow> rank_equality_rows(const qp::StageQp& qp) {
  std::vector<EqualityRow> found;
  const auto judge = [&](int label, bool holds) {
    found[label].rank = holds ? RowRank::dependent : RowRank::contradictory;
  };
  Demands next(0, 0);
  for (int k = qp.intervals(); k >= 0; --k) {
    const qp::Stage& s = qp.stages[k];
    Demands demands(s.nx, s.nu);
    add_rows_of_stage(qp, k, demands, found);
    demands.demand_of_next(s, next);
    demands.eliminate_inputs();
    if (k == 0 && qp.fixed_start) demands.insert_state(qp.start);
    demands.judge_empty(judge);
    next = std::move(demands);
  }
  std::stable_sort(found.begin(), found.end(), [](const EqualityRow& a, const EqualityRow& b) {
    return std::pair(a.stage, a.group) < std::pair(b.stage, b.group);
  });
  return found;
}

}  // namespace saltus
