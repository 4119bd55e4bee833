#include "problems/biped/survey/foot_reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <numbers>
#include <string_view>
#include <utility>

#include "problems/biped/survey/posture_search.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/temporary_file.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {
namespace {

constexpr double lowest_trunk =
    0.92;  // fraction of its standing height; leaves room to bend the legs
constexpr double between_limbs = 0.005;  // m
constexpr double farthest = 0.8;         // fraction of the trunk's height; longer than any step
constexpr int halvings = 5;              // bisections of that distance, to about 1 cm

// The body with the shapes of its limbs. Without shapes, only joint limits restrict the reach.
robots::FloatingRobot body_with_limbs(const robots::UrdfModel& model,
                                      const robots::RobotDescription& robot) {
  robots::FloatingRobot body = robots::floating_robot(model, robot);
  try {
    robots::add_capsules(body, model, robot);
  } catch (const InputError&) {
  }
  return body;
}

class Search {
 public:
  Search(const robots::UrdfModel& model, const robots::RobotDescription& robot,
         robots::FloatingRobot body)
      : model_(model), robot_(robot), body_(std::move(body)) {}

  std::optional<FootReach> run() {
    const auto standing =
        std::find_if(robot_.postures.begin(), robot_.postures.end(),
                     [](const auto& p) { return p.stance == robots::Stance::both; });
    if (standing == robot_.postures.end()) return std::nullopt;
    start_ = standing->joints;
    apart_ = std::abs(standing->other_foot[1]);
    trunk_ = trunk_height(start_);

    FootReach reach;
    const robots::Point2 beside(0.0, apart_), beneath(0.0, 0.5 * apart_);
    const auto from_foot = [&](const robots::Point2& to) { return reaches(to, 0.5 * to); };
    // The reach is that of the left foot, which is fixed: if it is ahead, the CoM is behind it.
    const auto from_com = [&](const robots::Point2& to) {
      const robots::Point2 com(-to[0], to[1]);
      return reaches(com + beneath, com);
    };
    if (!from_foot(beside) || !from_com(beneath)) return std::nullopt;
    for (int i = 0; i < reach_directions; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / reach_directions;
      const robots::Point2 along(std::cos(angle), std::sin(angle));
      reach.from_foot.push_back(farthest_along(beside, along, from_foot));
      reach.from_com.push_back(farthest_along(beneath, along, from_com));
    }
    return reach;
  }

 private:
  // Height of the root link above the left sole, m.
  double trunk_height(const robots::Posture& joints) const {
    const std::vector<Eigen::Isometry3d> poses = model_.link_poses(joints);
    Eigen::Isometry3d sole = poses[static_cast<std::size_t>(model_.link_index(robot_.left_sole))];
    sole.translate(Vec<double, 3>(0.0, 0.0, robot_.contact_plane_offset));
    return sole.inverse().translation().z();
  }
  // True if a posture exists with the left foot on the ground and the other foot and the CoM at
  // these places, (forward, away) relative to it.
  bool reaches(const robots::Point2& other_foot, const robots::Point2& com) const {
    PostureWish wish;
    wish.stance = robots::Side::left;
    wish.other_foot = {other_foot[0], -other_foot[1], 0.0};
    wish.com = {com[0], -com[1]};
    wish.trunk_height = 0.5 * (1.0 + lowest_trunk) * trunk_;
    wish.clearance = 2.0 * between_limbs;
    const FoundPosture found = find_posture(model_, robot_, body_, wish, start_);
    if (!found.is_found() || found.clearance <= between_limbs) return false;
    return std::abs(trunk_height(found.joints) - wish.trunk_height) <
           0.5 * (1.0 - lowest_trunk) * trunk_;
  }

  robots::Point2 farthest_along(const robots::Point2& from, const robots::Point2& along,
                                const std::function<bool(const robots::Point2&)>& reaches) const {
    double reached = 0.0, missed = farthest * trunk_;
    for (int i = 0; i < halvings; ++i) {
      const double middle = 0.5 * (reached + missed);
      (reaches(from + middle * along) ? reached : missed) = middle;
    }
    return from + reached * along;
  }

  const robots::UrdfModel& model_;
  const robots::RobotDescription& robot_;
  robots::FloatingRobot body_;
  robots::Posture start_;
  double apart_ = 0.0, trunk_ = 0.0;  // m
};

// FNV-1a hash of all inputs of the search.
class Fingerprint {
 public:
  void add(std::string_view text) {
    for (const char c : text) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  void add(double number) { add(fmt::format("{:.17g} ", number)); }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

std::uint64_t fingerprint(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                          const robots::FloatingRobot& body) {
  Fingerprint print;
  print.add("reach 2 ");  // version of the method; a new version discards old results
  std::ifstream file(model.source(), std::ios::binary);
  print.add(std::string(std::istreambuf_iterator<char>(file), {}));
  print.add(robot.left_sole);
  print.add(robot.right_sole);
  print.add(robot.contact_plane_offset);
  for (const robots::RobotDescription::Joint& joint : robot.joints) {
    print.add(joint.name);
    if (joint.position) {
      print.add(joint.position->lower);
      print.add(joint.position->upper);
    }
  }
  for (const robots::StandingPosture& posture : robot.postures)
    for (const auto& [joint, q] : posture.joints) {
      print.add(joint);
      print.add(q);
    }
  // Limb shapes, from the description or from meshes that may be installed later.
  for (const robots::FloatingRobot::Body& limb : body.bodies)
    for (const robots::RobotDescription::LinkCapsule& c : limb.capsules) {
      for (const Vec<double, 3>& end : {c.capsule.from, c.capsule.to})
        for (const double coordinate : end) print.add(coordinate);
      print.add(c.capsule.radius);
    }
  for (const auto& [one, other] : body.apart) {
    print.add(one);
    print.add(other);
  }
  return print.value();
}

bool read(const std::filesystem::path& path, FootReach& reach) {
  std::ifstream file(path);
  for (std::vector<robots::Point2>* corners : {&reach.from_foot, &reach.from_com}) {
    corners->resize(reach_directions);
    for (robots::Point2& corner : *corners)
      if (!(file >> corner[0] >> corner[1]) || !corner.allFinite()) return false;
  }
  return true;
}

// Rounds to the digits of the file. The run that searches and runs that read the file then agree
// bit for bit.
void round_to_file(FootReach& reach) {
  constexpr double per_metre = 1e6;
  for (std::vector<robots::Point2>* corners : {&reach.from_foot, &reach.from_com})
    for (robots::Point2& corner : *corners)
      corner = (corner * per_metre).array().round() / per_metre;
}

// Writes the file atomically, also if several processes write it at the same time.
void write(const std::filesystem::path& path, const FootReach& reach) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  std::string text;
  for (const std::vector<robots::Point2>* corners : {&reach.from_foot, &reach.from_com})
    for (const robots::Point2& corner : *corners)
      text += fmt::format("{:.6f} {:.6f}\n", corner[0], corner[1]);
  write_atomically(path, text, error);
}

}  // namespace

std::optional<FootReach> find_foot_reach(const robots::UrdfModel& model,
                                         const robots::RobotDescription& robot) {
  return Search(model, robot, body_with_limbs(model, robot)).run();
}

std::optional<FootReach> cached_foot_reach(const robots::UrdfModel& model,
                                           const robots::RobotDescription& robot,
                                           const std::filesystem::path& folder) {
  robots::FloatingRobot body = body_with_limbs(model, robot);
  const std::filesystem::path path =
      folder / fmt::format("reach-{:016x}.txt", fingerprint(model, robot, body));
  FootReach cached;
  if (read(path, cached)) return cached;
  std::optional<FootReach> found = Search(model, robot, std::move(body)).run();
  if (found) {
    round_to_file(*found);
    write(path, *found);
  }
  return found;
}

}  // namespace saltus::survey
