// One run of sequential quadratic programming from a start to its termination.
//
// At w, the solution w+ of the model gives the step d = w+ - w and the new multipliers. The l1
// merit function (l1_merit.hpp) accepts or rejects the step. A second-order correction handles
// rejections caused by the curvature of the rows; otherwise the step is shortened.
//
// Models have the exact Hessian and need not be convex. The QP solver finds a local solution by
// inertia correction (ipm_inertia.hpp) within a trust region, a box around w whose size follows the
// accepted steps. Without it, indefinite models could have meaningless distant solutions. If no
// trust region gives a descent step, the model is convexified (convexify.hpp) and shifted further
// as needed. A model without a feasible point is relaxed by an l1 penalty (elastic mode). If a
// convex model with a large penalty weight cannot reduce the violation, the program is infeasible.
// Cold starts estimate the multipliers by least squares first.
//
// Nocedal and Wright, Numerical Optimization, 2nd ed., ch. 18; Fletcher, Practical Methods of
// Optimization, 2nd ed., sec. 14.4 (trust regions and elastic mode).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "saltus/solver/barrier_run.hpp"
#include "saltus/solver/convexify.hpp"
#include "saltus/solver/elastic_qp.hpp"
#include "saltus/solver/l1_merit.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/quadratic_model.hpp"

namespace saltus {

/// Data that depend only on the patterns and are kept between runs.
struct SqpEngine {
  SqpEngine(const NonlinearProgram& program, const NativeSolverOptions& options);
  bool fits(const NonlinearProgram& program) const;

  QuadraticModel model;
  qp::QpOptions qp_options;
  SparsityPattern hessian_pattern;  ///< pattern of the program
  std::unique_ptr<qp::QpSolver> qp;
  std::vector<int> coupled;                          ///< variables coupled to others in the Hessian
  std::unique_ptr<Convexification> convexification;  ///< used for nonlinear programs
  std::unique_ptr<ElasticQp> elastic;                ///< created when first needed
  std::unique_ptr<BarrierEngine> barrier;            ///< created when first needed
};

class SqpRun {
 public:
  SqpRun(NonlinearProgram& program, const NativeSolverOptions& options, Curvature curvature,
         SqpEngine& engine, WallClock::time_point deadline, const SolveObserver& observer,
         int first_number = 0);

  NlpResult solve(const NlpPoint& start, bool warm);

 private:
  void report() const;
  bool timed_out() const { return WallClock::now() >= deadline_; }
  SolveStatus solve_once(bool warm);
  SolveStatus iterate(bool warm);
  void estimate_multipliers();
  std::optional<SolveStatus> step(bool warm);
  qp::QpResult solve_model(bool& is_elastic, bool last_resort, bool warm);
  qp::QpResult solve_elastic(NlpPoint& point, bool last_resort);
  bool serves(const qp::QpResult& r) const;
  void convexify(double shift);
  void set_trust_region(double radius);
  double length() const;
  bool is_stuck();
  double line_search(bool is_elastic, double shortest);
  bool correct_second_order(double predicted);
  double accept(const VectorXd& w, double alpha);

  NonlinearProgram& program_;
  const NativeSolverOptions& options_;
  Curvature curvature_;
  SqpEngine& engine_;
  QuadraticModel& model_;
  WallClock::time_point begin_ = WallClock::now(), deadline_;
  const SolveObserver& observer_;
  int first_number_;  // number of the first iteration that it reports
  NlpPoint point_, next_;
  L1Merit merit_;
  VectorXd rows_, trial_;
  VectorXd exact_;            // Hessian before convexification
  double radius_ = infinity;  // trust region: largest change of a coupled variable
  KktCheck::Residual kkt_;
  double elastic_weight_ = 0.0, largest_multiplier_ = 0.0;
  int iterations_ = 0;
  double step_ = 0.0, step_length_ = 0.0, shift_ = 0.0;  // last step, for the observer
};

}  // namespace saltus
