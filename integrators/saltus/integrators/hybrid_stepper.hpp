// Interface of schemes for hybrid integration: single steps along one field, with states and
// sensitivities at any point inside the step.
#pragma once

#include <cmath>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// The next point after s of a grid of equal steps over [0, 1].
inline double next_grid_point(double s, int steps) {
  constexpr double same = 1e-12;  // rounding of accumulated steps
  const double n = std::floor(s * steps + same) + 1.0;
  return n >= steps ? 1.0 : n / steps;
}

/// A flow in scaled time s in [0, 1] that can start at any s. Owns its workspace.
class FlowStepper {
 public:
  virtual ~FlowStepper() = default;

  /// Loads the argument `w` of an interval. Call it before the first begin() of the interval.
  virtual void load(const double* w) = 0;

  /// Starts at s with y = (x | q) along `field`, which must outlive the flow. For sensitivities,
  /// `sensitivity` (outputs x directions) is the total derivative of y and `start_slope`
  /// (directions) that of s, which is non-zero after an event. Null: states only.
  virtual IntegrationStatus begin(const IntervalField& field, double s, const double* y,
                                  const RowMajorMatrix* sensitivity, const double* start_slope) = 0;

  /// Takes one step, not beyond s = 1.
  virtual IntegrationStatus step() = 0;
  virtual double step_start() const = 0;
  virtual double step_end() const = 0;

  /// y at s inside the last step.
  virtual void state_at(double s, double* y) = 0;
  /// The derivative of y(s) at fixed s, and dy/ds of the numerical solution.
  virtual IntegrationStatus sensitivity_at(double s, RowMajorMatrix& sensitivity,
                                           double* slope) = 0;

  /// Number of parts of a step at whose ends guards are sampled.
  virtual int parts_per_step() const = 0;
  /// True if a restart between two steps costs nothing (one-step schemes).
  virtual bool restarts_freely() const = 0;
};

}  // namespace saltus
