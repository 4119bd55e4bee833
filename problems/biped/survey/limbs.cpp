#include "problems/biped/survey/limbs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>

#include "saltus/core/text.hpp"
#include "saltus/robots/model/mesh.hpp"

namespace saltus::survey {
namespace {

using Points = std::vector<Vec<double, 3>>;

class Survey {
 public:
  explicit Survey(const robots::UrdfModel& model)
      : model_(model),
        links_(model.links()),
        poses_(model.link_poses({})),
        group_(robots::rigid_leaders(model.links())) {}

  // Rotates everything about the vertical so that y points along `left`. Rounds the angle to a
  // multiple of 90 degrees if it is close to one.
  void face(const Vec<double, 3>& left) {
    constexpr double quarter = std::numbers::pi / 2.0, meant = 0.02;  // rad
    double yaw = std::atan2(-left.x(), left.y());
    const double whole = std::round(yaw / quarter) * quarter;
    if (std::abs(yaw - whole) < meant) yaw = whole;
    const Eigen::AngleAxisd turn(-yaw, Vec<double, 3>::UnitZ());
    for (Eigen::Isometry3d& pose : poses_) pose = turn * pose;
  }

  const std::vector<robots::UrdfModel::Link>& links() const { return links_; }
  const robots::UrdfModel::Link& link(int i) const { return links_[static_cast<std::size_t>(i)]; }
  const Eigen::Isometry3d& pose(int i) const { return poses_[static_cast<std::size_t>(i)]; }
  /// Links joined by fixed joints form a group, identified by its first link.
  int group(int i) const { return group_[static_cast<std::size_t>(i)]; }

  // Hull points of all links of the group, in the root's frame.
  Points points_of_group(int group) const {
    Points points = robots::rigid_hull_points(model_, group);
    for (Vec<double, 3>& p : points) p = pose(group) * p;
    return points;
  }

  // Mass of the link and of all its descendants, kg.
  double carried_mass(int first) const {
    std::vector<bool> carried(links_.size(), false);
    double mass = 0.0;
    for (std::size_t i = static_cast<std::size_t>(first); i < links_.size(); ++i) {
      carried[i] = static_cast<int>(i) == first ||
                   (links_[i].parent >= 0 && carried[static_cast<std::size_t>(links_[i].parent)]);
      if (carried[i]) mass += links_[i].mass;
    }
    return mass;
  }

  // Axis of a joint in the root's frame.
  Vec<double, 3> axis(int i) const { return pose(i).linear() * link(i).joint.axis; }

 private:
  const robots::UrdfModel& model_;
  const std::vector<robots::UrdfModel::Link>& links_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<int> group_;
};

// A link of the foot's group with x forward, y left, z up. Prefers names with "sole", then "foot".
int sole_link(const robots::UrdfModel& model, const Survey& survey, int group) {
  constexpr double parallel = 1e-3;  // rad
  int best = -1, best_rank = -1;
  for (std::size_t i = 0; i < survey.links().size(); ++i) {
    const int link = static_cast<int>(i);
    if (survey.group(link) != group) continue;
    if (!survey.pose(link).linear().isIdentity(parallel)) continue;
    const std::string name = lower_case(survey.link(link).name);
    const int rank = name.find("sole") != std::string::npos   ? 2
                     : name.find("foot") != std::string::npos ? 1
                                                              : 0;
    if (rank > best_rank) {
      best = link;
      best_rank = rank;
    }
  }
  const Mat<double, 3, 3> half_turn = Vec<double, 3>(-1.0, -1.0, 1.0).asDiagonal();
  for (std::size_t i = 0; i < survey.links().size() && best < 0; ++i) {
    const int link = static_cast<int>(i);
    if (survey.group(link) == group && survey.pose(link).linear().isApprox(half_turn, parallel))
      throw InputError(
          fmt::format("{}: by the names of the joints, left and right are exchanged: \"{}\" is on "
                      "the other side of the robot, seen along its x axis; correct the names, or "
                      "turn x forward",
                      model.source(), survey.link(link).name));
  }
  if (best < 0)
    throw InputError(fmt::format(
        "{}: no link fixed to \"{}\" has x forward, y to the left and z up when all joints are at "
        "zero; add one with a fixed joint, for the sole",
        model.source(), survey.link(group).name));
  return best;
}

FoundFoot foot_of_group(const robots::UrdfModel& model, const Survey& survey, int group) {
  constexpr double flat = 2e-3;  // m: points this close to the lowest touch the ground too
  const Points points = survey.points_of_group(group);
  if (points.empty())
    throw InputError(fmt::format(
        "{}: the foot of \"{}\" has neither a collision nor a visual shape; give it a <collision>",
        model.source(), survey.link(group).name));
  const int sole = sole_link(model, survey, group);
  const Eigen::Isometry3d to_sole = survey.pose(sole).inverse();
  double plane = infinity;
  for (const Vec<double, 3>& p : points) plane = std::min(plane, (to_sole * p).z());
  FoundFoot foot;
  foot.sole = survey.link(sole).name;
  foot.contact_plane_offset = plane;
  foot.origin = survey.pose(sole) * Vec<double, 3>(0.0, 0.0, plane);
  robots::FootRectangle& r = foot.rectangle;
  r = {between(infinity, -infinity), between(infinity, -infinity)};
  for (const Vec<double, 3>& point : points) {
    const Vec<double, 3> p = to_sole * point;
    if (p.z() > plane + flat) continue;
    r.x = between(std::min(r.x.lower, p.x()), std::max(r.x.upper, p.x()));
    r.y = between(std::min(r.y.lower, p.y()), std::max(r.y.upper, p.y()));
  }
  constexpr double least = 0.01;  // m, shortest edge of a foot
  if (r.x.upper - r.x.lower < least || r.y.upper - r.y.lower < least)
    throw InputError(fmt::format(
        "{}: the foot of \"{}\" touches the ground on only {:.1f} mm by {:.1f} mm; give it a "
        "<collision> with a flat underside",
        model.source(), survey.link(group).name, 1e3 * (r.x.upper - r.x.lower),
        1e3 * (r.y.upper - r.y.lower)));
  return foot;
}

bool moves(const robots::UrdfModel::Link& link) {
  return link.parent >= 0 && link.joint.motion == robots::UrdfModel::Joint::Motion::revolute;
}

// Joints from the root to the foot.
std::vector<int> chain(const robots::UrdfModel& model, const Survey& survey, int group) {
  std::vector<int> joints;
  for (int i = group; i >= 0; i = survey.link(i).parent) {
    const robots::UrdfModel::Link& link = survey.link(i);
    if (link.parent < 0 || link.joint.motion == robots::UrdfModel::Joint::Motion::fixed) continue;
    if (!link.joint.leader.empty())
      throw InputError(fmt::format(
          "{}: joint \"{}\" of a leg follows \"{}\" by <mimic>, so it has no motor of its "
          "own; remove its <mimic>",
          model.source(), link.joint.name, link.joint.leader));
    if (!moves(link) || !(link.joint.effort > 0.0))
      throw InputError(
          fmt::format("{}: joint \"{}\" of a leg {}; give it {}", model.source(), link.joint.name,
                      moves(link) ? "has no motor (its effort limit is 0)" : "is not revolute",
                      moves(link) ? "a <limit> with its effort" : "the type revolute"));
    joints.push_back(i);
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

bool is_of_left(const robots::RobotDescription::Mirror& mirror, const std::string& joint) {
  if (mirror.namesake(joint) == joint) return false;
  if (joint.starts_with(mirror.left) || joint.starts_with(mirror.right))
    return joint.starts_with(mirror.left);
  if (joint.ends_with(mirror.left) || joint.ends_with(mirror.right))
    return joint.ends_with(mirror.left);
  return joint.find(mirror.left) != std::string::npos;
}

std::set<std::string> names_of_joints(const Survey& survey) {
  std::set<std::string> names;
  for (const robots::UrdfModel::Link& link : survey.links())
    if (moves(link)) names.insert(link.joint.name);
  return names;
}

// The pair of words whose exchange maps the most joint names onto each other.
robots::RobotDescription::Mirror names_of_sides(const robots::UrdfModel& model,
                                                const Survey& survey) {
  constexpr std::array<std::pair<const char*, const char*>, 11> words{{{"left", "right"},
                                                                       {"Left", "Right"},
                                                                       {"LEFT", "RIGHT"},
                                                                       {"l_", "r_"},
                                                                       {"L_", "R_"},
                                                                       {"l", "r"},
                                                                       {"L", "R"},
                                                                       {"_l_", "_r_"},
                                                                       {"_L_", "_R_"},
                                                                       {"_l", "_r"},
                                                                       {"_L", "_R"}}};
  const std::set<std::string> names = names_of_joints(survey);
  robots::RobotDescription::Mirror best;
  std::size_t most = 0;
  for (const auto& [left, right] : words) {
    const robots::RobotDescription::Mirror mirror{left, right, {}};
    const auto pairs = static_cast<std::size_t>(
        std::count_if(names.begin(), names.end(), [&](const std::string& name) {
          const std::string namesake = mirror.namesake(name);
          return namesake != name && names.contains(namesake);
        }));
    if (pairs <= most) continue;
    most = pairs;
    best = mirror;
  }
  if (most == 0)
    throw InputError(
        fmt::format("{}: no joint names form left and right pairs, such as left_knee and "
                    "right_knee; rename the joints",
                    model.source()));
  return best;
}

// True if the names of the joints between the root and the link are those of an arm.
bool is_named_arm(const Survey& survey, int link) {
  constexpr std::array<std::string_view, 7> arm{"shoulder", "elbow", "wrist",  "hand",
                                                "finger",   "thumb", "gripper"};
  constexpr std::array<std::string_view, 6> leg{"hip", "thigh", "knee", "ankle", "leg", "foot"};
  bool is_arm = false;
  for (int i = link; survey.link(i).parent >= 0; i = survey.link(i).parent) {
    if (!moves(survey.link(i))) continue;
    const std::string name = lower_case(survey.link(i).joint.name);
    const auto is_part = [&](std::string_view word) {
      return name.find(word) != std::string::npos;
    };
    if (std::any_of(leg.begin(), leg.end(), is_part)) return false;
    is_arm = is_arm || std::any_of(arm.begin(), arm.end(), is_part);
  }
  return is_arm;
}

// Height of the joint at which a limb of at least three paired joints begins, m; infinite if the
// link belongs to no limb.
double start_of_limb(const Survey& survey, const robots::RobotDescription::Mirror& mirror,
                     const std::set<std::string>& names, int link) {
  constexpr int fewest = 3;
  double start = infinity;
  int count = 0;
  for (int i = link; i >= 0; i = survey.link(i).parent) {
    if (!moves(survey.link(i))) continue;
    const std::string namesake = mirror.namesake(survey.link(i).joint.name);
    if (namesake == survey.link(i).joint.name || !names.contains(namesake)) continue;
    start = survey.pose(i).translation().z();
    ++count;
  }
  if (count < fewest) return infinity;
  return start;
}

// The two lowest groups that no arm carries. Legs begin lower than arms, whatever their names are.
std::pair<int, int> feet(const robots::UrdfModel& model, const Survey& survey,
                         const robots::RobotDescription::Mirror& mirror) {
  constexpr double level = 0.02;  // m, largest height difference of the two
  constexpr double waist = 0.1;   // m, least height of shoulders above hips
  const std::set<std::string> names = names_of_joints(survey);
  struct End {
    double z, start;
    int link;
  };
  std::vector<End> ends;
  double hips = infinity;
  for (std::size_t i = 0; i < survey.links().size(); ++i) {
    const int link = static_cast<int>(i);
    if (survey.group(link) != link) continue;
    double z = infinity;
    for (const Vec<double, 3>& p : survey.points_of_group(link)) z = std::min(z, p.z());
    if (!(z < infinity)) continue;
    ends.push_back({z, start_of_limb(survey, mirror, names, link), link});
    if (!is_named_arm(survey, link)) hips = std::min(hips, ends.back().start);
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return std::pair(a.z, a.link) < std::pair(b.z, b.link);
  });
  const std::vector<End> all = ends;
  std::erase_if(ends, [&](const End& end) {
    return is_named_arm(survey, end.link) || (end.start < infinity && end.start > hips + waist);
  });
  const bool has_legs =
      std::any_of(ends.begin(), ends.end(), [](const End& end) { return end.start < infinity; });
  if (!has_legs && all.size() > ends.size() + 1)
    throw InputError(fmt::format(
        "{}: the robot has no legs, because its lowest links, \"{}\" and \"{}\", belong to arms; "
        "give a URDF with the legs",
        model.source(), survey.link(all[0].link).name, survey.link(all[1].link).name));
  const auto carries = [&](int one, int other) {
    for (int i = other; i >= 0; i = survey.link(i).parent)
      if (i == one) return true;
    return false;
  };
  if (ends.size() < 2 || ends[1].z > ends[0].z + level ||
      (ends.size() > 2 && ends[2].z < ends[1].z + 1e-3) || carries(ends[0].link, ends[1].link) ||
      carries(ends[1].link, ends[0].link))
    throw InputError(
        fmt::format("{}: with all joints at zero, the lowest links are not two feet at the same "
                    "height; model the robot standing, with the z axis of the root link up",
                    model.source()));
  return {ends[0].link, ends[1].link};
}

// Lengths are in m in a URDF. A CAD program may write mm.
void check_lengths(const robots::UrdfModel& model, const Survey& survey, int foot,
                   const FoundFoot& found) {
  constexpr double shortest = 0.05, longest = 3.0;  // m, of the legs of a humanoid
  double top = -infinity;
  for (const int joint : chain(model, survey, foot))
    top = std::max(top, survey.pose(joint).translation().z());
  const double leg = top - found.origin.z();
  if (leg < shortest || leg > longest)
    throw InputError(fmt::format(
        "{}: the leg of \"{}\" is {:.4g} m long, but those of humanoids have {} to {} m; write all "
        "lengths in m",
        model.source(), found.sole, leg, shortest, longest));
  const double length = found.rectangle.x.upper - found.rectangle.x.lower;
  if (length > leg)
    throw InputError(
        fmt::format("{}: the foot of \"{}\" is {:.4g} m long, but its leg only {:.4g} m; correct "
                    "its shape, for example with scale=\"0.001 0.001 0.001\" for a mesh in mm",
                    model.source(), found.sole, length, leg));
}

}  // namespace

Limbs find_limbs(const robots::UrdfModel& model) {
  // Fraction of the robot's mass. Lighter parts, such as hands and heads, are frozen.
  constexpr double least_mass = 0.012;
  Survey survey(model);
  Limbs limbs;
  limbs.mirror = names_of_sides(model, survey);
  auto [left, right] = feet(model, survey, limbs.mirror);
  const std::vector<int> leg = chain(model, survey, left);
  if (std::none_of(leg.begin(), leg.end(), [&](int joint) {
        return is_of_left(limbs.mirror, survey.link(joint).joint.name);
      }))
    std::swap(left, right);
  survey.face(survey.pose(left).translation() - survey.pose(right).translation());
  limbs.left = foot_of_group(model, survey, left);
  limbs.right = foot_of_group(model, survey, right);
  check_lengths(model, survey, left, limbs.left);
  check_lengths(model, survey, right, limbs.right);

  std::map<std::string, int> joints;
  for (std::size_t i = 0; i < survey.links().size(); ++i)
    if (moves(survey.links()[i])) joints[survey.links()[i].joint.name] = static_cast<int>(i);
  const auto is_paired = [&](int i) {
    const std::string namesake = limbs.mirror.namesake(survey.link(i).joint.name);
    return namesake != survey.link(i).joint.name && joints.contains(namesake);
  };
  std::set<int> legs;
  for (const int foot : {left, right})
    for (const int joint : chain(model, survey, foot)) legs.insert(joint);
  // Limbs are paired joints that carry enough mass. Motors of joints that carry limbs are kept too.
  std::set<int> kept = legs;
  for (const auto& [name, i] : joints) {
    if (!is_paired(i) || survey.carried_mass(i) < least_mass * model.total_mass()) continue;
    for (int k = i; k >= 0; k = survey.link(k).parent)
      if (moves(survey.link(k))) kept.insert(k);
  }
  std::string frozen, idle, coupled;
  for (const auto& [name, i] : joints)
    if (!kept.contains(i)) frozen += (frozen.empty() ? "" : ", ") + name;
  for (const int i : kept) {
    const robots::UrdfModel::Joint& joint = survey.link(i).joint;
    if (!joint.leader.empty())
      coupled += (coupled.empty() ? "" : ", ") + joint.name;
    else if (joint.effort > 0.0)
      limbs.joints.push_back(joint.name);
    else
      idle += (idle.empty() ? "" : ", ") + joint.name;
    if (legs.contains(i)) limbs.legs.push_back(joint.name);
  }
  if (!frozen.empty())
    limbs.notes.push_back(fmt::format("Frozen at zero, because they carry no limb: {}.", frozen));
  if (!idle.empty())
    limbs.notes.push_back(
        fmt::format("Frozen at zero, because their effort limit is 0: {}.", idle));
  if (!coupled.empty())
    limbs.notes.push_back(
        fmt::format("Frozen at zero, because they follow another joint (mimic): {}.", coupled));

  // A reflection in the plane y = 0 turns the axis a of a joint into -S a, S = diag(1, -1, 1).
  const Vec<double, 3> reflection(1.0, -1.0, 1.0);
  for (const std::string& name : limbs.joints) {
    const auto twin = joints.find(limbs.mirror.namesake(name));
    if (twin == joints.end()) continue;
    const Vec<double, 3> image = -reflection.cwiseProduct(survey.axis(joints.at(name)));
    if (image.dot(survey.axis(twin->second)) < 0.0) limbs.mirror.reversed.push_back(name);
  }

  double heaviest = -infinity;
  std::vector<double> mass_of_group(survey.links().size(), 0.0);
  for (std::size_t i = 0; i < survey.links().size(); ++i)
    mass_of_group[static_cast<std::size_t>(survey.group(static_cast<int>(i)))] +=
        survey.links()[i].mass;
  for (std::size_t i = 0; i < survey.links().size(); ++i) {
    bool is_leg = false;
    for (int k = static_cast<int>(i); k >= 0; k = survey.link(k).parent)
      is_leg = is_leg || legs.contains(k);
    // Half weight for the root, which carries the legs: pushes act on the link above it.
    const double weight = mass_of_group[i] * (survey.links()[i].parent < 0 ? 0.5 : 1.0);
    if (is_leg || weight <= heaviest) continue;
    heaviest = weight;
    limbs.trunk = survey.links()[i].name;
  }
  return limbs;
}

}  // namespace saltus::survey
