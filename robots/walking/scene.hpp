// What stands where, and what is aimed at.
#pragma once

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/support_polygon.hpp"
#include "saltus/robots/walking/step_plan.hpp"

namespace saltus {
class Settings;
}

namespace saltus::walking {

enum class Target { sole_midpoint, centroid };

struct SceneSettings {
  Stance stance = Stance::left;  ///< on what it stands at the start
  Target target = Target::sole_midpoint;
};

/// Declare the keys `stance` and `target`.
void declare_stance(Settings& settings, SceneSettings& scene);
void declare_target(Settings& settings, SceneSettings& scene);

/// Positions in the world, m.
struct Scene {
  Side side = Side::left;   ///< of the stance foot; of two that stand, one of them
  SoleFrame stance, swing;  ///< swing: where it stands, or will land
  FootRectangle stance_foot, swing_foot;
  bool two_feet = false;     ///< the swing foot stands, or its landing is due
  double com_height = 0.53;  ///< commanded, m
  Target target = Target::sole_midpoint;
  PlannedMotion motion;  ///< how the CoM gets there, if the planner of steps says so

  const SoleFrame& sole(Side foot) const { return foot == side ? stance : swing; }
  const FootRectangle& rectangle(Side foot) const {
    return foot == side ? stance_foot : swing_foot;
  }
  /// The feet change their roles, if they must.
  void stand_on(Side foot);

  /// Of both feet, and of the stance foot alone.
  SupportPolygon hull() const;
  SupportPolygon stance_polygon() const;
  Vec<double, 2> target_point() const;
};

/// In this posture, its stance foot (of both: the left one) at the origin of the world, the other
/// one on the same level ground.
Scene scene_of(const StandingPosture& posture, const RobotDescription& robot);
/// The first that stands on both feet. Throws InputError if there is none.
const StandingPosture& posture_on_both_feet(const RobotDescription& robot);

/// The posture on what the robot starts on. Throws InputError if it has none.
const StandingPosture& posture_on(Stance stance, const RobotDescription& robot);
/// In that posture.
Scene initial_scene(const SceneSettings& settings, const RobotDescription& robot);

}  // namespace saltus::walking
