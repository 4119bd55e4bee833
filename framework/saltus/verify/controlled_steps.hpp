// Integration with error control, by schemes that the transcriptions do not use.
//
// Non-stiff: the pair of Dormand and Prince 1980 of orders 5(4) with their continuous extension of
// order 4. Stiff: the L-stable SDIRK pair of orders 4(3) of Hairer and Wanner (Solving Ordinary
// Differential Equations II, section IV.6) with cubic Hermite interpolation. The first step, the
// largest step and the growth of steps are powers of the golden ratio. No step is therefore a
// simple fraction of the interval, so that oscillations synchronous with the grid are detected.
#pragma once

#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/verify/plan_field.hpp"

namespace saltus {

/// Integrates in steps from a scaled time to 1, with a polynomial for the state inside each step.
class ControlledSteps {
 public:
  /// Degree of the polynomials.
  static constexpr int degree = 4;

  /// `field` must outlive this object.
  ControlledSteps(PlanField& field, double tolerance);

  /// Keeps the error of a step below tolerance * max(unit, |y|) in each entry of (x | q).
  void set_units(const VectorXd& units) { units_ = units; }
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }
  /// Starts at s from y (states and integrals) with the field as currently loaded.
  void begin(double s, const double* y);
  /// Takes one step, at most to 1. Returns false if no step size succeeds.
  bool step();

  /// Goes back to the start of the last step. The next step ends before the fraction `theta` of it.
  void retry_before(double theta);

  /// True at the end of the interval.
  bool is_at_end() const { return s_ >= 1.0; }
  double step_start() const { return start_; }
  double step_length() const { return length_; }
  double time() const { return s_; }
  /// (x | q) at time().
  const std::vector<double>& state() const { return y_; }
  /// The coefficient of theta^power in y(step_start + theta step_length), outputs() numbers.
  const double* coefficient(int power) const { return polynomial_.data() + power * n_; }
  /// y inside the last step, theta in [0, 1].
  void state_at(double theta, double* y) const;
  /// True once the field has been found to be stiff; later intervals start with the implicit
  /// scheme.
  bool is_implicit() const { return implicit_; }
  /// True if the explicit scheme was used.
  bool was_explicit() const { return was_explicit_; }

 private:
  bool step_explicit();
  bool step_implicit();
  bool accept(double error, int order);
  double size_of(int i) const;
  bool solve_stage(int stage, double h);
  void interpolate_explicit(double h);
  void interpolate_implicit(double h);

  PlanField& field_;
  int n_, nx_;
  double tolerance_;
  VectorXd units_;
  double s_ = 0.0, h_ = 0.0, start_ = 0.0, length_ = 0.0;
  bool implicit_ = false, was_explicit_ = false, rejected_ = false;
  bool has_rate_ = false, has_factors_ = false;
  int steps_ = 0, stiff_signs_ = 0;
  double factored_h_ = 0.0;
  std::vector<double> y_, next_, stage_, error_, polynomial_, jacobian_, newton_;
  std::vector<std::vector<double>> k_;  // rates of the stages
  detail::DenseLu lu_;
};

}  // namespace saltus
