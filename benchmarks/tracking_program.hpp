// A nonlinear tracking problem as quadratic programs, linearised about plans.
#pragma once

#include <memory>

#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// min sum_k 1/2 |x_k - reference_k|_Q^2 + 1/2 |u_k|_R^2 subject to x_(k+1) = RK4(x_k, u_k), with
/// diagonal Q and R and bounds of states (k > 0) and inputs. Empty bounds: none.
struct Tracking {
  int nx = 0, nu = 0, intervals = 0, substeps = 1;
  double sample = 0.0;  ///< s
  Function dynamics;    ///< function of (t | x | u)
  VectorXd state_weight = {}, input_weight = {};
  VectorXd state_lower = {}, state_upper = {}, input_lower = {}, input_upper = {};
};

class TrackingProgram {
 public:
  explicit TrackingProgram(Tracking tracking);

  const qp::StageQp& qp() const { return qp_; }
  void start_at(const VectorXd& state) { qp_.start = state; }
  void follow(int stage, const VectorXd& reference);
  /// All stages at their references, inputs zero.
  qp::StagePoint reference_point() const;
  /// Writes the dynamics linearised at the point into qp(), which has absolute variables: its KKT
  /// residual at that point is that of the nonlinear program.
  void linearise(const qp::StagePoint& about);
  /// State of the model one sample later.
  VectorXd next(const VectorXd& state, const VectorXd& input);

 private:
  void integrate(const VectorXd& state, const VectorXd& input);

  Tracking tracking_;
  qp::StageQp qp_;
  std::unique_ptr<Integrator> integrator_;
  VectorXd argument_, end_;
  MatrixXd derivative_;
};

}  // namespace saltus::bench
