// Factors and solves the equations of the Newton step by a Riccati recursion.
//
//     (H + shift I + G'WG) dv + E'dy = -r_v,   E dv = -r_y,
//
// where E holds the dynamics x_next = F v + b and the equality rows. The backward pass, with P the
// Hessian of the cost to go, computes M = H + shift I + C'WC + F'P F and eliminates the inputs; P
// is the remaining block of the states. Two sweeps solve each right-hand side. Costates have the
// sign of d cost / d b. Derivation and sources: framework/design/riccati.md.
#include "saltus/qp/riccati_system.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace saltus::qp {
namespace {

// Equality rows enter by a quadratic penalty on their residual. Multipliers correct it, so that the
// rows hold exactly at the solution. The weight must exceed those of sides that depend on the rows.
constexpr double least_equality_weight = 1e9, most_equality_weight = 1e15;
constexpr double equality_weight_per_weight = 10.0;
// Largest accepted residual of violated rows after one solve and after all solves. The next weight
// aims at wanted_rest. Residuals below least_miss do not count as violations.
constexpr double largest_rest = 1e-3, largest_rest_of_all = 1e-6, wanted_rest = 1e-6;
constexpr double least_miss = 1e-9;
// Proximal term added to the Hessian of a step, never to the problem.
constexpr double proximal_weight = 1e-11;
constexpr double least_pivot = 1e-13;
// Cache size in doubles: 512 kB.
constexpr std::ptrdiff_t kept_near = 1 << 16;

// Prefetches a piece of memory before it is written.
void fetch(const double* begin, const double* end) {
  constexpr int line = 8;
  for (; begin < end; begin += line) __builtin_prefetch(begin, 1);
}

const double* end_of_M(const SweepStage& stage) {
  return stage.M + (stage.nx + stage.nu) * stage.ld;
}

}  // namespace

RiccatiSystem::RiccatiSystem(const StageQp& largest, std::span<const RiccatiKernel> kernels)
    : packed_(largest, kernels) {
  const PackedQp::Capacity& most = packed_.capacity;
  for (AlignedArray* of_sides : {&weights_, &side_work_}) *of_sides = AlignedArray(most.sides);
  for (AlignedArray* of_v : {&gradient_, &residual_v_, &correction_v_})
    *of_v = AlignedArray(most.variables);
  for (AlignedArray* of_y : {&residual_y_, &correction_y_}) *of_y = AlignedArray(most.equalities);
  work_ = AlignedArray(2 * most.work);
  row_work_ = AlignedArray(most.work);
  sum_ = AlignedArray(most.work);
}

// --- factorisation ------------------------------------------------------------------------------

void RiccatiSystem::add_rows(PackedStage& p, const double* weights) {
  for (const RowBlock& b : p.rows) {
    const int ld = padded(b.rows);
    const double* row_weights = work_.data();
    if (b.equality_at >= 0) {
      for (int i = 0; i < ld; i += lanes) store(&work_[i], broadcast(equality_weight_));
    } else if (b.lower_at < 0) {
      row_weights = weights + b.upper_at;
    } else if (b.upper_at < 0) {
      row_weights = weights + b.lower_at;
    } else {
      for (int i = 0; i < ld; i += lanes)
        store(&work_[i], load(weights + b.lower_at + i) + load(weights + b.upper_at + i));
    }
    double* H = b.joined < 0 ? p.sweep.M : p.R_work + b.joined * padded(p.sweep.nu) * p.sweep.nu;
    double* result = work_.data() + ld;
    if (b.pairs != nullptr || b.diagonal) {
      b.kernel->add_square(b, row_weights, H, result);
      continue;
    }
    // With more columns: C'(W C) as a product.
    const int ldc = padded(b.columns);
    double* weighted = result;
    double* square = weighted + ld * b.columns;
    for (int c = 0; c < b.columns; ++c)
      for (int i = 0; i < ld; i += lanes)
        store(weighted + c * ld + i, load(b.C + c * ld + i) * load(row_weights + i));
    if (b.contiguous && b.target[0] % lanes == 0) {
      // Computed in place: entries below the diagonal are not read.
      double* to = H + b.target[0];
      multiply_upper<Update::add>(b.columns, b.rows, b.Ct, ldc, weighted, 1, ld, to, to,
                                  b.joined < 0 ? p.sweep.ld : padded(p.sweep.nu));
      continue;
    }
    multiply_upper<Update::set>(b.columns, b.rows, b.Ct, ldc, weighted, 1, ld, square, square, ldc);
    for (int j = 0, at = 0; j < b.columns; ++j)
      for (int i = 0; i <= j; ++i) H[b.target[at++]] += square[i + j * ldc];
  }
  const BoundBlock& b = p.bounds;
  const int nx = p.sweep.nx, n = nx + p.sweep.nu;
  for (int i = 0; i < b.length && b.first + i < n; ++i) {
    double w = 0.0;
    if (b.lower_at >= 0) w += weights[b.lower_at + i] * packed_.active[b.lower_at + i];
    if (b.upper_at >= 0) w += weights[b.upper_at + i] * packed_.active[b.upper_at + i];
    const int j = b.first + i;
    if (p.parts > 1 && j >= nx)
      p.R_work[(j - nx) * (padded(p.sweep.nu) + 1)] += w;
    else
      p.sweep.M[j * (p.sweep.ld + 1)] += w;
  }
}

// Replaces the Hessian of the inputs by the joint Hessian of the parts.
void RiccatiSystem::join_parts(PackedStage& p) {
  const SweepStage& w = p.sweep;
  for (int part = 0; part + 2 < p.parts; ++part)
    p.split_kernel->join(w.nu, p.splits[part], work_.data(), least_pivot, p.splits[part + 1].before,
                         padded(w.nu), false);
  p.split_kernel->join(w.nu, p.splits[p.parts - 2], work_.data(), least_pivot,
                       w.M + w.nx * (w.ld + 1), w.ld, true);
}

bool RiccatiSystem::pack(const StageQp& qp) {
  least_equality_weight_ = least_equality_weight;
  return packed_.pack(qp);
}

void RiccatiSystem::pack_start(const StageQp& qp) {
  least_equality_weight_ = least_equality_weight;
  packed_.pack_start(qp);
}

bool RiccatiSystem::factor(const double* weights) {
  if (packed_.has_equality_rows) {
    Lanes most{};
    for (int i = 0; i < packed_.sides; i += lanes) {
      store(&weights_[i], load(weights + i));
      most = larger(most, load(weights + i));
    }
    equality_weight_ = std::clamp(equality_weight_per_weight * largest(most),
                                  least_equality_weight_, most_equality_weight);
  }
  const double* P = nullptr;
  int ld_P = 0;
  double check = 0.0;
  // For long programs, prefetches the previous stage during the current one.
  const bool fetches = packed_.stages.back().sweep.L - packed_.stages.front().sweep.L > kept_near;
  for (int k = static_cast<int>(packed_.stages.size()) - 1; k >= 0; --k) {
    PackedStage& p = packed_.stages[k];
    SweepStage& w = p.sweep;
    const double diagonal = proximal_weight + shift_;
    if (fetches && k > 0) {
      const SweepStage& before = packed_.stages[k - 1].sweep;
      fetch(before.L, w.L);
      fetch(end_of_M(w), end_of_M(before));
    }
    p.kernel->assemble(w, p.outer, diagonal, p.parts > 1 ? 0.0 : diagonal, P, ld_P, work_.data());
    if (p.parts > 1) p.split_kernel->begin(w.nu, p.parts, p.R, diagonal, shift_, p.R_work);
    add_rows(p, weights);
    if (p.parts > 1) join_parts(p);
    w.has_negative_curvature = false;
    p.kernel->eliminate(w, least_pivot);
    if (w.has_negative_curvature && !expects_convex_) return false;
    P = w.M;
    ld_P = w.ld;
    for (int j = 0; j < w.nu; ++j) check += w.pivot[j];
  }
  return std::isfinite(check);
}

// --- solution -----------------------------------------------------------------------------------

void RiccatiSystem::sweep(const double* gradient, const double* equality, double* dv, double* dy) {
  const SweepStage* next = nullptr;
  for (int k = static_cast<int>(packed_.stages.size()) - 1; k >= 0; --k) {
    PackedStage& p = packed_.stages[k];
    SweepStage& w = p.sweep;
    const double* g = gradient + p.v_at;
    if (p.parts > 1) {
      const double* further = g + w.ld;
      for (int i = 0; i < w.ld; i += lanes) store(w.p + i, load(g + i));
      for (int part = 1; part < p.parts; ++part, further += padded(w.nu))
        p.split_kernel->gather(w.nu, p.splits[part - 1], further, w.p + w.nx, work_.data());
      g = w.p;
    }
    p.kernel->backward(w, g, next ? next->M : nullptr, next ? next->ld : 0,
                       next ? next->p : nullptr, equality + p.costate_at, work_.data());
    next = &w;
  }
  for (std::size_t k = 0; k < packed_.stages.size(); ++k) {
    const PackedStage& p = packed_.stages[k];
    const SweepStage& w = p.sweep;
    double* v = dv + p.v_at;
    const bool last = k + 1 == packed_.stages.size();
    const SweepStage* after = last ? nullptr : &packed_.stages[k + 1].sweep;
    p.kernel->forward(w, last ? nullptr : after->M, last ? 0 : after->ld, last ? nullptr : after->p,
                      equality + p.costate_at, v, last ? nullptr : dv + packed_.stages[k + 1].v_at,
                      dy + p.costate_at);
    for (int part = p.parts - 1; part > 0; --part)
      p.split_kernel->divide(w.nu, p.splits[part - 1], v + w.nx,
                             v + w.ld + (part - 1) * padded(w.nu), work_.data());
  }
}

void RiccatiSystem::solve(const double* gradient, const double* equality, double* dv, double* dy) {
  if (!packed_.has_equality_rows) {
    sweep(gradient, equality, dv, dy);
    return;
  }
  // Satisfied rows give no information about the required weight.
  const double missed = largest_of_rows(equality);
  double first = 0.0, second = 0.0;
  do {
    solve_with_rows(gradient, equality, dv, dy);
    // The penalty on equality rows is large: a second solve corrects its rounding errors.
    refine(gradient, equality, dv, dy);
    if (missed > least_miss) first = largest_of_rows(residual_y_.data());
    refine(gradient, equality, dv, dy);
    if (missed <= least_miss) return;
    second = largest_of_rows(residual_y_.data());
    if (second <= std::fmax(largest_rest * first, largest_rest_of_all * missed)) return;
  } while (raise_equality_weight(second / first));
}

// Solves once more for the remaining residual. Afterwards residual_y_ holds that of the previous
// solve.
void RiccatiSystem::refine(const double* gradient, const double* equality, double* dv, double* dy) {
  products<false>(dv, dy, residual_v_.data(), residual_y_.data());
  multiply(dv, side_work_.data());
  for (int i = 0; i < packed_.sides; i += lanes)
    store(&side_work_[i], load(&side_work_[i]) * load(&weights_[i]));
  add_sides<1>(side_work_.data(), residual_v_.data());
  for (int i = 0; i < packed_.variables; i += lanes)
    store(&residual_v_[i],
          load(&residual_v_[i]) + load(gradient + i) + load(dv + i) * broadcast(shift_));
  for (int i = 0; i < packed_.equalities; i += lanes)
    store(&residual_y_[i], load(&residual_y_[i]) + load(equality + i));
  solve_with_rows(residual_v_.data(), residual_y_.data(), correction_v_.data(),
                  correction_y_.data());
  for (int i = 0; i < packed_.variables; i += lanes)
    store(dv + i, load(dv + i) + load(&correction_v_[i]));
  for (int i = 0; i < packed_.equalities; i += lanes)
    store(dy + i, load(dy + i) + load(&correction_y_[i]));
}

// Largest magnitude of the entries of equality rows in y.
double RiccatiSystem::largest_of_rows(const double* y) const {
  double most = 0.0;
  for (const PackedStage& p : packed_.stages)
    for (const RowBlock& b : p.rows)
      for (int i = 0; b.equality_at >= 0 && i < b.rows; ++i)
        most = std::fmax(most, std::fabs(y[b.equality_at + i]));
  return most;
}

// A solve leaves a fraction of about 1 / (1 + weight / stiffness) of a violation, given as `left`.
// The stiffness is that of the Hessian in the directions that satisfy the rows; it is large if
// inputs of size 1000 move states only slightly. Returns false if the weight cannot be raised.
bool RiccatiSystem::raise_equality_weight(double left) {
  // true if sides determine the weight, which is then large enough
  const bool is_for_sides = equality_weight_ > least_equality_weight_;
  if (is_for_sides || !(equality_weight_ < most_equality_weight) || !std::isfinite(left))
    return false;
  const double before = least_equality_weight_;
  least_equality_weight_ =
      std::fmin(equality_weight_ * std::fmin(left, 1.0) / wanted_rest, most_equality_weight);
  if (factor(weights_.data())) return true;
  least_equality_weight_ = before;
  factor(weights_.data());
  return false;
}

// Solves with the equality rows E dv = -equality as a penalty: dy = weight (E dv + equality).
void RiccatiSystem::solve_with_rows(const double* gradient, const double* equality, double* dv,
                                    double* dy) {
  double* scaled = row_work_.data();
  for (int i = 0; i < packed_.variables; i += lanes) store(&gradient_[i], load(gradient + i));
  for (const PackedStage& p : packed_.stages)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(scaled + i, load(equality + b.equality_at + i) * equality_weight_);
      b.kernel->add_transposed(b, scaled, 1.0, gradient_.data() + b.v_at);
    }
  sweep(gradient_.data(), equality, dv, dy);
  for (const PackedStage& p : packed_.stages)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      double* out = dy + b.equality_at;
      b.kernel->multiply(b, dv + b.v_at, 1.0, out);
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(out + i, (load(out + i) + load(equality + b.equality_at + i)) * equality_weight_);
    }
}

}  // namespace saltus::qp
