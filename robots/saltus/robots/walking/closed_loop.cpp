#include "saltus/robots/walking/closed_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "saltus/ocp/window.hpp"
#include "saltus/robots/model/levelled.hpp"
#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/cpu_time.hpp"

namespace saltus::walking {
namespace {

// What carries a penalty and gives way by less is not worth explaining, m.
constexpr double hardly = 1e-3;

// What the tick came to, costs and residuals recomputed. Allocates.
TickRecord tick_record(double t, const ControlTick& tick, RecedingHorizonController& controller) {
  TickRecord r;
  r.time = t;
  r.provenance = tick.provenance;
  const Solution plan = controller.report();
  r.status = plan.status;
  r.message = plan.message;
  r.seconds = tick.seconds;
  r.iterations = plan.iterations;
  r.cost = plan.cost;
  r.kkt = plan.kkt.scaled();
  for (const SoftViolation& use : plan.soft_violations)
    r.violation = std::max(r.violation, use.largest);
  return r;
}

std::unique_ptr<Planner> planner_of(const BipedProblem& problem, const RobotDescription& robot,
                                    const Scene& scene) {
  const BipedSettings& settings = problem.settings();
  const RobotDescription nominal = nominal_robot(settings.robot, robot);
  if (settings.controller == ControllerChoice::capture_point)
    return make_capture_point_controller(settings.baseline, settings.planner, settings.contact,
                                         nominal, scene, problem.contacts(scene));
  return problem.make_planner(nominal, scene);
}

class ClosedLoop {
 public:
  ClosedLoop(const BipedProblem& problem, const RobotDescription& robot, LeggedPlant& plant)
      : problem_(problem),
        plant_(plant),
        pushes_(problem.pushes()),
        period_(problem.settings().planner.step),
        scene_(initial_scene(problem, robot)),
        contacts_(problem.contacts(scene_)),
        steps_(problem.make_step_planner(nominal_robot(problem.settings().robot, robot), scene_)),
        planner_(planner_of(problem, robot, scene_)) {
    foot(scene_.side) = {true, true, scene_.stance.position};
    foot(other(scene_.side)) = {scene_.two_feet, scene_.two_feet, scene_.swing.position};
    for (const Push& push : pushes_) push_end_ = std::max(push_end_, push.end());
    log_.robot = robot;
    note_ground(0.0);
  }

  RunLog run(const Observer& observer) {
    for (long k = 0; !log_.stopped_early; ++k) {
      const double t = plant_.tick_time(k);
      if (is_over(t)) break;
      bool is_sample = plant_.sense(t);
      plan_steps(t);
      find_landing(t);
      const bool goes_on = !observer || observer(state(t));
      plan(t);
      log_.ticks.push_back(tick_record(t, *tick_, planner_->controller()));
      const bool is_on = apply(t, is_sample);
      keep_unmet(t);
      if (!is_on) break;
      if (!goes_on) interrupt();
    }
    if (log_.samples.empty() || plant_.truth_time() > log_.samples.back().time)
      record(plant_.truth_time(), push_);
    log_.final_scene = scene_;
    log_.final_scene.stance.position = foot(scene_.side).stood_at;
    if (swing_ == nullptr) log_.final_scene.swing.position = foot(other(scene_.side)).stood_at;
    log_.loop = planner_->controller().statistics();
    log_.solver = planner_->controller().solver_name();
    log_.unmet = unmet_.take();
    plant_.describe(log_);
    return std::move(log_);
  }

 private:
  struct Foot {
    bool stands = false;
    bool bore = false;                                 // stood before now
    Vec<double, 3> stood_at = Vec<double, 3>::Zero();  // really, last, m
  };
  Foot& foot(Side side) { return feet_[side == Side::left ? 0 : 1]; }
  const Foot& foot(Side side) const { return feet_[side == Side::left ? 0 : 1]; }
  bool on_two_feet() const { return feet_[0].stands && feet_[1].stands; }
  const char* mode_now() const {
    return on_two_feet() ? double_support
                         : support_of(foot(Side::left).stands ? Side::left : Side::right);
  }
  bool is_over(double t) const {
    return t > problem_.end_time(push_end_, swing_ != nullptr ? swing_->landing : infinity,
                                 log_.last_touchdown()) -
                   same_instant;
  }

  StepSituation situation(double t) const {
    StepSituation now;
    now.time = t;
    now.period = period_;
    now.mass = plant_.nominal_mass();
    now.gamma = plant_.measured();
    now.omega = frequency_of_height(now.gamma[2] - scene_.stance.position[2]);
    for (const Side side : {Side::left, Side::right})
      now.foot(side) = {levelled(plant_.sole(side)), plant_.sole_velocity(side), foot(side).stands,
                        swing_ != nullptr && swing_->foot == side ? swing_->lift_off : infinity};
    return now;
  }

  // A step whose lift-off is due begins. One that is under way follows the plan, if that names it.
  void plan_steps(double t) {
    CpuTime watch(log_.plan_seconds);
    const StepSituation now = situation(t);
    const double asked_at = thread_microseconds();
    plan_ = steps_->plan(now);
    scene_.motion = plan_.motion;
    const double seconds = 1e-6 * (thread_microseconds() - asked_at);
    if (plan_.is_stepping() || plan_.alternatives > 0) log_.plans.push_back({t, plan_, seconds});
    if (!plan_.is_stepping()) return;
    const PlannedStep& first = plan_.steps[0];
    if (swing_ == nullptr && first.lift_off < t + 0.5 * period_ && foot(other(first.foot)).stands)
      begin(t, first);
    if (swing_ == nullptr || swing_->foot != first.foot) return;
    const double lift_off = swing_->lift_off;
    *swing_ = first;
    swing_->lift_off = lift_off;
    StepRecord& step = log_.steps.back();
    step.due = first.landing;
    step.place = first.place;
    scene_.swing.position = first.place;
    scene_.two_feet = true;
    plant_.swing(t, {first.landing, first.earliest_landing, first.place});
  }

  void begin(double t, const PlannedStep& step) {
    if (foot(step.foot).stands) {
      const Side stance = other(step.foot);
      scene_.stand_on(stance);
      scene_.stance.position.head<2>() = plant_.sole(stance).position.head<2>();
      foot(stance).stood_at = plant_.true_sole(stance);
      foot(step.foot).stands = false;
      plant_.lift_off(t, step.foot);
    }
    under_way_ = step;
    under_way_.lift_off = t;
    swing_ = &under_way_;
    StepRecord record;
    record.foot = step.foot;
    record.lift_off = t;
    log_.steps.push_back(record);
    note_ground(t);
  }

  void find_landing(double t) {
    if (swing_ == nullptr) return;
    const std::optional<Landing> landing = plant_.find_landing(t);
    if (!landing) return;
    if (log_.touchdown == infinity) log_.touchdown = t;
    log_.steps.back().touchdown = t;
    log_.steps.back().landed_at = landing->actual;
    foot(swing_->foot) = {true, false, landing->actual};
    scene_.swing.position = landing->measured;
    swing_ = nullptr;
    contacts_.confirm(impact, t);
    note_ground(t);
  }

  // For pictures, if it is another one than before.
  void note_ground(double t) {
    const auto placed = [this](Side side) {
      SoleFrame sole = scene_.sole(side);
      sole.position = foot(side).stood_at;
      return PlacedFoot{sole, scene_.rectangle(side)};
    };
    const bool left = foot(Side::left).stands, right = foot(Side::right).stands;
    if (!log_.ground.empty() && log_.ground.back().left == left &&
        log_.ground.back().right == right)
      return;
    const SupportPolygon polygon =
        left && right ? SupportPolygon::under({placed(Side::left), placed(Side::right)})
                      : SupportPolygon::under({placed(left ? Side::left : Side::right)});
    log_.ground.push_back({t, left, right, polygon});
  }

  void plan(double t) {
    CpuTime watch(log_.plan_seconds);
    planner_->controller().prepare(t);  // ahead of the measurement: grid, plan moved on, blocks
    const Measurement measured{t,
                               plant_.measured(),
                               plant_.applied(),
                               foot(Side::left).bore,
                               foot(Side::right).bore,
                               plant_.contact_force()};
    for (Foot& f : feet_) f.bore = f.stands;
    schedule(t);
    tick_ = &planner_->tick(measured, scene_, contacts_);
  }

  // What is under way, then what is planned. A foot that is late lands after this tick at the
  // earliest, and none lifts off within it.
  void schedule(double t) {
    std::array<PlannedStep, StepPlan::most_steps> steps;
    std::size_t count = 0;
    const double next = t + period_;
    if (swing_ != nullptr) {
      steps[count] = *swing_;
      if (!plant_.lands_on_time()) steps[count].landing = std::max(swing_->landing, next);
      ++count;
    }
    for (int i = 0; i < plan_.count && count < steps.size(); ++i) {
      const PlannedStep& step = plan_.steps[i];
      if (swing_ != nullptr && i == 0 && step.foot == swing_->foot) continue;
      if (swing_ == nullptr && i == 0 && (!on_two_feet() || step.lift_off <= t)) break;  // landed
      steps[count] = step;
      steps[count].lift_off = std::max(step.lift_off, next);
      ++count;
    }
    if (count == 0 && contacts_.mode_at(t) == mode_now()) return;
    schedule_contacts(contacts_, foot(Side::left).stands, foot(Side::right).stands,
                      {steps.data(), count});
  }

  // The programs have the data of the tick until the next one.
  void keep_unmet(double t) {
    if (const MultipleShooting* steps = steps_->shooting(); steps != nullptr && !plan_.is_feasible)
      unmet_.keep("steps", t, plan_.missed, *steps);
    const TickRecord& tick = log_.ticks.back();
    if (tick.status == SolveStatus::time_limit) return;
    const double missed = is_success(tick.status) ? tick.violation : infinity;
    if (missed > hardly) unmet_.keep("wrenches", t, missed, planner_->controller().shooting());
  }

  // The input of the tick, piece by piece; false when the run is over.
  bool apply(double t, bool is_sample) {
    const HeldInput& input = tick_->input;
    const double end = input.back().start + input.back().length;
    while (true) {
      const InputPiece* piece = &input[0];
      for (const InputPiece& p : input)
        if (p.start <= t + same_instant) piece = &p;
      plant_.command(t, piece->input());
      const double next = step_end(t, piece->start + piece->length);
      if (is_sample) {
        push_ = total_push_force(pushes_, t, plant_.sample_end(next));
        record(t, push_);
      }
      const std::string failure = plant_.step(t, next);
      if (!failure.empty()) {
        log_.numerical_failure = true;
        stop(failure);
      }
      if (auto body = plant_.body_sample()) log_.body.push_back(std::move(*body));
      const std::string lost = problem_.lost(plant_.truth_time(), plant_.truth(), scene_);
      if (!lost.empty()) stop(lost);
      t = next;
      if (log_.stopped_early || end - t <= same_instant) return true;
      if (is_over(t)) return false;
      is_sample = plant_.sense(t);
      find_landing(t);
      // Whoever landed within the tick bears from then on.
      for (Foot& f : feet_) f.bore = f.stands;
    }
  }

  // A step is cut where a push begins or ends and where the foot is due.
  double step_end(double t, double end) const {
    double next = end;
    const auto cut = [&](double edge) {
      if (edge - t > same_instant && edge < next - same_instant) next = edge;
    };
    for (const Push& push : pushes_) {
      cut(push.start);
      cut(push.end());
    }
    if (swing_ != nullptr) cut(swing_->landing);
    return plant_.step_end(t, next);
  }

  void record(double t, const Vec<double, 3>& push) {
    const Vec<double, 9> gamma = plant_.truth();
    log_.samples.push_back({t, gamma, true_capture_point(gamma), plant_.applied(), push,
                            foot(Side::left).stands, foot(Side::right).stands});
  }
  // The pendulum stands on the ground below the stance foot.
  Vec<double, 2> true_capture_point(const Vec<double, 9>& gamma) const {
    const double omega = frequency_of_height(gamma[2] - scene_.stance.position[2]);
    return capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega);
  }

  LoopState state(double t) const {
    const Vec<double, 9> gamma = plant_.truth();
    const SupportPolygon ground = on_two_feet() ? scene_.hull() : scene_.stance_polygon();
    LoopState state{t, gamma[2]};
    state.margin = -ground.signed_distance(true_capture_point(gamma));
    const bool pushed = std::any_of(pushes_.begin(), pushes_.end(), [t](const Push& push) {
      return t > push.start - same_instant && t < push.end();
    });
    state.footing = swing_ != nullptr           ? Footing::stepping
                    : pushed                    ? Footing::pushed
                    : log_.touchdown < infinity ? Footing::landed
                                                : Footing::standing;
    return state;
  }

  void interrupt() {
    if (log_.stopped_early) return;
    log_.interrupted = true;
    stop(fmt::format("interrupted at {:.2f} s", log_.samples.back().time));
  }
  void stop(std::string reason) {
    log_.stopped_early = true;
    log_.stop_reason = std::move(reason);
  }

  const BipedProblem& problem_;
  LeggedPlant& plant_;
  std::vector<Push> pushes_;
  double push_end_ = 0.0;  // of the last one, s
  double period_;          // of planners, s
  Scene scene_;
  Schedule contacts_;
  std::unique_ptr<StepPlanner> steps_;
  std::unique_ptr<Planner> planner_;
  std::array<Foot, 2> feet_;
  StepPlan plan_;
  PlannedStep under_way_;
  PlannedStep* swing_ = nullptr;  // under_way_, if a foot swings and is to land
  const ControlTick* tick_ = nullptr;
  Vec<double, 3> push_ = Vec<double, 3>::Zero();  // of the last sample
  UnmetDecisions unmet_;
  RunLog log_;
};

}  // namespace

RunLog simulate(const BipedProblem& problem, const RobotDescription& robot, LeggedPlant& plant,
                const Observer& observer) {
  return ClosedLoop(problem, robot, plant).run(observer);
}

RunLog simulate(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer) {
  const BipedSettings& settings = problem.settings();
  const PlantStart start{robot,
                         problem.posture(robot),
                         initial_scene(problem, robot),
                         problem.pushes(),
                         settings.robot.mass_error,
                         settings.planner.step};
  const std::unique_ptr<LeggedPlant> plant =
      settings.plant.is_whole_body()
          ? make_whole_body_legged_plant(
                start, {urdf_of_body(settings.robot), settings.control, settings.contact},
                settings.plant)
          : make_centroidal_legged_plant(start);
  return simulate(problem, robot, *plant, observer);
}

}  // namespace saltus::walking
