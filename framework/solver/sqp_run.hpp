// One run of sequential quadratic programming: from a start to where it ends.
#pragma once

#include <memory>
#include <optional>
#include <vector>

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
};

class SqpRun {
 public:
  SqpRun(NonlinearProgram& program, const SqpOptions& options, Curvature curvature,
         SqpEngine& engine, WallClock::time_point deadline);

  NlpResult solve(const NlpPoint& start, bool warm);

 private:
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
  NlpPoint point_, next_;
  L1Merit merit_;
  VectorXd rows_, trial_;
  VectorXd exact_;            // Hessian as it came
  double radius_ = infinity;  // of the trust region: largest change of a coupled variable
  KktResidual kkt_;
  double elastic_weight_ = 0.0, largest_multiplier_ = 0.0;
  int iterations_ = 0;
};

}  // namespace saltus
