#include "saltus/robots/walking/scene.hpp"

#include <fmt/format.h>

#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"

namespace saltus::walking {

SupportPolygon Scene::hull() const {
  return SupportPolygon::under({{stance, stance_foot}, {swing, swing_foot}});
}

SupportPolygon Scene::stance_polygon() const {
  return SupportPolygon::under({{stance, stance_foot}});
}

Vec<double, 2> Scene::target_point() const {
  if (!two_feet) return stance.position.head<2>();
  if (target == Target::centroid) return hull().centroid();
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

Scene initial_scene(const SceneSettings& settings, const RobotDescription& robot) {
  Scene scene = scene_of(robot.posture_on(settings.stance), robot);
  scene.target = settings.target;
  return scene;
}

Vec<double, 12> reordered(Side stance, const Vec<double, 12>& wrenches) {
  if (stance == Side::left) return wrenches;
  Vec<double, 12> result;
  result << wrenches.tail<6>(), wrenches.head<6>();
  return result;
}

void declare_stance(Settings& s, SceneSettings& scene) {
  s.choice<Side>("stance", scene.stance, {{"left", Side::left}, {"right", Side::right}},
                 "the foot that it stands on; the other one steps");
}

void declare_target(Settings& s, SceneSettings& scene) {
  s.choice<Target>("target", scene.target,
                   {{"sole_midpoint", Target::sole_midpoint}, {"centroid", Target::centroid}},
                   "where the CoM shall come to rest after the step");
}

}  // namespace saltus::walking
