#include "saltus/robots/whole_body/measured_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus {
MeasuredPlant::MeasuredPlant(std::unique_ptr<Plant> plant, const MeasurementNoise& noise, int delay)
    : PlantAround(std::move(plant)), noise_(noise), random_(static_cast<unsigned>(noise.seed)) {
  for (const auto& [name, deviation] :
       {std::pair{"position", noise.position}, std::pair{"angle", noise.angle},
        std::pair{"velocity", noise.velocity},
        std::pair{"angular_velocity", noise.angular_velocity}, std::pair{"force", noise.force}})
    if (!(deviation >= 0.0) || !std::isfinite(deviation))
      throw DefinitionError(
          fmt::format("the measurement noise of \"{}\" is {}, expected a finite standard deviation "
                      "of at least 0",
                      name, deviation));
  if (delay < 0)
    throw DefinitionError(
        fmt::format("the delay of the torques is {} control ticks, expected at least 0", delay));
  waiting_.resize(static_cast<std::size_t>(delay), VectorXd::Zero(plant_->state().q.size()));
  measure();
}

void MeasuredPlant::reset(const WholeBodyState& state) {
  plant_->reset(state);
  random_.seed(static_cast<unsigned>(noise_.seed));
  normal_.reset();
  is_first_ = true;
  next_ = 0;
  measure();
}

void MeasuredPlant::set_torques(const VectorXd& torques) {
  if (waiting_.empty()) return plant_->set_torques(torques);
  if (is_first_) std::fill(waiting_.begin(), waiting_.end(), torques);
  is_first_ = false;
  plant_->set_torques(waiting_[next_]);
  waiting_[next_] = torques;
  next_ = (next_ + 1) % waiting_.size();
}

void MeasuredPlant::step() {
  plant_->step();
  measure();
}

double MeasuredPlant::draw(double deviation) { return deviation * normal_(random_); }

// Draws the same number of times whatever the deviations: each quantity keeps its noise when the
// others change.
void MeasuredPlant::measure() {
  state_ = plant_->state();
  contacts_[0] = plant_->contact(Side::left);
  contacts_[1] = plant_->contact(Side::right);
  if (noise_.is_zero()) return;
  Vec<double, 3> turn;
  for (int i = 0; i < 3; ++i) {
    state_.base.translation()[i] += draw(noise_.position);
    turn[i] = draw(noise_.angle);
    state_.base_twist[i] += draw(noise_.angular_velocity);
    state_.base_twist[3 + i] += draw(noise_.velocity);
  }
  state_.base.linear() = rotation_of_vector(turn) * state_.base.linear();
  for (double& q : state_.q) q += draw(noise_.angle);
  for (double& dq : state_.dq) dq += draw(noise_.angular_velocity);
  for (FootContact& contact : contacts_)
    for (double& w : contact.wrench) w *= 1.0 + draw(noise_.force);
}

}  // namespace saltus
