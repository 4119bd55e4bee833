#include "saltus/robots/walking/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::robots::walking {

void Scene::stand_on(Side foot) {
  if (foot == side) return;
  side = foot;
  std::swap(stance, swing);
  std::swap(stance_foot, swing_foot);
}

SupportPolygon Scene::hull() const {
  return SupportPolygon::under({{stance, stance_foot}, {swing, swing_foot}});
}

SupportOfTwoFeet Scene::support() const { return {{stance, stance_foot}, {swing, swing_foot}}; }

SupportPolygon Scene::stance_polygon() const {
  return SupportPolygon::under({{stance, stance_foot}});
}

Vec<double, 12> Scene::standing_wrenches(double mass, const Vec<double, 3>& com) const {
  const double weight = mass * standard_gravity;
  const Vec<double, 2> stride = (swing.position - stance.position).head<2>();
  const double along = stride.dot((com - stance.position).head<2>()) / stride.squaredNorm();
  const double share = two_feet ? std::clamp(along, 0.0, 1.0) : 0.0;  // share of the swing foot
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();
  wrenches[side == Side::left ? 2 : 8] = (1.0 - share) * weight;
  wrenches[side == Side::left ? 8 : 2] = share * weight;
  return wrenches;
}

Vec<double, 2> Scene::target_point() const {
  if (!two_feet) return stance.position.head<2>();
  if (target == SceneSettings::Target::centroid)
    if (const SupportOfTwoFeet feet = support(); feet.is_valid()) return feet.centroid();
  return 0.5 * (stance.position + swing.position).head<2>();
}

Scene scene_of(const StandingPosture& posture, const RobotDescription& robot) {
  Scene scene;
  scene.side = posture.side();
  scene.stance_foot = robot.foot(scene.side);
  scene.swing_foot = robot.foot(other(scene.side));
  scene.swing.position = posture.other_foot;
  scene.swing.position[2] = 0.0;  // the ground is level
  scene.two_feet = posture.stance == Stance::both;
  scene.com_height = posture.com[2];
  return scene;
}

const StandingPosture& posture_on_both_feet(const RobotDescription& robot) {
  for (const StandingPosture& posture : robot.postures)
    if (posture.stance == Stance::both) return posture;
  throw InputError(fmt::format("{}: {} has no posture on both feet", robot.file, robot.name));
}

const StandingPosture& posture_at_start(const SceneSettings& settings,
                                        const RobotDescription& robot) {
  if (!settings.posture.empty()) {
    std::string known;
    for (const StandingPosture& posture : robot.postures) {
      if (posture.stance != settings.stance) continue;
      if (posture.name.ends_with("_" + settings.posture)) return posture;
      known += (known.empty() ? "" : ", ") + posture.name;
    }
    throw InputError(fmt::format(
        "posture: no posture of {} with this stance has a name that ends with \"_{}\"; add one, or "
        "use the end of {}",
        robot.file, printable(shortened(settings.posture)), known.empty() ? "another one" : known));
  }
  if (settings.stance == Stance::both) return posture_on_both_feet(robot);
  return robot.posture_on(settings.stance == Stance::left ? Side::left : Side::right);
}

Scene initial_scene(const SceneSettings& settings, const RobotDescription& robot) {
  Scene scene = scene_of(posture_at_start(settings, robot), robot);
  scene.target = settings.target;
  return scene;
}

}  // namespace saltus::robots::walking
