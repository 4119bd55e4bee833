#include "saltus/integrators/restarted_stepper.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace saltus {

RestartedStepper::RestartedStepper(int steps, int nx, int ny, int directions)
    : nx_(nx),
      ny_(ny),
      nd_(directions),
      y_(ny),
      sensitivity_(ny, directions),
      start_slope_(directions),
      steps_(steps),
      end_(ny),
      next_sensitivity_(ny, directions) {}

IntegrationStatus RestartedStepper::begin(const IntervalField& field, double s, const double* y,
                                          const RowMajorMatrix* sensitivity,
                                          const double* start_slope) {
  field_ = &field;
  start_ = reached_ = s;
  std::copy_n(y, ny_, y_.begin());
  end_ = y_;
  with_sensitivity_ = sensitivity != nullptr;
  if (!with_sensitivity_) return IntegrationStatus::success;
  sensitivity_ = *sensitivity;
  std::copy_n(start_slope, nd_, start_slope_.begin());
  moving_ = std::any_of(start_slope_.begin(), start_slope_.end(), [](double v) { return v != 0; });
  return IntegrationStatus::success;
}

IntegrationStatus RestartedStepper::step() {
  if (reached_ > start_) {
    if (with_sensitivity_) {
      const IntegrationStatus status = propagate(reached_, next_sensitivity_, nullptr);
      if (status != IntegrationStatus::success) return status;
      std::swap(sensitivity_, next_sensitivity_);
      std::fill(start_slope_.begin(), start_slope_.end(), 0.0);
      moving_ = false;
    }
    y_ = end_;
    start_ = reached_;
  }
  reached_ = next_grid_point(start_, steps_);
  const IntegrationStatus status = advance(reached_, end_.data());
  if (status != IntegrationStatus::success) return status;
  return all_finite(end_.data(), ny_) ? IntegrationStatus::success : IntegrationStatus::not_finite;
}

void RestartedStepper::state_at(double s, double* y) {
  if (advance(s, y) != IntegrationStatus::success)
    std::fill_n(y, ny_, std::numeric_limits<double>::quiet_NaN());
}

}  // namespace saltus
