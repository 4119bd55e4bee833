// Options of the whole-body controllers, and a factory for the chosen one.
#pragma once

#include "saltus/robots/whole_body/inverse_dynamics_controller.hpp"
#include "saltus/robots/whole_body/momentum_controller.hpp"

namespace saltus {

/// Method of the whole-body controller.
enum class WholeBodyChoice { inverse_dynamics, momentum };

/// Method, period and options of the whole-body controller.
struct WholeBodyControl {
  double period = 0.002;                                       ///< control period, s
  WholeBodyChoice choice = WholeBodyChoice::inverse_dynamics;  ///< method
  WholeBodyWeights inverse_dynamics;                           ///< weights of inverse dynamics
  WholeBodyGains gains;                                        ///< gains of inverse dynamics
  MomentumOptions momentum;                                    ///< options of momentum control
  bool joint_speed_limits = false;  ///< limit joint speeds; not available with momentum control
  bool self_collision = false;      ///< keep limbs apart and let them collide; not available with
                                    ///< momentum control
};

/// Creates the chosen controller for this robot and these soles.
std::unique_ptr<WholeBodyController> make_whole_body_controller(const FloatingRobot& robot,
                                                                const ContactConeOptions& left,
                                                                const ContactConeOptions& right,
                                                                const WholeBodyControl& control);

}  // namespace saltus
