// A plain Gauss-Newton SQP for the hanging chain: linearise every stage, solve, take the full step.
#pragma once

#include <memory>
#include <vector>

#include "benchmarks/hanging_chain.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/qp/stage_qp_solver.hpp"

namespace saltus::bench {

/// min sum_k 1/2 |x_k - reference|_Q^2 + 1/2 |u_k|_R^2, Q = 2 I with 4 for the end's position,
/// R = 0.02 I; |u| <= 1; x_(k+1) = RK4(x_k, u_k).
class ChainProgram {
 public:
  explicit ChainProgram(const ChainData& data);

  const StageQp& qp() const { return qp_; }
  /// All stages at the reference, the robot at rest.
  StagePoint reference_point() const;
  /// Puts the dynamics about the point into qp(), which is in absolute variables: its KKT residual
  /// at that point is the one of the nonlinear program.
  void linearise(const StagePoint& about);

 private:
  ChainData data_;
  StageQp qp_;
  std::unique_ptr<Integrator> integrator_;
  VectorXd argument_, end_;
  MatrixXd derivative_;
};

/// One solution of the nonlinear program from the reference.
struct ChainSolve {
  struct Step {
    double linearisation = 0.0, qp = 0.0;  ///< microseconds
    QpResult result;
    double qp_residual = 0.0;  ///< of the QP's solution, recomputed
  };
  std::vector<Step> steps;
  double last_linearisation = 0.0;  ///< the one that finds the optimum reached
  double residual = 0.0;            ///< of the nonlinear program
};
ChainSolve solve_chain(ChainProgram& program, StageQpSolver& solver);

}  // namespace saltus::bench
