#include "saltus/robots/walking/closed_loop.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/ocp/window.hpp"
#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/cpu_time.hpp"

namespace saltus::walking {
namespace {

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
                                         nominal, scene);
  return problem.make_planner(nominal, scene);
}

class ClosedLoop {
 public:
  ClosedLoop(const BipedProblem& problem, const RobotDescription& robot, LeggedPlant& plant)
      : problem_(problem),
        plant_(plant),
        pushes_(problem.pushes()),
        lead_(problem.settings().planner.step),
        scene_(initial_scene(problem, robot)),
        contacts_(problem.contacts(scene_)),
        steps_(problem.make_step_planner(nominal_robot(problem.settings().robot, robot), scene_)),
        planner_(planner_of(problem, robot, scene_)) {
    log_.robot = robot;
    log_.final_scene = scene_;
  }

  RunLog run(const Observer& observer) {
    for (long k = 0; !log_.stopped_early; ++k) {
      const double t = plant_.tick_time(k);
      if (is_over(t)) break;
      bool is_sample = plant_.sense(t);
      decide_step(t);
      find_landing(t);
      const bool goes_on = !observer || observer(state(t));
      plan(t);
      log_.ticks.push_back(tick_record(t, *tick_, planner_->controller()));
      if (!apply(t, is_sample)) break;
      if (!goes_on) interrupt();
    }
    if (log_.samples.empty() || plant_.truth_time() > log_.samples.back().time)
      record(plant_.truth_time(), push_);
    log_.final_scene = scene_;
    if (has_landed()) log_.final_scene.swing.position = landed_at_;
    log_.loop = planner_->controller().statistics();
    log_.solver = planner_->controller().solver_name();
    plant_.describe(log_);
    return std::move(log_);
  }

 private:
  bool has_landed() const { return log_.touchdown < infinity; }
  bool is_over(double t) const {
    return t > problem_.end_time(landing_due_, log_.touchdown) - same_instant;
  }

  void decide_step(double t) {
    CpuTime watch(log_.plan_seconds);
    const StepPlan& plan = steps_->plan(situation(t));
    if (!plan.is_stepping() || has_landed()) return;
    const PlannedStep& step = plan.steps[0];
    landing_due_ = step.landing;
    contacts_.retime(impact, step.landing);
    scene_.swing.position = step.place;
    scene_.two_feet = true;
    plant_.swing(t, {step.landing, step.earliest_landing, step.place});
  }

  StepSituation situation(double t) const {
    StepSituation now;
    now.time = t;
    now.period = lead_;
    now.mass = plant_.nominal_mass();
    now.gamma = plant_.measured();
    now.omega = frequency_of_height(now.gamma[2]);
    now.foot(scene_.side).sole = scene_.stance;
    FootState& swing = now.foot(other(scene_.side));
    swing.sole = scene_.swing;
    swing.stands = has_landed() || initially_on_two_feet_;
    return now;
  }

  void find_landing(double t) {
    if (has_landed()) return;
    const std::optional<Landing> landing = plant_.find_landing(t);
    if (!landing) return;
    log_.touchdown = t;
    contacts_.confirm(impact, t);
    scene_.swing.position = landing->measured;
    landed_at_ = landing->actual;
  }

  void plan(double t) {
    CpuTime watch(log_.plan_seconds);
    planner_->controller().prepare(t);  // ahead of the measurement: grid, plan moved on, blocks
    const Measurement measured{t, plant_.measured(), reordered(scene_.side, plant_.applied()),
                               plant_.contact_force()};
    // A foot that is late lands after this tick at the earliest.
    if (!has_landed() && !plant_.lands_on_time() && contacts_.contains(impact))
      contacts_.hold(impact, t, lead_);
    tick_ = &planner_->tick(measured, scene_, contacts_);
  }

  // The input of the tick, piece by piece; false when the run is over.
  bool apply(double t, bool is_sample) {
    const HeldInput& input = tick_->input;
    const double end = input.back().start + input.back().length;
    while (true) {
      const InputPiece* piece = &input[0];
      for (const InputPiece& p : input)
        if (p.start <= t + same_instant) piece = &p;
      plant_.command(t, reordered(scene_.side, piece->input()));
      const double next = step_end(t, piece->start + piece->length);
      push_ = total_push_force(pushes_, t, next);
      if (is_sample) record(t, push_);
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
    cut(landing_due_);
    return plant_.step_end(t, next);
  }

  void record(double t, const Vec<double, 3>& push) {
    const Vec<double, 9> gamma = plant_.truth();
    const double omega = frequency_of_height(gamma[2]);
    log_.samples.push_back({t, gamma,
                            capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega),
                            plant_.applied(), push, has_landed() || initially_on_two_feet_});
  }

  LoopState state(double t) const {
    const Vec<double, 9> gamma = plant_.truth();
    const bool on_two_feet = has_landed() || initially_on_two_feet_;
    const SupportPolygon ground = on_two_feet ? scene_.hull() : scene_.stance_polygon();
    const double omega = frequency_of_height(gamma[2]);
    LoopState state{t, gamma[2]};
    state.margin = -ground.signed_distance(
        capture_point<double, 2>(gamma.head<2>(), gamma.segment<2>(3), omega));
    const bool pushed = std::any_of(pushes_.begin(), pushes_.end(), [t](const Push& push) {
      return t > push.start - same_instant && t < push.end();
    });
    state.footing = has_landed()              ? Footing::landed
                    : landing_due_ < infinity ? Footing::stepping
                    : pushed                  ? Footing::pushed
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
  double lead_;  // s
  Scene scene_;
  bool initially_on_two_feet_ = scene_.two_feet;
  Schedule contacts_;
  std::unique_ptr<StepPlanner> steps_;
  std::unique_ptr<Planner> planner_;
  double landing_due_ = infinity;  // s
  const ControlTick* tick_ = nullptr;
  Vec<double, 3> push_ = Vec<double, 3>::Zero();  // of the last step
  Vec<double, 3> landed_at_ = Vec<double, 3>::Zero();
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
