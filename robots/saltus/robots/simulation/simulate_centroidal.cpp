// The exact centroidal dynamics: a BalancePlanner drives a CentroidalPlant.
#include <fmt/format.h>

#include <utility>

#include "saltus/integrators/cvodes.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"
#include "saltus/robots/simulation/run_recorder.hpp"
#include "saltus/robots/walking/cpu_time.hpp"

namespace saltus::walking {
namespace {

// The simulation is the reference: far tighter than anything that is compared with it.
constexpr double plant_tolerance = 1e-11;

class CentroidalRun {
 public:
  CentroidalRun(const BipedProblem& problem, const RobotDescription& robot,
                const Observer& observer)
      : period_(problem.settings().planner.step),
        nominal_mass_(robot.mass * (1.0 + problem.settings().robot.mass_error)),
        scene_(initial_scene(problem, robot)),
        planner_(scene_, problem.contacts(scene_), make_step_planner(problem, robot, scene_),
                 make_planner(problem, robot, scene_), period_, LandingTime::as_planned),
        recorder_(problem, robot, planner_, observer),
        swing_side_(other(scene_.side)),
        swing_sole_(scene_.swing),
        plant_(robot.mass, start_state(problem.posture(robot)),
               cvodes({.method = CvodesMethod::Adams,
                       .tolerance = plant_tolerance,
                       .absolute_tolerance = plant_tolerance})) {
    plant_.foot(scene_.side) = {scene_.stance, true};
    plant_.foot(swing_side_) = {swing_sole_, scene_.two_feet};
    applied_ = scene_.standing_wrenches(robot.mass, plant_.state().head<3>());
  }

  RunLog run() {
    double t = 0.0;
    for (long k = 0; !recorder_.is_over(t = static_cast<double>(k) * period_); ++k) {
      tick(t);
      const double end = planner_.tick().input.back().start + planner_.tick().input.back().length;
      while (true) {
        t = move_on(t);
        if (end - t <= same_instant || recorder_.is_over(t)) break;
        if (has_landed(t)) recorder_.note_landing(t, truth(t));
        planner_.note_contacts();
      }
    }
    return recorder_.finish(applied_, truth(now_));
  }

 private:
  static Vec<double, 9> start_state(const StandingPosture& posture) {
    Vec<double, 9> gamma = Vec<double, 9>::Zero();
    gamma.head<3>() = posture.com;
    return gamma;
  }
  SoleFrame sole(Side foot) const {
    return foot == swing_side_ && !plant_.foot(foot).in_contact ? swing_sole_
                                                                : plant_.foot(foot).sole;
  }
  CentroidalEstimate estimate() const {
    CentroidalEstimate e;
    e.gamma = plant_.state();
    e.mass = nominal_mass_;
    e.left_sole = sole(Side::left);
    e.right_sole = sole(Side::right);
    e.applied = applied_;
    e.contact_force = plant_.contact_force(applied_);
    return e;
  }
  TrueState truth(double t) const {
    return {t, plant_.state(), {sole(Side::left).position, sole(Side::right).position}};
  }

  void tick(double t) {
    CpuTime watch(recorder_.log().plan_seconds);
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
    if (change.has_target) swing_sole_.position = planner_.step().place;
    const bool has_landed_now = has_landed(t);
    planner_.plan_wrenches(t, estimate());
    recorder_.note_tick(t, change, has_landed_now, step_seconds, truth(t));
  }

  // The swing foot lands at its time.
  bool has_landed(double t) {
    if (!planner_.is_stepping() || t <= planner_.step().landing - same_instant) return false;
    plant_.foot(swing_side_) = {swing_sole_, true};
    planner_.land(t, swing_sole_.position);
    return true;
  }

  // Under a constant input: to the end of its piece, or to where a push begins or ends and the foot
  // lands.
  double move_on(double t) {
    const HeldInput& input = planner_.tick().input;
    const InputPiece* piece = &input[0];
    for (const InputPiece& p : input)
      if (p.start <= t + same_instant) piece = &p;
    applied_ = planner_.wrenches(t);
    double next = piece->start + piece->length;
    const auto cut = [&](double edge) {
      if (edge - t > same_instant && edge < next - same_instant) next = edge;
    };
    for (const Push& push : recorder_.pushes()) {
      cut(push.start);
      cut(push.end());
    }
    if (planner_.is_stepping()) cut(planner_.step().landing);
    plant_.push = total_push_force(recorder_.pushes(), t, next);
    recorder_.note_sample(t, applied_, plant_.push, truth(t));
    const IntegrationStatus status = plant_.advance(next - t, applied_);
    std::string failure;
    if (status == IntegrationStatus::success)
      now_ = next;
    else
      failure = fmt::format("the plant could not be integrated at {:.3f} s: {}", t,
                            saltus::describe(status));
    recorder_.note_step(failure, truth(now_));
    return next;
  }

  double period_, nominal_mass_;
  Scene scene_;
  BalancePlanner planner_;
  RunRecorder recorder_;
  Side swing_side_;
  SoleFrame swing_sole_;
  CentroidalPlant plant_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  double now_ = 0.0;
};

}  // namespace

RunLog simulate_centroidal(const BipedProblem& problem, const RobotDescription& robot,
                           const Observer& observer) {
  return CentroidalRun(problem, robot, observer).run();
}

}  // namespace saltus::walking
