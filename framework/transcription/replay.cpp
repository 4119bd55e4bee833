#include "saltus/transcription/replay.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <vector>

namespace saltus {
namespace {

double difference(const VectorXd& a, const VectorXd& b, const VectorXd& nominal) {
  double worst = 0.0;
  for (int i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(a[i] - b[i]) / std::max(nominal[i], std::abs(b[i])));
  return worst;
}

}  // namespace

ReplayReport replay(const OptimalControlProblem& problem, const Trajectory& trajectory,
                    const IntegratorChoice& choice) {
  ReplayReport report;
  std::vector<std::unique_ptr<Integrator>> integrators;
  for (std::size_t j = 0; j < problem.phases().size(); ++j) {
    IntervalProblem interval = trajectory.phases()[j].integrator->problem();
    interval.running_cost = {};
    interval.differentiate_time = false;
    interval.differentiate_parameter.assign(interval.arguments.np, false);
    integrators.push_back(choice->make(interval));
  }
  VectorXd x = trajectory.pieces().front().state;
  MatrixXd flow = MatrixXd::Identity(x.size(), x.size());
  int phase = trajectory.pieces().front().phase;
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    for (; phase < piece.phase; ++phase) {
      const Jump& jump = problem.jumps()[phase + 1];
      if (!jump.map) continue;
      const VectorXd z = jump.argument(piece.start, x, trajectory.phases()[phase].parameters);
      flow = jump.map.dense_jacobian(z).middleCols(1, x.size()) * flow;
      x = jump.map(z);
    }
    Integrator& integrator = *integrators[piece.phase];
    const IntervalArguments a = integrator.arguments();
    const VectorXd& nominal = problem.phases()[piece.phase].nominal_state;
    VectorXd w(a.size()), end(integrator.outputs());
    MatrixXd derivative(integrator.outputs(), a.size());
    w << piece.state, piece.coefficients, trajectory.phases()[piece.phase].parameters, piece.start,
        piece.length;
    if (integrator.value(w.data(), end.data()) != IntegrationStatus::success) return report;
    report.from_nodes = std::max(report.from_nodes, difference(end, piece.end_state, nominal));
    w.head(a.nx) = x;
    if (integrator.jacobian(w.data(), end.data(), derivative) != IntegrationStatus::success)
      return report;
    x = end;
    flow = derivative.leftCols(a.nx) * flow;
    report.from_start = std::max(report.from_start, difference(x, piece.end_state, nominal));
    report.flow_growth =
        std::max(report.flow_growth, Eigen::JacobiSVD<MatrixXd>(flow).singularValues()[0]);
  }
  report.completed = true;
  return report;
}

}  // namespace saltus
