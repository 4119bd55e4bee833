#include "saltus/qp/riccati_system.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/qp/riccati_packer.hpp"

namespace saltus::qp {
namespace {

// Equality rows enter with a quadratic penalty on what the step leaves of them; their multipliers
// make up for it, so that at the solution they hold exactly. It must outweigh sides that depend on
// them.
constexpr double least_equality_weight = 1e9, most_equality_weight = 1e15;
constexpr double equality_weight_per_weight = 10.0;
// Added to the Hessian when a step is computed, never to the problem: a proximal term.
constexpr double proximal_weight = 1e-11;
constexpr double least_pivot = 1e-13;

}  // namespace

RiccatiSystem::RiccatiSystem(const StageQp& capacity, std::span<const RiccatiKernel> kernels)
    : kernels_(kernels.begin(), kernels.end()), stages_(capacity.stages.size()) {
  std::size_t doubles = 0, ints = 0;
  int blocks = 0, work = 64;
  for (std::size_t k = 0; k < capacity.stages.size(); ++k) {
    const Stage& s = capacity.stages[k];
    const int nx = static_cast<int>(s.q.size()), nu = static_cast<int>(s.r.size());
    const int next = static_cast<int>(s.b.size());
    const int n = nx + nu, ld = padded(n), spare = 8;
    const auto matrix = [&](int rows, int columns) {
      return static_cast<std::size_t>(padded(rows) + spare) * static_cast<std::size_t>(columns + 1);
    };
    // Stage matrices; those of parts are bounded by full ones of the inputs.
    doubles += matrix(next, n) + matrix(n, next) + 3 * matrix(n, n) + 4 * matrix(n, 1) +
               matrix(next, 1) + 8 * matrix(nu, nu) + matrix(next, nu) +
               8 * max_parts * matrix(nu, 1);
    ints += static_cast<std::size_t>(8 * (n + next + 16));
    int v = ld + max_parts * lanes + padded(nu), y = padded(next), sides = 2 * (ld + lanes);
    const auto rows = [&](int count, int columns) {
      const int c = std::max(columns, nu);
      doubles += 2 * (matrix(count, c) + matrix(c, count) + matrix(count, 1) +
                      (c <= max_pair_columns ? matrix(pairs_of(c), count) : matrix(1, 1)));
      // Few columns keep the products of pairs even where others would need more of them.
      doubles += 2 * matrix(pairs_of(max_pair_columns), count);
      ints += static_cast<std::size_t>(2 * (count + 2 * c + pairs_of(c) + 64));
      y += padded(count) + lanes;
      sides += 2 * (padded(count) + lanes);
      blocks += 2;
      work = std::max(work, padded(count) * (c + 2) + padded(c) * (c + 2));
    };
    for (const RowGroup& g : s.groups)
      rows(static_cast<int>(g.M.rows()), static_cast<int>(g.M.cols()));
    for (int part = 0; part < max_parts && (part == 0 || part < nu); ++part)
      rows(part == 0 ? n : nu, part == 0 ? n : nu);
    work = std::max({work, (padded(next) + 8) * (n + 2), 8 * (padded(nu) + 8) * (nu + 2)});
    max_variables_ += v;
    max_equalities_ += y;
    max_sides_ += sides;
  }
  numbers_ = Arena<double, AlignedArray>(doubles);
  integers_ = Arena<int, std::vector<int>>(ints);
  blocks_.resize(blocks);
  splits_.resize((max_parts - 1) * capacity.stages.size());
  active_ = AlignedArray(max_sides_);
  beta_ = AlignedArray(max_sides_);
  l1_ = AlignedArray(max_sides_);
  l2_ = AlignedArray(max_sides_);
  weights_ = AlignedArray(max_sides_);
  side_work_ = AlignedArray(max_sides_);
  wanted_ = AlignedArray(max_equalities_);
  work_ = AlignedArray(2 * work);
  gradient_ = AlignedArray(max_variables_);
  residual_v_ = AlignedArray(max_variables_);
  correction_v_ = AlignedArray(max_variables_);
  residual_y_ = AlignedArray(max_equalities_);
  correction_y_ = AlignedArray(max_equalities_);
  row_work_ = AlignedArray(work);
  sum_ = AlignedArray(work);
}

bool RiccatiSystem::pack(const StageQp& qp) {
  Packer packer{*this, qp};
  if (!packer.run()) return false;
  packer.fill_sides();
  return true;
}

void RiccatiSystem::pack_point(const StageQp& qp, const StagePoint& point, bool multipliers,
                               double* v, double* y, double* lambda) const {
  std::fill_n(v, variables_, 0.0);
  if (multipliers) {
    std::fill_n(y, equalities_, 0.0);
    std::fill_n(lambda, sides_, 0.0);
  }
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = stages_[k];
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
    for (const RowBlock& b : p.rows)
      for (int i = 0; i < b.rows; ++i) {
        const int j = b.source[i];
        const double value = b.group >= 0 ? from.group[b.group][j]
                             : j < s.nx   ? from.x_bound[j]
                                          : from.u_bound[j - s.nx];
        if (b.equality_at >= 0) y[b.equality_at + i] = value / b.scale[i];
        if (b.upper_at >= 0) lambda[b.upper_at + i] = std::max(value, 0.0);
        if (b.lower_at >= 0) lambda[b.lower_at + i] = std::max(-value, 0.0);
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

// Soft rows of the fixed start alone are no part of the packed program; what they miss is
// penalised.
void RiccatiSystem::penalise_settled_rows(const StageQp& qp, StagePoint::AtStage& to) const {
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

void RiccatiSystem::unpack_point(const StageQp& qp, const double* v, const double* y,
                                 const double* lambda, StagePoint& point) const {
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const Stage& s = qp.stages[k];
    const PackedStage& p = stages_[k];
    StagePoint::AtStage& to = point.stages[k];
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    for (int j = 0; j < s.nx; ++j) to.x[j] = j < p.constant_states ? qp.start[j] : main[j];
    const int own = p.parts > 1 ? m : s.nu, shift = s.nx - p.constant_states;
    for (int j = 0; j < own; ++j) to.u[j] = main[shift + j];
    for (int part = 1; part < p.parts; ++part) {
      const double* from = main + p.sweep.ld + (part - 1) * ldm;
      for (int i = 0; i < m; ++i) {
        double sum = 0.0;
        for (int c = 0; c < m; ++c) sum += p.T_inverse[i + ((part - 1) * m + c) * ldm] * from[c];
        to.u[part * m + i] = sum;
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
    for (const RowBlock& b : p.rows)
      for (int i = 0; i < b.rows; ++i) {
        if (b.equality_at >= 0) add(b.group, b.source[i], y[b.equality_at + i] * b.scale[i]);
        if (b.upper_at >= 0) add(b.group, b.source[i], lambda[b.upper_at + i]);
        if (b.lower_at >= 0) add(b.group, b.source[i], -lambda[b.lower_at + i]);
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

void RiccatiSystem::roll_out(double* v) {
  for (std::size_t k = 0; k + 1 < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const int nn = p.sweep.next, n = p.sweep.nx + p.sweep.nu;
    const double* main = with_resultant(p, v);
    double* next = work_.data();
    for (int i = 0; i < p.sweep.ld_next; i += lanes) store(next + i, load(p.b + i));
    multiply_vector<Update::add>(nn, n, p.sweep.flow, p.sweep.ld_next, main, next);
    std::copy(next, next + nn, v + stages_[k + 1].v_at);
  }
}

// --- products -----------------------------------------------------------------------------------

// The stage's main variables, with the inputs of further parts added to those of the first: what
// the dynamics see.
const double* RiccatiSystem::with_resultant(const PackedStage& p, const double* v) {
  const double* main = v + p.v_at;
  if (p.parts == 1) return main;
  const SweepStage& w = p.sweep;
  double* sum = sum_.data();
  for (int i = 0; i < w.ld; i += lanes) store(sum + i, load(main + i));
  for (int part = 1; part < p.parts; ++part) {
    const double* further = main + w.ld + (part - 1) * padded(w.nu);
    for (int i = 0; i < w.nu; ++i) sum[w.nx + i] += further[i];
  }
  return sum;
}

template <bool affine>
void RiccatiSystem::products(const double* v, const double* y, double* stationarity,
                             double* equality) {
  const double* costate = nullptr;  // of the dynamics that lead into the stage
  double* force = work_.data();
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const SweepStage& w = p.sweep;
    const int ldm = padded(w.nu);
    const double* main = v + p.v_at;
    double* out = stationarity + p.v_at;
    const double* pi = y + p.costate_at;
    double* gap = equality + p.costate_at;
    for (int i = 0; i < w.ld; i += lanes) store(out + i, affine ? load(p.g + i) : Lanes{});
    for (int i = 0; i < w.ld_next; i += lanes) store(gap + i, affine ? load(p.b + i) : Lanes{});
    p.kernel->products(w, p.H, main, with_resultant(p, v), pi,
                       w.next > 0 ? v + stages_[k + 1].v_at : nullptr, out, force, gap);
    for (int i = 0; i < w.nx && costate != nullptr; ++i) out[i] -= costate[i];
    if (w.next > 0)
      for (int i = 0; i < w.ld; i += lanes) store(out + i, load(out + i) + load(force + i));
    for (int part = 1; part < p.parts; ++part) {
      const double* further = main + w.ld + (part - 1) * ldm;
      double* to = out + w.ld + (part - 1) * ldm;
      for (int i = 0; i < ldm; i += lanes)
        store(to + i, affine ? load(p.r + (part - 1) * ldm + i) : Lanes{});
      multiply_vector<Update::add>(w.nu, w.nu, p.R + (part - 1) * ldm * w.nu, ldm, further, to);
      for (int i = 0; i < w.nu; ++i) to[i] += force[w.nx + i];
    }
    costate = pi;
  }
  if (!has_equality_rows_) return;
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      b.kernel->multiply(b, v + b.v_at, 1.0, equality + b.equality_at);
      if (affine)
        for (int i = 0; i < padded(b.rows); ++i)
          equality[b.equality_at + i] -= wanted_[b.equality_at + i];
      b.kernel->add_transposed(b, y + b.equality_at, 1.0, stationarity + b.v_at);
    }
}

void RiccatiSystem::multiply(const double* v, double* side) {
  const auto mask = [&](int at, int rows) {
    for (int i = at; i < at + padded(rows); i += lanes)
      store(side + i, load(side + i) * load(&active_[i]));
  };
  for (const PackedStage& p : stages_) {
    for (const RowBlock& b : p.rows) {
      if (b.equality_at >= 0) continue;
      if (b.upper_at >= 0) b.kernel->multiply(b, v + b.v_at, -1.0, side + b.upper_at);
      if (b.lower_at >= 0 && b.upper_at >= 0)
        for (int i = 0; i < padded(b.rows); i += lanes)
          store(side + b.lower_at + i, -load(side + b.upper_at + i));
      else if (b.lower_at >= 0)
        b.kernel->multiply(b, v + b.v_at, 1.0, side + b.lower_at);
      if (b.partial && b.lower_at >= 0) mask(b.lower_at, b.rows);
      if (b.partial && b.upper_at >= 0) mask(b.upper_at, b.rows);
    }
    const BoundBlock& b = p.bounds;
    for (int i = 0; i < b.length; i += lanes) {
      const Lanes x = load(v + p.v_at + b.first + i);
      if (b.lower_at >= 0) store(side + b.lower_at + i, x * load(&active_[b.lower_at + i]));
      if (b.upper_at >= 0) store(side + b.upper_at + i, -x * load(&active_[b.upper_at + i]));
    }
  }
}

template <int sign>
void RiccatiSystem::add_sides(const double* side, double* v) {
  double* rows = work_.data();
  for (const PackedStage& p : stages_) {
    for (const RowBlock& b : p.rows) {
      if (b.equality_at >= 0) continue;
      if (b.lower_at < 0) {
        b.kernel->add_transposed(b, side + b.upper_at, -sign, v + b.v_at);
      } else if (b.upper_at < 0) {
        b.kernel->add_transposed(b, side + b.lower_at, sign, v + b.v_at);
      } else {
        for (int i = 0; i < padded(b.rows); i += lanes)
          store(rows + i, load(side + b.lower_at + i) - load(side + b.upper_at + i));
        b.kernel->add_transposed(b, rows, sign, v + b.v_at);
      }
    }
    const BoundBlock& b = p.bounds;
    for (int i = 0; i < b.length; i += lanes) {
      double* to = v + p.v_at + b.first + i;
      Lanes sum{};
      if (b.lower_at >= 0) sum += load(side + b.lower_at + i) * load(&active_[b.lower_at + i]);
      if (b.upper_at >= 0) sum -= load(side + b.upper_at + i) * load(&active_[b.upper_at + i]);
      store(to, load(to) + (sign > 0 ? sum : -sum));
    }
  }
}

void RiccatiSystem::multiply_transposed(const double* side, double* v) {
  for (int i = 0; i < variables_; i += lanes) store(v + i, Lanes{});
  add_sides<1>(side, v);
}

void RiccatiSystem::evaluate(const double* v, const double* y, const double* lambda,
                             double* stationarity, double* equality, double* side) {
  products<true>(v, y, stationarity, equality);
  add_sides<-1>(lambda, stationarity);
  multiply(v, side);
}

void RiccatiSystem::apply(const double* v, const double* y, const double* lambda,
                          double* stationarity, double* equality, double* side) {
  products<false>(v, y, stationarity, equality);
  add_sides<-1>(lambda, stationarity);
  multiply(v, side);
}

double RiccatiSystem::cost(const double* v) {
  double* slope = work_.data();
  double total = 0.0;
  // v'(1/2 H v + g) of one block.
  const auto add = [&](int size, const double* H, const double* g, const double* at) {
    multiply_vector<Update::set>(size, size, H, padded(size), at, slope);
    for (int i = 0; i < size; ++i) total += (0.5 * slope[i] + g[i]) * at[i];
  };
  for (const PackedStage& p : stages_) {
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    add(p.sweep.nx + m, p.H, p.g, main);
    for (int part = 0; part + 1 < p.parts; ++part)
      add(m, p.R + part * ldm * m, p.r + part * ldm, main + p.sweep.ld + part * ldm);
  }
  return total;
}

// --- factorisation ------------------------------------------------------------------------------

void RiccatiSystem::add_rows(PackedStage& p, const double* weights) {
  double* row_weights = work_.data();
  for (const RowBlock& b : p.rows) {
    const int ld = padded(b.rows);
    for (int i = 0; i < ld; i += lanes) {
      Lanes sum{};
      if (b.lower_at >= 0) sum += load(weights + b.lower_at + i);
      if (b.upper_at >= 0) sum += load(weights + b.upper_at + i);
      if (b.equality_at >= 0) sum = broadcast(equality_weight_);
      store(row_weights + i, sum);
    }
    double* H = b.part == 0 ? p.sweep.M : p.R_work + (b.part - 1) * padded(p.sweep.nu) * p.sweep.nu;
    double* result = row_weights + ld;
    if (b.pairs != nullptr) {
      b.kernel->add_square(b, row_weights, H, result);
      continue;
    }
    // More columns: C'(W C) as a product.
    const int ldc = padded(b.columns);
    double* weighted = result;
    double* square = weighted + ld * b.columns;
    for (int c = 0; c < b.columns; ++c)
      for (int i = 0; i < ld; i += lanes)
        store(weighted + c * ld + i, load(b.C + c * ld + i) * load(row_weights + i));
    multiply_upper<Update::set>(b.columns, b.rows, b.Ct, ldc, weighted, 1, ld, square, ldc);
    for (int j = 0, at = 0; j < b.columns; ++j)
      for (int i = 0; i <= j; ++i) H[b.target[at++]] += square[i + j * ldc];
  }
  const BoundBlock& b = p.bounds;
  const int n = p.sweep.nx + p.sweep.nu;
  for (int i = 0; i < b.length && b.first + i < n; ++i) {
    double w = 0.0;
    if (b.lower_at >= 0) w += weights[b.lower_at + i] * active_[b.lower_at + i];
    if (b.upper_at >= 0) w += weights[b.upper_at + i] * active_[b.upper_at + i];
    p.sweep.M[(b.first + i) * (p.sweep.ld + 1)] += w;
  }
}

// The joint Hessian of the parts takes the place of the first part's.
void RiccatiSystem::factor_parts(PackedStage& p) {
  const SweepStage& w = p.sweep;
  for (int part = 1; part < p.parts; ++part)
    p.split_kernel->join(w.nu, w.M + w.nx * (w.ld + 1), w.ld, p.splits[part - 1], work_.data(),
                         least_pivot);
}

bool RiccatiSystem::factor(const double* weights) {
  if (has_equality_rows_) {
    Lanes most{};
    for (int i = 0; i < sides_; i += lanes) {
      store(&weights_[i], load(weights + i));
      most = larger(most, load(weights + i));
    }
    equality_weight_ = std::clamp(equality_weight_per_weight * largest(most), least_equality_weight,
                                  most_equality_weight);
  }
  const double* P = nullptr;
  int ld_P = 0;
  double check = 0.0;
  for (int k = static_cast<int>(stages_.size()) - 1; k >= 0; --k) {
    PackedStage& p = stages_[k];
    SweepStage& w = p.sweep;
    const int n = w.nx + w.nu;
    for (int i = 0; i < w.ld * n; i += lanes) store(w.M + i, load(p.H + i));
    for (int i = 0; i < n; ++i) w.M[i * (w.ld + 1)] += proximal_weight + shift_;
    const int further = (p.parts - 1) * padded(w.nu) * w.nu;
    for (int i = 0; i < further; i += lanes) store(p.R_work + i, load(p.R + i));
    for (int part = 1; part < p.parts && shift_ > 0.0; ++part)
      for (int i = 0; i < w.nu; ++i)
        p.R_work[(part - 1) * padded(w.nu) * w.nu + i * (padded(w.nu) + 1)] += shift_;
    add_rows(p, weights);
    if (p.parts > 1) factor_parts(p);
    w.curves_down = false;
    p.kernel->factor(w, P, ld_P, work_.data(), least_pivot);
    if (w.curves_down && !expects_convex_) return false;
    P = w.M;
    ld_P = w.ld;
    for (int j = 0; j < w.nu; ++j) check += w.pivot[j];
  }
  return std::isfinite(check);
}

// --- solution -----------------------------------------------------------------------------------

void RiccatiSystem::sweep(const double* gradient, const double* equality, double* dv, double* dy) {
  const SweepStage* next = nullptr;
  for (int k = static_cast<int>(stages_.size()) - 1; k >= 0; --k) {
    PackedStage& p = stages_[k];
    SweepStage& w = p.sweep;
    const double* g = gradient + p.v_at;
    for (int i = 0; i < w.ld; i += lanes) store(w.p + i, load(g + i));
    for (int part = 1; part < p.parts; ++part)
      p.split_kernel->gather(w.nu, p.splits[part - 1], g + w.ld + (part - 1) * padded(w.nu),
                             w.p + w.nx, work_.data());
    p.kernel->backward(w, next ? next->M : nullptr, next ? next->ld : 0, next ? next->p : nullptr,
                       equality + p.costate_at, work_.data());
    next = &w;
  }
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    const PackedStage& p = stages_[k];
    const SweepStage& w = p.sweep;
    double* v = dv + p.v_at;
    const bool last = k + 1 == stages_.size();
    const SweepStage* after = last ? nullptr : &stages_[k + 1].sweep;
    p.kernel->forward(w, last ? nullptr : after->M, last ? 0 : after->ld, last ? nullptr : after->p,
                      equality + p.costate_at, v, last ? nullptr : dv + stages_[k + 1].v_at,
                      dy + p.costate_at);
    const int n = w.nx + w.nu;
    for (int i = n; i < w.ld; ++i) v[i] = 0.0;
    for (int part = p.parts - 1; part > 0; --part)
      p.split_kernel->share(w.nu, p.splits[part - 1], v + w.nx,
                            v + w.ld + (part - 1) * padded(w.nu), work_.data());
  }
}

void RiccatiSystem::solve(const double* gradient, const double* equality, double* dv, double* dy) {
  if (!has_equality_rows_) {
    sweep(gradient, equality, dv, dy);
    return;
  }
  solve_with_rows(gradient, equality, dv, dy);
  // The penalty on equality rows is steep: what rounding loses is won back by a second solve.
  for (int round = 0; round < 2; ++round) {
    products<false>(dv, dy, residual_v_.data(), residual_y_.data());
    multiply(dv, side_work_.data());
    for (int i = 0; i < sides_; i += lanes)
      store(&side_work_[i], load(&side_work_[i]) * load(&weights_[i]));
    add_sides<1>(side_work_.data(), residual_v_.data());
    for (int i = 0; i < variables_; i += lanes)
      store(&residual_v_[i],
            load(&residual_v_[i]) + load(gradient + i) + load(dv + i) * broadcast(shift_));
    for (int i = 0; i < equalities_; i += lanes)
      store(&residual_y_[i], load(&residual_y_[i]) + load(equality + i));
    solve_with_rows(residual_v_.data(), residual_y_.data(), correction_v_.data(),
                    correction_y_.data());
    for (int i = 0; i < variables_; i += lanes)
      store(dv + i, load(dv + i) + load(&correction_v_[i]));
    for (int i = 0; i < equalities_; i += lanes)
      store(dy + i, load(dy + i) + load(&correction_y_[i]));
  }
}

// Equality rows E dv = -equality, penalty_of: dy = weight (E dv + equality).
void RiccatiSystem::solve_with_rows(const double* gradient, const double* equality, double* dv,
                                    double* dy) {
  double* scaled = row_work_.data();
  for (int i = 0; i < variables_; i += lanes) store(&gradient_[i], load(gradient + i));
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(scaled + i, load(equality + b.equality_at + i) * equality_weight_);
      b.kernel->add_transposed(b, scaled, 1.0, gradient_.data() + b.v_at);
    }
  sweep(gradient_.data(), equality, dv, dy);
  for (const PackedStage& p : stages_)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      double* out = dy + b.equality_at;
      b.kernel->multiply(b, dv + b.v_at, 1.0, out);
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(out + i, (load(out + i) + load(equality + b.equality_at + i)) * equality_weight_);
    }
}

}  // namespace saltus::qp
