// The flow of one mode by any one-step scheme on the fixed grid of the interval.
//
// Dense output restarts the scheme with a part of the step: y(s) = Phi(y_n, s_n, L), L = s - s_n.
// It is as accurate as the step, and its derivatives are exact. After an event, s_n and L vary with
// w.
#pragma once

#include <vector>

#include "saltus/integrators/hybrid_stepper.hpp"

namespace saltus {

class RestartedStepper : public FlowStepper {
 public:
  void load(const double*) final {}
  IntegrationStatus begin(const IntervalField& field, double s, const double* y,
                          const RowMajorMatrix* sensitivity, const double* start_slope) final;
  IntegrationStatus step() final;
  double step_start() const final { return start_; }
  double step_end() const final { return reached_; }
  /// NaN if the scheme fails.
  void state_at(double s, double* y) final;
  IntegrationStatus sensitivity_at(double s, RowMajorMatrix& sensitivity, double* slope) final {
    return propagate(s, sensitivity, slope);
  }
  int parts_per_step() const final { return 4; }
  bool restarts_freely() const final { return true; }

 protected:
  RestartedStepper(int steps, int nx, int ny, int directions);

  /// Computes y at s by a step of length s - start_. step() checks that it is finite.
  virtual IntegrationStatus advance(double s, double* y) = 0;
  /// Computes the derivative of y(s) at fixed s, and dy/ds unless `slope` is null. Returns
  /// not_finite if a value is not finite.
  virtual IntegrationStatus propagate(double s, RowMajorMatrix& sensitivity, double* slope) = 0;

  const int nx_, ny_, nd_;  // states, outputs, directions
  const IntervalField* field_ = nullptr;
  double start_ = 0.0;               // start of the last step
  std::vector<double> y_;            // y at start_
  RowMajorMatrix sensitivity_;       // sensitivity at start_
  std::vector<double> start_slope_;  // derivative of start_
  bool moving_ = false;              // start_slope_ is non-zero

 private:
  int steps_;
  double reached_ = 0.0;
  bool with_sensitivity_ = false;
  std::vector<double> end_;
  RowMajorMatrix next_sensitivity_;
};

}  // namespace saltus
