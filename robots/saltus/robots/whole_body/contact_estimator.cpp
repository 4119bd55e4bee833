#include "saltus/robots/whole_body/contact_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace saltus::robots {

void ContactEstimator::expect(double earliest, double landing, double height) {
  earliest_ = earliest;
  landing_ = landing;
  height_ = height;
}

void ContactEstimator::update(const Evidence& now) {
  const double dt = now.time - time_;
  time_ = now.time;
  if (now.time < earliest_) {
    log_odds_ = -infinity;
    unlikely_ = 0.0;
    return;
  }
  log_odds_ = (now.force / options_.force - 1.0) / options_.force_unit;
  if (!options_.is_estimated) return;
  const auto doubt = [this](double excess, double unit) {
    return std::clamp(excess / unit, 0.0, options_.most_doubt);
  };
  log_odds_ -= doubt(now.height - height_, options_.height_unit) +
               doubt(landing_ - now.time, options_.time_unit) +
               doubt(now.speed - options_.speed, options_.speed_unit);
  unlikely_ = probability() < options_.lost ? unlikely_ + dt : 0.0;
}

double ContactEstimator::probability() const { return 1.0 / (1.0 + std::exp(-log_odds_)); }

}  // namespace saltus::robots
