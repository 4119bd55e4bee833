// Mehrotra's predictor-corrector method for convex quadratic programs, for any linear algebra that
// models KktSystem. Notation and derivation: framework/design/riccati.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "framework/qp/ipm_certificates.hpp"
#include "framework/qp/ipm_corrector.hpp"
#include "framework/qp/ipm_iterate.hpp"
#include "framework/qp/ipm_start.hpp"
#include "framework/qp/ipm_steps.hpp"
#include "framework/qp/kkt_system.hpp"
#include "framework/qp/qp_result.hpp"

namespace saltus::qp {

template <KktSystem System>
class InteriorPoint {
 public:
  /// Largest sizes of the systems to be solved, padding included. Nothing allocates later.
  InteriorPoint(int variables, int equalities, int sides)
      : point_(variables, equalities, sides),
        residuals_(variables, equalities, sides),
        step_(variables, equalities, sides),
        other_(variables, equalities, sides),
        best_(variables, equalities, sides),
        target_(sides),
        weights_(sides),
        work_(sides),
        gradient_(variables),
        scratch_(variables, equalities, sides) {}

  /// The start is read from it (with `warm`, v, y and lambda; otherwise v), and the last iterate
  /// is left in it.
  Iterate& point() { return point_; }

  QpResult solve(System& system, const QpOptions& options, QpClock::time_point deadline,
                 bool warm) {
    QpResult result;
    if (!begin(system, options, warm)) {
      result.status = QpStatus::numerical_failure;
      return result;
    }
    const Lengths size(system);
    Progress progress;
    for (int iteration = 0;; ++iteration) {
      const double scale = multiplier_scale(size);
      tolerance_ = options.tolerance * std::fmax(1.0, scale / large_multiplier);
      acceptable_ = options.tolerance * scale;
      requested_ = options.tolerance;
      follow_residuals(system, size);
      result.iterations = iteration;
      if (residuals_.largest <= tolerance_ && residuals_.feasibility <= options.tolerance &&
          trusted_steps_ == 0 && residuals_.mu <= enough_on_average * tolerance_) {
        result.status = QpStatus::optimal;
        return result;
      }
      keep_best(progress, size);
      const bool goes_on = progress.counts(residuals_.largest);
      if (!goes_on || shortest_step_ < suspicious_step) {
        result.status = why_not(system, progress);
        if (result.status != QpStatus::optimal) return result;
      }
      const bool late = deadline != QpClock::time_point::max() && QpClock::now() >= deadline;
      if (late || !goes_on || iteration == options.max_iterations || !advance(system, size)) {
        result.status = progress.has_best ? QpStatus::optimal
                        : late            ? QpStatus::deadline
                        : std::isfinite(residuals_.largest) && iteration == options.max_iterations
                            ? QpStatus::iteration_limit
                            : QpStatus::numerical_failure;
        if (progress.has_best) std::swap(point_, best_);
        return result;
      }
    }
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  struct Lengths {
    explicit Lengths(System& system)
        : variables(system.variables()),
          equalities(system.equalities()),
          sides(system.sides()),
          first_soft(system.first_soft()) {
      double active = 0.0;
      for (int i = 0; i < sides; ++i) active += system.active()[i];
      for (int i = first_soft; i < sides; ++i) active += system.active()[i];
      products = active;
    }
    int variables, equalities, sides, first_soft;
    double products;  // how many s lambda and t tau there are
  };

  // Rounding may forbid the last digits where multipliers are large. The best point that meets the
  // tolerance in units of the multipliers is kept for the case that it does not get better.
  struct Progress {
    double least = infinite, best = infinite;
    int without = 0;
    bool has_best = false;
    /// False when nothing has improved for too long, or nothing is left to improve.
    bool counts(double residual) {
      without = residual < 0.5 * least ? 0 : without + 1;
      least = std::fmin(least, residual);
      return std::isfinite(residual) && without < (has_best ? patience_at_end : patience);
    }
  };
  void keep_best(Progress& progress, const Lengths& size) {
    if (trusted_steps_ != 0 || !(residuals_.largest <= acceptable_) ||
        residuals_.feasibility > requested_ || !(residuals_.largest < progress.best))
      return;
    progress.best = residuals_.largest;
    progress.has_best = true;
    std::copy_n(point_.v.data(), size.variables, best_.v.data());
    std::copy_n(point_.y.data(), size.equalities, best_.y.data());
    std::copy_n(point_.lambda.data(), size.sides, best_.lambda.data());
  }
  QpStatus why_not(System& system, const Progress& progress) {
    if (progress.has_best) return QpStatus::optimal;
    if (is_infeasible(system, point_.v, point_.y, point_.lambda, scratch_) ||
        is_infeasible(system, point_.v, step_.y, step_.lambda, scratch_))
      return QpStatus::infeasible;
    return is_unbounded(system, point_, scratch_) ? QpStatus::unbounded : QpStatus::optimal;
  }

  static constexpr int patience = 20, patience_at_end = 6;
  // Centrality correctors (Gondzio) where the step is short, and what they must bring.
  static constexpr int centrality_corrections = 1;
  static constexpr double short_step = 0.9, hoped_gain = 0.2, least_gain = 0.01;
  // Products are not driven further below the tolerance than this: it would only cost digits.
  static constexpr double floor_of_products = 2e-3, enough_on_average = 1e-2;
  static constexpr int longest_trust = 6;
  static constexpr double suspicious_step = 1e-2;
  static constexpr int cycle = 4;
  static constexpr double hoped_fall = 0.9, cautious_centring = 0.3, cautious_second_order = 0.5;

  bool begin(System& system, const QpOptions& options, bool warm) {
    cautious_ = false;
    least_mu_ = infinite;
    steps_without_fall_ = 0;
    shortest_step_ = 1.0;
    last_step_ = 1.0;
    trusted_steps_ = 0;
    has_residuals_ = false;
    tolerance_ = options.tolerance;
    if (warm)
      return begin_warm(system, options);
    else if (options.start == QpStart::guess)
      start_at_guess(system, options.start_barrier, point_, work_);
    else
      return start_least_squares(system, point_, work_, gradient_, residuals_.equality);
    return true;
  }

  // One full Newton step from the lifted point: exact if what binds is what bound before. How badly
  // gaps and multipliers then contradict each other says how far the neighbour is.
  bool begin_warm(System& system, const QpOptions& options) {
    const Lengths size(system);
    lift_products(system, options.warm_barrier, point_, work_);
    evaluate(system, size);
    weigh(system, point_, weights_);
    if (!system.factor(weights_.data())) return false;
    predictor_target(system, point_, target_);
    direction(system, size);
    add(point_.v, step_.v, 1.0, size.variables);
    add(point_.y, step_.y, 1.0, size.equalities);
    add(point_.lambda, step_.lambda, 1.0, size.sides);
    const double distance = mean_mismatch(system, point_, work_);
    lift_products(
        system,
        std::clamp(barrier_per_mismatch * distance, least_warm_barrier, options.start_barrier),
        point_, work_);
    return true;
  }
  static constexpr double barrier_per_mismatch = 1e-2, least_warm_barrier = 1e-6;

  // A step of length a leaves (1 - a) of every linear residual: as long as the optimum is far, that
  // is taken for granted. The last word is always the residual of the problem itself.
  void follow_residuals(System& system, const Lengths& size) {
    Residuals& r = residuals_;
    measure_products(system, size);
    const bool far = r.largest_product > acceptable_ && trusted_steps_ < longest_trust;
    if (far && has_residuals_) {
      ++trusted_steps_;
      scale(r.stationarity, 1.0 - last_step_, size.variables);
      scale(r.equality, 1.0 - last_step_, size.equalities);
      scale(r.side, 1.0 - last_step_, size.sides);
      for (int i = size.first_soft; i < size.sides; i += lanes)
        store(&r.soft[i], load(&r.soft[i]) * (1.0 - last_step_));
    } else {
      trusted_steps_ = 0;
      evaluate(system, size);
    }
    measure(size);
    has_residuals_ = true;
  }

  void evaluate(System& system, const Lengths& size) {
    Residuals& r = residuals_;
    system.evaluate(point_.v.data(), point_.y.data(), point_.lambda.data(), r.stationarity.data(),
                    r.equality.data(), r.side.data());
    for (int i = 0; i < size.first_soft; i += lanes)
      store(&r.side[i], (load(&r.side[i]) - load(system.beta() + i) - load(&point_.s[i])) *
                            load(system.active() + i));
    for (int i = size.first_soft; i < size.sides; i += lanes) {
      const Lanes active = load(system.active() + i), t = load(&point_.t[i]);
      store(&r.side[i],
            (load(&r.side[i]) - load(system.beta() + i) + t - load(&point_.s[i])) * active);
      store(&r.soft[i], (load(system.l1() + i) + load(system.l2() + i) * t -
                         load(&point_.lambda[i]) - load(&point_.tau[i])) *
                            active);
    }
  }

  void measure_products(System& system, const Lengths& size) {
    Lanes product{}, total{};
    for (int i = 0; i < size.sides; i += lanes) {
      const Lanes p = load(&point_.s[i]) * load(&point_.lambda[i]);
      product = larger(product, p);
      total += p;
    }
    for (int i = size.first_soft; i < size.sides; i += lanes) {
      const Lanes p = load(&point_.t[i]) * load(&point_.tau[i]) * load(system.active() + i);
      product = larger(product, p);
      total += p;
    }
    residuals_.largest_product = qp::largest(product);
    residuals_.mu = size.products > 0.0 ? sum(total) / size.products : 0.0;
  }

  void measure(const Lengths& size) {
    Residuals& r = residuals_;
    r.feasibility = std::fmax(largest_magnitude(r.side.data(), size.sides),
                              largest_magnitude(r.equality.data(), size.equalities));
    Lanes soft{};
    for (int i = size.first_soft; i < size.sides; i += lanes)
      soft = larger(soft, magnitude(load(&r.soft[i])));
    const double dual =
        std::fmax(largest_magnitude(r.stationarity.data(), size.variables), qp::largest(soft));
    r.largest = std::fmax(std::fmax(r.feasibility, r.largest_product), dual);
    // fmax ignores NaN: a sum does not.
    r.largest += 0.0 * (r.mu + sum_of(r.stationarity.data(), size.variables));
  }

  bool advance(System& system, const Lengths& size) {
    weigh(system, point_, weights_);
    if (!system.factor(weights_.data())) return false;
    // Predictor: all products to zero.
    predictor_target(system, point_, target_);
    direction(system, size);
    StepLengths affine = largest_steps(point_, step_, size.first_soft, size.sides);
    affine.primal = affine.dual = std::fmin(1.0, std::fmin(affine.primal, affine.dual));
    // Corrector: products to sigma mu, with the second-order term of the predictor.
    const double after = mean_product_after(system, point_, step_, affine, size.products);
    // Mehrotra's method can cycle. Once mu has not fallen, it is held nearer to the central path.
    const bool falls = residuals_.mu < hoped_fall * least_mu_;
    least_mu_ = std::fmin(least_mu_, residuals_.mu);
    steps_without_fall_ = falls ? 0 : steps_without_fall_ + 1;
    cautious_ = cautious_ || steps_without_fall_ >= cycle;
    const double least_centring = cautious_ ? cautious_centring : 0.0;
    const double wanted =
        std::fmax(std::fmax(centring(residuals_.mu, after), least_centring) * residuals_.mu,
                  floor_of_products * tolerance_);
    corrector_target(system, point_, step_, wanted, cautious_ ? cautious_second_order : 1.0,
                     target_);
    direction(system, size);
    StepLengths length = damped_steps(point_, step_, size.first_soft, size.sides, residuals_.mu);
    for (int round = 0; round < centrality_corrections && length.primal < short_step; ++round) {
      std::swap(step_, other_);
      centrality_target(system, point_, other_, std::fmin(1.0, length.primal + hoped_gain), wanted,
                        target_);
      direction(system, size);
      const StepLengths longer =
          damped_steps(point_, step_, size.first_soft, size.sides, residuals_.mu);
      if (longer.primal < length.primal + least_gain) {
        if (longer.primal < length.primal)
          std::swap(step_, other_);
        else
          length = longer;
        break;
      }
      length = longer;
    }
    shortest_step_ = last_step_ = std::fmin(length.primal, length.dual);
    move(length, size);
    return true;
  }

  // Newton step for the products in target_, given as "what is wanted away, over s" (see
  // ipm_corrector.hpp).
  void direction(System& system, const Lengths& size) {
    side_gradient(system, point_, residuals_, weights_, target_, work_);
    system.multiply_transposed(work_.data(), gradient_.data());
    for (int i = 0; i < size.variables; i += lanes)
      store(&gradient_[i], load(&gradient_[i]) + load(&residuals_.stationarity[i]));
    system.solve(gradient_.data(), residuals_.equality.data(), step_.v.data(), step_.y.data());
    system.multiply(step_.v.data(), step_.s.data());
    recover_sides(system, point_, residuals_, target_, step_);
  }

  void move(const StepLengths& length, const Lengths& size) {
    add(point_.v, step_.v, length.primal, size.variables);
    add(point_.y, step_.y, length.dual, size.equalities);
    add(point_.s, step_.s, length.primal, size.sides);
    add(point_.lambda, step_.lambda, length.dual, size.sides);
    for (int i = size.first_soft; i < size.sides; i += lanes) {
      store(&point_.t[i], load(&point_.t[i]) + load(&step_.t[i]) * length.primal);
      store(&point_.tau[i], load(&point_.tau[i]) + load(&step_.tau[i]) * length.dual);
    }
  }

  static void scale(AlignedArray& a, double factor, int size) {
    for (int i = 0; i < size; i += lanes) store(&a[i], load(&a[i]) * factor);
  }
  static void add(AlignedArray& to, const AlignedArray& step, double length, int size) {
    for (int i = 0; i < size; i += lanes) store(&to[i], load(&to[i]) + load(&step[i]) * length);
  }
  static double largest_magnitude(const double* a, int size) {
    Lanes result{};
    for (int i = 0; i < size; i += lanes) result = larger(result, magnitude(load(a + i)));
    return qp::largest(result);
  }
  static double sum_of(const double* a, int size) {
    Lanes result{};
    for (int i = 0; i < size; i += lanes) result += load(a + i);
    return sum(result);
  }
  // A side with a multiplier of a million cannot be met to 1e-8 / 1e6: rounding forbids it. Beyond
  // this size of the multipliers the tolerance grows with them.
  static constexpr double large_multiplier = 1e4;
  double multiplier_scale(const Lengths& size) const {
    const double y = largest_magnitude(point_.y.data(), size.equalities);
    const double lambda = largest_magnitude(point_.lambda.data(), size.sides);
    return std::fmax(1.0, std::fmax(y, lambda));
  }

  Iterate point_;
  Residuals residuals_;
  Iterate step_, other_, best_;
  SideTarget target_;
  AlignedArray weights_, work_, gradient_;
  CertificateSpace scratch_;
  bool cautious_ = false;
  double least_mu_ = infinite;
  int steps_without_fall_ = 0;
  double shortest_step_ = 1.0, last_step_ = 1.0, requested_ = 1e-8;
  double tolerance_ = 1e-8, acceptable_ = 1e-8;  // the same in units of the multipliers
  int trusted_steps_ = 0;
  bool has_residuals_ = false;
};

}  // namespace saltus::qp
