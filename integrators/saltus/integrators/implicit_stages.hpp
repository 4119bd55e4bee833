// The stages of one Runge-Kutta step in scaled time from s over the length D:
//   X_i = x + D sum_j a_ij F_j,   F_j = F(s + c_j D, X_j),
// Newton's method solves implicit stages to rounding. The factors of M_ij = I delta_ij - D a_ij
// F_Xj give derivatives of the stages in forward and adjoint mode.
#pragma once

#include <vector>

#include "saltus/core/dense_lu.hpp"
#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// Data of one step. Fields of several modes may share it, sized for the most Jacobian entries.
struct ImplicitStep {
  struct Stage {
    VectorXd z, phi, entries;  // argument, rates, Jacobian entries
    VectorXd adjoint;          // Fbar
    VectorXd gradient;         // phi_z' Fbar
  };
  ImplicitStep(int stages, const IntervalField& field, int entries);

  std::vector<Stage> stages;
  detail::DenseLu matrix;  // M
};

class StageSolver {
 public:
  StageSolver(ButcherTableau tableau, const VectorXd& nominal_state, int states, int outputs);

  const ButcherTableau& tableau() const { return tableau_; }
  int count() const { return tableau_.stages(); }
  /// d = a^-T b for implicit schemes: x+ = x + sum_i d_i (X_i - x), which avoids the rounding of
  /// stiff rates.
  const VectorXd& end_weights() const { return end_weights_; }

  /// Computes the stages into states(). Rates and slopes are those of the last iterate.
  IntegrationStatus find(const IntervalField& field, double s, double length, const double* x,
                         ImplicitStep& step);
  /// X_1 | X_2 | ...
  const double* states() const { return states_.data(); }
  const double* state(int stage) const { return states_.data() + stage * nx_; }
  /// Call after find(). evaluate_rates() computes the rates at the stages, evaluate_slopes() also
  /// their Jacobians and the factors of M.
  void evaluate_rates(const IntervalField& field, double s, double length, ImplicitStep& step);
  IntegrationStatus evaluate_slopes(const IntervalField& field, double s, double length,
                                    ImplicitStep& step);

 private:
  IntegrationStatus find_explicit(const IntervalField& field, double s, double length,
                                  const double* x, ImplicitStep& step);
  IntegrationStatus correct(const IntervalField& field, double s, double length, const double* x,
                            ImplicitStep& step);

  ButcherTableau tableau_;
  int nx_, ny_;
  bool is_explicit_;
  VectorXd end_weights_, nominal_;
  VectorXd states_, shorter_states_, residual_, slope_;
  double fraction_ = 1.0;  // fraction of the step reached by continuation
};

}  // namespace saltus
