// Momentum control in two levels, the reference of the literature: first the wrenches that give the
// momentum its rate, then the torques that make the feet transmit them. After Nava, Romano, Nori,
// Pucci, "Stability analysis and design of momentum-based controllers for humanoid robots", 2016.
//
// Level 1, a quadratic program over the wrenches f of the feet that stand, within their cones:
//   min |rate(f) - wanted|^2 + weights on |f - planned|^2 and of |tau(f)|^2.
// Level 2, with J and a the Jacobians and accelerations of both feet, J_s those of the feet that
// stand, S the selection of the joints, Lambda = J M^-1 S, N = I - Lambda^+ Lambda:
//   tau(f) = Lambda^+ (J M^-1 (h - J_s' f) - dJ/dt nu + a) + N tau_0,
// where tau_0 would give the joints the accelerations of the posture if no foot had to be obeyed.
// A foot that stands shall not accelerate; one that swings has its task here, below it in rank
// only by a larger damping of the pseudo-inverse: straight legs are singular.
//
// Torques are found without regard to their limits and cut afterwards, joint limits are not seen:
// that is the method, and what the inverse-dynamics program does better.
#pragma once

#include <memory>

#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

/// Of control by momentum.
struct MomentumOptions {
  double linear_momentum = 1.0;    ///< per N^2
  double angular_momentum = 10.0;  ///< per (Nm)^2
  double wrench = 1e-3;            ///< of the difference to the planned wrenches, per N^2, (Nm)^2
  double torque = 0.0;             ///< per (Nm)^2
  double posture = 50.0, posture_damping = 14.0;  ///< 1/s^2, 1/s
  double stance_damping = 50.0;                   ///< 1/s, on what is left of a stance foot's twist
  /// Of the pseudo-inverse, on accelerations of the feet: m/s^2 and rad/s^2 per Nm.
  double stance_regularisation = 1e-3, swing_regularisation = 0.1;
  double limit_horizon = 0.05;  ///< s; only to say that a joint runs into its limit
};

/// Throws DefinitionError for an option that is negative or not finite, and for zero where the
/// solution would not be unique: wrench, regularisations, limit_horizon.
std::unique_ptr<WholeBodyController> make_momentum_controller(const FloatingRobot& robot,
                                                              const ContactConeOptions& left,
                                                              const ContactConeOptions& right,
                                                              const MomentumOptions& options = {});

}  // namespace saltus
