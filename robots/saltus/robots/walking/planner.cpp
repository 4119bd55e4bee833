#include "saltus/robots/walking/planner.hpp"

#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/any_real_time_solver.hpp"
#include "saltus/qp/riccati_kernels.hpp"

namespace saltus::robots::walking {
namespace {

// Stage sizes of a tick with costs on changes of the wrenches: 9 states, the previous wrench of
// every stance foot, and its wrench. Other sizes use the run-time kernel.
constexpr qp::RiccatiKernel tick_kernels[] = {
    qp::riccati_kernel<0, 6, 15, true>(),  qp::riccati_kernel<15, 6, 15, true>(),
    qp::riccati_kernel<15, 6, 9>(),        qp::riccati_kernel<15, 12, 21, true>(),
    qp::riccati_kernel<0, 12, 21, true>(), qp::riccati_kernel<21, 12, 21, true>(),
    qp::riccati_kernel<21, 12, 9>(),       qp::riccati_kernel<9, 0, 0>()};

// A solver that has no time in a fraction of the ticks. These ticks come in runs of one to five.
class LateSolver final : public RealTimeSolver {
 public:
  LateSolver(std::unique_ptr<RealTimeSolver> solver, const PlannerSettings& settings)
      : solver_(std::move(solver)),
        random_(static_cast<unsigned>(settings.missed_seed)),
        begin_(
            std::min(1.0, settings.missed_fraction / (mean * (1.0 - settings.missed_fraction)))) {}
  void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept override {
    solver_->prepare(program, guess);
  }
  RealTimeSolver::Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                                  WallClock::time_point deadline) noexcept override {
    return solver_->feedback(program, point, warm, is_late() ? WallClock::now() : deadline);
  }
  std::string name() const override { return solver_->name(); }

 private:
  static constexpr int longest = 5;
  static constexpr double mean = 0.5 * (1 + longest);

  bool is_late() {
    if (left_ == 0) {
      left_ = -1;  // at least one tick between runs
      return false;
    }
    if (left_ < 0) {
      if (std::uniform_real_distribution<double>(0.0, 1.0)(random_) >= begin_) return false;
      left_ = std::uniform_int_distribution<int>(1, longest)(random_);
    }
    --left_;
    return true;
  }

  std::unique_ptr<RealTimeSolver> solver_;
  std::mt19937 random_;
  double begin_;  // probability of a run per tick
  int left_ = 0;  // late ticks of this run; negative: none
};

}  // namespace

ControllerOptions controller_options(const PlannerSettings& settings, double mass, Side stance) {
  ControllerOptions options;
  options.period = settings.step;
  if (settings.deadline > 0.0) options.deadline = settings.deadline;
  options.fallback_input = VectorXd::Zero(12);
  options.fallback_input[stance == Side::left ? 2 : 8] = mass * standard_gravity;
  return options;
}

RecedingHorizonController make_tick_controller(OptimalControlProblem problem, int intervals,
                                               const PlannerSettings& settings, double mass,
                                               Side stance) {
  MultipleShooting shooting(std::move(problem),
                            {.intervals_per_phase = intervals, .integrator = zero_order_hold()});
  auto solver = make_real_time_solver(
      shooting,
      {.solver = settings.solver, .tolerance = settings.tolerance, .kernels = tick_kernels});
  if (settings.missed_fraction > 0.0)
    solver = std::make_unique<LateSolver>(std::move(solver), settings);
  return {std::move(shooting), std::move(solver), controller_options(settings, mass, stance)};
}

}  // namespace saltus::robots::walking
