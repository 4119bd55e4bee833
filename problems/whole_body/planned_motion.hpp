// Interpolates a plan between its nodes by cubic polynomials with continuous velocity.
#pragma once

#include <vector>

#include "problems/whole_body/problem.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus::whole_body {

/// States of a plan at any time. A periodic plan repeats itself, shifted by `stride` each time.
class PlannedMotion {
 public:
  /// Velocity at the start of the plan.
  enum class Start {
    at_rest,   ///< the motion begins at rest, or at the end of a period
    in_motion  ///< the plan begins in the middle of a motion
  };

  PlannedMotion() = default;
  /// `stride`: distance between two periods, m.
  explicit PlannedMotion(Trajectory plan, Start start = Start::at_rest, bool periodic = false,
                         double stride = 0.0);

  double begin() const { return times_.front(); }    ///< s
  double end() const { return times_.back(); }       ///< s
  double length() const { return end() - begin(); }  ///< s
  const Trajectory& plan() const { return plan_; }   ///< the plan itself
  int periods(double t) const;                       ///< complete periods before t (s)
  double in_plan(double t) const;                    ///< t (s) in the first period
  /// State at t (s). Constant before and after a plan that is not periodic. Before a plan that
  /// begins in motion it is extrapolated with the first rate.
  VectorXd state(double t) const;
  /// Time derivative of the state, 1/s.
  VectorXd rate(double t) const;
  /// Input at t (s). After the end it is that of the last interval.
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
