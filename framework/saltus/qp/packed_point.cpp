// Converts points of a program in stages to the packed program and back. The user sees one
// multiplier for both sides of a row, positive if the upper side is active. Inputs of further parts
// are T_p u_p.
#include <algorithm>

#include "saltus/qp/packed_qp.hpp"

namespace saltus::qp {
namespace {

// Soft rows that depend only on the fixed start are not part of the packed program; their violation
// is penalised.
void penalise_settled_rows(const StageQp& qp, StagePoint::AtStage& to) {
  const Stage& s = qp.stages.front();
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const RowGroup& group = s.groups[g];
    const bool settled =
        std::all_of(group.columns.begin(), group.columns.end(), [&](int j) { return j < s.nx; });
    if (!group.soft || !settled) continue;
    for (int i = 0; i < group.rows; ++i) {
      double value = 0.0;
      for (std::size_t c = 0; c < group.columns.size(); ++c)
        value += group.M(i, static_cast<int>(c)) * qp.start[group.columns[c]];
      if (value > group.upper[i])
        to.group[g][i] = group.l1[i] + group.l2[i] * (value - group.upper[i]);
      if (value < group.lower[i])
        to.group[g][i] = -group.l1[i] - group.l2[i] * (group.lower[i] - value);
    }
  }
}

}  // namespace

void pack_point(const StageQp& qp, const StagePoint& point, const PackedQp& packed,
                bool multipliers, double* v, double* y, double* lambda) {
  std::fill_n(v, packed.variables, 0.0);
  if (multipliers) {
    std::fill_n(y, packed.equalities, 0.0);
    std::fill_n(lambda, packed.sides, 0.0);
  }
  for (std::size_t k = 0; k < packed.stages.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = packed.stages[k];
    const StagePoint::AtStage& from = point.stages[k];
    const int m = p.sweep.nu, ldm = padded(m);
    double* main = v + p.v_at;
    for (int j = p.constant_states; j < s.nx; ++j) main[j] = from.x[j];
    const int own = p.parts > 1 ? m : s.nu, shift = s.nx - p.constant_states;
    for (int j = 0; j < own; ++j) main[shift + j] = from.u[j];
    for (int part = 1; part < p.parts; ++part) {
      double* to = main + p.sweep.ld + (part - 1) * ldm;
      for (int c = 0; c < m; ++c)
        for (int i = 0; i < m; ++i)
          to[i] += p.T[i + ((part - 1) * m + c) * ldm] * from.u[part * m + c];
    }
    if (!multipliers) continue;
    for (int i = 0; i < p.sweep.next; ++i) y[p.costate_at + i] = from.costate[i];
    for (const RowBlock& b : p.rows) {
      if (b.group >= 0 && b.equality_at < 0) {
        const double* values = from.group[b.group].data();
        for (int i = 0; i < b.rows && b.upper_at >= 0; ++i)
          lambda[b.upper_at + i] = std::max(values[b.source[i]], 0.0);
        for (int i = 0; i < b.rows && b.lower_at >= 0; ++i)
          lambda[b.lower_at + i] = std::max(-values[b.source[i]], 0.0);
        continue;
      }
      for (int i = 0; i < b.rows; ++i) {
        const int j = b.source[i];
        const double value = b.group >= 0 ? from.group[b.group][j]
                             : j < s.nx   ? from.x_bound[j]
                                          : from.u_bound[j - s.nx];
        if (b.equality_at >= 0) y[b.equality_at + i] = value / b.scale[i];
        if (b.upper_at >= 0) lambda[b.upper_at + i] = std::max(value, 0.0);
        if (b.lower_at >= 0) lambda[b.lower_at + i] = std::max(-value, 0.0);
      }
    }
    const int n = p.sweep.nx + p.sweep.nu;
    for (int i = 0; i < p.bounds.length && p.bounds.first + i < n; ++i) {
      const int j = p.bounds.first + i + p.constant_states;
      const double value = j < s.nx ? from.x_bound[j] : from.u_bound[j - s.nx];
      if (p.bounds.upper_at >= 0) lambda[p.bounds.upper_at + i] = std::max(value, 0.0);
      if (p.bounds.lower_at >= 0) lambda[p.bounds.lower_at + i] = std::max(-value, 0.0);
    }
  }
}

void unpack_point(const StageQp& qp, const PackedQp& packed, const double* v, const double* y,
                  const double* lambda, StagePoint& point) {
  for (std::size_t k = 0; k < packed.stages.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = packed.stages[k];
    StagePoint::AtStage& to = point.stages[k];
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    for (int j = 0; j < s.nx; ++j) to.x[j] = j < p.constant_states ? qp.start[j] : main[j];
    const int own = p.parts > 1 ? m : s.nu, shift = s.nx - p.constant_states;
    for (int j = 0; j < own; ++j) to.u[j] = main[shift + j];
    for (int part = 1; part < p.parts; ++part) {
      const double* from = main + p.sweep.ld + (part - 1) * ldm;
      double* own_inputs = to.u.data() + part * m;
      std::fill_n(own_inputs, m, 0.0);
      for (int c = 0; c < m; ++c) {
        const double* column = p.T_inverse + ((part - 1) * m + c) * ldm;
        for (int i = 0; i < m; ++i) own_inputs[i] += column[i] * from[c];
      }
    }
    for (int i = 0; i < p.sweep.next; ++i) to.costate[i] = y[p.costate_at + i];
    to.x_bound.setZero();
    to.u_bound.setZero();
    for (VectorXd& g : to.group) g.setZero();
    const auto add = [&](int group, int j, double value) {
      if (group >= 0)
        to.group[group][j] += value;
      else if (j < s.nx)
        to.x_bound[j] += value;
      else
        to.u_bound[j - s.nx] += value;
    };
    for (const RowBlock& b : p.rows) {
      if (b.group >= 0 && b.equality_at < 0) {
        double* values = to.group[b.group].data();
        for (int i = 0; i < b.rows && b.upper_at >= 0; ++i)
          values[b.source[i]] += lambda[b.upper_at + i];
        for (int i = 0; i < b.rows && b.lower_at >= 0; ++i)
          values[b.source[i]] -= lambda[b.lower_at + i];
        continue;
      }
      for (int i = 0; i < b.rows; ++i) {
        if (b.equality_at >= 0) add(b.group, b.source[i], y[b.equality_at + i] * b.scale[i]);
        if (b.upper_at >= 0) add(b.group, b.source[i], lambda[b.upper_at + i]);
        if (b.lower_at >= 0) add(b.group, b.source[i], -lambda[b.lower_at + i]);
      }
    }
    const int n = p.sweep.nx + p.sweep.nu;
    for (int i = 0; i < p.bounds.length && p.bounds.first + i < n; ++i) {
      const int j = p.bounds.first + i + p.constant_states;
      if (p.bounds.upper_at >= 0) add(-1, j, lambda[p.bounds.upper_at + i]);
      if (p.bounds.lower_at >= 0) add(-1, j, -lambda[p.bounds.lower_at + i]);
    }
    if (p.constant_states > 0) penalise_settled_rows(qp, to);
  }
}

}  // namespace saltus::qp
