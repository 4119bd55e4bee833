#include "problems/whole_body/planned_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus::whole_body {

PlannedMotion::PlannedMotion(Trajectory plan, Start start, bool periodic, double stride)
    : plan_(std::move(plan)), start_(start), periodic_(periodic), stride_(stride) {
  for (const Trajectory::Piece& piece : plan_.pieces()) {
    times_.push_back(piece.start);
    states_.push_back(piece.state);
  }
  times_.push_back(plan_.end_time());
  states_.push_back(plan_.final_state());
  for (std::size_t i = 0; i < times_.size(); ++i) slopes_.push_back(slope(i));
}

int PlannedMotion::periods(double t) const {
  return periodic_ ? static_cast<int>(std::floor((t - begin()) / length())) : 0;
}

double PlannedMotion::in_plan(double t) const {
  return periodic_ ? std::clamp(t - periods(t) * length(), begin(), end()) : t;
}

VectorXd PlannedMotion::state(double t) const { return moved(at(in_plan(t), 0), periods(t)); }

VectorXd PlannedMotion::rate(double t) const { return at(in_plan(t), 1); }

VectorXd PlannedMotion::input(double t) const {
  return plan_.input(std::clamp(in_plan(t), begin(), end() - 1e-9));
}

int PlannedMotion::phase(double t) const {
  const double now = in_plan(t);
  return now >= end() ? static_cast<int>(plan_.phases().size()) - 1
                      : plan_.piece_at(std::max(now, begin())).phase;
}

VectorXd PlannedMotion::moved(VectorXd x, int periods) const {
  x[0] += periods * stride_;
  if (periods != 0) x[x.size() - coordinates] += periods * stride_;  // of the base
  return x;
}

VectorXd PlannedMotion::slope(std::size_t i) const {
  const std::size_t last = times_.size() - 1;
  if (i > 0 && i < last) return (states_[i + 1] - states_[i - 1]) / (times_[i + 1] - times_[i - 1]);
  if (i == 0 && start_ == Start::in_motion)
    return (states_[1] - states_[0]) / (times_[1] - times_[0]);
  if (!periodic_) return VectorXd::Zero(states_[i].size());
  return (moved(states_[1], 1) - states_[last - 1]) /
         (times_[1] - times_[0] + times_[last] - times_[last - 1]);
}

VectorXd PlannedMotion::at(double t, int derivative) const {
  if (!periodic_ && (t <= begin() || t >= end())) {
    const bool before = t <= begin();
    const VectorXd& x = before ? states_.front() : states_.back();
    const VectorXd& dx = before ? slopes_.front() : slopes_.back();
    if (derivative == 1) return dx;
    return before ? (x + (t - begin()) * dx).eval() : x;
  }
  const auto i =
      std::min(static_cast<std::size_t>(std::ranges::upper_bound(times_, t) - times_.begin()) - 1,
               times_.size() - 2);
  const double h = times_[i + 1] - times_[i], s = (t - times_[i]) / h;
  const VectorXd &a = states_[i], &b = states_[i + 1], &da = slopes_[i], &db = slopes_[i + 1];
  if (derivative == 0)
    return (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s) * a + s * s * (3.0 - 2.0 * s) * b +
           h * s * (1.0 - s) * ((1.0 - s) * da - s * db);
  return 6.0 * s * (1.0 - s) / h * (b - a) + (1.0 - s) * (1.0 - 3.0 * s) * da +
         s * (3.0 * s - 2.0) * db;
}

}  // namespace saltus::whole_body
