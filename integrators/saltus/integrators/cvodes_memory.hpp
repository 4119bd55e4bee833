// One CVODES solver for fields of one size: set-up, tolerances and callbacks. The field can change
// between integrations, as hybrid systems require.
#pragma once

#include <cvodes/cvodes.h>

#include <memory>
#include <vector>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/sundials_support.hpp"

namespace saltus::sundials {

/// Converts a return code of CVode().
IntegrationStatus status_of_cvode(int code);

/// Equations in scaled time: dy/ds = F(s, y), dS_j/ds = F_y S_j + F_theta_j (interval_field.hpp).
/// The absolute tolerance of S_j is that of y divided by the magnitude of w_j.
class CvodesMemory {
 public:
  /// `field` has the size of all fields. `entries` is the largest number of Jacobian entries.
  CvodesMemory(const IntervalProblem& problem, const CvodesOptions& options,
               const IntervalField& field, int entries);

  static IntegrationStatus status_of(int code) { return status_of_cvode(code); }
  static constexpr int one_step = CV_ONE_STEP;

  /// Sets the field for the next begin().
  void use(const IntervalField& field) { field_ = &field; }

  double* state() const { return y_.data(); }
  double* sensitivity(int direction) const { return sensitivity_.data(direction); }
  int directions() const { return directions_; }

  /// Starts at s from state(), and from sensitivity() if `sensitivities` is true. Integration never
  /// passes s = 1. `w` is the interval's argument, which scales tolerances. Returns a CVODES code.
  int begin(double s, const double* w, bool sensitivities);
  /// Calls CVode() once towards s = 1 with CV_NORMAL or CV_ONE_STEP. Sets state() and `reached`.
  int advance(int task, double& reached);
  /// Sets sensitivity() at the time reached.
  int read_sensitivity();
  /// State or sensitivities inside the last step, from the interpolant of the method.
  int interpolate(double s, double* y);
  int interpolate_sensitivity(double s);

  /// Computes F(s, y), outputs() entries.
  bool evaluate(double s, const double* y, double* rates);

 private:
  struct FreeCvode {
    void operator()(void* memory) const { CVodeFree(&memory); }
  };

  void create_state_solver();
  void create_sensitivity_solver();
  int sensitivity_method() const;
  bool update_sensitivity_tolerances(const double* w);
  bool evaluate_jacobian(double s, const double* x);
  static int rate(sunrealtype s, N_Vector y, N_Vector rates, void* user);
  static int state_jacobian(sunrealtype s, N_Vector y, N_Vector, SUNMatrix matrix, void* user,
                            N_Vector, N_Vector, N_Vector);
  static int sensitivity_rate(int count, sunrealtype s, N_Vector y, N_Vector, N_Vector* sensitivity,
                              N_Vector* rates, void* user, N_Vector, N_Vector);

  const IntervalProblem& problem_;
  CvodesOptions options_;
  const IntervalField* field_;
  int outputs_, directions_;
  Context context_;  // outlives everything created in it
  std::vector<double> absolute_;
  Vector y_, inside_;
  VectorArray sensitivity_, sensitivity_tolerance_;
  std::vector<double> sensitivity_scale_;
  Matrix matrix_;
  LinearSolver linear_;
  NonlinearSolver nonlinear_, sensitivity_nonlinear_;
  std::unique_ptr<void, FreeCvode> memory_;
  std::vector<double> z_, phi_, entries_;
  StoredException exception_;
};

}  // namespace saltus::sundials
