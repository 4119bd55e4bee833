// What the closed loops on the centroidal model and on the whole body have in common.
#pragma once

#include "saltus/robots/walking/simulation.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::push_recovery {

/// On the stance foot in the robot's posture for it, the other foot beside it. Throws InputError if
/// it has none.
Scene initial_scene(const Config& config, const RobotDescription& robot);

/// The robot that the controllers believe in: its mass with Config::mass_error.
RobotDescription nominal_robot(const Config& config, RobotDescription robot);

/// The share of the impulse that was given up to `t` (s), 0 to 1.
double push_share(const Push& push, double t);
/// Mean of the force over an interval, s: applied as a constant it gives the impulse of the
/// interval exactly, wherever its ends lie. World axes, N.
Vec<double, 3> mean_push_force(const Push& push, double from, double to);

/// Whether the robot lies on the ground, whatever follows; it stands with its CoM at `com_height`,
/// m.
bool has_fallen(const Vec<double, 9>& gamma, double com_height);

/// The same as a sentence; a fall before the push is said as such.
std::string fall_sentence(const Push& push, double t);

/// When enough has been seen to judge (s); `touchdown` is infinite until the foot has landed.
double end_time(const Push& push, const StepLogic& steps, double touchdown);

/// For whoever watches, before the tick at `t` (s). `touchdown` is infinite until the foot has
/// landed. Allocates.
LoopState loop_state(const Push& push, double t, const Vec<double, 9>& gamma, const Scene& scene,
                     const StepLogic& steps, double touchdown);

/// What the tick came to, costs and residuals recomputed. Allocates.
TickRecord tick_record(double t, const ControlTick& tick, RecedingHorizonController& controller);

}  // namespace saltus::push_recovery
