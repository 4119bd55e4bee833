#include "problems/push_recovery/step_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "saltus/app/settings.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::push_recovery {
namespace {

// Largest yaw of the feet relative to each other while the robot turns, rad.
constexpr double largest_turn = 0.2;

Vec<double, 2> centre_of(const robots::FootRectangle& foot) {
  return {0.5 * (foot.x.lower + foot.x.upper), 0.5 * (foot.y.lower + foot.y.upper)};
}

robots::SupportPolygon::HalfPlanes half_planes(const std::vector<robots::Point2>& corners,
                                               const Vec<double, 2>& offset) {
  Eigen::Matrix<double, Eigen::Dynamic, 2> points(static_cast<int>(corners.size()), 2);
  for (std::size_t i = 0; i < corners.size(); ++i)
    points.row(static_cast<int>(i)) = (corners[i] + offset).transpose();
  return robots::SupportPolygon::hull(points).half_planes(reach_rows);
}

// Removes the sides towards the other leg, where the feet limit the motion and not the reach from
// the CoM. They are replaced by copies of another side.
robots::SupportPolygon::HalfPlanes outer(robots::SupportPolygon::HalfPlanes sides) {
  int farthest = 0;
  for (int i = 0; i < sides.rows(); ++i)
    if (sides.A(i, 1) > sides.A(farthest, 1)) farthest = i;
  for (int i = 0; i < sides.rows(); ++i)
    if (sides.A(i, 1) < -0.1) {
      sides.A.row(i) = sides.A.row(farthest);
      sides.b[i] = sides.b[farthest];
    }
  return sides;
}

}  // namespace

survey::FootReach reach_of(const robots::walking::Step& step) {
  const double x = step.forward_max, y0 = step.lateral_min, y1 = step.lateral_max;
  return {{{-x, y0}, {x, y0}, {x, y1}, {-x, y1}}, {{-x, -y1}, {x, -y1}, {x, y1}, {-x, y1}}};
}

void declare_settings(Settings& s, StepPlanning& p, robots::walking::Step& step) {
  using robots::walking::Step;
  s.choice(
      "step.planner", {"push_formula", "icp_formula", "reactive", "ocp"},
      [&step]() -> std::optional<std::size_t> {
        if (step.planner == Step::Planner::formula) return step.known ? 0 : 1;
        return step.planner == Step::Planner::reactive ? 2 : 3;
      },
      [&step](std::size_t i) {
        constexpr Step::Planner planners[] = {Step::Planner::formula, Step::Planner::formula,
                                              Step::Planner::reactive, Step::Planner::ocp};
        step.planner = planners[i];
        step.known = i == 0;
        step.trigger = step.known ? Step::Trigger::push : Step::Trigger::icp;
      },
      "push_formula: one step of the foot in the air, step.duration after the start of the push, "
      "which it knows; icp_formula: the same after the capture point leaves the sole; reactive: "
      "any number of steps of either foot, whenever the capture point leaves the support polygon; "
      "ocp: steps by optimal control. No planner uses other information on the push");
  s.integer("step.most", p.most_steps, "", "maximum number of steps planned ahead (ocp)",
            between(0, most_planned_steps));
  s.number("step.shortest_s", p.shortest, "s", "minimum duration of a swing (reactive, ocp)",
           between(0.05, 10.0));
  s.number("step.usual_s", p.usual, "s", "duration of a swing without urgency (ocp)",
           between(0.05, 10.0));
  s.number("step.longest_s", p.longest, "s", "maximum duration of a swing (ocp)",
           between(0.05, 10.0));
  s.number("step.foot_speed", p.foot_speed, "m/s", "maximum speed of the swing foot (ocp)",
           above(0.0));
  s.number("step.double_support_s", p.double_support, "s", "minimum time between two steps (ocp)",
           between(0.01, 10.0));
  s.number("step.sole_margin", p.sole_margin, "m",
           "width of the border of the soles that plans do not use (ocp)", at_least(0.0));
  s.number("step.momentum", p.momentum, "Nms", "maximum angular momentum in plans (ocp)",
           at_least(0.0));
  s.number("step.torque", p.torque, "Nm", "maximum rate of the angular momentum in plans (ocp)",
           at_least(0.0));
  s.choice<bool>("step.reach", p.robot_reach, {{"robot", true}, {"settings", false}},
                 "reachable places of the feet (ocp): from the robot's kinematics, if there is a "
                 "URDF, or from step.forward_max, step.lateral_min and step.lateral_max");
  s.number("step.lead_s", p.lead, "s",
           "time and place of a landing are fixed this long before it (ocp)", at_least(0.0));
  s.vector("step.weights", p.weights, "",
           "weights of rest at the border of the soles, of 0.1 s and 0.1 m of deviation from the "
           "usual time and place, and of one second of pressure at the border of the sole (ocp)",
           at_least(0.0));
  s.removed("step.price", "2", "0.4");
  s.removed("step.hysteresis", "0.5", "0.4");
  s.flag("step.bring_back", p.bring_back,
         "one second after the robot has come to rest, it steps back to the usual distance of its "
         "feet (ocp)");
  s.rule({"step.bring_back", "step.planner"}, [&p, &step] {
    return p.bring_back && step.planner != Step::Planner::ocp
               ? "step.bring_back needs step.planner=ocp: the other planners step only after pushes"
               : "";
  });
  s.vector(
      "walk.velocity", p.velocity, "m/s",
      "velocity of a walking robot: forward, to the left, and yaw rate (rad/s, to the left) (ocp)");
  s.number("walk.duration", p.walk_duration, "s",
           "duration of the walk; the robot stands afterwards", between(0.0, 3600.0));
  s.number("walk.swing_s", p.walking_swing, "s",
           "usual duration of a swing while walking, from step.shortest_s to step.longest_s",
           between(0.05, 10.0));
  s.number("walk.double_support_s", p.usual_support, "s", "usual time on both feet while walking",
           between(0.01, 10.0));
  for (const char* key : {"step.shortest", "step.usual", "step.longest", "step.lead",
                          "step.double_support", "walk.double_support"})
    s.renamed(key, std::string(key) + "_s", "0.4");
  s.rule({"walk.double_support_s", "step.double_support_s"}, [&p] {
    return p.usual_support >= p.double_support
               ? ""
               : fmt::format(
                     "walk.double_support_s ({}) is shorter than step.double_support_s ({}), the "
                     "minimum time on both feet; increase it",
                     p.usual_support, p.double_support);
  });
  s.rule({"walk.velocity", "walk.swing_s", "walk.double_support_s", "step.foot_speed"},
         [&p]() -> std::string {
           // A foot swings over two steps; its peak speed is 15/8 of the mean speed.
           const double speed = 15.0 / 8.0 * 2.0 * p.velocity.head<2>().norm() *
                                (p.walking_swing + p.usual_support) / p.walking_swing;
           if (speed <= p.foot_speed) return "";
           return fmt::format(
               "walk.velocity requires a swing foot at {:.2f} m/s, but step.foot_speed is {}; "
               "reduce walk.velocity or increase step.foot_speed",
               speed, p.foot_speed);
         });
  s.rule({"walk.velocity", "walk.swing_s", "walk.double_support_s"}, [&p]() -> std::string {
    const double turn = std::abs(p.velocity[2]) * (p.walking_swing + p.usual_support);
    return turn <= largest_turn
               ? ""
               : fmt::format(
                     "the yaw rate of walk.velocity turns the feet by {:.2f} rad against each "
                     "other, but the planner takes them for parallel, which is accurate up to {} "
                     "rad; reduce walk.velocity, walk.swing_s or walk.double_support_s",
                     turn, largest_turn);
  });
  s.rule({"walk.velocity", "step.planner"}, [&p, &step]() -> std::string {
    if (p.walks() && step.planner != Step::Planner::ocp)
      return "walk.velocity needs step.planner=ocp: the other planners do not walk";
    return "";
  });
  const auto rule_of_swing = [&s, &p, &step](const char* key, const double& swing, bool walking) {
    s.rule({"step.planner", "step.shortest_s", key, "step.longest_s"},
           [key, walking, &swing, &p, &step]() -> std::string {
             if (step.planner != Step::Planner::ocp || (walking && !p.walks()) ||
                 (p.shortest <= swing && swing <= p.longest))
               return "";
             return fmt::format(
                 "{} ({}) must lie between step.shortest_s ({}) and step.longest_s ({}); change "
                 "one of them",
                 key, swing, p.shortest, p.longest);
           });
  };
  rule_of_swing("step.usual_s", p.usual, false);
  rule_of_swing("walk.swing_s", p.walking_swing, true);
  s.rule({"step.planner", "step.shortest_s", "step.duration"}, [&p, &step] {
    return step.planner != Step::Planner::reactive || p.shortest <= step.duration
               ? ""
               : fmt::format(
                     "step.shortest_s ({}) exceeds step.duration ({}), the maximum duration of a "
                     "swing with step.planner=reactive; change one of them",
                     p.shortest, step.duration);
  });
  s.rule({"step.shortest_s", "step.longest_s"}, [&p] {
    return p.shortest < p.longest ? ""
                                  : fmt::format(
                                        "step.shortest_s ({}) must be below step.longest_s "
                                        "({})",
                                        p.shortest, p.longest);
  });
}

namespace {

// The reach of legs with unlimited joints cannot be searched.
void check_leg_limits(const robots::UrdfModel& model, const robots::RobotDescription& robot) {
  for (const std::string& sole : {robot.left_sole, robot.right_sole})
    for (int link = model.link_index(sole); link >= 0; link = model.links()[link].parent) {
      const robots::UrdfModel::Link& at = model.links()[link];
      if (at.name == robot.base) break;
      if (at.joint.motion == robots::UrdfModel::Joint::Motion::fixed) continue;
      const auto described = std::find_if(robot.joints.begin(), robot.joints.end(),
                                          [&](const robots::RobotDescription::Joint& joint) {
                                            return joint.name == at.joint.name;
                                          });
      if (described == robot.joints.end()) continue;  // frozen
      const Bounds limits = described->position.value_or(at.joint.position);
      if (std::isfinite(limits.lower) && std::isfinite(limits.upper)) continue;
      throw InputError(
          fmt::format("{}: joint \"{}\" of a leg has no position limits, which determine the reach "
                      "of the feet; add them, or set step.reach=settings",
                      robot.file, at.joint.name));
    }
}

void check_reach(const StepModel& model, const Vec<double, 2>& stride,
                 const Vec<double, 2>& velocity) {
  // Feet alternate: a lateral velocity moves one foot away from the other, and the next one towards
  // it.
  const double pace = model.usual_swing + model.usual_support;
  for (const double side : {-1.0, 1.0}) {
    const Vec<double, 2> place = stride + pace * Vec<double, 2>(velocity[0], side * velocity[1]);
    if ((model.reach.A * place - model.reach.b).maxCoeff() <= 0.0) continue;
    throw InputError(fmt::format(
        "walk.velocity requires steps of {:.2f} m forward and {:.2f} m sideways, which is beyond "
        "the reach of the legs; reduce walk.velocity, walk.swing_s or walk.double_support_s",
        place[0], place[1]));
  }
}

}  // namespace

std::optional<survey::FootReach> reach_of_robot(const StepPlanning& planning,
                                                const robots::walking::RobotChoice& choice,
                                                const robots::RobotDescription& robot) {
  if (!planning.robot_reach || robot.joints.empty()) return std::nullopt;
  const std::optional<std::filesystem::path> urdf = walking::urdf_of(choice);
  if (!urdf) return std::nullopt;
  const robots::UrdfModel model = robots::UrdfModel::read(*urdf);
  check_leg_limits(model, robot);
  return survey::cached_foot_reach(model, robot, cache_folder() / "reach");
}

std::unique_ptr<robots::walking::StepPlanner> make_step_choice(
    const StepPlanning& planning, const robots::walking::Step& step,
    const robots::walking::Scene& scene, double mass,
    const std::optional<survey::FootReach>& robot_reach) {
  const robots::FootRectangle& left =
      scene.side == robots::Side::left ? scene.stance_foot : scene.swing_foot;
  const robots::FootRectangle& right =
      scene.side == robots::Side::left ? scene.swing_foot : scene.stance_foot;
  const SoleCentres centres{centre_of(left), centre_of(right)};
  // From the origins of the soles to their centres, away from the other foot and to the foot's own
  // side.
  const Vec<double, 2> apart(0.0, centres.left[1] - centres.right[1]), own = centres.left;

  StepModel model;
  const Vec<double, 2> half = {0.5 * (left.x.upper - left.x.lower),
                               0.5 * (left.y.upper - left.y.lower)};
  model.sole = (half.array() - planning.sole_margin).cwiseMax(0.001);
  model.standing_sole = half;
  const double height = std::max(scene.com_height, 0.01);
  const double per_momentum = 1.0 / (mass * height * pendulum_frequency(height));
  model.lent = std::max(planning.momentum * per_momentum, 1e-6);
  model.lent_rate = std::max(planning.torque * per_momentum, 1e-6);
  if (!robot_reach && (step.forward_max <= 0.0 || step.lateral_min >= step.lateral_max))
    throw InputError(
        fmt::format("step.forward_max ({} m), step.lateral_min ({} m) and step.lateral_max ({} m) "
                    "leave no place for a foot; widen them, or use step.planner=icp_formula",
                    step.forward_max, step.lateral_min, step.lateral_max));
  const survey::FootReach reach = robot_reach ? *robot_reach : reach_of(step);
  model.reach = half_planes(reach.from_foot, apart);
  model.leg = outer(half_planes(reach.from_com, own));
  model.weights.rest = planning.weights[0];
  model.weights.duration = planning.weights[1];
  model.weights.stride = planning.weights[2];
  model.weights.pressure = planning.weights[3];
  model.swing_speed = planning.foot_speed;
  model.swing = between(planning.shortest, planning.longest);
  model.usual_swing = std::clamp(planning.walks() ? planning.walking_swing : planning.usual,
                                 planning.shortest, planning.longest);
  model.double_support = between(planning.double_support, planning.double_support + 0.5);
  model.usual_support = planning.usual_support;
  // A step due to a push lifts off in the same tick. Until then the wrenches would hold the CoM by
  // angular momentum, which exceeds its bound within 20 ms.
  if (planning.leads_the_way())
    model.weights.support = 1.0;
  else
    model.unloading.lower = 0.002;
  if (planning.walks()) check_reach(model, step.fixed_place + apart, planning.velocity.head<2>());

  StepChoiceSettings choice;
  choice.most_steps = step.allowed ? planning.most_steps : 0;
  choice.price = planning.price;
  choice.hysteresis = planning.hysteresis;
  choice.lead = planning.lead;
  choice.velocity = planning.velocity;
  choice.bring_back = planning.bring_back;
  choice.walk_until = planning.walk_duration;
  return std::make_unique<StepChoice>(model, choice, centres, step.fixed_place + apart);
}

}  // namespace saltus::push_recovery
