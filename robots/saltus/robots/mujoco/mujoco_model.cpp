#include "saltus/robots/mujoco/mujoco_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <exception>
#include <utility>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots::mujoco_engine {
namespace {

// Contacts are springs and dampers at the acceleration level: time constant (s) and damping ratio
// of the penetration. Friction is stiffer by a factor, so that a loaded foot does not creep.
constexpr double contact_time = 0.005, contact_damping = 1.0, friction_stiffness = 10.0;

// Second limit of a joint that is limited on one side only, rad.
constexpr double no_limit = 1e4;

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

// ---- MJCF --------------------------------------------------------------------------------------

std::string numbers(const char* attribute, const Eigen::Ref<const VectorXd>& values) {
  std::string text = fmt::format(" {}=\"", attribute);
  for (const double v : values) text += fmt::format("{:.17g} ", v);
  text.back() = '"';
  return text;
}

std::string pose_xml(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return numbers("pos", pose.translation()) +
         numbers("quat", Vec<double, 4>(q.w(), q.x(), q.y(), q.z()));
}

bool is_foot(const FloatingRobot& robot, int body) {
  return body == robot.left_sole.body || body == robot.right_sole.body;
}

// Collision bits: 1 for the ground, 2 for limbs among each other.
std::string capsule_xml(const Capsule& capsule, bool is_of_foot) {
  constexpr double shortest = 1e-4;  // m; MuJoCo requires a positive length
  Vec<double, 6> ends;
  ends << capsule.from, capsule.to;
  if (capsule.length() < shortest) ends[5] += shortest;
  return fmt::format(
      "<geom type=\"capsule\" contype=\"{}\" conaffinity=\"2\" size=\"{:.17g}\"{}/>\n",
      is_of_foot ? 2 : 3, capsule.radius, numbers("fromto", ends));
}

// Excludes pairs of bodies that may touch. MuJoCo itself excludes a body and its parent.
std::string exclusions_xml(const FloatingRobot& robot) {
  std::string text = "<contact>\n";
  const int bodies = static_cast<int>(robot.bodies.size());
  for (int a = 0; a < bodies; ++a)
    for (int b = a + 1; b < bodies; ++b)
      if (robot.bodies[static_cast<std::size_t>(b)].parent != a &&
          std::find(robot.apart.begin(), robot.apart.end(), std::pair(a, b)) == robot.apart.end())
        text += fmt::format("<exclude body1=\"{}\" body2=\"{}\"/>\n", a, b);
  return text + "</contact>\n";
}

std::string body_xml(const FloatingRobot& robot, int i, const Plant::Options& options) {
  const FloatingRobot::Body& b = robot.bodies[i];
  const Mat<double, 3, 3>& I = b.inertia;
  std::string text = fmt::format("<body name=\"{}\"{}>\n", i, pose_xml(b.origin));
  if (b.parent < 0) {
    text += "<freejoint name=\"0\"/>\n";
  } else {
    const bool limited = b.position.lower > -infinity || b.position.upper < infinity;
    text += fmt::format(
        "<joint name=\"{}\" type=\"hinge\"{} damping=\"{:.17g}\" armature=\"{:.17g}\" "
        "limited=\"{}\"",
        i, numbers("axis", b.axis), options.joint_friction, b.drive.rotor_inertia, limited);
    if (limited)
      text += numbers("range", Vec<double, 2>(std::max(b.position.lower, -no_limit),
                                              std::min(b.position.upper, no_limit)));
    text += "/>\n";
  }
  Vec<double, 6> inertia;
  inertia << I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
  text += fmt::format("<inertial mass=\"{:.17g}\"{}{}/>\n", b.mass, numbers("pos", b.com),
                      numbers("fullinertia", inertia));
  for (const UrdfModel::Box& box : b.boxes)
    text += fmt::format("<geom type=\"box\" contype=\"1\" conaffinity=\"0\"{}{}/>\n",
                        numbers("size", 0.5 * box.size), pose_xml(box.pose));
  if (options.self_collision)
    for (const RobotDescription::LinkCapsule& c : b.capsules)
      text += capsule_xml(c.capsule, is_foot(robot, i));
  for (int child = i + 1; child < static_cast<int>(robot.bodies.size()); ++child)
    if (robot.bodies[child].parent == i) text += body_xml(robot, child, options);
  return text + "</body>\n";
}

// Level ground is a plane: it has no edges and the cheapest collisions. The priority of boxes makes
// their friction that of the contact.
std::string ground_xml(const Plant::Options& options) {
  if (options.ground.is_level())
    return "<geom type=\"plane\" size=\"0 0 1\" contype=\"0\" conaffinity=\"1\"/>\n";
  std::string text;
  for (const GroundBox& box : ground_boxes(options)) {
    if (box.is_soft) continue;
    text +=
        fmt::format("<geom type=\"box\" contype=\"0\" conaffinity=\"1\" priority=\"1\"{}{}{}/>\n",
                    numbers("friction", Vec<double, 3>(box.friction, 0.0, 0.0)),
                    numbers("size", 0.5 * box.size), pose_xml(box.pose));
  }
  return text;
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

std::string to_mjcf(const FloatingRobot& robot, const Plant::Options& options) {
  // Inertias are taken as given.
  return fmt::format(
             "<mujoco>\n<compiler angle=\"radian\" inertiafromgeom=\"false\" "
             "balanceinertia=\"false\"/>\n"
             "<option timestep=\"{:.17g}\" gravity=\"0 0 {:.17g}\" cone=\"elliptic\" "
             "impratio=\"{}\"/>\n"
             "<default><joint armature=\"0\"/><geom condim=\"3\" solref=\"{} {}\" "
             "friction=\"{:.17g} 0 0\"/></default>\n"
             "<worldbody>\n",
             options.step, -standard_gravity, friction_stiffness, contact_time, contact_damping,
             options.friction) +
         ground_xml(options) + body_xml(robot, 0, options) + "</worldbody>\n" +
         (options.self_collision ? exclusions_xml(robot) : "") + "</mujoco>\n";
}

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
