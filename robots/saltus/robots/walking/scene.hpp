// What stands where, and what is aimed at.
#pragma once

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/model/support_polygon.hpp"
#include "saltus/robots/walking/step_plan.hpp"

namespace saltus::walking {

/// What the centre of mass shall come to rest above.
enum class Target { sole_midpoint, centroid };

/// Where the robot shall come to rest.
struct SceneSettings {
  Stance stance = Stance::left;           ///< on what it stands at the start
  Target target = Target::sole_midpoint;  ///< above what
};

/// Positions in the world, m.
struct Scene {
  Side side = Side::left;                 ///< of the stance foot; of two that stand, one of them
  SoleFrame stance, swing;                ///< swing: where it stands, or will land
  FootRectangle stance_foot, swing_foot;  ///< their rectangles
  bool two_feet = false;                  ///< the swing foot stands, or its landing is due
  double com_height = 0.53;               ///< commanded, m
  Target target = Target::sole_midpoint;  ///< above what the CoM shall come to rest
  PlannedMotion motion;  ///< how the CoM gets there, if the planner of steps says so

  /// By its side.
  const SoleFrame& sole(Side foot) const { return foot == side ? stance : swing; }
  /// By its side.
  const FootRectangle& rectangle(Side foot) const {
    return foot == side ? stance_foot : swing_foot;
  }
  /// The feet change their roles, if they must.
  void stand_on(Side foot);

  /// Of both feet, and of the stance foot alone.
  SupportPolygon hull() const;
  /// Of the stance sole, in world axes.
  SupportPolygon stance_polygon() const;
  /// What the feet bear of a body that stands still with its CoM (m) there: left and right, level
  /// sole axes, N and Nm; of two feet by the law of the lever, without torques.
  Vec<double, 12> standing_wrenches(double mass, const Vec<double, 3>& com) const;
  /// Where the CoM shall come to rest, world x and y, m.
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
