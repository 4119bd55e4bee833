// Whole-body controller by momentum control in two levels, the reference method of the literature.
// Level 1 finds wrenches that give the requested rate of momentum. Level 2 finds torques with which
// the feet transmit them. After Nava, Romano, Nori, Pucci, "Stability analysis and design of
// momentum-based controllers for humanoid robots", 2016.
//
// Level 1 is a quadratic program over the wrenches f of the stance feet, within their cones:
//   min |rate(f) - wanted|^2 + weights on |f - planned|^2 and of |tau(f)|^2.
// Level 2 uses the Jacobians J and accelerations a of both feet, J_s of the stance feet, the
// selection S of the joints, Lambda = J M^-1 S and N = I - Lambda^+ Lambda:
//   tau(f) = Lambda^+ (J M^-1 (h - J_s' f) - dJ/dt nu + a) + N tau_0,
// where tau_0 gives the joints the accelerations of the posture without constraints by the feet. A
// stance foot has zero acceleration. A swing foot tracks its task in the same equation. Its
// pseudo-inverse has a larger damping, because straight legs are singular.
//
// The method ignores torque limits, which are applied by cutting afterwards, and joint limits. The
// inverse-dynamics program respects both.
#pragma once

#include <memory>

#include "saltus/robots/model/contact_cone.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus {

/// Options of momentum control.
struct MomentumOptions {
  double linear_momentum = 1.0;    ///< per N^2
  double angular_momentum = 10.0;  ///< per (Nm)^2
  double wrench = 1e-3;            ///< deviation from the planned wrenches, per N^2, (Nm)^2
  double torque = 0.0;             ///< per (Nm)^2
  double posture = 50.0, posture_damping = 14.0;  ///< 1/s^2, 1/s
  double stance_damping = 50.0;                   ///< 1/s, on the remaining twist of a stance foot
  /// Damping of the pseudo-inverse, on accelerations of the feet: m/s^2 and rad/s^2 per Nm.
  double stance_regularisation = 1e-3, swing_regularisation = 0.1;
  double limit_horizon = 0.05;  ///< s; only to report that a joint runs into its limit
};

/// Creates a momentum controller. Throws DefinitionError for an option that is negative or not
/// finite, and for zero if the solution would not be unique: wrench, regularisations,
/// limit_horizon.
std::unique_ptr<WholeBodyController> make_momentum_controller(const FloatingRobot& robot,
                                                              const ContactConeOptions& left,
                                                              const ContactConeOptions& right,
                                                              const MomentumOptions& options = {});

}  // namespace saltus
