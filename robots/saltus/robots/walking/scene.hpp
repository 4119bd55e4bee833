// Scene of a biped: positions of the feet and the target of the CoM.
#pragma once

#include <string>

#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::robots::walking {

/// Stance at the start and target of the CoM.
struct SceneSettings {
  /// Point above which the centre of mass comes to rest.
  enum class Target { sole_midpoint, centroid };

  Stance stance = Stance::left;           ///< feet that carry the robot at the start
  Target target = Target::sole_midpoint;  ///< point above which the CoM comes to rest
  /// End of the name of the posture at the start, as "bent" in "left_stance_bent". Empty: the
  /// first posture with this stance.
  std::string posture{};
};
/// Deprecated name.
using Target [[deprecated("use SceneSettings::Target; removed in 0.4")]] = SceneSettings::Target;

/// Positions in the world, m.
struct Scene {
  Side side = Side::left;                 ///< side of `stance`; with two standing feet, one of them
  SoleFrame stance, swing;                ///< swing: where it stands, or will land
  FootRectangle stance_foot, swing_foot;  ///< sole rectangles
  bool two_feet = false;                  ///< true if the swing foot stands or its landing is due
  double com_height = 0.53;               ///< desired height, m
  SceneSettings::Target target =
      SceneSettings::Target::sole_midpoint;  ///< point above which the CoM comes to rest
  double yaw_momentum = 0.0;                 ///< desired angular momentum about the vertical, Nms
  StepPlan::Motion motion;  ///< planned motion of the CoM, if the step planner gives one

  /// Sole frame of the given side.
  const SoleFrame& sole(Side foot) const { return foot == side ? stance : swing; }
  /// Sole rectangle of the given side.
  const FootRectangle& rectangle(Side foot) const {
    return foot == side ? stance_foot : swing_foot;
  }
  /// Makes `foot` the stance foot.
  void stand_on(Side foot);

  /// Support polygon: hull of both feet.
  SupportPolygon hull() const;
  /// Returns the same hull in a form that control loops can use.
  SupportOfTwoFeet support() const;
  /// Polygon of the stance sole, in world axes.
  SupportPolygon stance_polygon() const;
  /// Wrenches on the feet of a body at rest with this CoM (world, m): left and right, level sole
  /// axes, N and Nm. Two feet share the weight by the law of the lever, without torques.
  Vec<double, 12> standing_wrenches(double mass, const Vec<double, 3>& com) const;
  /// Point at which the CoM comes to rest, world x and y, m.
  Vec<double, 2> target_point() const;
};

/// Scene of this posture. Its stance foot (the left one for a posture on both feet) is at the
/// origin of the world, the other one on the same level ground.
Scene scene_of(const StandingPosture& posture, const RobotDescription& robot);
/// The first posture on both feet. Throws InputError if there is none.
const StandingPosture& posture_on_both_feet(const RobotDescription& robot);

/// The posture at the start. Throws InputError if there is none.
const StandingPosture& posture_at_start(const SceneSettings& settings,
                                        const RobotDescription& robot);
/// Scene of the posture of the settings.
Scene initial_scene(const SceneSettings& settings, const RobotDescription& robot);

}  // namespace saltus::robots::walking
