#include "saltus/transcription/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/verify/flow_growth.hpp"
#include "saltus/verify/plan_rows.hpp"

namespace saltus {
namespace {

double difference(const VectorXd& a, const VectorXd& b, const VectorXd& unit) {
  double worst = 0.0;
  for (int i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(a[i] - b[i]) / std::max(unit[i], std::abs(b[i])));
  return worst;
}

}  // namespace

ReplayReport replay(const OptimalControlProblem& problem, const Trajectory& trajectory,
                    const IntegratorChoice& choice) {
  ReplayReport report;
  if (trajectory.empty() || trajectory.phases().size() != problem.phases().size())
    throw DefinitionError(fmt::format(
        "replay of problem '{}': the trajectory has {} phases and {} pieces, expected {} phases",
        problem.name(), trajectory.phases().size(), trajectory.pieces().size(),
        problem.phases().size()));
  std::vector<std::unique_ptr<Integrator>> integrators;
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    IntervalProblem interval = trajectory.phases()[j].integrator->problem();
    interval.running_cost = {};
    interval.differentiate_time = false;
    interval.differentiate_parameter.assign(interval.arguments.np, false);
    integrators.push_back(choice->make(interval));
  }
  const std::vector<VectorXd> units = units_of_states(problem, plan_of(problem, trajectory));
  VectorXd x = trajectory.pieces().front().state;
  MatrixXd flow = MatrixXd::Identity(x.size(), x.size());
  int phase = trajectory.pieces().front().phase;
  for (const Trajectory::Piece& piece : trajectory.pieces()) {
    for (; phase < piece.phase; ++phase) {
      const Jump& jump = problem.jumps()[phase + 1];
      if (!jump.map) continue;
      const VectorXd z = jump.argument(piece.start, x, trajectory.phases()[phase].parameters);
      flow = jump.map.dense_jacobian(z).middleCols(1, x.size()) * flow;
      x = jump.map(z);
    }
    Integrator& integrator = *integrators[piece.phase];
    const IntervalArguments a = integrator.arguments();
    const VectorXd& unit = units[piece.phase];
    VectorXd w(a.size()), end(integrator.outputs());
    MatrixXd derivative(integrator.outputs(), a.size());
    w << piece.state, piece.coefficients, trajectory.phases()[piece.phase].parameters, piece.start,
        piece.length;
    if (integrator.value(w.data(), end.data()) != IntegrationStatus::success) return report;
    report.from_nodes = std::max(
        report.from_nodes, difference(end, piece.end_state, unit.cwiseMax(piece.state.cwiseAbs())));
    w.head(a.nx) = x;
    if (integrator.jacobian(w.data(), end.data(), derivative) != IntegrationStatus::success)
      return report;
    x = end;
    flow = derivative.leftCols(a.nx) * flow;
    report.from_start = std::max(report.from_start, difference(x, piece.end_state, unit));
    report.flow_growth = std::max(report.flow_growth, largest_singular_value(flow));
  }
  report.completed = true;
  return report;
}

}  // namespace saltus
