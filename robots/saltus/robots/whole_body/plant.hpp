// Physics engine: a robot on ground that is level under its stance foot.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Simulated dynamics, driven by joint torques. One call of step() is one step of the engine.
class Plant {
 public:
  /// Ground. Its height is 0 on the side of the line y = `edge` that contains the origin. The other
  /// members describe the part beyond the edge by x and the distance from the edge, so the opposite
  /// `edge` gives the mirror image.
  struct Ground {
    double edge = -0.18;  ///< y of the edge, m
    /// The edge lies ahead, at x = |edge|. Then `height` is the height at the edge, slope_side the
    /// rise per metre to the left, and `end_forward` and `end_side` are not used.
    bool ahead = false;
    double height = 0.0;         ///< at x = 0, 0.06 m beyond the edge; m
    double slope_forward = 0.0;  ///< rise per metre of x
    double slope_side = 0.0;     ///< rise per metre away from the edge
    /// The ground ends at this x, or at this distance from the edge, m. Beyond an end it is 5 cm
    /// lower. With both slopes, the end in x is a line across the slope, which turns slightly.
    std::optional<double> end_forward = std::nullopt, end_side = std::nullopt;
    /// Random heights within this bound (m), of square tiles of 0.1 m up to 2 m from the origin
    /// in x and from the edge.
    double roughness = 0.0;
    int seed = 1;           ///< seed of the random heights
    double friction = 0.0;  ///< Coulomb friction; 0: as Options::friction
    /// Depth to which a sole sinks that carries the whole weight, m; 0: rigid ground. Engines leave
    /// soft ground out; make_soft_ground() adds its forces on the feet. It is 5 cm deep.
    double sink = 0.0;

    /// True if the whole ground is level and has the same properties.
    bool is_level() const {
      return height == 0.0 && slope_forward == 0.0 && slope_side == 0.0 && !end_forward &&
             !end_side && roughness == 0.0 && friction == 0.0 && sink == 0.0;
    }
  };

  /// Options of the ground and the engine.
  struct Options {
    double step = 1e-3;           ///< time step, s
    double friction = 1.0;        ///< Coulomb friction of the ground
    double joint_friction = 0.0;  ///< viscous, Nm s/rad
    Ground ground;                ///< shape of the ground, level by default
    /// Lets capsules of bodies that must stay apart collide with each other, and capsules of all
    /// bodies except the feet with the ground.
    bool self_collision = false;
  };

  virtual ~Plant() = default;
  /// Sets the state and clears all forces.
  virtual void reset(const WholeBodyState& state) = 0;
  /// Sets the joint torques for the next steps, Nm.
  virtual void set_torques(const VectorXd& torques) = 0;
  /// Sets the inertias of the rotors that move with the joints, for the next steps, kg m^2. At
  /// first they are those of the robot's drives.
  virtual void set_rotor_inertias(const VectorXd& inertias) = 0;
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
