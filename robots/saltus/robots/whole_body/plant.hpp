// Physics engine: a robot on level ground with at most one step in it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace saltus {

/// Of the ground and of the engine.
struct PlantOptions {
  double step = 1e-3;           ///< s
  double friction = 1.0;        ///< Coulomb, of the ground
  double joint_friction = 0.0;  ///< viscous, Nm s/rad
  /// The ground is z = 0; beyond the line y = ground_edge, seen from the origin, z = ground_step. m
  double ground_step = 0.0, ground_edge = -0.18;
  /// Capsules of bodies that must stay apart collide, and those of all bodies but the feet with the
  /// ground.
  bool self_collision = false;
};

/// A slab of ground: a box, its upper face on the ground.
struct GroundBox {
  Vec<double, 3> centre, size;  ///< m
};
/// The ground as boxes: one, or two with a step. Throws DefinitionError if the step's numbers are
/// not finite, or the edge is at the origin.
std::vector<GroundBox> ground_boxes(const PlantOptions& options);

/// Torques in, motion out. One call is one step of the engine.
class Plant {
 public:
  virtual ~Plant() = default;
  /// At rest or moving, forces forgotten.
  virtual void reset(const WholeBodyState& state) = 0;
  /// Joint torques for the next step(s), Nm; cut to the limits of the robot.
  virtual void set_torques(const VectorXd& torques) = 0;
  /// A force (world axes, N) at a point of a body (its own frame, m) during the next step only.
  virtual void push(int body, const Vec<double, 3>& force, const Vec<double, 3>& point) = 0;
  /// One step of the engine.
  virtual void step() = 0;

  virtual double time() const = 0;  ///< s
  /// Of the whole body.
  virtual const WholeBodyState& state() const = 0;
  /// Forces of a foot.
  virtual const FootContact& contact(Side side) const = 0;
  /// For messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus
