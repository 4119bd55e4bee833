// Newton's step of the interior-point method for given targets of the products.
//
//     H dv + E'dy - G'dl = -rv,   E dv = -ry,   dl + W (G dv + rs) = -c
//
// where rs is the residual of the sides, W their condensed weights and c their targets (with the
// violation of soft sides eliminated, see ipm_corrector.hpp). Usually dl is eliminated and follows
// from G dv. A satisfied side with a large multiplier has a weight W that dominates H, and G dv is
// lost in rounding where W multiplies it. Then W^-1 is raised to W^-1 + d, dl stays an unknown, and
// iterative refinement corrects the effect of the lift d.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>

#include "saltus/qp/ipm_corrector.hpp"
#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/kkt_system.hpp"

namespace saltus::qp {

template <KktSystem System>
class NewtonStep {
 public:
  NewtonStep(int variables, int equalities, int sides)
      : weights_(sides),
        lifted_(sides),
        offset_(sides),
        side_work_(sides),
        side_residual_(sides),
        residual_v_(variables),
        correction_v_(variables),
        residual_y_(equalities),
        correction_y_(equalities),
        best_(variables, equalities, sides) {}

  /// Resets the lift d to its value for a new program.
  void reset() { level_ = 0; }

  /// Factors the system for steps from this iterate. Steps are refined if weights are large or with
  /// `careful`. Returns the value of system.factor(), which adds shift I to H.
  bool factor(System& system, const Iterate& p, bool careful, double shift = 0.0) {
    shift_ = shift;
    system.set_shift(shift);
    stiff_ = weigh(system, p, weights_) > stiff_weight || careful;
    return stiff_ ? factor_lifted(system) : system.factor(weights_.data());
  }

  void solve(System& system, const Iterate& p, const Residuals& r, const SideTarget& target,
             Iterate& step) {
    if (stiff_) {
      solve_refined(system, p, r, target, step);
      return;
    }
    side_gradient(system, p, r, weights_, target, side_work_);
    std::copy_n(r.stationarity.data(), system.variables(), residual_v_.data());
    system.add_transposed(side_work_.data(), residual_v_.data());
    system.solve(residual_v_.data(), r.equality.data(), step.v.data(), step.y.data());
    system.multiply(step.v.data(), step.s.data());
    recover_sides(system, p, r, weights_, target, step);
  }

 private:
  static constexpr double stiff_weight = 1e11;
  // H loses a fraction 1e-16 / lift of its accuracy. The convergence rate of the refinement is the
  // larger of this fraction and of lift times the stiffness of H.
  static constexpr double lifts[] = {1e-12, 1e-10, 0.0, 1e-14, 1e-8};
  static constexpr int levels = std::size(lifts);
  static constexpr int refinements = 8;
  // Thresholds for the error of a step: the largest error of its products relative to the
  // multipliers. In the other equations, one of the units below counts as `accurate`.
  static constexpr double accurate = 1e-3, very_accurate = 1e-6, worthwhile = 0.5;
  static constexpr double stationarity_unit = 1e-10, equality_unit = 1e-9;

  bool factor_lifted(System& system) {
    const Lanes lift = broadcast(lifts[level_]);
    for (int i = 0; i < system.sides(); i += lanes)
      store(&lifted_[i], load(&weights_[i]) / (load(&weights_[i]) * lift + 1.0));
    return system.factor(lifted_.data());
  }

  void solve_refined(System& system, const Iterate& p, const Residuals& r, const SideTarget& target,
                     Iterate& step) {
    side_offset(system, p, r, target, offset_);
    double smallest = 1e300;
    for (int tried = 0; tried < levels; ++tried) {
      if (tried > 0) {
        level_ = (level_ + 1) % levels;
        if (!factor_lifted(system)) continue;
      }
      refine(system, p, r, step, smallest);
      if (smallest <= accurate) break;
    }
    std::copy_n(best_.v.data(), system.variables(), step.v.data());
    std::copy_n(best_.y.data(), system.equalities(), step.y.data());
    std::copy_n(best_.lambda.data(), system.sides(), step.lambda.data());
    system.multiply(step.v.data(), step.s.data());
    recover_from_multipliers(system, p, r, target, step);
  }

  // Keeps the step in best_ if its error is the smallest so far.
  void refine(System& system, const Iterate& p, const Residuals& r, Iterate& step,
              double& smallest) {
    const int sides = system.sides(), variables = system.variables();
    const int equalities = system.equalities();
    const Lanes lift = broadcast(lifts[level_]);
    for (int i = 0; i < variables; i += lanes) {
      store(&step.v[i], Lanes{});
      store(&residual_v_[i], Lanes{});
    }
    for (int i = 0; i < equalities; i += lanes) {
      store(&step.y[i], Lanes{});
      store(&residual_y_[i], Lanes{});
    }
    for (int i = 0; i < sides; i += lanes) {
      store(&step.lambda[i], Lanes{});
      store(&side_residual_[i], Lanes{});
    }
    double last = 1e300;
    for (int round = 0;; ++round) {
      accumulate(residual_v_, r.stationarity, variables);
      accumulate(residual_y_, r.equality, equalities);
      // side_residual_ holds G dv. Computes the residual of the last equation, and the same divided
      // by 1 + lift W.
      Lanes wrong{}, multipliers{};
      for (int i = 0; i < sides; i += lanes) {
        const Lanes w = load(&weights_[i]), step_lambda = load(&step.lambda[i]);
        const Lanes lacking =
            step_lambda + load(&offset_[i]) + w * (load(&side_residual_[i]) + load(&r.side[i]));
        const Lanes size = load(&p.lambda[i]) + magnitude(step_lambda);
        multipliers = larger(multipliers, size);
        wrong = larger(wrong, magnitude(lacking) / (size + 1e-100));
        store(&side_work_[i], lacking / (w * lift + 1.0));
      }
      if (round > 0) {
        const double unit = stationarity_unit * std::fmax(1.0, largest(multipliers));
        double error = std::fmax(largest(wrong), accurate / unit * size_of(residual_v_, variables));
        error = std::fmax(error, accurate / equality_unit * size_of(residual_y_, equalities));
        if (error < smallest) {
          smallest = error;
          std::copy_n(step.v.data(), variables, best_.v.data());
          std::copy_n(step.y.data(), equalities, best_.y.data());
          std::copy_n(step.lambda.data(), sides, best_.lambda.data());
        }
        if (!(error < worthwhile * last) || error < very_accurate || round == refinements) return;
        last = error;
      }
      system.add_transposed(side_work_.data(), residual_v_.data());
      system.solve(residual_v_.data(), residual_y_.data(), correction_v_.data(),
                   correction_y_.data());
      system.multiply(correction_v_.data(), side_residual_.data());
      for (int i = 0; i < sides; i += lanes)
        store(&step.lambda[i], load(&step.lambda[i]) - load(&side_work_[i]) -
                                   load(&lifted_[i]) * load(&side_residual_[i]));
      accumulate(step.v, correction_v_, variables);
      accumulate(step.y, correction_y_, equalities);
      system.apply(step.v.data(), step.y.data(), step.lambda.data(), residual_v_.data(),
                   residual_y_.data(), side_residual_.data());
      for (int i = 0; i < variables && shift_ > 0.0; i += lanes)
        store(&residual_v_[i], load(&residual_v_[i]) + load(&step.v[i]) * shift_);
    }
  }

  static void accumulate(AlignedArray& to, const AlignedArray& a, int size) {
    for (int i = 0; i < size; i += lanes) store(&to[i], load(&to[i]) + load(&a[i]));
  }
  static double size_of(const AlignedArray& a, int size) {
    Lanes result{};
    for (int i = 0; i < size; i += lanes) result = larger(result, magnitude(load(&a[i])));
    return largest(result);
  }

  AlignedArray weights_, lifted_;
  AlignedArray offset_, side_work_, side_residual_;
  AlignedArray residual_v_, correction_v_, residual_y_, correction_y_;
  Iterate best_;
  bool stiff_ = false;
  double shift_ = 0.0;
  int level_ = 0;
};

}  // namespace saltus::qp
