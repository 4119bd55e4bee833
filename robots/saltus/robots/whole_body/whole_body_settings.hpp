// Options of the whole-body controller, and the controller that they choose.
#pragma once

#include "saltus/robots/whole_body/inverse_dynamics_controller.hpp"
#include "saltus/robots/whole_body/momentum_controller.hpp"

namespace saltus {

/// Which controller of the whole body.
enum class WholeBodyChoice { inverse_dynamics, momentum };

/// Which controller of the whole body, how often, with which weights.
struct WholeBodyControl {
  double period = 0.002;                                       ///< s
  WholeBodyChoice choice = WholeBodyChoice::inverse_dynamics;  ///< which one
  WholeBodyWeights inverse_dynamics;                           ///< its weights
  WholeBodyGains gains;                                        ///< of the same
  MomentumOptions momentum;                                    ///< of the other one
  bool joint_speed_limits = false;  ///< joints keep below their largest speeds; not by momentum
  bool self_collision = false;      ///< limbs keep off each other, likewise, and collide
};

/// The one that is chosen, for this robot and these soles.
std::unique_ptr<WholeBodyController> make_whole_body_controller(const FloatingRobot& robot,
                                                                const ContactConeOptions& left,
                                                                const ContactConeOptions& right,
                                                                const WholeBodyControl& control);

}  // namespace saltus
