#include "problems/whole_body/tasks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace saltus::whole_body {
namespace {

constexpr double clearance = 0.03;  // of a foot in the air above the higher of both places, m
constexpr double touching = -1e-4;  // height of a sole that stands on the ground, m
constexpr double closest = 0.11, farthest = 0.35;  // of a chosen place from the other foot, m
constexpr int left = 0, right = 1;

robots::SoleFrame place(double x, double y, double z = 0.0) { return robots::flat_sole({x, y, z}); }

// Builds the modes of a task, foot by foot.
class Script {
 public:
  Script(const Body& body, std::string name, const robots::SoleFrame& left_sole,
         const robots::SoleFrame& right_sole)
      : body_(body), places_{left_sole, right_sole} {
    task_.name = std::move(name);
    VectorXd q = VectorXd::Zero(coordinates);
    q.tail<joints>() = body.nominal;
    // The base may face another way than the feet.
    const Mat<double, 3, 3> sole =
        robots::Kinematics<joints, double>(body.tree, q).rotation(body.soles[left]);
    q[5] = -std::atan2(sole(1, 0), sole(0, 0));
    const robots::Kinematics<joints, double> robot(body.tree, q);
    for (int foot = 0; foot < 2; ++foot)
      q.head<3>() += 0.5 * (places_[foot].position - robot.position(body.soles[foot]));
    task_.start = q_ = posture_on(body_, places_, middle(), q);
  }

  /// Moves a foot to another place. Until its toe is raised it stays behind x = `behind` (m).
  Script& step(int foot, const robots::SoleFrame& to, std::optional<double> behind = {}) {
    const int stance = 1 - foot;
    const robots::SoleFrame from = places_[foot];
    const double low = std::min(lowest(foot, from), lowest(foot, to)) + touching;
    const double high = std::max(highest(foot, from), highest(foot, to)) + clearance;
    stand("shift", 0.4 * middle() + 0.6 * centre(stance));
    robots::SoleFrame middle_place = to;
    middle_place.position = 0.5 * (from.position + to.position);
    if (behind) middle_place.position.head<2>() = from.position.head<2>();
    middle_place.position[2] = high + 0.01;
    swing("lift", foot, middle_place, stance);
    task_.modes.back().lowest = lowest(foot, from) + touching;
    task_.modes.back().above = high;
    task_.modes.back().behind = behind;
    swing("land", foot, to, stance);
    task_.modes.back().lowest = behind ? lowest(foot, to) + touching : low;
    return *this;
  }
  /// Moves a foot to a place that the plan chooses, near the expected one.
  Script& step_near(int foot, const robots::SoleFrame& expected) {
    step(foot, expected);
    chosen_ = foot;
    for (std::size_t i = task_.modes.size() - 2; i < task_.modes.size(); ++i)
      task_.modes[i].chooses = true;
    const double x = places_[1 - foot].position[0], y = places_[1 - foot].position[1];
    const Bounds away = between(closest, farthest);
    task_.choice = {expected.position.head<2>(), between(x - farthest, x + farthest),
                    foot == left ? between(y + away.lower, y + away.upper)
                                 : between(y - away.upper, y - away.lower)};
    return *this;
  }
  /// Both feet leave the ground and land in the same places.
  Script& hop() {
    stand("push", middle());
    Mode rise{"rise", {}, between(0.05, 0.25), 0.1, q_};
    rise.swings = {left, right};
    rise.lowest = touching;
    Mode fall = rise;
    rise.above = 0.01;
    fall.name = "fall";
    add(std::move(rise));
    add(std::move(fall));
    return *this;
  }
  /// Ends at rest above the middle of the feet.
  Task come_to_rest() {
    stand("settle", middle());
    task_.goal = middle();
    return task_;
  }
  /// Ends as it began, `stride` further (m).
  Task repeat(double stride) {
    task_.periodic = true;
    task_.stride = stride;
    return task_;
  }

 private:
  Vec<double, 2> centre(int foot) const {
    const robots::FootRectangle& sole = body_.feet[foot];
    const Vec<double, 3> in_sole(0.5 * (sole.x.lower + sole.x.upper),
                                 0.5 * (sole.y.lower + sole.y.upper), 0.0);
    return (places_[foot].position + places_[foot].rotation * in_sole).head<2>();
  }
  Vec<double, 2> middle() const { return 0.5 * (centre(left) + centre(right)); }
  static double height(const robots::SoleFrame& at, double x) {
    return at.position[2] + at.rotation(2, 0) * x;
  }
  double lowest(int foot, const robots::SoleFrame& at) const {
    return std::min(height(at, body_.feet[foot].x.lower), height(at, body_.feet[foot].x.upper));
  }
  double highest(int foot, const robots::SoleFrame& at) const {
    return std::max(height(at, body_.feet[foot].x.lower), height(at, body_.feet[foot].x.upper));
  }
  Contact contact(int foot) const {
    return {body_.soles[foot], places_[foot], body_.feet[foot], foot == chosen_};
  }

  void stand(const std::string& name, const Vec<double, 2>& com) {
    add({name,
         {contact(left), contact(right)},
         between(0.15, 1.0),
         0.5,
         posture_on(body_, places_, com, q_)});
  }
  void swing(const std::string& name, int foot, const robots::SoleFrame& to, int stance) {
    places_[foot] = to;
    Mode mode{name,
              {contact(stance)},
              between(0.15, 0.8),
              0.35,
              posture_on(body_, places_, centre(stance), q_)};
    mode.swings = {foot};
    add(std::move(mode));
  }
  void add(Mode mode) {
    q_ = mode.end;
    if (const auto same = std::ranges::count_if(
            task_.modes, [&](const Mode& m) { return m.name.starts_with(mode.name); });
        same > 0)
      mode.name += fmt::format(" {}", same + 1);
    task_.modes.push_back(std::move(mode));
  }

  const Body& body_;
  robots::SoleFrame places_[2];
  int chosen_ = -1;  // foot with a chosen place
  VectorXd q_;
  Task task_;
};

Task step(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width;
  Script script(body, "step", place(0.0, y), place(0.0, -y));
  const robots::SoleFrame to = place(s.length, s.foot == left ? y : -y);
  return (s.chosen ? script.step_near(s.foot, to) : script.step(s.foot, to)).come_to_rest();
}

// A step in place, or to a place that depends on a push.
Task recover(const Body& body, const Sizes& s) {
  Sizes sizes = s;
  sizes.length = 0.0;
  sizes.chosen = true;
  return step(body, sizes);
}

Task walk(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width, l = s.length;
  return Script(body, "walk", place(0.0, y), place(l, -y))
      .step(left, place(2.0 * l, y))
      .step(right, place(3.0 * l, -y))
      .repeat(2.0 * l);
}

Task step_up(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width, edge = edge_ahead(body);
  const double x = edge - body.feet[left].x.lower + 0.02;
  return Script(body, "step_up", place(0.0, y), place(0.0, -y))
      .step(right, place(x, -y, s.height), edge - 0.005)
      .step(left, place(x, y, s.height), edge - 0.005)
      .come_to_rest();
}

Task ramp(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width, angle = s.slope * std::numbers::pi / 180.0;
  const double edge = edge_ahead(body);
  const auto on_ramp = [&](double along, double side) {
    robots::SoleFrame sole = place(edge + along * std::cos(angle), side, along * std::sin(angle));
    sole.rotation = Eigen::AngleAxisd(-angle, Vec<double, 3>::UnitY()).toRotationMatrix();
    return sole;
  };
  const double first = 0.02 - body.feet[left].x.lower;
  return Script(body, "ramp", place(0.0, y), place(0.0, -y))
      .step(right, on_ramp(first, -y))
      .step(left, on_ramp(first, y))
      .come_to_rest();
}

Task turn(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width, angle = s.turn * std::numbers::pi / 180.0;
  const auto turned = [&](int foot, double by) {
    const double side = foot == left ? y : -y;
    return robots::flat_sole({-side * std::sin(by), side * std::cos(by), 0.0}, by);
  };
  return Script(body, "turn", place(0.0, y), place(0.0, -y))
      .step(left, turned(left, 0.5 * angle))
      .step(right, turned(right, 0.5 * angle))
      .step(left, turned(left, angle))
      .step(right, turned(right, angle))
      .come_to_rest();
}

Task hop(const Body& body, const Sizes& s) {
  const double y = 0.5 * s.width;
  return Script(body, "hop", place(0.0, y), place(0.0, -y)).hop().come_to_rest();
}

struct Named {
  std::string name;
  Task (*make)(const Body&, const Sizes&);
};
const std::vector<Named>& tasks() {
  static const std::vector<Named> all{{"step", step},       {"recover", recover}, {"walk", walk},
                                      {"step_up", step_up}, {"ramp", ramp},       {"turn", turn},
                                      {"hop", hop}};
  return all;
}

}  // namespace

double edge_ahead(const Body& body) { return body.feet[left].x.upper + 0.02; }

const std::vector<std::string>& task_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Named& entry : tasks()) all.push_back(entry.name);
    return all;
  }();
  return names;
}

Task task(const std::string& name, const Body& body, const Sizes& sizes) {
  for (const Named& entry : tasks())
    if (entry.name == name) return entry.make(body, sizes);
  throw DefinitionError(fmt::format("there is no task '{}'", name));
}

}  // namespace saltus::whole_body
