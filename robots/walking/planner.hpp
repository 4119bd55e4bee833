// The controllers of the example behind one interface: from the measured state to wrenches.
#pragma once

#include <cmath>
#include <memory>

#include "problems/push_recovery/config.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/robot_description.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::push_recovery {

/// omega of the pendulum (1/s) at a height that was measured (m), whatever it is: never below 1 cm.
inline double frequency_of_height(double height) {
  return pendulum_frequency(std::fmax(height, 0.01));
}

/// What a controller knows about a tick.
struct Measurement {
  double time = 0.0;  ///< s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();
  Vec<double, 12> applied =
      Vec<double, 12>::Zero();  ///< wrenches applied last, sole axes, stance then swing
  Vec<double, 3> contact_force = Vec<double, 3>::Zero();  ///< their sum, world axes, N
};

/// The scene: what stands where, and what is aimed at.
struct Scene {
  Side side = Side::left;   ///< of the stance foot
  SoleFrame stance, swing;  ///< swing: where it stands, or will land
  FootRectangle stance_foot, swing_foot;
  bool two_feet = false;     ///< the swing foot stands or is about to
  double com_height = 0.53;  ///< commanded, m
  Target target = Target::sole_midpoint;

  SupportPolygon hull() const;
  Vec<double, 2> target_point() const;
};

/// A pair of wrenches from the order (stance, swing) into (left, right), or back.
Vec<double, 12> reordered(Side stance, const Vec<double, 12>& wrenches);

class Planner {
 public:
  virtual ~Planner() = default;
  /// `impact_time`: absolute time of the landing, infinite if none is due.
  /// The result, wrenches of stance and swing foot, lasts until the next tick.
  virtual const ControlTick& tick(const Measurement& measured, const Scene& scene,
                                  double impact_time) = 0;
  virtual RecedingHorizonController& controller() = 0;
};

/// What the settings ask for, for the programs of this transcription.
std::unique_ptr<RealTimeSolver> make_tick_solver(const Config& config, MultipleShooting& shooting);
ControllerOptions controller_options(const Config& config, const RobotDescription& robot);

/// The receding horizon controller of the paper.
std::unique_ptr<Planner> make_mpc(const Config& config, const RobotDescription& robot,
                                  const Scene& scene);

}  // namespace saltus::push_recovery
