#include "saltus/robots/simulation/run_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::robots::walking {
namespace {

// Violations of soft constraints below this are not explained, m.
constexpr double negligible = 1e-3;

// Recomputes costs and residuals of the plan. Allocates.
LoopLog::Tick tick_record(const ControlTick& tick, RecedingHorizonController& controller) {
  const Solution plan = controller.report();
  LoopLog::Tick r;
  r.provenance = tick.provenance;
  r.status = plan.status;
  r.message = plan.message;
  r.iterations = plan.iterations;
  r.objective = plan.cost;
  r.kkt = plan.kkt.scaled();
  r.seconds = tick.seconds;
  r.preparation = tick.preparation;
  r.check = tick.check;
  for (const Solution::SoftViolation& use : plan.soft_violations)
    r.violation = std::max(r.violation, use.largest);
  return r;
}

}  // namespace

RunRecorder::RunRecorder(const BipedProblem& problem, const RobotDescription& robot,
                         BalancePlanner& planner, const Observer& observer)
    : problem_(problem), planner_(planner), observer_(observer), pushes_(problem.pushes()) {
  const Scene& scene = planner_.scene();
  for (const Side side : {Side::left, Side::right}) stood_at(side) = scene.sole(side).position;
  for (const Push& push : pushes_) push_end_ = std::max(push_end_, push.end());
  log_.robot = robot;
  note_ground(0.0);
}

bool RunRecorder::is_over(double t) {
  if (log_.stopped_early) return true;
  if (t > interrupted_at_ - same_instant) {
    log_.interrupted = true;
    stop(fmt::format("interrupted at {:.2f} s", log_.samples.back().time));
    return true;
  }
  return t > problem_.end_time(push_end_,
                               planner_.is_stepping() ? planner_.step().landing : infinity,
                               log_.last_touchdown()) -
                 same_instant;
}

void RunRecorder::note_tick(double t, const BalancePlanner::StepChange& change, bool has_landed,
                            double step_seconds, const TrueState& truth) {
  const StepPlan::Step& step = planner_.step();
  const StepPlan& plan = planner_.plan();
  if (plan.is_stepping() || plan.alternatives > 0)
    log_.step_plans.push_back({t, plan, step_seconds});
  if (change.has_lifted) stood_at(other(step.foot)) = truth.sole(other(step.foot));
  if (change.has_begun) {
    RunLog::Step record;
    record.foot = step.foot;
    record.lift_off = t;
    log_.steps.push_back(record);
    note_ground(t);
  }
  if (change.has_target) {
    log_.steps.back().due = step.landing;
    log_.steps.back().place = step.place;
  }
  if (has_landed) note_landing(t, truth);
  if (observer_ && !observer_(state(t, truth)))
    interrupted_at_ = t + problem_.settings().planner.step;
  tick_ = tick_record(planner_.tick(), planner_.planner().controller());
  keep_unmet(t);
}

std::vector<Pulse> RunRecorder::pushes() const {
  std::vector<Pulse> pulses(pushes_.begin(), pushes_.end());
  for (Pulse& pulse : pulses) pulse.direction.normalize();
  return pulses;
}

void RunRecorder::note_landing(double t, const TrueState& truth) {
  if (log_.touchdown == infinity) log_.touchdown = t;
  const Side foot = planner_.step().foot;
  stood_at(foot) = truth.sole(foot);
  log_.steps.back().touchdown = t;
  log_.steps.back().landed_at = stood_at(foot);
  note_ground(t);
}

void RunRecorder::note_loss(double t) {
  RunLog::Step& step = log_.steps.back();
  if (log_.touchdown == step.touchdown) log_.touchdown = infinity;
  step.touchdown = infinity;
  ++log_.lost_contacts;
  note_ground(t);
}

void RunRecorder::note_sample(double t, const Vec<double, 12>& applied, const Vec<double, 3>& push,
                              const TrueState& truth) {
  push_ = push;
  log_.samples.push_back({t, truth.gamma, capture_point_of(truth.gamma), applied, push,
                          planner_.stands(Side::left), planner_.stands(Side::right)});
}

void RunRecorder::note_failure(const std::string& failure) {
  log_.numerical_failure = true;
  stop(failure);
}

void RunRecorder::note_step(const std::string& failure, const TrueState& truth) {
  if (!failure.empty()) note_failure(failure);
  const std::string lost = problem_.lost(truth.time, truth.gamma, planner_.scene());
  if (!lost.empty()) stop(lost);
}

RunLog RunRecorder::finish(const Vec<double, 12>& applied, const TrueState& truth) {
  if (log_.samples.empty() || truth.time > log_.samples.back().time)
    note_sample(truth.time, applied, push_, truth);
  Scene& scene = log_.final_scene = scene_of_soles();
  scene.stance.position = stood_at(scene.side);
  if (!planner_.is_stepping()) scene.swing.position = stood_at(other(scene.side));
  log_.controller = planner_.planner().controller().solver_name();
  log_.unmet_decisions = unmet_.take();
  return std::move(log_);
}

// The planner's scene with the rectangles of the soles. The planner may know smaller areas, which
// the controller estimates; a verdict must not depend on them.
Scene RunRecorder::scene_of_soles() const {
  Scene scene = planner_.scene();
  scene.stance_foot = log_.robot.foot(scene.side);
  scene.swing_foot = log_.robot.foot(other(scene.side));
  return scene;
}

// Records the contacts with the ground if they have changed.
void RunRecorder::note_ground(double t) {
  const Scene scene = scene_of_soles();
  const auto placed = [&](Side side) {
    SoleFrame sole = scene.sole(side);
    sole.position = stood_at(side);
    return PlacedFoot{sole, scene.rectangle(side)};
  };
  const bool left = planner_.stands(Side::left), right = planner_.stands(Side::right);
  if (!log_.ground.empty() && log_.ground.back().left == left && log_.ground.back().right == right)
    return;
  const SupportPolygon polygon =
      left && right ? SupportPolygon::under({placed(Side::left), placed(Side::right)})
                    : SupportPolygon::under({placed(left ? Side::left : Side::right)});
  log_.ground.push_back({t, left, right, polygon});
}

void RunRecorder::keep_unmet(double t) {
  const StepPlan& plan = planner_.plan();
  if (const MultipleShooting* steps = planner_.step_planner().shooting();
      steps != nullptr && !plan.is_feasible)
    unmet_.keep("steps", t, plan.missed, *steps);
  if (tick_->status == SolveStatus::time_limit) return;
  const double missed = is_success(tick_->status) ? tick_->violation : infinity;
  if (missed > negligible)
    unmet_.keep("wrenches", t, missed, planner_.planner().controller().shooting());
}

// The base of the pendulum is on the ground at the height of the stance foot.
Vec<double, 2> RunRecorder::capture_point_of(const Vec<double, 9>& gamma) const {
  const double omega = lipm_frequency(gamma[2] - planner_.scene().stance.position[2]);
  return capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega);
}

LoopState RunRecorder::state(double t, const TrueState& truth) const {
  const Scene scene = scene_of_soles();
  const SupportPolygon ground = on_two_feet() ? scene.hull() : scene.stance_polygon();
  LoopState state{t, truth.gamma[2]};
  state.margin = -ground.signed_distance(capture_point_of(truth.gamma));
  const bool pushed = std::any_of(pushes_.begin(), pushes_.end(), [t](const Push& push) {
    return t > push.start - same_instant && t < push.end();
  });
  state.footing = planner_.is_stepping()      ? LoopState::Footing::stepping
                  : pushed                    ? LoopState::Footing::pushed
                  : log_.touchdown < infinity ? LoopState::Footing::landed
                                              : LoopState::Footing::standing;
  return state;
}

void RunRecorder::stop(std::string reason) {
  log_.stopped_early = true;
  log_.stop_reason = std::move(reason);
}

void run_until_over(LoopController& controller, LoopPlant& plant, RunRecorder& recorder) {
  LoopOptions options;
  options.duration = infinity;
  options.record = false;
  options.until = [&recorder](double t, const VectorRef&) { return recorder.is_over(t); };
  options.disturbances.pulses = recorder.pushes();
  LoopLog log = simulate_closed_loop(controller, plant, options);
  if (!log.completed && !recorder.has_stopped()) recorder.note_failure(log.message);
  static_cast<LoopLog&>(recorder.log()) = std::move(log);
}

Vec<double, 3> mean_force(std::span<const Pulse> pushes, double from, double to) {
  Vec<double, 3> force = Vec<double, 3>::Zero();
  for (const Pulse& push : pushes) force += push.mean(from, to);
  return force;
}

RunLog simulate(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer) {
  return problem.settings().plant.is_whole_body() ? simulate_whole_body(problem, robot, observer)
                                                  : simulate_centroidal(problem, robot, observer);
}

}  // namespace saltus::robots::walking
