// Mehrotra's predictor-corrector method for convex quadratic programs, with any linear algebra that
// models KktSystem. Notation and derivation: framework/design/riccati.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/qp/ipm_active_set.hpp"
#include "saltus/qp/ipm_certificates.hpp"
#include "saltus/qp/ipm_convergence.hpp"
#include "saltus/qp/ipm_corrector.hpp"
#include "saltus/qp/ipm_inertia.hpp"
#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/ipm_newton.hpp"
#include "saltus/qp/ipm_residuals.hpp"
#include "saltus/qp/ipm_start.hpp"
#include "saltus/qp/ipm_steps.hpp"
#include "saltus/qp/kkt_system.hpp"
#include "saltus/qp/qp_result.hpp"

namespace saltus::qp {

template <KktSystem System>
class InteriorPoint {
 public:
  /// Takes the largest sizes of the systems to be solved, padding included; later calls do not
  /// allocate. Warm starts of convex programs first try up to `active_set_rounds` rounds, see
  /// ipm_active_set.hpp.
  InteriorPoint(int variables, int equalities, int sides, int active_set_rounds = 0)
      : active_set_rounds_(active_set_rounds),
        point_(variables, equalities, sides),
        step_(variables, equalities, sides),
        other_(variables, equalities, sides),
        target_(sides),
        residuals_(variables, equalities, sides),
        convergence_(variables, equalities, sides),
        newton_(variables, equalities, sides),
        work_(sides),
        row_size_(sides),
        gradient_(variables),
        equality_(equalities),
        active_set_(variables, equalities, sides),
        certificates_(variables, equalities, sides) {}

  /// Start and result. A warm start reads v, y and lambda, a cold start reads v. After solve() it
  /// holds the last iterate.
  Iterate& point() { return point_; }

  /// After a numerical failure, solves once more from the other kind of start.
  QpResult solve(System& system, const QpOptions& options, WallClock::time_point deadline,
                 bool warm) {
    newton_.reset();  // only before the first attempt: the second one keeps the lift d of the first
    certificates_.best_multiple = 0.0;
    const QpResult first = attempt(system, options, deadline, warm);
    if (first.status != QpStatus::numerical_failure) return first;
    constexpr double far_from_the_sides = 1.0;
    QpOptions other = options;
    other.start = !warm && options.start == QpOptions::Start::least_squares
                      ? QpOptions::Start::guess
                      : QpOptions::Start::least_squares;
    other.start_barrier = std::max(options.start_barrier, far_from_the_sides);
    other.max_iterations = std::max(0, options.max_iterations - first.iterations);
    std::fill_n(point_.v.data(), system.variables(), 0.0);
    QpResult second = attempt(system, other, deadline, false);
    second.iterations += first.iterations;
    const bool broke =
        second.status == QpStatus::numerical_failure || second.status == QpStatus::iteration_limit;
    if (broke && certificates_.best_multiple > certified_multiple_at_end) {
      second.status = QpStatus::infeasible;
      std::copy_n(certificates_.best_y.data(), system.equalities(), point_.y.data());
      std::copy_n(certificates_.best_lambda.data(), system.sides(), point_.lambda.data());
    }
    return second;
  }

 private:
  QpResult attempt(System& system, const QpOptions& options, WallClock::time_point deadline,
                   bool warm) {
    QpResult result;
    result.status = QpStatus::numerical_failure;
    restart(system, options);
    if (warm && (starts_at_optimum(system) || solves_by_active_set(system, options, deadline))) {
      result.status = QpStatus::optimal;
      result.iterations = rounds_;
      result.residual = residuals_.at_point().largest;
      result.violation = residuals_.at_point().feasibility;
      return result;
    }
    if (!begin(system, options, warm)) return result;
    for (int iteration = 0;; ++iteration) {
      result.iterations = rounds_ + iteration;
      convergence_.weigh_multipliers(system, point_);
      residuals_.follow(system, point_, last_step_, convergence_.acceptable());
      const Residuals& r = residuals_.at_point();
      if (convergence_.reached(system, point_, residuals_)) {
        result.status = QpStatus::optimal;
        break;
      }
      const bool goes_on = convergence_.goes_on(r);
      const bool suspicious =
          !goes_on || last_step_ < suspicious_step || caution_ > 0 || convergence_.has_diverged();
      if (suspicious && has_no_solution(system, result.status)) break;
      const bool late = is_late(deadline);
      const bool last = result.iterations >= options.max_iterations;
      if (!late && !last && goes_on && advance(system)) continue;
      if (convergence_.has_best()) {
        convergence_.restore(point_, result.residual, result.violation);
        result.status = QpStatus::optimal;
        return result;
      }
      result.status = late                               ? QpStatus::deadline
                      : last && std::isfinite(r.largest) ? QpStatus::iteration_limit
                                                         : QpStatus::numerical_failure;
      break;
    }
    result.residual = residuals_.at_point().largest;
    result.violation = residuals_.at_point().feasibility;
    return result;
  }

  static constexpr double infinite = std::numeric_limits<double>::infinity();
  // Centrality correctors (Gondzio) for short steps, and the gain in step length that they must
  // bring.
  static constexpr int centrality_corrections = 1;
  static constexpr double short_step = 0.9, target_gain = 0.2, least_gain = 0.01;
  // Steps shorter than this trigger the search for a certificate that there is no solution.
  static constexpr double suspicious_step = 0.05;
  // Mehrotra's method can cycle. If mu has not fallen for `cycle` steps, iterates are kept closer
  // to the central path.
  static constexpr int cycle = 4, most_caution = 2;
  static constexpr double target_decrease = 0.9, cautious_centring = 0.3;
  // a step of this length leaves the products well centred
  static constexpr double centred_step = 0.99;
  static constexpr int most_halvings = 8;
  static constexpr double expected_fall = 0.1;
  static constexpr double second_order[] = {1.0, 0.5, 0.0};  // fraction, by caution

  void restart(System& system, const QpOptions& options) {
    caution_ = rounds_ = 0;
    least_mu_ = infinite;
    steps_without_fall_ = 0;
    last_step_ = 1.0;
    system.expect_convex(options.convex);
    inertia_.reset(options.convex);
    residuals_.reset(system);
    convergence_.reset(options.tolerance);
  }

  bool starts_at_optimum(System& system) {
    convergence_.weigh_multipliers(system, point_);
    system.multiply(point_.v.data(), work_.data());
    if (!slacks_from_values(system, convergence_.tolerance(), work_, point_)) return false;
    residuals_.follow(system, point_, 1.0, convergence_.acceptable());
    return convergence_.reached(system, point_, residuals_);
  }

  // Expects G v in work_: see starts_at_optimum().
  bool solves_by_active_set(System& system, const QpOptions& options,
                            WallClock::time_point deadline) {
    const int most = std::min(active_set_rounds_, options.max_iterations);
    if (most <= 0 || !options.convex) return false;
    const bool found = active_set_.solve(
        system, convergence_.tolerance(), most, work_, point_, [&] { return is_late(deadline); },
        [&] { return starts_at_optimum(system); });
    rounds_ = active_set_.rounds();
    if (!found) system.multiply(point_.v.data(), work_.data());
    return found;
  }

  static bool is_late(WallClock::time_point deadline) {
    return deadline != WallClock::time_point::max() && WallClock::now() >= deadline;
  }

  bool begin(System& system, const QpOptions& options, bool warm) {
    if (warm) {
      // starts_at_optimum() left G v in work_.
      start_warm(system, options.warm_barrier, work_, point_, row_size_);
      residuals_.reset(system);
      return true;
    }
    if (options.start == QpOptions::Start::least_squares) {
      weigh_sides(system, row_size_);
      const bool factored = inertia_.correct([&](double shift) {
        system.set_shift(shift);
        return system.factor(row_size_.data());
      });
      if (factored) start_least_squares(system, row_size_, point_, work_, gradient_, equality_);
      return factored;
    }
    start_at_guess(system, options.start_barrier, point_, work_);
    return true;
  }

  bool factor(System& system, bool careful) {
    const bool done = inertia_.correct(
        [&](double shift) { return newton_.factor(system, point_, careful, shift); });
    if (inertia_.shift() > 0.0) residuals_.distrust();
    return done;
  }

  // The last step points in the direction of divergence before the iterates have grown, so it is
  // checked too.
  bool has_no_solution(System& system, QpStatus& status) {
    if (is_unbounded(system, point_.v, certificates_) ||
        is_unbounded(system, step_.v, certificates_)) {
      status = QpStatus::unbounded;
      return true;
    }
    if (convergence_.has_best()) return false;
    const auto prove = [&](const Iterate& multipliers) {
      return could_be_certificate(system, residuals_.at_point(), point_.s, multipliers) &&
             is_infeasible(system, point_.v, multipliers.y, multipliers.lambda, certificates_);
    };
    if (prove(point_)) {
      status = QpStatus::infeasible;
    } else if (prove(step_)) {
      status = QpStatus::infeasible;
      // The multipliers report the infeasibility certificate.
      std::copy_n(step_.y.data(), system.equalities(), point_.y.data());
      for (int i = 0; i < system.sides(); ++i)
        point_.lambda[i] = std::fmax(step_.lambda[i], 0.0) * system.active()[i];
    }
    return status == QpStatus::infeasible;
  }

  bool advance(System& system) {
    const Residuals& r = residuals_.at_point();
    const int soft = system.first_soft(), sides = system.sides();
    if (!factor(system, residuals_.lost_digits())) return false;
    // Predictor: targets zero for all products.
    predictor_target(system, point_, target_);
    newton_.solve(system, point_, r, target_, step_);
    const double affine = std::fmin(1.0, largest_step(point_, step_, soft, sides));
    // Corrector: targets `wanted` for the products, with the second-order term of the predictor.
    const double after = mean_product_after(system, point_, step_, affine, residuals_.products());
    detect_cycles(r.mu);
    const double least_centring = caution_ > 0 ? cautious_centring : 0.0;
    const double wanted = std::fmax(std::fmax(centring(r.mu, after), least_centring) * r.mu,
                                    convergence_.least_product(residuals_.products()));
    corrector_target(system, point_, step_, wanted, second_order[caution_], target_);
    newton_.solve(system, point_, r, target_, step_);
    double length = damped_step(point_, step_, soft, sides, r.mu);
    for (int round = 0; round < centrality_corrections && length < short_step; ++round) {
      std::swap(step_, other_);
      centrality_target(system, point_, other_, std::fmin(1.0, length + target_gain), wanted,
                        target_);
      newton_.solve(system, point_, r, target_, step_);
      const double longer = damped_step(point_, step_, soft, sides, r.mu);
      const bool helps = longer >= length + least_gain;
      if (longer < length) std::swap(step_, other_);
      length = std::fmax(length, longer);
      if (!helps) break;
    }
    // While rows are violated, the multipliers may have to grow.
    const bool only_products = r.feasibility <= convergence_.tolerance();
    if (caution_ == most_caution && only_products) length = descending(system, length);
    if (length > centred_step) caution_ = 0;
    move(system, length);
    return true;
  }

  // Halves the step length until the products decrease as expected for that length.
  double descending(System& system, double length) const {
    const double mu = residuals_.at_point().mu;
    for (int halvings = 0; halvings < most_halvings; ++halvings) {
      const double after = mean_product_after(system, point_, step_, length, residuals_.products());
      if (after <= (1.0 - expected_fall * length) * mu) break;
      length *= 0.5;
    }
    return length;
  }

  void detect_cycles(double mu) {
    steps_without_fall_ = mu < target_decrease * least_mu_ ? 0 : steps_without_fall_ + 1;
    least_mu_ = std::fmin(least_mu_, mu);
    if (steps_without_fall_ < cycle || caution_ == most_caution) return;
    ++caution_;
    steps_without_fall_ = 0;
  }

  void move(System& system, double length) {
    const int soft = system.first_soft(), sides = system.sides();
    last_step_ = length;
    add(point_.v, step_.v, length, 0, system.variables());
    add(point_.y, step_.y, length, 0, system.equalities());
    add(point_.s, step_.s, length, 0, sides);
    add(point_.lambda, step_.lambda, length, 0, sides);
    add(point_.t, step_.t, length, soft, sides);
    add(point_.tau, step_.tau, length, soft, sides);
  }
  static void add(AlignedArray& to, const AlignedArray& step, double length, int first, int last) {
    for (int i = first; i < last; i += lanes) store(&to[i], load(&to[i]) + load(&step[i]) * length);
  }

  int active_set_rounds_;
  Iterate point_, step_, other_;
  SideTarget target_;
  ResidualTracker<System> residuals_;
  Convergence<System> convergence_;
  NewtonStep<System> newton_;
  AlignedArray work_, row_size_, gradient_, equality_;
  ActiveSetRounds<System> active_set_;
  InertiaCorrection inertia_;
  CertificateSpace certificates_;
  int caution_ = 0;
  double least_mu_ = infinite, last_step_ = 1.0;
  int steps_without_fall_ = 0;
  int rounds_ = 0;  // rounds of the active set
};

}  // namespace saltus::qp
