#include "saltus/robots/whole_body/measurement_noise.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/rotation_vector.hpp"

namespace saltus::robots {

NoiseSource::NoiseSource(const MeasurementNoise& noise)
    : noise_(noise), random_(static_cast<unsigned>(noise.seed)) {
  for (const auto& [name, deviation] :
       {std::pair{"position", noise.position}, std::pair{"angle", noise.angle},
        std::pair{"velocity", noise.velocity},
        std::pair{"angular_velocity", noise.angular_velocity}, std::pair{"force", noise.force}})
    if (!(deviation >= 0.0) || !std::isfinite(deviation))
      throw DefinitionError(
          fmt::format("the measurement noise of \"{}\" is {}, expected a finite standard deviation "
                      "of at least 0",
                      name, deviation));
}

void NoiseSource::reset() {
  random_.seed(static_cast<unsigned>(noise_.seed));
  normal_.reset();
}

// The number of draws does not depend on the deviations, so each quantity keeps its noise when the
// others change.
void NoiseSource::disturb(WholeBodyEstimate& measured) {
  if (noise_.is_zero()) return;
  WholeBodyState& state = measured.state;
  Vec<double, 3> turn;
  for (int i = 0; i < 3; ++i) {
    state.base.translation()[i] += draw(noise_.position);
    turn[i] = draw(noise_.angle);
    state.base_twist[i] += draw(noise_.angular_velocity);
    state.base_twist[3 + i] += draw(noise_.velocity);
  }
  state.base.linear() = exp_so3(turn) * state.base.linear();
  for (double& q : state.q) q += draw(noise_.angle);
  for (double& dq : state.dq) dq += draw(noise_.angular_velocity);
  for (WholeBodyEstimate::Contact* contact : {&measured.left, &measured.right})
    for (double& w : contact->wrench) w *= 1.0 + draw(noise_.force);
}

}  // namespace saltus::robots
