// A FloatingRobot as a model of MuJoCo. Only this folder sees MuJoCo.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::mujoco_engine {

/// The robot above the ground, in MuJoCo's own format MJCF. Names are numbers: body i of
/// the robot is "i", so is the joint that leads to it.
std::string to_mjcf(const FloatingRobot& robot, const PlantOptions& options);

/// MuJoCo's model and its working memory, with the order of the FloatingRobot. MuJoCo's warnings
/// and errors are not printed and end no process: warnings are counted in data(), errors become
/// InputError here and `false` later.
class Model {
 public:
  Model(const FloatingRobot& robot, const PlantOptions& options);

  mjModel& model() const { return *model_; }
  mjData& data() const { return *data_; }
  int joints() const { return static_cast<int>(joint_dof_.size()); }
  int body(int i) const { return bodies_[i]; }  ///< MuJoCo's number of body i
  int joint_dof(int i) const { return joint_dof_[i]; }

  /// Empties the working memory and sets positions and velocities.
  void write(const WholeBodyState& state);
  void read(WholeBodyState& state) const;
  /// Of MuJoCo body `body`, from the last kinematics.
  Eigen::Isometry3d pose(int body) const;

  /// Everything up to the forces: kinematics, contacts, bias. False on an error of MuJoCo.
  bool begin_step();
  /// Forces, accelerations, and on to the next state. False on an error of MuJoCo.
  bool end_step();
  /// Did MuJoCo complain since the last write: numbers out of range, contacts dropped?
  bool has_warnings() const;

  /// As in DynamicsModel, at the last kinematics.
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

}  // namespace saltus::mujoco_engine
