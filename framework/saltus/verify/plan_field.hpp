// The differential equation of one interval of a plan in scaled time s = (t - start) / length:
//   y = (x | q),  dy/ds = length * (f(z) | L(z)),  z = (t | x | u(s) | p).
#pragma once

#include <vector>

#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// Rates of states and integrals along an interval of a plan. Owns its work memory.
class PlanField {
 public:
  /// `integrands` have one output each and may be empty.
  PlanField(const Arguments& sizes, Function dynamics, std::vector<Function> integrands,
            InputShape shape);

  /// Loads times, inputs and parameters of an interval. They must outlive their use here.
  void load(const Plan::Interval& interval, const VectorXd& parameters);
  /// Inactive integrands are not evaluated; their integrals stay constant.
  void activate(int integrand, bool active) { active_[integrand] = active ? 1 : 0; }
  bool is_active(int integrand) const { return active_[integrand] != 0; }
  /// Replaces the dynamics by those of the active mode.
  void use(const Function& dynamics) { dynamics_ = dynamics; }

  const Arguments& sizes() const { return sizes_; }
  int states() const { return sizes_.nx; }
  /// States and integrals.
  int outputs() const { return sizes_.nx + static_cast<int>(integrands_.size()); }
  double start() const { return start_; }
  double length() const { return length_; }
  bool has_linear_input() const { return shape_ == InputShape::linear; }
  /// Entry i of the input at s = 0, and its change until s = 1.
  double input_at_start(int i) const { return (*coefficients_)[i]; }
  double input_change(int i) const {
    return has_linear_input() ? (*coefficients_)[sizes_.nu + i] - (*coefficients_)[i] : 0.0;
  }
  double parameter(int i) const { return (*parameters_)[i]; }

  /// z at scaled time s and state x; valid until the next call.
  const double* argument(double s, const double* x);
  /// Computes dy/ds at (s, y). Returns false if it is not finite.
  bool rates(double s, const double* y, double* rates);
  /// Computes length * f_x by rows (states x states). Returns false if it is not finite.
  bool state_jacobian(double s, const double* x, double* rows);

 private:
  Arguments sizes_;
  Function dynamics_;
  std::vector<Function> integrands_;
  std::vector<char> active_;
  InputShape shape_;
  double start_ = 0.0, length_ = 0.0;
  const VectorXd* coefficients_ = nullptr;
  const VectorXd* parameters_ = nullptr;
  std::vector<double> z_, values_, entries_;
};

}  // namespace saltus
