#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::robots::walking {
Schedule first_contacts(const BipedSettings& settings, const Scene& scene) {
  const bool one_step = settings.step.planner == Step::Planner::formula;
  if (scene.two_feet) return two_feet_throughout(one_step ? 1 : events_ahead);
  return one_foot_then_two(infinity, scene.side, one_step ? 1 : events_ahead);
}

}  // namespace saltus::robots::walking
