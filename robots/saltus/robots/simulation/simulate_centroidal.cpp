// The exact centroidal dynamics: a BalancePlanner drives a CentroidalPlant.
#include <fmt/format.h>

#include <cmath>

#include "saltus/integrators/sundials.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"
#include "saltus/robots/simulation/run_recorder.hpp"
#include "saltus/robots/walking/cpu_time.hpp"
#include "saltus/robots/walking/push.hpp"

namespace saltus::robots::walking {
namespace {

// The simulation is the reference. Its tolerance is far below that of all quantities compared.
constexpr double plant_tolerance = 1e-11;

// Both sides of the closed loop: planners with their control period, and the centroidal model.
class CentroidalRun final : LoopController, LoopPlant {
 public:
  CentroidalRun(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer)
      : period_(problem.settings().planner.step),
        nominal_mass_(robot.mass * (1.0 + problem.settings().robot.mass_error)),
        scene_(initial_scene(problem, robot)),
        planner_(scene_, problem.contacts(scene_), make_step_planner(problem, robot, scene_),
                 make_planner(problem, robot, scene_), period_,
                 BalancePlanner::LandingTime::as_planned),
        recorder_(problem, robot, planner_, observer),
        swing_side_(other(scene_.side)),
        swing_sole_(scene_.swing),
        plant_(robot.mass, start_state(problem.posture(robot)),
               cvodes({.method = CvodesOptions::Method::Adams,
                       .tolerance = plant_tolerance,
                       .absolute_tolerance = plant_tolerance})) {
    plant_.foot(scene_.side) = {scene_.stance, true};
    plant_.foot(swing_side_) = {swing_sole_, scene_.two_feet};
    applied_ = scene_.standing_wrenches(robot.mass, plant_.state().head<3>());
  }

  RunLog run() {
    run_until_over(*this, *this, recorder_);
    return recorder_.finish(applied_, truth());
  }

 private:
  std::string name() const override { return "centroidal"; }
  double period() const override { return period_; }
  std::optional<LoopLog::Tick> last_tick() override { return recorder_.take_tick(); }
  double time() const override { return now_; }
  VectorXd state() const override { return plant_.state(); }
  int inputs() const override { return 12; }
  bool take_pulses(std::span<const Pulse> pushes) override {
    pushes_.assign(pushes.begin(), pushes.end());
    return true;
  }

  static Vec<double, 9> start_state(const StandingPosture& posture) {
    Vec<double, 9> gamma = Vec<double, 9>::Zero();
    gamma.head<3>() = posture.com;
    return gamma;
  }
  SoleFrame sole(Side foot) const {
    return foot == swing_side_ && !plant_.foot(foot).in_contact ? swing_sole_
                                                                : plant_.foot(foot).sole;
  }
  BalancePlanner::Estimate estimate() const {
    BalancePlanner::Estimate e;
    e.gamma = plant_.state();
    e.mass = nominal_mass_;
    e.left_sole = sole(Side::left);
    e.right_sole = sole(Side::right);
    e.applied = applied_;
    e.contact_force = plant_.contact_force(applied_);
    return e;
  }
  TrueState truth() const {
    return {now_, plant_.state(), {sole(Side::left).position, sole(Side::right).position}};
  }

  const HeldInput& tick(double t, const VectorRef&) override {
    CpuTime watch(recorder_.log().plan_seconds);
    now_ = t;  // equal except for rounding
    double step_seconds = 0.0;
    BalancePlanner::StepChange change;
    {
      CpuTime step_watch(step_seconds);
      change = planner_.plan_steps(t, estimate());
    }
    if (change.has_lifted) {
      swing_side_ = planner_.step().foot;
      swing_sole_ = plant_.foot(swing_side_).sole;
      plant_.foot(swing_side_).in_contact = false;
    }
    if (change.has_target) {
      const StepPlan::Step& step = planner_.step();
      swing_sole_.position = step.place;
      if (step.heading) swing_sole_ = flat_sole(step.place, *step.heading);
    }
    const bool has_landed_now = has_landed(t);
    planner_.plan_wrenches(t, estimate());
    recorder_.note_tick(t, change, has_landed_now, step_seconds, truth());
    return planner_.tick().input;
  }

  // The swing foot lands at the planned time.
  bool has_landed(double t) {
    if (!planner_.is_stepping() || t <= planner_.step().landing - same_instant) return false;
    plant_.foot(swing_side_) = {swing_sole_, true};
    planner_.land(t, swing_sole_.position);
    return true;
  }

  bool advance(const VectorRef& wrenches, double length) override {
    applied_ = wrenches;
    double end = now_ + length;
    for (const HeldInput::Piece& piece :
         planner_.tick().input)  // avoids the rounding of a difference
      if (std::abs(piece.start + piece.length - end) < same_instant)
        end = piece.start + piece.length;
    while (end - now_ > same_instant) {
      if (has_landed(now_)) recorder_.note_landing(now_, truth());
      planner_.note_contacts();
      const double t = now_, next = next_cut(end);
      plant_.push = mean_force(pushes_, t, next);
      recorder_.note_sample(t, applied_, plant_.push, truth());
      const IntegrationStatus status = plant_.advance(next - t, applied_);
      std::string failure;
      if (status == IntegrationStatus::success)
        now_ = next;
      else
        failure = fmt::format("the plant could not be integrated at {:.3f} s: {}", t,
                              saltus::describe(status));
      recorder_.note_step(failure, truth());
      if (recorder_.has_stopped()) return false;
    }
    return true;
  }

  // Time of the next start or end of a push, or landing; at most `end`.
  double next_cut(double end) const {
    double next = end;
    const auto cut = [&](double edge) {
      if (edge - now_ > same_instant && edge < next - same_instant) next = edge;
    };
    for (const Pulse& push : pushes_) {
      cut(push.start);
      cut(push.end());
    }
    if (planner_.is_stepping()) cut(planner_.step().landing);
    return next;
  }

  double period_, nominal_mass_;
  Scene scene_;
  BalancePlanner planner_;
  RunRecorder recorder_;
  Side swing_side_;
  SoleFrame swing_sole_;
  CentroidalPlant plant_;
  std::vector<Pulse> pushes_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  double now_ = 0.0;
};

}  // namespace

RunLog simulate_centroidal(const BipedProblem& problem, const RobotDescription& robot,
                           const Observer& observer) {
  return CentroidalRun(problem, robot, observer).run();
}

}  // namespace saltus::robots::walking
