// Conversion of a FloatingRobot to a MuJoCo model. Only this folder includes MuJoCo.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots::mujoco_engine {

/// Model and data of MuJoCo in the order of the FloatingRobot. Warnings and errors of MuJoCo are
/// neither printed nor fatal: warnings are counted in data(), errors throw InputError in the
/// constructor and return `false` later.
class Model {
 public:
  Model(const FloatingRobot& robot, const Plant::Options& options);

  mjModel& model() const { return *model_; }
  mjData& data() const { return *data_; }
  int joints() const { return static_cast<int>(joint_dof_.size()); }
  int body(int i) const { return bodies_[i]; }  ///< MuJoCo's number of body i
  int joint_dof(int i) const { return joint_dof_[i]; }
  /// Inertia of the rotor of joint i, kg m^2. begin_step() uses it.
  double& rotor_inertia(int i) { return model_->dof_armature[joint_dof_[i]]; }

  /// Resets the data and sets positions and velocities.
  void write(const WholeBodyState& state);
  void read(WholeBodyState& state) const;
  /// Pose of MuJoCo body `body`, from the last kinematics.
  Eigen::Isometry3d pose(int body) const;

  /// Computes everything up to the forces: kinematics, contacts, bias. False on an error of MuJoCo.
  bool begin_step();
  /// Computes forces, accelerations and the next state. False on an error of MuJoCo.
  bool end_step();
  /// True if MuJoCo has issued warnings since the last write(): numbers out of range, or dropped
  /// contacts.
  bool has_warnings() const;

  /// Mass matrix as in DynamicsModel, at the last kinematics.
  MatrixXd mass_matrix() const;

 private:
  struct Deleter {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  int base_position_ = 0, base_dof_ = 0;
  std::vector<int> bodies_, joint_position_, joint_dof_;
};

}  // namespace saltus::robots::mujoco_engine
