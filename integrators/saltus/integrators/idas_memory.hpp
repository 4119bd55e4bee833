// One IDAS solver for fields of one size, with or without algebraic states: set-up, tolerances and
// callbacks. The field can change between integrations, as hybrid systems require.
#pragma once

#include <idas/idas.h>

#include <memory>
#include <optional>
#include <vector>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/sundials_support.hpp"

namespace saltus::sundials {

/// Converts a return code of IDASolve().
IntegrationStatus status_of_ida(int code);

/// Equations in scaled time, with Y = (x | z | q) and the field's phi = (f | g | L):
///   x' = h f,  0 = g,  q' = h L,   and for the sensitivity to w_j the same, differentiated.
class IdasMemory {
 public:
  /// The states of `field` are x followed by z, one z per equation of `algebraic`. The entries of w
  /// are those of `problem`, without z. `entries` is the largest number of Jacobian entries of any
  /// field.
  IdasMemory(const IntervalProblem& problem, const IdasOptions& options, const IntervalField& field,
             int entries, const AlgebraicEquations* algebraic = nullptr);

  void use(const IntervalField& field) { field_ = &field; }

  /// Y. Set x and q before begin(), which computes z.
  double* state() const { return y_.data(); }
  double* sensitivity(int direction) const { return sensitivity_.data(direction); }
  int directions() const { return directions_; }
  int states() const { return nx_; }
  int first_cost() const { return nx_ + nz_; }

  /// Starts at s from state(), and from sensitivity() if `sensitivities` is true. Integration never
  /// passes s = 1. `w` is the interval's argument, which scales tolerances. Returns an IDAS code.
  int begin(double s, const double* w, bool sensitivities);
  int advance(int task, double& reached);
  int read_sensitivity();
  int interpolate(double s, double* y);
  int interpolate_sensitivity(double s);
  /// Computes (h f | h L), or (h f | g | h L), at (s, Y).
  bool evaluate(double s, const double* y, double* rates);
  /// Computes (f | g | L) at (s, state()), not multiplied by the length.
  void rates_at(double s, double* rates);

  static IntegrationStatus status_of(int code) { return status_of_ida(code); }
  static constexpr int until_end = IDA_NORMAL, one_step = IDA_ONE_STEP;

 private:
  struct FreeIda {
    void operator()(void* memory) const { IDAFree(&memory); }
  };

  void create_state_solver();
  void create_sensitivity_solver();
  bool update_sensitivity_tolerances(const double* w);
  bool evaluate_jacobian(double s, const double* y);
  bool make_consistent(double s, bool sensitivities);
  void sensitivity_rates(double s);
  int direction_of(int d) const { return d < nx_ ? d : d + nz_; }
  bool is_algebraic(int r) const { return r >= nx_ && r < nx_ + nz_; }
  static int residual(sunrealtype s, N_Vector y, N_Vector slope, N_Vector result, void* user);
  static int jacobian(sunrealtype s, sunrealtype cj, N_Vector y, N_Vector, N_Vector,
                      SUNMatrix matrix, void* user, N_Vector, N_Vector, N_Vector);
  static int sensitivity_residual(int count, sunrealtype s, N_Vector y, N_Vector, N_Vector,
                                  N_Vector* sensitivity, N_Vector* slope, N_Vector* result,
                                  void* user, N_Vector, N_Vector, N_Vector);

  const IntervalProblem& problem_;
  IdasOptions options_;
  const IntervalField* field_;
  const AlgebraicEquations* algebraic_;
  std::optional<AlgebraicEquations::Solution> solution_;  // if there are equations
  int nz_, nx_, outputs_, directions_, first_algebraic_entry_ = 0;
  Context context_;  // outlives everything created in it
  std::vector<double> absolute_;
  Vector y_, slope_, inside_;
  VectorArray sensitivity_, sensitivity_slope_, sensitivity_tolerance_;
  std::vector<double> sensitivity_scale_;
  Matrix matrix_;
  LinearSolver linear_;
  std::unique_ptr<void, FreeIda> memory_;
  std::vector<double> z_, phi_, entries_, dense_, reduced_, algebraic_slope_;
  RowMajorMatrix stacked_, rates_, algebraic_rates_;  // for all directions of the field
  StoredException exception_;
};

}  // namespace saltus::sundials
