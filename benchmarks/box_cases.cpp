// Random programs with boxes, to compare run-time sizes with fixed sizes.
#include <array>

#include "benchmarks/cases.hpp"
#include "benchmarks/contenders.hpp"
#include "saltus/core/random.hpp"

namespace saltus::bench {
namespace {

constexpr int intervals = 20;

// Dynamics near the limit of stability, a start within one, and a box for every third state whose
// sides lie just outside the range of some admissible inputs: feasible by construction. The target
// of the cost is beyond the boxes, so that they are active.
qp::StageQp box_qp(int nx, int nu, std::uint64_t seed) {
  constexpr double input_limit = 1.0, margin = 0.05;
  Random random(seed);
  std::vector<qp::StageCapacity> capacity(intervals + 1, {nx, nu, {}});
  capacity.back().nu = 0;
  qp::StageQp qp(capacity);

  const MatrixXd A =
      0.95 * MatrixXd::Identity(nx, nx) + 0.2 / std::sqrt(nx) * random.matrix(nx, nx);
  const MatrixXd B = 0.3 * random.matrix(nx, nu);
  const MatrixXd J = random.matrix(nx, nx);
  const MatrixXd Q = 0.1 / nx * J.transpose() * J + 0.1 * MatrixXd::Identity(nx, nx);
  const VectorXd target = 3.0 * random.matrix(nx, 1);
  qp.start = random.matrix(nx, 1);

  VectorXd x = qp.start, lower = VectorXd::Constant(nx, infinity), upper = -lower;
  for (int k = 0; k < intervals; ++k) {
    x = A * x + B * (0.5 * input_limit * random.matrix(nu, 1));
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  for (int k = 0; k <= intervals; ++k) {
    qp::Stage& s = qp.stages[k];
    s.Q = Q;
    s.q = -Q * target;
    s.constant = 0.5 * target.dot(Q * target);
    for (int i = 0; i < nx && k > 0; i += 3) {
      s.x_lower[i] = lower[i] - margin;
      s.x_upper[i] = upper[i] + margin;
    }
    if (k == intervals) continue;
    s.A = A;
    s.B = B;
    s.R = 0.1 * MatrixXd::Identity(nu, nu);
    s.u_lower.setConstant(-input_limit);
    s.u_upper.setConstant(input_limit);
  }
  return qp;
}

std::string name_of(int nx, int nu) {
  return "box/" + std::to_string(nx) + "x" + std::to_string(nu);
}

template <int nx, int nu>
CaseGroup group() {
  const std::string fixed = name_of(nx, nu), any = fixed + ",run-time-sizes";
  return {.names = {fixed, any}, .run = [fixed, any](const Selection& selection) {
            static constexpr std::array<qp::RiccatiKernel, 3> kernels{
                qp::riccati_kernel<nx, nu, nx>(), qp::riccati_kernel<0, nu, nx>(),
                qp::riccati_kernel<nx, 0, 0>()};
            const qp::StageQp capacity = box_qp(nx, nu, 1);
            Contenders contenders(selection);
            contenders.add(fixed, capacity, {}, kernels);
            contenders.add(any, capacity, {}, {});
            for (int seed = 1; seed <= selection.solves && !contenders.empty(); ++seed) {
              const qp::StageQp qp = box_qp(nx, nu, seed);
              contenders.solve(qp, qp::StagePoint(qp), seed,
                               [&](Measurement& m, const qp::StagePoint& point) {
                                 m.detail("binding bounds", binding_bounds(qp, point));
                               });
            }
            return contenders.results();
          }};
}

}  // namespace

std::vector<CaseGroup> box_cases() {
  return {group<4, 1>(), group<8, 3>(), group<12, 4>(), group<18, 3>(), group<24, 12>()};
}

}  // namespace saltus::bench
