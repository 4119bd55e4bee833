// Targets of an interior-point step, and the sides in the condensed system.
//
// The target of a side is the product to be removed divided by s: (s lambda - wanted) / s. It gives
// dlambda = -target - W ds with W = lambda / s. On soft sides the violation t is eliminated too:
// with D = l2 + W + tau / t, the condensed weight is W (D - W) / D.
#pragma once

#include <algorithm>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Below this slack, changes are lost in the rounding of the rows.
inline constexpr double tiny_slack = 1e-11;

/// Mehrotra's centring parameter: it decreases with the progress of the predictor.
inline double centring(double mu, double mu_after_predictor) {
  const double ratio = mu > 0.0 ? std::clamp(mu_after_predictor / mu, 0.0, 1.0) : 0.0;
  return ratio * ratio * ratio;
}

/// Computes the condensed weights of the sides and returns the largest.
template <class System>
double weigh(System& system, const Iterate& p, AlignedArray& weights) {
  Lanes most{};
  for (int i = 0; i < system.first_soft(); i += lanes) {
    const Lanes w = load(&p.lambda[i]) / load(&p.s[i]);
    store(&weights[i], w);
    most = larger(most, w);
  }
  for (int i = system.first_soft(); i < system.sides(); i += lanes) {
    const Lanes w = load(&p.lambda[i]) / load(&p.s[i]);
    const Lanes rest = load(system.l2() + i) + load(&p.tau[i]) / load(&p.t[i]);
    const Lanes both = w * rest / (rest + w);
    store(&weights[i], both);
    most = larger(most, both);
  }
  return largest(most);
}

/// Target of the predictor: zero for all products.
template <class System>
void predictor_target(System& system, const Iterate& p, SideTarget& target) {
  for (int i = 0; i < system.sides(); i += lanes) store(&target.side[i], load(&p.lambda[i]));
  for (int i = system.first_soft(); i < system.sides(); i += lanes)
    store(&target.soft[i], load(&p.tau[i]) * load(system.active() + i));
}

/// Target of the corrector: `wanted` for all products, with the second-order term.
template <class System>
void corrector_target(System& system, const Iterate& p, const Iterate& predictor, double wanted,
                      double second_order, SideTarget& target) {
  for (int i = 0; i < system.sides(); i += lanes) {
    const Lanes correction = load(&predictor.s[i]) * load(&predictor.lambda[i]) * second_order -
                             load(system.active() + i) * wanted;
    store(&target.side[i], load(&p.lambda[i]) + correction / load(&p.s[i]));
  }
  for (int i = system.first_soft(); i < system.sides(); i += lanes) {
    const Lanes correction =
        load(&predictor.t[i]) * load(&predictor.tau[i]) * second_order - wanted;
    store(&target.soft[i],
          (load(&p.tau[i]) + correction / load(&p.t[i])) * load(system.active() + i));
  }
}

/// Gondzio's centrality corrector: moves products that a step of this length would leave far from
/// `wanted` to within a factor of ten of it.
template <class System>
void centrality_target(System& system, const Iterate& p, const Iterate& step, double length,
                       double wanted, SideTarget& target) {
  constexpr double factor = 10.0;
  const Lanes low = broadcast(wanted / factor), high = broadcast(wanted * factor);
  for (int i = 0; i < system.sides(); i += lanes) {
    const Lanes s = load(&p.s[i]);
    const Lanes product =
        (s + load(&step.s[i]) * length) * (load(&p.lambda[i]) + load(&step.lambda[i]) * length);
    const Lanes inside = smaller(larger(product, low), high);
    const Lanes change = larger(inside - product, -high) * load(system.active() + i);
    store(&target.side[i], load(&target.side[i]) - change / s);
  }
  for (int i = system.first_soft(); i < system.sides(); i += lanes) {
    const Lanes t = load(&p.t[i]);
    const Lanes product =
        (t + load(&step.t[i]) * length) * (load(&p.tau[i]) + load(&step.tau[i]) * length);
    const Lanes inside = smaller(larger(product, low), high);
    const Lanes change = larger(inside - product, -high) * load(system.active() + i);
    store(&target.soft[i], load(&target.soft[i]) - change / t);
  }
}

template <class System>
Lanes soft_offset(System& system, const Iterate& p, const Residuals& r, const SideTarget& target,
                  int i) {
  const Lanes w = load(&p.lambda[i]) / load(&p.s[i]);
  const Lanes D = load(system.l2() + i) + load(&p.tau[i]) / load(&p.t[i]) + w;
  const Lanes e = load(&r.soft[i]) + load(&target.side[i]) + load(&target.soft[i]);
  return load(&target.side[i]) - w * e / D;
}

/// Computes the part of dlambda = -offset - weight (G dv + residual) that does not depend on dv.
template <class System>
void side_offset(System& system, const Iterate& p, const Residuals& r, const SideTarget& target,
                 AlignedArray& offset) {
  for (int i = 0; i < system.first_soft(); i += lanes) store(&offset[i], load(&target.side[i]));
  for (int i = system.first_soft(); i < system.sides(); i += lanes)
    store(&offset[i], soft_offset(system, p, r, target, i));
}

/// Computes gradient = offset + W residual, which G' then adds to the right-hand side.
template <class System>
void side_gradient(System& system, const Iterate& p, const Residuals& r,
                   const AlignedArray& weights, const SideTarget& target, AlignedArray& gradient) {
  for (int i = 0; i < system.first_soft(); i += lanes)
    store(&gradient[i], load(&target.side[i]) + load(&weights[i]) * load(&r.side[i]));
  for (int i = system.first_soft(); i < system.sides(); i += lanes)
    store(&gradient[i],
          soft_offset(system, p, r, target, i) + load(&weights[i]) * load(&r.side[i]));
}

/// Given G dv in step.s, computes ds, dlambda and, on soft sides, dt and dtau.
template <class System>
void recover_sides(System& system, const Iterate& p, const Residuals& r,
                   const AlignedArray& weights, const SideTarget& target, Iterate& step) {
  for (int i = 0; i < system.first_soft(); i += lanes) {
    const Lanes ds = load(&step.s[i]) + load(&r.side[i]);
    store(&step.s[i], ds);
    store(&step.lambda[i], -load(&target.side[i]) - load(&weights[i]) * ds);
  }
  for (int i = system.first_soft(); i < system.sides(); i += lanes) {
    const Lanes w = load(&p.lambda[i]) / load(&p.s[i]);
    const Lanes u = load(&p.tau[i]) / load(&p.t[i]);
    const Lanes D = load(system.l2() + i) + u + w;
    const Lanes e = load(&r.soft[i]) + load(&target.side[i]) + load(&target.soft[i]);
    const Lanes y = load(&step.s[i]) + load(&r.side[i]);
    const Lanes active = load(system.active() + i);
    const Lanes dt = -(e + w * y) / D * active;
    store(&step.t[i], dt);
    store(&step.s[i], y + dt);
    store(&step.lambda[i], -load(&target.side[i]) - w * (y + dt));
    store(&step.tau[i], (-load(&target.soft[i]) - u * dt) * active);
  }
}

/// Given G dv in step.s and dlambda in step.lambda, computes ds and, on soft sides, dt and dtau.
/// The linear equations hold for any dlambda. Variables too small for these equations follow from
/// their product instead.
template <class System>
void recover_from_multipliers(System& system, const Iterate& p, const Residuals& r,
                              const SideTarget& target, Iterate& step) {
  const Lanes tiny = broadcast(tiny_slack);
  for (int i = 0; i < system.sides(); i += lanes) {
    const Lanes s = load(&p.s[i]), lambda = load(&p.lambda[i]);
    const Lanes from_rows = load(&step.s[i]) + load(&r.side[i]);
    const Lanes from_multiplier = -(load(&target.side[i]) + load(&step.lambda[i])) * s / lambda;
    if (i < system.first_soft()) {
      store(&step.s[i], smaller(tiny, lambda) > s ? from_multiplier : from_rows);
      continue;
    }
    const Lanes t = load(&p.t[i]), tau = load(&p.tau[i]), u = tau / t;
    const Lanes w = lambda / s, rest = load(system.l2() + i) + u;
    const Lanes active = load(system.active() + i);
    const Lanes pull = load(&step.lambda[i]) - load(&r.soft[i]);
    const Lanes small_dt = (pull - load(&target.soft[i])) / rest;
    const Lanes dt = (rest > w ? small_dt : from_multiplier - from_rows) * active;
    const Lanes ds = rest > w && smaller(tiny, lambda) < s ? from_rows + dt : from_multiplier;
    const Lanes from_penalty = load(system.l2() + i) * dt - pull;
    const Lanes from_product = -load(&target.soft[i]) - u * dt;
    store(&step.t[i], dt);
    store(&step.s[i], active > 0.0 ? ds : from_rows);
    store(&step.tau[i], (smaller(tiny, t) > tau ? from_product : from_penalty) * active);
  }
}

/// Mean product of the sides after a step of this length.
template <class System>
double mean_product_after(System& system, const Iterate& p, const Iterate& step, double length,
                          double products) {
  Lanes total{};
  for (int i = 0; i < system.sides(); i += lanes)
    total += (load(&p.s[i]) + load(&step.s[i]) * length) *
             (load(&p.lambda[i]) + load(&step.lambda[i]) * length);
  for (int i = system.first_soft(); i < system.sides(); i += lanes)
    total += (load(&p.t[i]) + load(&step.t[i]) * length) *
             (load(&p.tau[i]) + load(&step.tau[i]) * length) * load(system.active() + i);
  return products > 0.0 ? sum(total) / products : 0.0;
}

}  // namespace saltus::qp
