// The flow of one mode by a one-step scheme on the fixed grid of the interval, whatever the scheme.
//
// Dense output is the scheme itself, restarted with a part of the step: y(s) = Phi(y_n, s_n, L),
// L = s - s_n, as accurate as the step and exact to differentiate. Behind an event s_n moves with
// w, and so does L.
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
  /// NaN where the scheme fails.
  void state_at(double s, double* y) final;
  IntegrationStatus sensitivity_at(double s, RowMajorMatrix& sensitivity, double* slope) final {
    return propagate(s, sensitivity, slope);
  }
  int parts_per_step() const final { return 4; }
  bool restarts_freely() const final { return true; }

 protected:
  RestartedStepper(int steps, int nx, int ny, int directions);

  /// y at s, by a step of the length s - start_; whether that is finite is looked at by step().
  virtual IntegrationStatus advance(double s, double* y) = 0;
  /// The derivative of y(s) at fixed s, and with `slope` also dy/ds; not_finite if it is not.
  virtual IntegrationStatus propagate(double s, RowMajorMatrix& sensitivity, double* slope) = 0;

  const int nx_, ny_, nd_;  // states, outputs, directions
  const IntervalField* field_ = nullptr;
  double start_ = 0.0;               // of the last step
  std::vector<double> y_;            // there
  RowMajorMatrix sensitivity_;       // there
  std::vector<double> start_slope_;  // of start_
  bool moving_ = false;              // start_slope_ is not zero

 private:
  int steps_;
  double reached_ = 0.0;
  bool with_sensitivity_ = false;
  std::vector<double> end_;
  RowMajorMatrix next_sensitivity_;
};

}  // namespace saltus
