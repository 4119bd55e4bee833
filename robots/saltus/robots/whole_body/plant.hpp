// Physics engine: a robot on level ground with at most one step in it.
#pragma once

#include <memory>
#include <string>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Simulated dynamics, driven by joint torques. One call of step() is one step of the engine.
class Plant {
 public:
  /// Options of the ground and the engine.
  struct Options {
    double step = 1e-3;           ///< time step, s
    double friction = 1.0;        ///< Coulomb friction of the ground
    double joint_friction = 0.0;  ///< viscous, Nm s/rad
    /// Step in the ground: the height is 0, and `ground_step` (m) beyond the line y = `ground_edge`
    /// (m), seen from the origin.
    double ground_step = 0.0, ground_edge = -0.18;
    /// Lets capsules of bodies that must stay apart collide with each other, and capsules of all
    /// bodies except the feet with the ground.
    bool self_collision = false;
  };

  virtual ~Plant() = default;
  /// Sets the state and clears all forces.
  virtual void reset(const WholeBodyState& state) = 0;
  /// Sets the joint torques for the next steps, Nm.
  virtual void set_torques(const VectorXd& torques) = 0;
  /// Applies a force (world axes, N) at a point of a body (its own frame, m) during the next step
  /// only.
  virtual void push(int body, const Vec<double, 3>& force, const Vec<double, 3>& point) = 0;
  /// Advances by one step of the engine.
  virtual void step() = 0;

  virtual double time() const = 0;  ///< s
  /// Current state of the whole body.
  virtual const WholeBodyState& state() const = 0;
  /// Contact of a foot.
  virtual const WholeBodyEstimate::Contact& contact(Side side) const = 0;
  /// Name for messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using Plant [[deprecated("use robots::Plant; removed in 0.4")]] = robots::Plant;
/// Deprecated name.
using PlantOptions [[deprecated("use robots::Plant::Options; removed in 0.4")]] =
    robots::Plant::Options;
}  // namespace saltus
