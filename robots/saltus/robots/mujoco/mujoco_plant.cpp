#include "saltus/robots/mujoco/mujoco_plant.hpp"

#include <fmt/format.h>

#include <limits>

#include "saltus/robots/mujoco/mujoco_model.hpp"

namespace saltus::robots {
namespace {

class MujocoPlant final : public Plant {
 public:
  MujocoPlant(const FloatingRobot& robot, const Plant::Options& options)
      : engine_(robot, options),
        feet_{robot.left_sole, robot.right_sole},
        torques_(VectorXd::Zero(robot.joints())) {
    finish(engine_.begin_step());
  }

  void reset(const WholeBodyState& state) override {
    engine_.write(state);
    mju_zero(engine_.data().xfrc_applied, 6 * engine_.model().nbody);
    torques_.setZero();
    contacts_[0] = contacts_[1] = {};
    has_failed_ = false;
    finish(engine_.begin_step());
  }
  void set_torques(const VectorXd& torques) override { torques_ = torques; }
  void set_rotor_inertias(const VectorXd& inertias) override {
    for (int i = 0; i < engine_.joints(); ++i) {
      double& inertia = engine_.rotor_inertia(i);
      has_begun_ = has_begun_ && inertia == inertias[i];
      inertia = inertias[i];
    }
  }
  // MuJoCo applies forces at the body's CoM.
  void push(int body, const Vec<double, 3>& force, const Vec<double, 3>& point) override {
    const int b = engine_.body(body);
    const mjData& d = engine_.data();
    const Vec<double, 3> com = Eigen::Map<const Vec<double, 3>>(d.xipos + 3 * b);
    Eigen::Map<Vec<double, 6>> applied(d.xfrc_applied + 6 * b);
    applied.head<3>() += force;
    applied.tail<3>() += (engine_.pose(b) * point - com).cross(force);
  }

  // Between two steps, kinematics and contacts are those of the current state, so a push acts at
  // the current position of the body.
  void step() override {
    if (has_failed_) return;
    mjData& d = engine_.data();
    for (int i = 0; i < engine_.joints(); ++i) d.qfrc_applied[engine_.joint_dof(i)] = torques_[i];
    bool done = (has_begun_ || engine_.begin_step()) && engine_.end_step();
    if (done) read_contacts();
    mju_zero(d.xfrc_applied, 6 * engine_.model().nbody);
    done = done && engine_.begin_step();
    finish(done);
  }

  double time() const override { return engine_.data().time; }
  const WholeBodyState& state() const override { return state_; }
  const WholeBodyEstimate::Contact& contact(Side side) const override {
    return contacts_[side == Side::left ? 0 : 1];
  }
  std::string name() const override {
    return fmt::format("MuJoCo {}, elliptic friction cones", mj_versionString());
  }

 private:
  // MuJoCo resets the robot when numbers leave their range. This counts as a failure.
  void finish(bool done) {
    engine_.read(state_);
    has_begun_ = true;
    has_failed_ = !done || engine_.has_warnings() || !state_.is_finite();
    if (has_failed_) state_.q.setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  // Forces, points and poses all belong to the state before the step.
  void read_contacts() {
    contacts_[0] = contacts_[1] = {};
    const mjModel& m = engine_.model();
    const mjData& d = engine_.data();
    for (int c = 0; c < d.ncon; ++c) {
      const mjContact& contact = d.contact[c];
      if (contact.efc_address < 0) continue;  // not part of the dynamics
      const int first = m.geom_bodyid[contact.geom1], second = m.geom_bodyid[contact.geom2];
      constexpr int ground = 0;                           // MuJoCo's world
      if (first != ground && second != ground) continue;  // contact of two limbs
      Vec<double, 6> local;  // (force | torque) on the second geom, in the contact's frame
      mj_contactForce(&m, &d, c, local.data());
      using Frame = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;  // one row per axis
      const Eigen::Map<const Frame> axes(contact.frame);
      const Eigen::Map<const Vec<double, 3>> point(contact.pos);
      for (int foot = 0; foot < 2; ++foot) {
        const int body = engine_.body(feet_[foot].body);
        if (first != body && second != body) continue;
        const double sign = second == body ? 1.0 : -1.0;
        const Vec<double, 3> force = sign * (axes.transpose() * local.head<3>());
        const Vec<double, 3> torque = sign * (axes.transpose() * local.tail<3>());
        const Vec<double, 3> origin = (engine_.pose(body) * feet_[foot].pose).translation();
        contacts_[foot].touches = true;
        contacts_[foot].wrench.head<3>() += force;
        contacts_[foot].wrench.tail<3>() += torque + (point - origin).cross(force);
      }
    }
  }

  mujoco_engine::Model engine_;
  FloatingRobot::Frame feet_[2];
  VectorXd torques_;
  bool has_begun_ = false;  // begin_step() has used the present inertias of the rotors
  bool has_failed_ = false;
  WholeBodyState state_;
  WholeBodyEstimate::Contact contacts_[2];
};

}  // namespace

bool has_mujoco() { return true; }

std::unique_ptr<Plant> make_mujoco_plant(const FloatingRobot& robot,
                                         const Plant::Options& options) {
  return std::make_unique<MujocoPlant>(robot, options);
}

MatrixXd mujoco_mass_matrix(const FloatingRobot& robot, const WholeBodyState& state) {
  mujoco_engine::Model engine(robot, {});
  engine.write(state);
  if (!engine.begin_step()) throw InputError("MuJoCo cannot compute the mass matrix of this state");
  return engine.mass_matrix();
}

}  // namespace saltus::robots
