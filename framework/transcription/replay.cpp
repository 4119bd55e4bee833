#include "saltus/transcription/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/transcription/plan_magnitudes.hpp"

namespace saltus {
namespace {

double difference(const VectorXd& a, const VectorXd& b, const VectorXd& unit) {
  double worst = 0.0;
  for (int i = 0; i < a.size(); ++i)
    worst = std::max(worst, std::abs(a[i] - b[i]) / std::max(unit[i], std::abs(b[i])));
  return worst;
}

// The largest singular value, by plane rotations that make the columns orthogonal (Hestenes 1958).
// In plain loops: a decomposition of Eigen takes ten seconds to compile.
double largest_singular_value(MatrixXd A) {
  const auto product = [&](int p, int q) {
    double sum = 0.0;
    for (int i = 0; i < A.rows(); ++i) sum += A(i, p) * A(i, q);
    return sum;
  };
  const int columns = static_cast<int>(A.cols()), enough_sweeps = 50;
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < enough_sweeps; ++sweep) {
    rotated = false;
    for (int p = 0; p < columns; ++p)
      for (int q = p + 1; q < columns; ++q) {
        const double pp = product(p, p), qq = product(q, q), pq = product(p, q);
        if (!(std::abs(pq) > std::numeric_limits<double>::epsilon() * std::sqrt(pp * qq))) continue;
        const double cotangent = (qq - pp) / (2.0 * pq);  // of twice the angle
        const double tangent = std::copysign(1.0, cotangent) /
                               (std::abs(cotangent) + std::sqrt(1.0 + cotangent * cotangent));
        const double c = 1.0 / std::sqrt(1.0 + tangent * tangent), s = c * tangent;
        for (int i = 0; i < A.rows(); ++i) {
          const double a = A(i, p), b = A(i, q);
          A(i, p) = c * a - s * b;
          A(i, q) = s * a + c * b;
        }
        rotated = true;
      }
  }
  double largest = 0.0;
  for (int p = 0; p < columns; ++p) largest = std::max(largest, std::sqrt(product(p, p)));
  return largest;
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
  const std::vector<VectorXd> units = units_of_states(trajectory);
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
    const VectorXd& unit = units[piece.phase];
    VectorXd w(a.size()), end(integrator.outputs());
    MatrixXd derivative(integrator.outputs(), a.size());
    w << piece.state, piece.coefficients, trajectory.phases()[piece.phase].parameters, piece.start,
        piece.length;
    if (integrator.value(w.data(), end.data()) != IntegrationStatus::success) return report;
    report.from_nodes = std::max(report.from_nodes, difference(end, piece.end_state, unit));
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
