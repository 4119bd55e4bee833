// Products of the packed program with H, F and C, for residuals and refinement.
//
//     stationarity = H v [+ g] + F'y + E'y - G'lambda,   dynamics = F v [+ b] - x_next,
//     equality rows = E v [- e],   sides = G v
//
// The dynamics see the sum of the inputs of all parts. Upper sides enter as rows with reversed
// sign.
#include <algorithm>
#include <cmath>

#include "saltus/qp/riccati_system.hpp"

namespace saltus::qp {

// The main variables of the stage with the inputs of all parts added, as the dynamics see them.
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
  const double* costate = nullptr;  // multipliers of the dynamics that lead into the stage
  double* force = work_.data();
  for (std::size_t k = 0; k < packed_.stages.size(); ++k) {
    const PackedStage& p = packed_.stages[k];
    const SweepStage& w = p.sweep;
    const int ldm = padded(w.nu);
    const double* main = v + p.v_at;
    double* out = stationarity + p.v_at;
    const double* pi = y + p.costate_at;
    double* gap = equality + p.costate_at;
    p.kernel->products(w, p.H, affine ? p.g : nullptr, affine ? p.b : nullptr, main,
                       with_resultant(p, v), costate, pi,
                       w.next > 0 ? v + packed_.stages[k + 1].v_at : nullptr, out, force, gap);
    for (int part = 1; part < p.parts; ++part) {
      const double* further = main + w.ld + (part - 1) * ldm;
      double* to = out + w.ld + (part - 1) * ldm;
      for (int i = 0; i < ldm; i += lanes)
        store(to + i, affine ? load(p.r + (part - 1) * ldm + i) : Lanes{});
      multiply_vector<Update::add>(w.nu, w.nu, p.R + part * ldm * w.nu, ldm, further, to);
      for (int i = 0; i < w.nu; ++i) to[i] += force[w.nx + i];
    }
    costate = pi;
  }
  if (!packed_.has_equality_rows) return;
  for (const PackedStage& p : packed_.stages)
    for (const RowBlock& b : p.rows) {
      if (b.equality_at < 0) continue;
      b.kernel->multiply(b, v + b.v_at, 1.0, equality + b.equality_at);
      if (affine)
        for (int i = 0; i < padded(b.rows); ++i)
          equality[b.equality_at + i] -= packed_.wanted[b.equality_at + i];
      b.kernel->add_transposed(b, y + b.equality_at, 1.0, stationarity + b.v_at);
    }
}

void RiccatiSystem::multiply(const double* v, double* side) {
  const auto mask = [&](int at, int rows) {
    for (int i = at; i < at + padded(rows); i += lanes)
      store(side + i, load(side + i) * load(&packed_.active[i]));
  };
  for (const PackedStage& p : packed_.stages) {
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
      if (b.lower_at >= 0) store(side + b.lower_at + i, x * load(&packed_.active[b.lower_at + i]));
      if (b.upper_at >= 0) store(side + b.upper_at + i, -x * load(&packed_.active[b.upper_at + i]));
    }
  }
}

template <int sign>
void RiccatiSystem::add_sides(const double* side, double* v) {
  double* rows = work_.data();
  for (const PackedStage& p : packed_.stages) {
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
      if (b.lower_at >= 0)
        sum += load(side + b.lower_at + i) * load(&packed_.active[b.lower_at + i]);
      if (b.upper_at >= 0)
        sum -= load(side + b.upper_at + i) * load(&packed_.active[b.upper_at + i]);
      store(to, load(to) + (sign > 0 ? sum : -sum));
    }
  }
}

void RiccatiSystem::add_transposed(const double* side, double* v) { add_sides<1>(side, v); }

void RiccatiSystem::row_sizes(double* side) {
  for (const PackedStage& p : packed_.stages) {
    for (const RowBlock& b : p.rows) {
      if (b.equality_at >= 0) continue;
      if (b.twin != nullptr) {
        for (int i = 0; i < padded(b.rows); i += lanes) {
          if (b.lower_at >= 0) store(side + b.lower_at + i, load(side + b.twin->lower_at + i));
          if (b.upper_at >= 0) store(side + b.upper_at + i, load(side + b.twin->upper_at + i));
        }
        continue;
      }
      for (int i = 0; i < padded(b.rows); i += lanes) {
        Lanes square{};
        for (int c = 0; c < (b.diagonal ? 1 : b.columns); ++c) {
          const Lanes entry = load(b.C + c * padded(b.rows) + i);
          square += entry * entry;
        }
        for (int l = 0; l < lanes; ++l) square[l] = std::sqrt(square[l]);
        if (b.lower_at >= 0) store(side + b.lower_at + i, square);
        if (b.upper_at >= 0) store(side + b.upper_at + i, square);
      }
    }
    const BoundBlock& b = p.bounds;
    if (b.lower_at >= 0) std::fill_n(side + b.lower_at, b.length, 1.0);
    if (b.upper_at >= 0) std::fill_n(side + b.upper_at, b.length, 1.0);
  }
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

void RiccatiSystem::constants(double* stationarity, double* equality) const {
  for (int i = 0; i < packed_.equalities; ++i) equality[i] = -packed_.wanted[i];
  for (const PackedStage& p : packed_.stages) {
    const int further = (p.parts - 1) * padded(p.sweep.nu);
    std::copy_n(p.g, p.sweep.ld, stationarity + p.v_at);
    std::copy_n(p.r, further, stationarity + p.v_at + p.sweep.ld);
    std::copy_n(p.b, p.sweep.ld_next, equality + p.costate_at);
  }
}

double RiccatiSystem::cost(const double* v) {
  double* slope = work_.data();
  Lanes total{};
  // Returns v'(1/2 H v + g) of one block; padding is zero.
  const auto add = [&](int size, const double* H, const double* g, const double* at) {
    multiply_vector<Update::set>(size, size, H, padded(size), at, slope);
    for (int i = 0; i < size; i += lanes)
      total += (load(slope + i) * 0.5 + load(g + i)) * load(at + i);
  };
  for (const PackedStage& p : packed_.stages) {
    const int m = p.sweep.nu, ldm = padded(m);
    const double* main = v + p.v_at;
    add(p.sweep.nx + m, p.H, p.g, main);
    for (int part = 0; part + 1 < p.parts; ++part)
      add(m, p.R + (part + 1) * ldm * m, p.r + part * ldm, main + p.sweep.ld + part * ldm);
  }
  return sum(total);
}

void RiccatiSystem::roll_out(double* v) {
  for (std::size_t k = 0; k + 1 < packed_.stages.size(); ++k) {
    const PackedStage& p = packed_.stages[k];
    const int nn = p.sweep.next, n = p.sweep.nx + p.sweep.nu;
    const double* main = with_resultant(p, v);
    double* next = work_.data();
    for (int i = 0; i < p.sweep.ld_next; i += lanes) store(next + i, load(p.b + i));
    multiply_vector<Update::add>(nn, n, p.sweep.flow, p.sweep.ld_next, main, next);
    std::copy(next, next + nn, v + packed_.stages[k + 1].v_at);
  }
}

// riccati_system.cpp uses these for refinement.
template void RiccatiSystem::products<false>(const double*, const double*, double*, double*);
template void RiccatiSystem::add_sides<1>(const double*, double*);

}  // namespace saltus::qp
