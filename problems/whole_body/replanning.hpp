// Replans the motion of the whole body from the measured state.
#pragma once

#include <array>

#include "problems/whole_body/planned_motion.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"

namespace saltus::whole_body {

/// Solves the remaining problem by one real-time iteration per period. The plan decides when a
/// phase begins.
class Replanner {
 public:
  /// Plans `problem` on the given grid, every `period` (s). `plan` is a solution of the problem.
  Replanner(const OptimalControlProblem& problem, const ShootingOptions& grid, double period,
            const Trajectory& plan);

  /// The plan from the state at time t (s) on. Its first phase is phase().
  PlannedMotion plan_from(double t, const VectorXd& state);
  double period() const { return controller_.period(); }  ///< s
  /// Index of the active phase in the whole problem.
  int phase() const { return controller_.phase(); }
  /// True if the motion ends within a period after t (s).
  bool is_over(double t) const;

  /// Statistics of the solves so far.
  struct Statistics {
    LatencyHistogram processor;              ///< processor time of a solve, s
    std::array<long, provenances> counts{};  ///< solves by Provenance
  };
  const Statistics& statistics() const { return statistics_; }  ///< see Statistics

 private:
  bool is_last() const;

  ShrinkingHorizonController controller_;
  int phases_;
  double end_of_phase_;  // in the last plan, s
  Statistics statistics_;
};

}  // namespace saltus::whole_body
