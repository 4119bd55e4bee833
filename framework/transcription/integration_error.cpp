#include "saltus/transcription/integration_error.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "saltus/core/bounds.hpp"
#include "saltus/transcription/plan_magnitudes.hpp"

namespace saltus {
namespace {

// The same intervals by the finer scheme; derivatives are not asked for.
std::vector<std::unique_ptr<Integrator>> finer_integrators(const IntegratorScheme& finer,
                                                           const Trajectory& trajectory) {
  std::vector<std::unique_ptr<Integrator>> result;
  for (const Trajectory::PhaseInfo& phase : trajectory.phases()) {
    IntervalProblem interval = phase.integrator->problem();
    interval.differentiate_time = false;
    interval.differentiate_parameter.assign(interval.arguments.np, false);
    result.push_back(finer.make(interval));
  }
  return result;
}

}  // namespace

std::optional<IntegrationError> integration_error(const IntegratorScheme& scheme,
                                                  const Trajectory& trajectory) {
  const IntegratorChoice finer = scheme.refined();
  if (finer == nullptr || trajectory.empty()) return std::nullopt;
  const auto integrators = finer_integrators(*finer, trajectory);
  IntegrationError error;
  std::vector<VectorXd> sums(integrators.size());  // per phase and state
  for (std::size_t j = 0; j < sums.size(); ++j)
    sums[j] = VectorXd::Zero(integrators[j]->arguments().nx);
  const std::vector<VectorXd> units = units_of_states(trajectory);
  double worst = -1.0;
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    const Trajectory::PhaseInfo& phase = trajectory.phases()[piece.phase];
    Integrator& fine = *integrators[piece.phase];
    const IntervalArguments a = fine.arguments();
    VectorXd w(a.size()), coarse_end(fine.outputs()), fine_end(fine.outputs());
    w << piece.state, piece.coefficients, phase.parameters, piece.start, piece.length;
    const bool works =
        phase.integrator->value(w.data(), coarse_end.data()) == IntegrationStatus::success &&
        fine.value(w.data(), fine_end.data()) == IntegrationStatus::success && fine_end.allFinite();
    double here = works ? 0.0 : infinity;
    int state = 0;
    for (int i = 0; works && i < a.nx; ++i) {
      const double unit = std::max(units[piece.phase][i], std::abs(fine_end[i]));
      const double off = std::abs(fine_end[i] - coarse_end[i]) / unit;
      sums[piece.phase][i] += off;
      if (off > here) here = off, state = i;
    }
    if (!works) sums[piece.phase].setConstant(infinity);
    error.intervals.push_back(here);
    if (here <= worst) continue;
    worst = here;
    error.phase = phase.name;
    error.state = state;
    error.time = piece.start;
  }
  for (const VectorXd& sum : sums)
    if (sum.size() > 0) error.states = std::max(error.states, sum.maxCoeff());
  return error;
}

}  // namespace saltus
