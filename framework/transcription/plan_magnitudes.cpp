#include "saltus/transcription/plan_magnitudes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "saltus/transcription/quantities.hpp"

namespace saltus {

std::vector<VectorXd> units_of_states(const Trajectory& trajectory) {
  constexpr double zero = 1e-9;
  std::map<Eigen::Index, VectorXd> largest;  // by the number of states
  const auto look_at = [&](const VectorXd& x) {
    VectorXd& known =
        largest.try_emplace(x.size(), VectorXd::Constant(x.size(), zero)).first->second;
    for (int i = 0; i < x.size(); ++i)
      if (std::isfinite(x[i])) known[i] = std::max(known[i], std::abs(x[i]));
  };
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    look_at(piece.state);
    look_at(piece.end_state);
  }
  std::vector<VectorXd> units;
  for (const Trajectory::PhaseInfo& phase : trajectory.phases()) {
    const IntervalProblem& interval = phase.integrator->problem();
    const int nx = interval.arguments.nx;
    const auto found = largest.find(nx);  // a phase without a piece may be the only one of its size
    VectorXd unit = found != largest.end() ? found->second : VectorXd::Ones(nx);
    for (int i = 0; i < nx; ++i) {
      const double nominal = interval.nominal_state.size() > 0 ? interval.nominal_state[i] : 1.0;
      unit[i] = is_declared(nominal) ? nominal : std::min(1.0, unit[i]);
    }
    units.push_back(std::move(unit));
  }
  return units;
}

}  // namespace saltus
