#include "problems/push_recovery/step_choice.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::push_recovery {
namespace {

// A foot returns to its usual place if the robot has been at rest for this time (s), slower than
// this (m/s), and the foot is farther away than this (m).
constexpr double rest_before = 1.0, rest_speed = 0.05, off_place = 0.02;
// Penalised violations below this value are due to the solver's rounding and its last step, m.
constexpr double hardly = 2e-3;
// Longest time between landings while walking, s.
constexpr double slowest_pace = 1.0;
// Latest lift-off in the cost, s, and time to shift the weight when starting from rest, s.
constexpr double latest = 0.3, first_shift = 0.3;
// Largest share of the standing robot's violation that a step may leave.
constexpr double helpful = 0.1;
// Smallest half size of the supported part of a sole in plans, m.
constexpr double smallest_half = 1e-3;

bool is_known(const StepSituation& now) {
  return std::isfinite(now.time) && std::isfinite(now.omega) && now.omega > 0.0 && now.mass > 0.0 &&
         now.gamma.allFinite() && now.left.sole.position.allFinite() &&
         now.right.sole.position.allFinite();
}

}  // namespace

// --- frames ------------------------------------------------------------------------------------

Vec<double, 2> StepChoice::Frame::into(const Vec<double, 3>& point) const {
  return turned((point - origin).head<2>());
}
Vec<double, 2> StepChoice::Frame::turned(const Vec<double, 2>& vector) const {
  return {forward.dot(vector), towards.dot(vector)};
}
Vec<double, 3> StepChoice::Frame::out(const Vec<double, 2>& point) const {
  const Vec<double, 2> along = forward * point[0] + towards * point[1];
  return origin + Vec<double, 3>(along[0], along[1], 0.0);
}

Vec<double, 3> StepChoice::centre(const StepSituation& now, robots::Side side) const {
  const robots::SoleFrame& sole = now.foot(side).sole;
  const Vec<double, 2>& c = centres_.of(side);
  return sole.position + sole.rotation * Vec<double, 3>(c[0], c[1], 0.0);
}

// Support of a sole as in StepNow, in the frame on the stance foot. It keeps a smallest size.
Vec<double, 4> StepChoice::support(const StepSituation& now, robots::Side side,
                                   robots::Side stance) const {
  const std::optional<robots::FootRectangle>& area = now.foot(side).support;
  if (!area) return Vec<double, 4>::Zero();
  const Vec<double, 2> lower(area->x.lower, area->y.lower), upper(area->x.upper, area->y.upper);
  Vec<double, 2> off = 0.5 * (lower + upper) - centres_.of(side);
  if (stance == robots::Side::left) off[1] = -off[1];
  const Vec<double, 2> most = model_.sole.array() - smallest_half;
  const Vec<double, 2> lost = model_.standing_sole - 0.5 * (upper - lower);
  Vec<double, 4> result;
  result << off, lost.cwiseMin(most).cwiseMax(0.0);
  return result;
}

StepChoice::Frame StepChoice::frame_on(const StepSituation& now, robots::Side stance) const {
  Frame frame;
  frame.origin = centre(now, stance);
  const Vec<double, 2> forward = now.foot(stance).sole.rotation.col(0).head<2>();
  // except for a foot that is not upright
  if (forward.norm() > 0.5) frame.forward = forward.normalized();
  const double side = stance == robots::Side::left ? -1.0 : 1.0;
  frame.towards = side * Vec<double, 2>(-frame.forward[1], frame.forward[0]);
  return frame;
}

// --- the choice --------------------------------------------------------------------------------

StepChoice::StepChoice(const StepModel& model, const StepChoiceSettings& settings,
                       const SoleCentres& centres, const Vec<double, 2>& stride)
    : model_(model),
      settings_(settings),
      centres_(centres),
      stride_(stride),
      pace_(model.usual_swing + model.usual_support) {
  const int most = std::clamp(settings.most_steps, 0, most_planned_steps);
  candidates_.push_back({StepProgram(model, 0, false), 0, false});
  for (int k = 1; k <= most; ++k) {
    candidates_.push_back({StepProgram(model, k, false), k, false});
    for (const robots::Side first : {robots::Side::left, robots::Side::right})
      candidates_.push_back({StepProgram(model, k, true), k, true, first});
  }
}

void StepChoice::restart() {
  plan_ = {};
  incumbent_ = -1;
  for (Candidate& c : candidates_) c.solved_at = -infinity;
  unloading_since_ = swinging_since_ = at_rest_since_ = infinity;
  is_bringing_back_ = false;
  landed_last_ = -1;
  landed_at_ = -infinity;
  pace_ = model_.usual_swing + model_.usual_support;
}

bool StepChoice::is_fixed(const StepSituation& now) const {
  return plan_.count > 0 && !now.foot(plan_.steps[0].foot).stands && swinging_since_ < infinity &&
         now.time > plan_.steps[0].landing - settings_.lead;
}

const StepPlan& StepChoice::plan(const StepSituation& now) {
  const WallClock::time_point begin = WallClock::now();
  iterations_ = 0;
  plan_.alternatives = 0;
  plan_.chosen = -1;
  asked_ = nullptr;
  if (!is_known(now)) return plan_;
  const bool two_feet = now.left.stands && now.right.stands;
  velocity_ = settings_.velocity;
  // The last swing of the walk ends as it began. Otherwise its landing would be moved ahead.
  const bool is_last_swing = !two_feet && swinging_since_ < settings_.walk_until;
  if (now.time >= settings_.walk_until && !is_last_swing) velocity_.setZero();
  if (!now.left.stands && !now.right.stands) return plan_;
  const robots::Side in_air =
      now.left.stands ? robots::Side::right : robots::Side::left;  // if one foot stands
  if (!two_feet || now.gamma.segment<3>(3).norm() > rest_speed)
    at_rest_since_ = infinity;
  else
    at_rest_since_ = std::min(at_rest_since_, now.time);
  if (two_feet) {
    if (swinging_since_ < infinity && plan_.count > 0) {
      landed_last_ = static_cast<int>(plan_.steps[0].foot);
      if (std::isfinite(landed_at_))
        pace_ = std::clamp(now.time - landed_at_, model_.swing.lower, slowest_pace);
      landed_at_ = now.time;
    }
    swinging_since_ = infinity;
    if (incumbent_ >= 0 && !candidates_[incumbent_].from_two_feet) incumbent_ = -1;
  } else {
    unloading_since_ = infinity;
    if (now.foot(in_air).swings()) {
      if (swinging_since_ == infinity) lifted_from_ = centre(now, in_air);
      swinging_since_ = now.foot(in_air).lifted_off;
    }
    if (incumbent_ >= 0 && candidates_[incumbent_].from_two_feet) incumbent_ = -1;
  }
  if (is_fixed(now)) return plan_;
  if (settings_.bring_back && two_feet) is_bringing_back_ = is_off_its_place(now);
  const bool must_land = !two_feet && swinging_since_ < infinity;

  // The current candidate first, then the others with increasing number of steps.
  int best = -1;
  for (Candidate& c : candidates_) c.solution = nullptr;
  const auto consider = [&](int i) {
    Candidate& c = candidates_[i];
    if (c.solution != nullptr || (c.steps > 0 && c.from_two_feet != two_feet)) return;
    if (c.steps == 0 && (must_land || (walks() && best >= 0))) return;
    // Feet alternate. Otherwise the front foot could step onto its own place again and again.
    if (!velocity_.isZero(0.0) && two_feet && c.steps > 0 &&
        static_cast<int>(c.first) == landed_last_)
      return;
    if (!two_feet && c.first != in_air) {
      c.first = in_air;
      c.solved_at = -infinity;
    }
    const double so_far = best >= 0 ? candidates_[best].cost : infinity;
    // Skip a candidate whose steps alone cost at least as much as the best one so far.
    if (i != incumbent_ && settings_.price * c.steps >= so_far) return;
    if (best >= 0 && iterations_ >= settings_.budget) return;
    look_at(c, now);
    if (c.cost < so_far) best = i;
  };
  if (incumbent_ >= 0) consider(incumbent_);
  // While walking, standing is only used if nothing else was found.
  const int first = walks() ? 1 : 0;
  for (int i = first; i < static_cast<int>(candidates_.size()); ++i) consider(i);
  if (best < 0 || first == 0) consider(0);
  if (incumbent_ >= 0 && best >= 0 && candidates_[incumbent_].solution != nullptr &&
      candidates_[incumbent_].cost < candidates_[best].cost + settings_.hysteresis)
    best = incumbent_;
  // A standing robot would lose its balance by a step that leaves more of its violation. With arms
  // and trunk, the robot can do more than its pendulum model.
  const Candidate& standing = candidates_.front();
  if (best > 0 && !walks() && standing.solution != nullptr && standing.solution->is_solved &&
      candidates_[best].solution->missed > helpful * standing.solution->missed)
    best = 0;
  for (const Candidate& c : candidates_)
    if (c.solution != nullptr) note(c, now);
  if (best >= 0) {
    plan_.chosen = 0;
    for (int i = 0; i < best; ++i) plan_.chosen += candidates_[i].solution != nullptr;
    carry_out(candidates_[best], now);
    incumbent_ = best;
    asked_ = &candidates_[best];
  } else if (plan_.alternatives > 0) {  // keep the plan
    plan_.is_feasible = false;
    plan_.missed = infinity;
    asked_ = &*std::ranges::find_if(candidates_,
                                    [](const Candidate& c) { return c.solution != nullptr; });
  }
  seconds_ = seconds_since(begin);
  return plan_;
}

const MultipleShooting* StepChoice::shooting() const {
  return asked_ == nullptr ? nullptr : &asked_->program.shooting();
}

// True on two feet after a time at rest. A step in progress continues until the landing.
bool StepChoice::is_off_its_place(const StepSituation& now) const {
  if (is_bringing_back_ && unloading_since_ < infinity) return true;
  if (now.time < at_rest_since_ + rest_before) return false;
  const Vec<double, 2> apart =
      frame_on(now, robots::Side::left).into(centre(now, robots::Side::right));
  return (apart - stride_).norm() > off_place;
}

// The left foot if the robot stands on both feet.
robots::Side StepChoice::stance_of(const Candidate& c, const StepSituation& now) const {
  if (c.steps > 0) return other(c.first);
  return now.left.stands ? robots::Side::left : robots::Side::right;
}

// Displacements between two landings, by the time between the last two, in the frame on the stance
// foot. Lateral velocities move both feet, whichever side they are on. When the robot turns, step k
// is made in the direction halfway between the headings of feet k - 1 and k.
Vec<double, 2 * most_planned_steps> StepChoice::drift(robots::Side stance) const {
  const double side = stance == robots::Side::left ? -1.0 : 1.0;  // 1: y is to the left
  const Vec<double, 2> way = Vec<double, 2>(velocity_[0], side * velocity_[1]) * pace_;
  Vec<double, 2 * most_planned_steps> all;
  for (int k = 0; k < most_planned_steps; ++k) {
    all.segment<2>(2 * k) = way;
    if (velocity_[2] == 0.0) continue;
    const Vec<double, 2> stride(stride_[0], k % 2 == 0 ? stride_[1] : -stride_[1]);
    const Eigen::Rotation2Dd direction(side * (k + 0.5) * turn());
    all.segment<2>(2 * k) = direction * (way + stride) - stride;
  }
  return all;
}

void StepChoice::look_at(Candidate& c, const StepSituation& now) {
  const robots::Side stance = stance_of(c, now);
  const Frame frame = frame_on(now, stance);
  StepNow<double> data;
  data.omega = now.omega;
  data.stride = stride_;
  data.drift = drift(stance);
  const Vec<double, 2> other_foot = frame.into(centre(now, other(stance)));
  if (now.foot(other(stance)).stands) data.other = other_foot;
  data.swing = data.aim = other_foot;
  if (walks()) {
    data.stance_support = support(now, stance, stance);
    data.other_support =
        now.foot(other(stance)).stands ? support(now, other(stance), stance) : data.stance_support;
  }
  if (!now.foot(other(stance)).stands && swinging_since_ < infinity) {
    data.swing = frame.into(lifted_from_);
    data.aim = frame.into(aim_);
    data.swung = now.time - swinging_since_;
  }

  const double height = robots::standard_gravity / (now.omega * now.omega);
  const Vec<double, 3> com = now.gamma.head<3>(), velocity = now.gamma.segment<3>(3),
                       momentum = now.gamma.tail<3>();
  const Vec<double, 2> rest =
      robots::capture_point_at_rest(com, velocity, momentum, now.mass, now.omega);
  const Vec<double, 2> lent =
      Vec<double, 2>(-momentum[1], momentum[0]) / (now.mass * height * now.omega);
  // With a late start the unloading is shortened. Otherwise the lift-off would be postponed from
  // tick to tick.
  const double begun = std::min(unloading_since_, now.time);
  const double allowed = begun > landed_at_ + 2.0 * now.period ? first_shift : 0.0;
  const double clock = c.from_two_feet
                           ? std::min(now.time - begun - allowed, model_.usual_support + latest)
                           : data.swung;
  Vec<double, step_states> state;
  state << frame.into(com), frame.into({rest[0], rest[1], 0.0}), frame.turned(lent), clock;
  // Keep a distance from the bounds: the interior-point method fails if the state is on a bound.
  const double lent_most = 0.95 * model_.lent;
  for (int i = 4; i < 6; ++i) state[i] = std::clamp(state[i], -lent_most, lent_most);

  Bounds phase = between(0.01, model_.swing.upper);
  if (c.from_two_feet) {
    const double unloaded = std::isfinite(unloading_since_) ? now.time - unloading_since_ : 0.0;
    // Events due within half a tick begin now; no bound may prevent this.
    phase = between(std::max(0.2 * now.period, model_.unloading.lower - unloaded),
                    model_.unloading.upper);
  }
  const auto solve = [&](double elapsed, int most_iterations) {
    c.solution = &c.program.solve(data, state, phase, elapsed, most_iterations);
    iterations_ += c.solution->iterations;
    return c.solution->is_solved;
  };
  // Start from the previous plan if there is one and it is recent enough.
  const bool is_warm = now.time - c.solved_at < 1.5 * now.period;
  if (!is_warm || !solve(now.time - c.solved_at, settings_.iterations)) {
    c.program.restart();
    solve(0.0, settings_.first_iterations);
  }
  c.solved_at = c.solution->is_solved ? now.time : -infinity;
  c.cost = c.solution->is_solved ? c.solution->cost + settings_.price * c.steps : infinity;
}

void StepChoice::note(const Candidate& c, const StepSituation& now) {
  if (plan_.alternatives >= StepPlan::most_alternatives) return;
  robots::walking::StepPlan::Alternative& a = plan_.alternative[plan_.alternatives++];
  a = {};
  a.steps = c.steps;
  a.first = c.first;
  a.cost = c.cost;
  if (c.steps == 0 || !c.solution->is_solved) return;
  const Frame frame = frame_on(now, other(c.first));
  a.place = in_world(frame, c.first, c.solution->place[0], turn());
  a.landing = now.time + c.solution->landing[0];
}

Vec<double, 3> StepChoice::in_world(const Frame& frame, robots::Side foot,
                                    const Vec<double, 2>& place, double turn) const {
  const Vec<double, 2>& c = centres_.of(foot);
  Vec<double, 2> forward = frame.forward;
  if (turn != 0.0) forward = Eigen::Rotation2Dd(turn) * forward;
  const Vec<double, 2> left(-forward[1], forward[0]);
  const Vec<double, 2> offset = forward * c[0] + left * c[1];
  return frame.out(place) - Vec<double, 3>(offset[0], offset[1], 0.0);
}

void StepChoice::carry_out(const Candidate& c, const StepSituation& now) {
  plan_.missed = c.solution->missed;
  plan_.is_feasible = plan_.missed < hardly;
  const bool is_new = plan_.count == 0 || plan_.steps[0].foot != c.first;
  plan_.count = c.steps;
  const Frame frame = frame_on(now, stance_of(c, now));
  pressure_ = frame.out(c.solution->pressure).head<2>();
  lent_rate_ = frame.forward * c.solution->lent_rate[0] + frame.towards * c.solution->lent_rate[1];
  plan_.motion.samples = 0;
  if (walks()) {  // the CoM must move before the foot lifts off
    c.program.sample(plan_.motion);
    plan_.motion.begin = now.time;
    for (int i = 0; i < plan_.motion.samples; ++i)
      for (Vec<double, 2>* point : {&plan_.motion.com[i], &plan_.motion.capture_point[i]})
        *point = frame.out(*point).head<2>();
  }
  if (c.steps == 0) {
    unloading_since_ = infinity;
    return;
  }
  robots::Side foot = c.first;
  for (int k = 0; k < c.steps; ++k, foot = other(foot)) {
    robots::walking::StepPlan::Step& step = plan_.steps[k];
    step.foot = foot;
    step.lift_off = now.time + c.solution->lift_off[k];
    step.landing = now.time + c.solution->landing[k];
    const double turned = (k + 1) * turn();
    step.place = in_world(frame, foot, c.solution->place[k], turned);
    if (settings_.velocity[2] != 0.0)
      step.heading = std::atan2(frame.forward[1], frame.forward[0]) + turned;
    const double begin = k == 0 && swinging_since_ < infinity ? swinging_since_ : step.lift_off;
    step.earliest_landing = 0.5 * (begin + step.landing);
  }
  if (c.from_two_feet && (is_new || unloading_since_ == infinity)) unloading_since_ = now.time;
  if (!c.from_two_feet && swinging_since_ == infinity) {
    swinging_since_ = now.time;
    lifted_from_ = centre(now, c.first);
  }
  aim_ = frame.out(c.solution->place[0]);
}

}  // namespace saltus::push_recovery
