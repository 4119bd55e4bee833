#include "framework/mpc/receding_horizon.hpp"

#include <utility>

namespace saltus {

const char* describe(Provenance provenance) {
  switch (provenance) {
    case Provenance::optimal:
      return "optimal";
    case Provenance::shifted:
      return "shifted";
    case Provenance::none:
      return "none";
  }
  return "unknown";
}

RecedingHorizonController::RecedingHorizonController(MultipleShooting shooting,
                                                     std::unique_ptr<Solver> solver, double period)
    : shooting_(std::move(shooting)), solver_(std::move(solver)), period_(period) {}

ControlTick RecedingHorizonController::tick(double t, const VectorRef& state) {
  ControlTick result;
  shooting_.start_at(t, state);
  result.solution = solve(shooting_, *solver_, shooting_.guess_from(plan_));
  if (result.solution.ok()) {
    plan_ = result.solution.trajectory;
    result.provenance = Provenance::optimal;
  } else {
    result.provenance = plan_.empty() ? Provenance::none : Provenance::shifted;
  }
  if (result.provenance != Provenance::none) result.input = hold(plan_, t, period_);
  return result;
}

}  // namespace saltus
