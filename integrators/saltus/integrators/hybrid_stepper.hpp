// What hybrid integration needs from a scheme: one step at a time along one field, the state
// anywhere inside that step, and sensitivities there.
#pragma once

#include <cmath>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// The next point of a grid of equal steps over [0, 1] that is not s.
inline double next_grid_point(double s, int steps) {
  constexpr double same = 1e-12;  // rounding of sums of steps
  const double n = std::floor(s * steps + same) + 1.0;
  return n >= steps ? 1.0 : n / steps;
}

/// A flow in scaled time s in [0, 1] that can be begun anywhere. Owns its work space.
class FlowStepper {
 public:
  virtual ~FlowStepper() = default;

  /// Before the first begin() of every interval; `w` is its argument.
  virtual void load(const double* w) = 0;

  /// Begins at s with y = (x | q) along `field`, which must outlive the flow. For sensitivities,
  /// `sensitivity` (outputs x directions) is the total derivative of y and `start_slope`
  /// (directions) that of s: the flow begins at an event whose time moves. Null: states only.
  virtual IntegrationStatus begin(const IntervalField& field, double s, const double* y,
                                  const RowMajorMatrix* sensitivity, const double* start_slope) = 0;

  /// One more step, never beyond 1.
  virtual IntegrationStatus step() = 0;
  virtual double step_start() const = 0;
  virtual double step_end() const = 0;

  /// y at s inside the last step.
  virtual void state_at(double s, double* y) = 0;
  /// The derivative of y(s) at fixed s, and dy/ds of the numerical solution.
  virtual IntegrationStatus sensitivity_at(double s, RowMajorMatrix& sensitivity,
                                           double* slope) = 0;

  /// In how many parts of a step guards are looked at.
  virtual int parts_per_step() const = 0;
  /// Whether beginning anew between two steps costs nothing (one-step schemes).
  virtual bool restarts_freely() const = 0;
};

}  // namespace saltus
