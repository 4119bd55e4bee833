// One run of sequential quadratic programming: from a start to where it ends.
//
// From w the solution w+ of the model gives the step d = w+ - w and the new multipliers. The step
// is judged by the l1 merit function (l1_merit.hpp), corrected to second order where the curvature
// of the rows alone makes it fail, and shortened where that does not help.
//
// Models have the exact Hessian and need not be convex: the QP solver finds a local solution by
// inertia correction (ipm_inertia.hpp) within a trust region, a box about w that follows the steps
// which were accepted, because a far solution of an indefinite model says nothing. Where no trust
// region gives a step downhill the model is convexified (convexify.hpp), and shifted further while
// that does not help. A model without a feasible point is relaxed by an l1 penalty (elastic mode),
// and where a convex model with a large penalty weight cannot reduce the violations the program is
// infeasible. Of cold starts the multipliers are estimated by least squares first.
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
#include "saltus/solver/quadratic_model.hpp"
#include "saltus/solver/sqp.hpp"

namespace saltus {

/// What depends on the patterns only, kept between runs.
struct SqpEngine {
  SqpEngine(const NonlinearProgram& program, const SqpOptions& options);
  bool fits(const NonlinearProgram& program) const;

  QuadraticModel model;
  QpOptions qp_options;
  SparsityPattern hessian_pattern;  ///< of the program
  std::unique_ptr<QpSolver> qp;
  std::vector<int> coupled;                          ///< variables that meet others in the Hessian
  std::unique_ptr<Convexification> convexification;  ///< of nonlinear programs
  std::unique_ptr<ElasticQp> elastic;                ///< once it was needed
  std::unique_ptr<BarrierEngine> barrier;            ///< once it was needed
};

class SqpRun {
 public:
  SqpRun(NonlinearProgram& program, const SqpOptions& options, Curvature curvature,
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
  QpResult solve_model(bool& is_elastic, bool last_resort, bool warm);
  QpResult solve_elastic(NlpPoint& point, bool last_resort);
  bool serves(const QpResult& r) const;
  void convexify(double shift);
  void set_trust_region(double radius);
  double length() const;
  bool is_stuck();
  double line_search(bool is_elastic, double shortest);
  bool correct_second_order(double predicted);
  double accept(const VectorXd& w, double alpha);

  NonlinearProgram& program_;
  const SqpOptions& options_;
  Curvature curvature_;
  SqpEngine& engine_;
  QuadraticModel& model_;
  WallClock::time_point begin_ = WallClock::now(), deadline_;
  const SolveObserver& observer_;
  int first_number_;  // of the iterations that it hears of
  NlpPoint point_, next_;
  L1Merit merit_;
  VectorXd rows_, trial_;
  VectorXd exact_;            // Hessian as it came
  double radius_ = infinity;  // of the trust region: largest change of a coupled variable
  KktResidual kkt_;
  double elastic_weight_ = 0.0, largest_multiplier_ = 0.0;
  int iterations_ = 0;
  double step_ = 0.0, step_length_ = 0.0, shift_ = 0.0;  // of the last step, for the observer
};

}  // namespace saltus
