#include "saltus/robots/walking/reactive_steps.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/robots/model/capture_point.hpp"

namespace saltus::robots::walking {
namespace {

// Interval between the swing times that are compared, s.
constexpr double time_step = 0.05;
// A swing time has reserve if the place is within this fraction of the reach. The rest is kept for
// the remaining push.
constexpr double comfortable = 0.5;
// Distance by which the capture point must have left the support polygon, m. It exceeds the effect
// of sensor noise.
constexpr double trigger_margin = 0.003;
// Measurements settle within this time after a landing, s. No step starts earlier.
constexpr double after_landing = 0.03;
// Tie break between two feet: violation in m per m of swing distance.
constexpr double way_weight = 0.02;

using Corners = Mat<double, 8, 2>;

Corners corners(const SoleFrame& left, const FootRectangle& left_foot, const SoleFrame& right,
                const FootRectangle& right_foot) {
  Corners points;
  points << foot_corners(left, left_foot), foot_corners(right, right_foot);
  return points;
}

Vec<double, 2> nearest_on_segment(const Vec<double, 2>& a, const Vec<double, 2>& b,
                                  const Vec<double, 2>& x) {
  const Vec<double, 2> along = b - a;
  const double length = along.squaredNorm();
  const double s = length > 0.0 ? std::clamp(along.dot(x - a) / length, 0.0, 1.0) : 0.0;
  return a + s * along;
}

// Nearest point of the convex hull, without computing the hull: an edge has all other corners on
// its left.
Vec<double, 2> nearest_in_hull(const Corners& points, const Vec<double, 2>& x) {
  Vec<double, 2> nearest = x;
  double least = infinity;
  bool outside = false;
  for (int i = 0; i < points.rows(); ++i)
    for (int j = 0; j < points.rows(); ++j) {
      if (i == j) continue;
      const Vec<double, 2> a = points.row(i).transpose(), b = points.row(j).transpose();
      const Vec<double, 2> normal(b[1] - a[1], a[0] - b[0]);  // to the right, outwards
      if (((points * normal).array() > a.dot(normal) + 1e-12).any()) continue;
      if (normal.dot(x - a) <= 0.0) continue;
      outside = true;
      const Vec<double, 2> point = nearest_on_segment(a, b, x);
      if ((point - x).norm() >= least) continue;
      least = (point - x).norm();
      nearest = point;
    }
  return outside ? nearest : x;
}

Vec<double, 2> in_sole(const SoleFrame& sole, const Vec<double, 2>& point) {
  const Vec<double, 3> offset(point[0] - sole.position[0], point[1] - sole.position[1], 0.0);
  return (sole.rotation.transpose() * offset).head<2>();
}

Vec<double, 3> from_sole(const SoleFrame& sole, double forward, double left) {
  Vec<double, 3> point = sole.position + sole.rotation * Vec<double, 3>(forward, left, 0.0);
  point[2] = sole.position[2];
  return point;
}

Vec<double, 2> nearest_of_sole(const SoleFrame& sole, const FootRectangle& foot,
                               const Vec<double, 2>& x) {
  const Vec<double, 2> local = in_sole(sole, x);
  return from_sole(sole, std::clamp(local[0], foot.x.lower, foot.x.upper),
                   std::clamp(local[1], foot.y.lower, foot.y.upper))
      .head<2>();
}

}  // namespace

ReactiveSteps::ReactiveSteps(const Step& options, const Scene& scene)
    : options_(options),
      lead_(options.decision_lead.value_or(options.shortest)),
      left_foot_(scene.rectangle(Side::left)),
      right_foot_(scene.rectangle(Side::right)) {}

const StepPlan& ReactiveSteps::plan(const StepSituation& now) {
  const Vec<double, 2> xi = capture_point_at_rest(now.gamma.head<3>(), now.gamma.segment<3>(3),
                                                  now.gamma.tail<3>(), now.mass, now.omega);
  plan_.alternatives = 0;
  plan_.chosen = -1;
  if (now.left.swings() || now.right.swings()) {
    follow(now, xi);
    return plan_;
  }
  if (plan_.count > 0) landed_at_ = now.time;
  plan_.count = 0;
  if (options_.allowed && now.time >= landed_at_ + after_landing) consider(now, xi);
  return plan_;
}

ReactiveSteps::Landing ReactiveSteps::landing(const StepSituation& now, const Vec<double, 2>& xi,
                                              Side swing, double lift_off, double landing) const {
  const Side stance = other(swing);
  const SoleFrame& sole = now.foot(stance).sole;
  const double away = stance == Side::left ? -1.0 : 1.0;
  // Support by both feet, if they stand, until lift-off; then by the stance sole.
  Vec<double, 2> later = xi;
  if (now.foot(swing).stands) {
    const Vec<double, 2> on_both =
        nearest_in_hull(corners(now.left.sole, left_foot_, now.right.sole, right_foot_), xi);
    later = propagate_capture_point<double, 2>(later, on_both, now.omega,
                                               std::max(0.0, lift_off - now.time));
  }
  later = propagate_capture_point<double, 2>(later, nearest_of_sole(sole, rectangle(stance), later),
                                             now.omega,
                                             std::max(0.0, landing - std::max(now.time, lift_off)));
  const Vec<double, 2> wanted = in_sole(sole, later);
  Landing result;
  result.time = landing;
  result.place =
      from_sole(sole, std::clamp(wanted[0], -options_.forward_max, options_.forward_max),
                away * std::clamp(away * wanted[1], options_.lateral_min, options_.lateral_max));
  const SoleFrame landed{result.place, sole.rotation};
  const Corners hull = stance == Side::left ? corners(sole, left_foot_, landed, right_foot_)
                                            : corners(landed, left_foot_, sole, right_foot_);
  result.missed = (later - nearest_in_hull(hull, later)).norm();
  result.comfortable =
      std::abs(wanted[0]) <= comfortable * options_.forward_max &&
      away * wanted[1] <=
          options_.lateral_min + comfortable * (options_.lateral_max - options_.lateral_min);
  return result;
}

// The longest time that catches the capture point with reserve, else the one with the smallest
// miss, else the shortest.
ReactiveSteps::Landing ReactiveSteps::best_landing(const StepSituation& now,
                                                   const Vec<double, 2>& xi, Side swing,
                                                   double lift_off, double earliest,
                                                   double latest) const {
  Landing best;
  for (double time = latest;; time -= time_step) {
    time = std::max(time, earliest);
    const Landing found = landing(now, xi, swing, lift_off, time);
    if (found.missed <= best.missed) best = found;
    if ((best.missed <= 0.0 && best.comfortable) || time <= earliest) return best;
  }
}

void ReactiveSteps::follow(const StepSituation& now, const Vec<double, 2>& xi) {
  if (plan_.count == 0) return;
  const StepPlan::Step& step = plan_.steps[0];
  if (now.time > step.landing - lead_ + 1e-6) return;
  const double earliest = std::max(step.lift_off + options_.shortest, now.time + lead_);
  set_step(step.foot, step.lift_off,
           best_landing(now, xi, step.foot, step.lift_off, std::min(earliest, step.landing),
                        step.landing));
}

void ReactiveSteps::consider(const StepSituation& now, const Vec<double, 2>& xi) {
  const bool both = now.left.stands && now.right.stands;
  const Side stance = now.left.stands ? Side::left : Side::right;
  const Corners ground = corners(now.left.sole, left_foot_, now.right.sole, right_foot_);
  const Vec<double, 2> nearest =
      both ? nearest_in_hull(ground, xi)
           : nearest_of_sole(now.foot(stance).sole, rectangle(stance), xi);
  const double outside = (xi - nearest).norm();
  if (outside <= trigger_margin) return;
  const double lift_off = now.time;
  double least = infinity;
  Landing chosen;
  Side foot = Side::right;
  for (const Side swing : {Side::left, Side::right}) {
    if (!now.foot(other(swing)).stands) continue;
    const Landing found = best_landing(now, xi, swing, lift_off, lift_off + options_.shortest,
                                       lift_off + std::max(options_.shortest, options_.duration));
    // Distance that would remain by then without a step, with the centre of pressure at the edge.
    const double standing = outside * std::exp(now.omega * (found.time - now.time));
    const double way = (found.place - now.foot(swing).sole.position).head<2>().norm();
    const bool helps =
        options_.decide == Step::Decision::always || found.missed < helpful * standing;
    const double cost = helps ? found.missed + way_weight * way : infinity;
    plan_.alternative[plan_.alternatives++] = {1, swing, cost, found.place, found.time};
    if (cost >= least) continue;
    least = cost;
    chosen = found;
    foot = swing;
    plan_.chosen = plan_.alternatives - 1;
  }
  plan_.alternative[plan_.alternatives] = {
      0, foot, outside * std::exp(now.omega * options_.duration), Vec<double, 3>::Zero(), infinity};
  if (plan_.chosen < 0) plan_.chosen = plan_.alternatives;
  ++plan_.alternatives;
  if (least < infinity) set_step(foot, lift_off, chosen);
}

void ReactiveSteps::set_step(Side foot, double lift_off, const Landing& landing) {
  plan_.count = 1;
  plan_.steps[0] = {foot, lift_off, landing.time, 0.5 * (lift_off + landing.time), landing.place};
}

std::unique_ptr<StepPlanner> make_reactive_steps(const Step& options, const Scene& scene) {
  return std::make_unique<ReactiveSteps>(options, scene);
}

}  // namespace saltus::robots::walking
