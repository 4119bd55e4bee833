#include "tests/support/stage_conversion.hpp"

#include <algorithm>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {

StageConversion::StageConversion(const qp::StageQp& qp) {
  for (std::size_t k = 0; k < qp.stages.size(); ++k) {
    const qp::Stage& s = qp.stages[k];
    StageOffset& p = offsets_.emplace_back();
    p.nx = s.nx;
    p.nu = s.nu;
    p.next = k + 1 < qp.stages.size() ? qp.stages[k + 1].nx : 0;
    p.x = variables_;
    p.u = p.x + s.nx;
    variables_ = p.u + s.nu;
    for (const qp::RowGroup& g : s.groups) {
      p.groups.push_back({g.rows, rows_, g.soft ? variables_ : -1, g.columns});
      rows_ += g.rows;
      if (g.soft) variables_ += 2 * g.rows;
    }
    p.dynamics = rows_;
    rows_ += p.next;
  }
  std::vector<std::pair<int, int>> hessian, rows;
  for_each_hessian(qp, [&](int row, int col, double) { hessian.emplace_back(row, col); });
  for_each_row_entry(qp, [&](int row, int col, double) { rows.emplace_back(row, col); });
  sparse_ = qp::SparseQp(SparsityPattern::from_pairs(variables_, variables_, std::move(hessian)),
                         SparsityPattern::from_pairs(rows_, variables_, std::move(rows)));
  update(qp);
}

bool StageConversion::fits(const qp::StageQp& qp) const {
  if (qp.stages.size() != offsets_.size()) return false;
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const qp::Stage& s = qp.stages[k];
    const StageOffset& p = offsets_[k];
    if (s.nx != p.nx || s.nu != p.nu || s.groups.size() != p.groups.size()) return false;
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      const qp::RowGroup& g = s.groups[j];
      const Group& h = p.groups[j];
      if (g.rows != h.rows || g.soft != (h.first_slack >= 0) || g.columns != h.columns)
        return false;
    }
  }
  return true;
}

// Emits entries in the order of the patterns: by rows, with ascending columns.
template <class Emit>
void StageConversion::for_each_hessian(const qp::StageQp& qp, Emit&& emit) const {
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const qp::Stage& s = qp.stages[k];
    const StageOffset& p = offsets_[k];
    for (int i = 0; i < s.nx; ++i)
      for (int j = 0; j <= i; ++j) emit(p.x + i, p.x + j, s.Q(i, j));
    for (int i = 0; i < s.nu; ++i) {
      for (int j = 0; j < s.nx; ++j) emit(p.u + i, p.x + j, s.S(i, j));
      for (int j = 0; j <= i; ++j) emit(p.u + i, p.u + j, s.R(i, j));
    }
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      if (!s.groups[j].soft) continue;
      for (int i = 0; i < 2 * s.groups[j].rows; ++i) {
        const int t = p.groups[j].first_slack + i;
        emit(t, t, s.groups[j].l2[i / 2]);
      }
    }
  }
}

template <class Emit>
void StageConversion::for_each_row_entry(const qp::StageQp& qp, Emit&& emit) const {
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const qp::Stage& s = qp.stages[k];
    const StageOffset& p = offsets_[k];
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      const qp::RowGroup& g = s.groups[j];
      const Group& rows = p.groups[j];
      for (int i = 0; i < g.rows; ++i) {
        for (std::size_t c = 0; c < g.columns.size(); ++c)
          emit(rows.first_row + i, p.x + g.columns[c], g.M(i, c));
        if (!g.soft) continue;
        emit(rows.first_row + i, rows.first_slack + 2 * i, 1.0);
        emit(rows.first_row + i, rows.first_slack + 2 * i + 1, -1.0);
      }
    }
    for (int i = 0; i < p.next; ++i) {
      for (int j = 0; j < s.nx; ++j) emit(p.dynamics + i, p.x + j, s.A(i, j));
      for (int j = 0; j < s.nu; ++j) emit(p.dynamics + i, p.u + j, s.B(i, j));
      emit(p.dynamics + i, offsets_[k + 1].x + i, -1.0);
    }
  }
}

void StageConversion::update(const qp::StageQp& qp) {
  if (!fits(qp))
    throw DefinitionError(
        "The sparse form was made for other sizes of states, inputs or rows than this program "
        "has.");
  qp::SparseQp& to = sparse_;
  double* value = to.hessian.data();
  for_each_hessian(qp, [&](int, int, double entry) { *value++ = entry; });
  value = to.rows.data();
  for_each_row_entry(qp, [&](int, int, double entry) { *value++ = entry; });

  to.constant = 0.0;
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const qp::Stage& s = qp.stages[k];
    const StageOffset& p = offsets_[k];
    const bool given = k == 0 && qp.fixed_start;
    to.constant += s.constant;
    to.gradient.segment(p.x, s.nx) = s.q.head(s.nx);
    to.gradient.segment(p.u, s.nu) = s.r.head(s.nu);
    to.lower.segment(p.x, s.nx) = (given ? qp.start : s.x_lower).head(s.nx);
    to.upper.segment(p.x, s.nx) = (given ? qp.start : s.x_upper).head(s.nx);
    to.lower.segment(p.u, s.nu) = s.u_lower.head(s.nu);
    to.upper.segment(p.u, s.nu) = s.u_upper.head(s.nu);
    for (std::size_t j = 0; j < s.groups.size(); ++j) {
      const qp::RowGroup& g = s.groups[j];
      const Group& rows = p.groups[j];
      to.row_lower.segment(rows.first_row, g.rows) = g.lower.head(g.rows);
      to.row_upper.segment(rows.first_row, g.rows) = g.upper.head(g.rows);
      for (int i = 0; i < (g.soft ? g.rows : 0); ++i) {
        const int t = rows.first_slack + 2 * i;
        to.gradient[t] = to.gradient[t + 1] = g.l1[i];
        to.lower[t] = to.lower[t + 1] = 0.0;
        to.upper[t] = g.lower[i] == -infinity ? 0.0 : infinity;
        to.upper[t + 1] = g.upper[i] == infinity ? 0.0 : infinity;
      }
    }
    to.row_lower.segment(p.dynamics, p.next) = -s.b.head(p.next);
    to.row_upper.segment(p.dynamics, p.next) = -s.b.head(p.next);
  }
}

void StageConversion::convert(const qp::StageQp& qp, const qp::StagePoint& from,
                              PrimalDualPoint& to) const {
  to.w.resize(variables_);
  to.z.resize(variables_);
  to.lambda.resize(rows_);
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const StageOffset& p = offsets_[k];
    const qp::StagePoint::AtStage& at = from.stages[k];
    to.w.segment(p.x, p.nx) = at.x.head(p.nx);
    to.w.segment(p.u, p.nu) = at.u.head(p.nu);
    to.z.segment(p.x, p.nx) = at.x_bound.head(p.nx);
    to.z.segment(p.u, p.nu) = at.u_bound.head(p.nu);
    to.lambda.segment(p.dynamics, p.next) = at.costate.head(p.next);
    for (std::size_t j = 0; j < p.groups.size(); ++j) {
      const qp::RowGroup& g = qp.stages[k].groups[j];
      const Group& rows = p.groups[j];
      for (int i = 0; i < g.rows; ++i) {
        const double multiplier = at.group[j][i];
        to.lambda[rows.first_row + i] = multiplier;
        if (rows.first_slack < 0) continue;
        double value = 0.0;
        for (std::size_t c = 0; c < g.columns.size(); ++c)
          value += g.M(i, c) * to.w[p.x + g.columns[c]];
        const int t = rows.first_slack + 2 * i;
        to.w[t] = std::max(g.lower[i] - value, 0.0);
        to.w[t + 1] = std::max(value - g.upper[i], 0.0);
        // Stationarity in t: l1 + l2 t + multiplier + z = 0 below, with - multiplier above.
        to.z[t] = -(g.l1[i] + g.l2[i] * to.w[t] + multiplier);
        to.z[t + 1] = -(g.l1[i] + g.l2[i] * to.w[t + 1] - multiplier);
      }
    }
  }
}

void StageConversion::convert(const PrimalDualPoint& from, qp::StagePoint& to) const {
  for (std::size_t k = 0; k < offsets_.size(); ++k) {
    const StageOffset& p = offsets_[k];
    qp::StagePoint::AtStage& at = to.stages[k];
    at.x.head(p.nx) = from.w.segment(p.x, p.nx);
    at.u.head(p.nu) = from.w.segment(p.u, p.nu);
    at.x_bound.head(p.nx) = from.z.segment(p.x, p.nx);
    at.u_bound.head(p.nu) = from.z.segment(p.u, p.nu);
    at.costate.head(p.next) = from.lambda.segment(p.dynamics, p.next);
    for (std::size_t j = 0; j < p.groups.size(); ++j)
      at.group[j].head(p.groups[j].rows) =
          from.lambda.segment(p.groups[j].first_row, p.groups[j].rows);
  }
}

}  // namespace saltus
