#include "problems/whole_body/replanning.hpp"

#include "saltus/core/clock.hpp"

namespace saltus::whole_body {
namespace {

constexpr double feasible = 1e-4;  // largest violation of a plan that counts as feasible

std::vector<RecedingHorizonController> controllers(const OptimalControlProblem& problem,
                                                   const ShootingOptions& grid, double period) {
  return remaining_controllers(problem, grid, [&](MultipleShooting rest) {
    return RecedingHorizonController(std::move(rest), {.period = period, .feasibility = feasible});
  });
}

double end_of_first_phase(const Trajectory& plan) {
  double end = plan.end_time();
  for (const Trajectory::Piece& piece : plan.pieces())
    if (piece.phase == 0) end = piece.end();
  return end;
}

}  // namespace

Replanner::Replanner(const OptimalControlProblem& problem, const ShootingOptions& grid,
                     double period, const Trajectory& plan)
    : controller_(problem, controllers(problem, grid, period)),
      phases_(static_cast<int>(problem.phases().size())),
      end_of_phase_(end_of_first_phase(plan)) {
  controller_.adopt_plan(plan);
}

bool Replanner::is_last() const { return phase() + 1 == phases_; }

bool Replanner::is_over(double t) const {
  return is_last() && end_of_phase_ - t < controller_.period();
}

PlannedMotion Replanner::plan_from(double t, const VectorXd& state) {
  if (!is_last() && end_of_phase_ - t < controller_.period()) controller_.enter(phase() + 1, t);
  const double before = thread_microseconds();
  const ControlTick& tick = controller_.tick(t, state);
  statistics_.processor.add(1e-6 * (thread_microseconds() - before));
  ++statistics_.counts[static_cast<std::size_t>(tick.provenance)];
  end_of_phase_ = controller_.end_of_phase(phase());
  return PlannedMotion(controller_.report().trajectory, PlannedMotion::Start::in_motion);
}

}  // namespace saltus::whole_body
