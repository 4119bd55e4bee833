#include "saltus/robots/model/urdf_model.hpp"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "saltus/core/file_content.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/model/xml_nesting.hpp"

namespace saltus::robots {
namespace {

// Robots have a few hundred links. The functions that read them are recursive.
constexpr std::size_t most_links = 2000;

// Breaks the reference cycles of links that urdfdom joined in a cycle; otherwise they are never
// freed.
struct LetGo {
  urdf::ModelInterface& model;
  ~LetGo() {
    for (auto& [name, link] : model.links_) {
      link->child_links.clear();
      link->child_joints.clear();
    }
  }
};

// length of a message that is still readable, in characters
constexpr std::size_t longest_clause = 1000;

// urdfdom reports errors to a process-wide log and continues with a half-read link after most of
// them. While an object of this class lives, the errors are collected here and not printed.
class CollectedLog : public console_bridge::OutputHandler {
 public:
  CollectedLog() { console_bridge::useOutputHandler(this); }
  ~CollectedLog() override { console_bridge::restorePreviousOutputHandler(); }
  CollectedLog(const CollectedLog&) = delete;
  CollectedLog& operator=(const CollectedLog&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    // Visual elements that cannot be drawn do not matter here. The causes precede this message.
    if (text.rfind("Could not parse visual element", 0) == 0) {
      errors_.resize(link_start_);
      return;
    }
    errors_.push_back(text);
    if (text.rfind("Could not parse", 0) == 0) link_start_ = errors_.size();
  }
  bool empty() const { return errors_.empty(); }
  // The first message is the cause, the later ones its consequences; joined into one clause.
  std::string clause() const {
    std::string text;
    for (std::string error : errors_) {
      std::replace(error.begin(), error.end(), '\n', ' ');
      error = error.substr(0, error.find(".  "));  // keep the first sentence
      while (!error.empty() && (error.back() == '.' || error.back() == ' ')) error.pop_back();
      error = shortened(error);
      if (text.size() + error.size() > longest_clause) return text + "; and more";
      if (text.find(error) == std::string::npos) text += (text.empty() ? "" : "; ") + error;
    }
    return text;
  }

 private:
  std::vector<std::string> errors_;
  std::size_t link_start_ = 0;  // first message after the last finished group
};

Vec<double, 3> vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Eigen::Isometry3d isometry(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.translation() = vector(pose.position);
  result.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return result;
}

// Principal moments in ascending order, kg m^2.
Vec<double, 3> principal_moments(const Mat<double, 3, 3>& inertia) {
  return Eigen::SelfAdjointEigenSolver<Mat<double, 3, 3>>(inertia, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

std::string text_of(const Vec<double, 3>& moments) {
  return fmt::format("principal moments {:.6g}, {:.6g} and {:.6g} kg m^2", moments[0], moments[1],
                     moments[2]);
}

void check_inertial(const UrdfModel::Link& link, const std::string& source) {
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("{}: link \"{}\" {}; correct its <inertial> element", source,
                                 shortened(link.name), what));
  };
  if (!std::isfinite(link.mass)) fail(fmt::format("has the mass {}", link.mass));
  if (link.mass < 0.0) fail(fmt::format("has the negative mass {} kg", link.mass));
  constexpr double heaviest = 1e5;  // kg; simulators lose precision or abort for larger masses
  if (link.mass > heaviest) fail(fmt::format("has the implausible mass {:.3g} kg", link.mass));
  if (!link.com.allFinite()) fail("has a centre of mass that is not finite");
  if (!link.inertia.allFinite()) fail("has an inertia that is not finite");
  if (link.mass == 0.0) return;  // a massless frame; its inertia is ignored
  const Vec<double, 3> moments = principal_moments(link.inertia);
  // A point mass may be fixed to a body: see check_rigid_groups(). Its moments are zero up to the
  // rounding of the file's author.
  constexpr double no_radius = 1e-8;  // m, radius of gyration
  if (moments.cwiseAbs().maxCoeff() < no_radius * no_radius * link.mass) return;
  if (moments[0] < 0.0 || (moments[0] == 0.0 && moments[2] > 0.0))
    fail(fmt::format("has an inertia that is not positive ({})", text_of(moments)));
  // Files carry about six digits. A flat body, for which the sum is exact, must pass.
  constexpr double rounding = 1e-5;
  if (moments[2] > (moments[0] + moments[1]) * (1.0 + rounding))
    fail(
        fmt::format("has a physically impossible inertia: the principal moment {:.6g} kg m^2 "
                    "exceeds the sum of the other two, {:.6g} and {:.6g}",
                    moments[2], moments[0], moments[1]));
}

UrdfModel::Joint convert(const urdf::Joint& joint, const std::string& source) {
  UrdfModel::Joint result;
  result.name = joint.name;
  result.origin = isometry(joint.parent_to_joint_origin_transform);
  switch (joint.type) {
    case urdf::Joint::FIXED:
      return result;
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      result.motion = UrdfModel::Joint::Motion::revolute;
      break;
    case urdf::Joint::PRISMATIC:
      result.motion = UrdfModel::Joint::Motion::prismatic;
      break;
    default:
      throw InputError(fmt::format(
          "{}: joint \"{}\" is neither fixed, revolute, continuous nor prismatic; model a free "
          "base by leaving the root link unattached",
          source, shortened(joint.name)));
  }
  result.axis = vector(joint.axis);
  if (!(result.axis.norm() > 0.0) || !result.axis.allFinite())
    throw InputError(fmt::format("{}: joint \"{}\" has a zero axis; correct its <axis>", source,
                                 shortened(joint.name)));
  result.axis.normalize();
  if (joint.limits) {
    if (joint.type != urdf::Joint::CONTINUOUS)
      result.position = between(joint.limits->lower, joint.limits->upper);
    result.effort = joint.limits->effort;
    if (joint.limits->velocity > 0.0) result.velocity = joint.limits->velocity;
  }
  if (joint.mimic) result.leader = joint.mimic->joint_name;
  return result;
}

// Shape of a visual or collision element; empty for unknown shapes.
template <class Element>
std::optional<UrdfModel::LinkShape> shape_of(const Element& element) {
  const urdf::Geometry* geometry = element.geometry.get();
  if (geometry == nullptr) return std::nullopt;
  UrdfModel::LinkShape result;
  result.pose = isometry(element.origin);
  if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(geometry)) {
    result.shape = UrdfModel::LinkShape::Shape::mesh;
    result.mesh = mesh->filename;
    result.size = vector(mesh->scale);
  } else if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
    result.size = vector(box->dim);
  } else if (const auto* tube = dynamic_cast<const urdf::Cylinder*>(geometry)) {
    result.shape = UrdfModel::LinkShape::Shape::cylinder;
    result.size = {2.0 * tube->radius, 2.0 * tube->radius, tube->length};
  } else if (const auto* ball = dynamic_cast<const urdf::Sphere*>(geometry)) {
    result.shape = UrdfModel::LinkShape::Shape::sphere;
    result.size.setConstant(2.0 * ball->radius);
  } else {
    return std::nullopt;
  }
  return result;
}

std::optional<UrdfModel::LinkShape> convert(const urdf::Visual& visual) {
  auto result = shape_of(visual);
  if (result && visual.material != nullptr)
    result->colour = {visual.material->color.r, visual.material->color.g, visual.material->color.b};
  return result;
}

UrdfModel::Link convert(const urdf::Link& link, int parent, const std::string& source) {
  UrdfModel::Link result;
  result.name = link.name;
  result.parent = parent;
  if (link.parent_joint) result.joint = convert(*link.parent_joint, source);
  if (link.inertial) {
    const urdf::Inertial& inertial = *link.inertial;
    const Eigen::Isometry3d frame = isometry(inertial.origin);
    Mat<double, 3, 3> moments;
    moments << inertial.ixx, inertial.ixy, inertial.ixz,  //
        inertial.ixy, inertial.iyy, inertial.iyz,         //
        inertial.ixz, inertial.iyz, inertial.izz;
    result.mass = inertial.mass;
    result.com = frame.translation();
    result.inertia = frame.linear() * moments * frame.linear().transpose();
    check_inertial(result, source);
  }
  for (const auto& collision : link.collision_array) {
    const auto shape = shape_of(*collision);
    if (!shape) continue;
    result.collisions.push_back(*shape);
    if (shape->shape == UrdfModel::LinkShape::Shape::box)
      result.collision_boxes.push_back({shape->pose, shape->size});
  }
  for (const auto& visual : link.visual_array)
    if (const auto look = convert(*visual)) result.visuals.push_back(*look);
  return result;
}

// Links fixed to each other move as one body, which must have an inertia.
void check_rigid_groups(const std::vector<UrdfModel::Link>& links, const std::string& source) {
  struct Group {
    double mass = 0.0;
    Vec<double, 3> moment = Vec<double, 3>::Zero();         // sum of mass times position
    Mat<double, 3, 3> inertia = Mat<double, 3, 3>::Zero();  // about the frame of the first link
  };
  std::vector<Group> groups(links.size());
  const std::vector<int> first = rigid_leaders(links);
  std::vector<Eigen::Isometry3d> pose(links.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const UrdfModel::Link& link = links[i];
    if (first[i] != static_cast<int>(i))
      pose[i] = pose[static_cast<std::size_t>(link.parent)] * link.joint.origin;
    Group& group = groups[static_cast<std::size_t>(first[i])];
    const Vec<double, 3> com = pose[i] * link.com;
    const Mat<double, 3, 3> R = pose[i].linear();
    group.mass += link.mass;
    group.moment += link.mass * com;
    group.inertia +=
        R * link.inertia * R.transpose() +
        link.mass * (com.squaredNorm() * Mat<double, 3, 3>::Identity() - com * com.transpose());
  }
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Group& group = groups[i];
    if (group.mass == 0.0) continue;
    const Vec<double, 3> com = group.moment / group.mass;
    const Vec<double, 3> moments = principal_moments(
        group.inertia -
        group.mass * (com.squaredNorm() * Mat<double, 3, 3>::Identity() - com * com.transpose()));
    constexpr double rounding = 1e-12;  // relative to the largest moment
    if (!(moments[0] > rounding * moments[2]))
      throw InputError(
          fmt::format("{}: link \"{}\", together with the links fixed to it, has an inertia that "
                      "is not positive ({}); "
                      "correct its <inertial> element",
                      source, shortened(links[i].name), text_of(moments)));
  }
}

std::string suggestion(const std::string& given, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(given, known);
  constexpr std::size_t few = 40;  // names that a message can list
  if (!nearest.empty()) return fmt::format("; did you mean \"{}\"?", shortened(nearest));
  const std::string all = join_names(known);
  return known.size() > few || all.size() > longest_clause ? "" : "; the known names are " + all;
}

}  // namespace

std::vector<int> rigid_leaders(const std::vector<UrdfModel::Link>& links) {
  std::vector<int> leaders(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const bool is_fixed =
        links[i].parent >= 0 && links[i].joint.motion == UrdfModel::Joint::Motion::fixed;
    leaders[i] = is_fixed ? leaders[static_cast<std::size_t>(links[i].parent)]
                          : static_cast<int>(i);  // parents precede their children
  }
  return leaders;
}

UrdfModel UrdfModel::read(const std::filesystem::path& file) {
  const std::string source = file.string();
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    throw InputError(fmt::format("{}: there is no such file; give the path of a URDF", source));
  if (!std::filesystem::is_regular_file(file, ignored))
    throw InputError(fmt::format("{}: this is not a file; give the path of a URDF", source));
  return parse(file_content(file), source);
}

UrdfModel UrdfModel::parse(const std::string& text, const std::string& source) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(fmt::format("{}: the file is empty; give the path of a URDF", source));
  if (text.find("<robot") == std::string::npos)
    throw InputError(fmt::format(
        "{}: this is not a URDF, because it has no <robot> element; give the path of a URDF",
        source));
  if (const auto doubt = xml_nesting_error(text))
    throw InputError(fmt::format("{}: {}", source, *doubt));
  urdf::ModelInterfaceSharedPtr urdf;
  {
    CollectedLog log;
    std::string reason;
    try {
      urdf = urdf::parseURDF(text);
    } catch (const std::exception& error) {
      reason = error.what();
    }
    if (!urdf || !log.empty())
      throw InputError(
          fmt::format("{}: the file is truncated or not a valid URDF ({}); correct or replace it",
                      source, log.empty() ? reason : log.clause()));
  }
  const LetGo let_go{*urdf};
  if (urdf->links_.size() > most_links)
    throw InputError(fmt::format("{}: the robot has {} links, more than {}", source,
                                 urdf->links_.size(), most_links));
  UrdfModel model;
  model.source_ = source;
  model.name_ = urdf->getName();
  const auto add = [&](const auto& self, const urdf::Link& link, int parent) -> void {
    const int index = static_cast<int>(model.links_.size());
    // urdfdom reads joints that lead back to a link as an infinite tree.
    if (model.links_.size() >= urdf->links_.size())
      throw InputError(
          fmt::format("{}: the joints form a cycle through link \"{}\"; a URDF must be a tree, so "
                      "remove one of them",
                      source, shortened(link.name)));
    model.links_.push_back(convert(link, parent, source));
    for (const auto& child : link.child_links) self(self, *child, index);
  };
  add(add, *urdf->getRoot(), -1);
  const std::vector<std::string> reached = model.link_names();
  for (const auto& [name, link] : urdf->links_) {
    if (std::find(reached.begin(), reached.end(), name) == reached.end())
      throw InputError(
          fmt::format("{}: no chain of joints leads from the root \"{}\" to link \"{}\", because "
                      "its joints form a cycle; remove one of them",
                      source, shortened(urdf->getRoot()->name), shortened(name)));
  }
  check_rigid_groups(model.links_, source);
  for (const UrdfModel::Link& link : model.links_) model.total_mass_ += link.mass;
  if (!(model.total_mass_ > 0.0))
    throw InputError(
        fmt::format("{}: the robot \"{}\" has no mass; give its links <inertial> elements", source,
                    shortened(model.name_)));
  return model;
}

std::vector<std::string> UrdfModel::link_names() const {
  std::vector<std::string> names;
  names.reserve(links_.size());
  for (const UrdfModel::Link& link : links_) names.push_back(link.name);
  return names;
}

std::vector<std::string> UrdfModel::moving_joint_names() const {
  std::vector<std::string> names;
  for (const UrdfModel::Link& link : links_)
    if (link.joint.motion != UrdfModel::Joint::Motion::fixed) names.push_back(link.joint.name);
  return names;
}

int UrdfModel::link_index(const std::string& link) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].name == link) return static_cast<int>(i);
  throw InputError(fmt::format("{}: there is no link \"{}\"{}", source_, shortened(link),
                               suggestion(link, link_names())));
}

std::vector<Eigen::Isometry3d> UrdfModel::link_poses(const Posture& posture) const {
  const std::vector<std::string> joints = moving_joint_names();
  for (const auto& [joint, position] : posture) {
    if (std::find(joints.begin(), joints.end(), joint) == joints.end())
      throw InputError(fmt::format("{}: there is no movable joint \"{}\"{}", source_,
                                   shortened(joint), suggestion(joint, joints)));
    if (!std::isfinite(position))
      throw InputError(fmt::format("{}: the position of joint \"{}\" is {}; give a finite number",
                                   source_, shortened(joint), position));
  }
  std::vector<Eigen::Isometry3d> poses;
  poses.reserve(links_.size());
  for (const UrdfModel::Link& link : links_) {
    if (link.parent < 0) {
      poses.push_back(Eigen::Isometry3d::Identity());
      continue;
    }
    Eigen::Isometry3d pose = poses[link.parent] * link.joint.origin;
    const auto found = posture.find(link.joint.name);
    if (found != posture.end()) {
      if (link.joint.motion == UrdfModel::Joint::Motion::revolute)
        pose.rotate(Eigen::AngleAxisd(found->second, link.joint.axis));
      else
        pose.translate(found->second * link.joint.axis);
    }
    poses.push_back(pose);
  }
  return poses;
}

Eigen::Isometry3d UrdfModel::link_pose(const std::string& link, const std::string& reference,
                                       const Posture& posture) const {
  const int of = link_index(link);
  const int in = link_index(reference);
  const std::vector<Eigen::Isometry3d> poses = link_poses(posture);
  return poses[in].inverse() * poses[of];
}

Vec<double, 3> UrdfModel::centre_of_mass(const std::string& reference,
                                         const Posture& posture) const {
  const int in = link_index(reference);
  const std::vector<Eigen::Isometry3d> poses = link_poses(posture);
  Vec<double, 3> moment = Vec<double, 3>::Zero();
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].mass > 0.0) moment += links_[i].mass * (poses[i] * links_[i].com);
  return poses[in].inverse() * Vec<double, 3>(moment / total_mass_);
}

std::vector<int> UrdfModel::rigid_group(int link) const {
  const std::vector<int> leaders = rigid_leaders(links_);
  std::vector<int> group;
  for (int i = 0; i < static_cast<int>(links_.size()); ++i)
    if (leaders[static_cast<std::size_t>(i)] == leaders[static_cast<std::size_t>(link)])
      group.push_back(i);
  return group;
}

bool UrdfModel::has_collision_box(const std::string& link) const {
  for (const int i : rigid_group(link_index(link)))
    if (!links_[static_cast<std::size_t>(i)].collision_boxes.empty()) return true;
  return false;
}

UrdfModel::Foot UrdfModel::foot(const std::string& sole_link) const {
  const int sole = link_index(sole_link);
  const Eigen::Isometry3d to_sole = link_poses({})[sole].inverse();
  const std::vector<Eigen::Isometry3d> poses = link_poses({});

  struct Extent {
    Vec<double, 3> lowest, highest;
  };
  std::vector<Extent> boxes;
  double lowest_corner = infinity;  // m, of the rotated boxes
  std::string rotated;              // link of that box
  for (int i : rigid_group(sole))
    for (const UrdfModel::Box& box : links_[i].collision_boxes) {
      const Eigen::Isometry3d pose = to_sole * poses[i] * box.pose;
      const Mat<double, 3, 3> turn = pose.linear().cwiseAbs();
      // Parallel axes: every column has one entry near 1. Angles in files carry about six digits.
      if ((turn.colwise().maxCoeff().array() < 1.0 - 1e-6).any()) {
        const double corner = pose.translation().z() - 0.5 * turn.row(2).dot(box.size);
        if (corner < lowest_corner) rotated = links_[i].name;
        lowest_corner = std::min(lowest_corner, corner);
        continue;
      }
      const Vec<double, 3> half = 0.5 * turn.array().round().matrix() * box.size;
      boxes.push_back({pose.translation() - half, pose.translation() + half});
    }
  double plane = infinity;
  for (const Extent& box : boxes) plane = std::min(plane, box.lowest.z());
  // m: boxes within this distance of the lowest one also touch the ground
  constexpr double same_plane = 1e-4;
  if (lowest_corner < plane - same_plane)
    throw InputError(
        fmt::format("{}: the collision box on link \"{}\" is rotated relative to the frame of "
                    "\"{}\"; give a "
                    "sole link whose axes are parallel to the foot's box",
                    source_, shortened(rotated), shortened(sole_link)));
  if (boxes.empty())
    throw InputError(
        fmt::format("{}: the foot of \"{}\" has no collision box that defines its rectangle; add "
                    "a <collision> with a <box> to a link fixed to it",
                    source_, shortened(sole_link)));
  UrdfModel::Foot foot;
  foot.contact_plane_offset = plane;
  foot.rectangle = {between(infinity, -infinity), between(infinity, -infinity)};
  for (const Extent& box : boxes) {
    if (box.lowest.z() > plane + same_plane) continue;
    foot.rectangle.x.lower = std::min(foot.rectangle.x.lower, box.lowest.x());
    foot.rectangle.x.upper = std::max(foot.rectangle.x.upper, box.highest.x());
    foot.rectangle.y.lower = std::min(foot.rectangle.y.lower, box.lowest.y());
    foot.rectangle.y.upper = std::max(foot.rectangle.y.upper, box.highest.y());
  }
  if (!(foot.rectangle.x.lower < foot.rectangle.x.upper) ||
      !(foot.rectangle.y.lower < foot.rectangle.y.upper))
    throw InputError(
        fmt::format("{}: the collision box of the foot of \"{}\" has no area; correct its size",
                    source_, shortened(sole_link)));
  return foot;
}

}  // namespace saltus::robots
