#include "saltus/robots/mujoco/mujoco_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <exception>
#include <utility>

#include "saltus/robots/mujoco/mjcf.hpp"

namespace saltus::robots::mujoco_engine {
namespace {

// ---- errors ------------------------------------------------------------------------------------

// An error handler of MuJoCo must not return. MuJoCo is C code: exceptions must not pass through
// it, but a long jump may.
thread_local std::jmp_buf* way_out = nullptr;

void on_error(const char*) {
  if (way_out == nullptr) std::terminate();  // only calls inside guarded() can fail
  std::longjmp(*way_out, 1);
}
void on_warning(const char*) {}  // counted in mjData

// `call` must own no resources: the jump runs no destructors.
template <class Call>
bool guarded(const Call& call) {
  std::jmp_buf here;
  std::jmp_buf* const outer = way_out;
  if (setjmp(here) != 0) {
    way_out = outer;
    return false;
  }
  way_out = &here;
  call();
  way_out = outer;
  return true;
}

[[noreturn]] void refuse(const FloatingRobot& robot, const std::string& reason) {
  throw InputError(fmt::format("MuJoCo rejects the robot {}: {}", robot.name, reason));
}

std::unique_ptr<mjVFS> file_in_memory(const char* name, const std::string& text) {
  auto files = std::make_unique<mjVFS>();  // 2 MB
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(text.size())) != 0) return nullptr;
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), name)], text.data(), text.size());
  return files;
}

Mat<double, 3, 3> rotation(const mjtNum* quaternion) {
  return Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3])
      .normalized()
      .toRotationMatrix();
}

}  // namespace

Model::Model(const FloatingRobot& robot, const Plant::Options& options) {
  mju_user_error = on_error;
  mju_user_warning = on_warning;
  constexpr const char* file = "robot.xml";
  std::unique_ptr<mjVFS> files = file_in_memory(file, to_mjcf(robot, options));
  if (files == nullptr) refuse(robot, "its description does not fit into memory");
  std::array<char, 1000> reason{};
  const bool loaded = guarded([&] {
    model_.reset(mj_loadXML(file, files.get(), reason.data(), static_cast<int>(reason.size())));
  });
  mj_deleteVFS(files.get());
  if (!loaded || model_ == nullptr)
    refuse(robot, reason[0] != '\0' ? reason.data() : "internal error");
  if (!guarded([&] { data_.reset(mj_makeData(model_.get())); }) || data_ == nullptr)
    refuse(robot, "no memory");

  const mjModel& m = *model_;
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) {
    const std::string name = std::to_string(i);
    bodies_.push_back(mj_name2id(&m, mjOBJ_BODY, name.c_str()));
    const int joint = mj_name2id(&m, mjOBJ_JOINT, name.c_str());
    if (i == 0) {
      base_position_ = m.jnt_qposadr[joint];
      base_dof_ = m.jnt_dofadr[joint];
    } else {
      joint_position_.push_back(m.jnt_qposadr[joint]);
      joint_dof_.push_back(m.jnt_dofadr[joint]);
    }
  }
}

// A free joint's linear velocity is that of the body's origin in world axes, its angular velocity
// is in the body's axes.
void Model::write(const WholeBodyState& state) {
  mjData& d = *data_;
  mj_resetData(model_.get(), &d);
  const Eigen::Quaterniond q(state.base.linear());
  Eigen::Map<Vec<double, 7>> base(d.qpos + base_position_);
  Eigen::Map<Vec<double, 6>> velocity(d.qvel + base_dof_);
  base << state.base.translation(), q.w(), q.x(), q.y(), q.z();
  velocity << state.base_twist.tail<3>(),
      state.base.linear().transpose() * state.base_twist.head<3>();
  for (int i = 0; i < joints(); ++i) {
    d.qpos[joint_position_[i]] = state.q[i];
    d.qvel[joint_dof_[i]] = state.dq[i];
  }
}

void Model::read(WholeBodyState& state) const {
  const mjData& d = *data_;
  const Eigen::Map<const Vec<double, 7>> base(d.qpos + base_position_);
  const Eigen::Map<const Vec<double, 6>> velocity(d.qvel + base_dof_);
  state.q.resize(joints());
  state.dq.resize(joints());
  state.base = Eigen::Isometry3d::Identity();
  state.base.linear() = rotation(base.data() + 3);
  state.base.translation() = base.head<3>();
  state.base_twist << state.base.linear() * velocity.tail<3>(), velocity.head<3>();
  for (int i = 0; i < joints(); ++i) {
    state.q[i] = d.qpos[joint_position_[i]];
    state.dq[i] = d.qvel[joint_dof_[i]];
  }
}

Eigen::Isometry3d Model::pose(int body) const {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation(data_->xquat + 4 * body);
  pose.translation() = Eigen::Map<const Vec<double, 3>>(data_->xpos + 3 * body);
  return pose;
}

bool Model::begin_step() {
  return guarded([this] { mj_step1(model_.get(), data_.get()); });
}

bool Model::end_step() {
  return guarded([this] { mj_step2(model_.get(), data_.get()); });
}

bool Model::has_warnings() const {
  for (int i = 0; i < mjNWARNING; ++i)
    if (i != mjWARN_VGEOMFULL && data_->warning[i].number > 0) return true;
  return false;
}

MatrixXd Model::mass_matrix() const {
  const int n = 6 + joints();
  MatrixXd full(n, n);  // symmetric: rows or columns
  mj_fullM(model_.get(), full.data(), data_->qM);
  // qvel = S nu.
  MatrixXd S = MatrixXd::Zero(n, n);
  const Mat<double, 3, 3> R = rotation(data_->qpos + base_position_ + 3);
  S.block(base_dof_ + 3, 0, 3, 3).setIdentity();
  S.block(base_dof_, 3, 3, 3) = R;
  for (int i = 0; i < joints(); ++i) S(joint_dof_[i], 6 + i) = 1.0;
  return S.transpose() * full * S;
}

}  // namespace saltus::robots::mujoco_engine
