// The motion of a plan between its nodes: cubic polynomials with continuous velocity.
#pragma once

#include <vector>

#include "problems/whole_body/problem.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus::whole_body {

/// States of a plan at all times. A periodic plan repeats itself, each time `stride` further.
class PlannedMotion {
 public:
  /// Tells how the motion starts.
  enum class Start {
    at_rest,   ///< the motion begins at rest, or at the end of a period
    in_motion  ///< the plan begins in the middle of a motion
  };

  PlannedMotion() = default;
  /// `stride` in m.
  explicit PlannedMotion(Trajectory plan, Start start = Start::at_rest, bool periodic = false,
                         double stride = 0.0);

  double begin() const { return times_.front(); }    ///< s
  double end() const { return times_.back(); }       ///< s
  double length() const { return end() - begin(); }  ///< s
  const Trajectory& plan() const { return plan_; }   ///< the plan itself
  int periods(double t) const;                       ///< complete periods before t (s)
  double in_plan(double t) const;                    ///< t (s) in the first period
  /// State at t (s). Before and after a plan that is not periodic it does not change, but before a
  /// plan that begins in motion it follows the first rate.
  VectorXd state(double t) const;
  /// Its rate, 1/s.
  VectorXd rate(double t) const;
  /// Input at t (s), of the last interval after the end.
  VectorXd input(double t) const;
  /// Index of the phase of the plan at t (s).
  int phase(double t) const;

 private:
  VectorXd moved(VectorXd x, int periods) const;
  VectorXd slope(std::size_t i) const;
  VectorXd at(double t, int derivative) const;

  Trajectory plan_;
  Start start_ = Start::at_rest;
  bool periodic_ = false;
  double stride_ = 0.0;
  std::vector<double> times_;
  std::vector<VectorXd> states_, slopes_;
};

}  // namespace saltus::whole_body
