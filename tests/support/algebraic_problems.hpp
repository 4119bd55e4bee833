// Differential-algebraic problems of index 1 with known answers.
#pragma once

#include <cmath>

#include "saltus/ocp/interval_problem_of.hpp"
#include "saltus/ocp/phase.hpp"

namespace saltus::testing_support {

/// The dynamics x' and the algebraic state z of one phase as an interval without costs.
inline IntervalProblem differentiable_interval_of(const PhaseDefinition& phase) {
  IntervalProblem interval = saltus::interval_problem_of(phase);
  interval.differentiate_parameter.assign(phase.sizes.np, true);
  return interval;
}

/// Chemical Akzo Nobel: two substances react under carbon dioxide; z is a complex in equilibrium.
/// Test Set for IVP Solvers, Mazzia and Magherini, release 2.4, chapter 3.
struct AkzoNobel {
  static constexpr double k1 = 18.7, k2 = 0.58, k3 = 0.09, k4 = 0.42, K = 34.4, klA = 3.3,
                          Ks = 115.83, pCO2 = 0.9, H = 737.0;
  template <class S>
  Vec<S, 5> operator()(const S&, const Vec<S, 5>& y, const Vec<S, 1>& z) const {
    using std::sqrt;
    const S root = sqrt(y[1]), square = y[0] * y[0];
    const S r1 = k1 * square * square * root, r2 = k2 * y[2] * y[3], r3 = k2 / K * y[0] * y[4],
            r4 = k3 * y[0] * y[3] * y[3], r5 = k4 * z[0] * z[0] * root;
    const S inflow = klA * (pCO2 / H - y[1]);
    return {-2.0 * r1 + r2 - r3 - r4, -0.5 * r1 - r4 - 0.5 * r5 + inflow, r1 - r2 + r3,
            -r2 + r3 - 2.0 * r4, r2 - r3 + r5};
  }
};
inline PhaseDefinition akzo_nobel() {
  const auto equilibrium = [](const auto&, const auto& y, const auto& z) {
    return AkzoNobel::Ks * y[0] * y[3] - z[0];
  };
  Phase<5, 0, 0, 1> phase{"reaction", AkzoNobel{}, equilibrium, Vec<double, 1>{0.3},
                          exactly(180.0)};
  phase.nominal(Vec<double, 5>{0.1, 1e-3, 0.1, 1e-3, 1e-2}, VectorXd());
  return phase.definition();
}
const inline VectorXd akzo_nobel_start =
    (VectorXd(5) << 0.444, 0.00123, 0.0, 0.007, 0.0).finished();

/// Mathematical pendulum of length 1 in Cartesian coordinates. Its constraint is differentiated
/// twice, and z is the tension divided by mass and length.
struct Pendulum {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& z) const {
    return {x[2], x[3], -z[0] * x[0], -z[0] * x[1] - gravity};
  }
  static constexpr double gravity = 9.81;
};
inline PhaseDefinition pendulum() {
  const auto tension = [](const auto&, const auto& x, const auto& z) {
    return x[2] * x[2] + x[3] * x[3] - z[0] * (x[0] * x[0] + x[1] * x[1]) -
           Pendulum::gravity * x[1];
  };
  return Phase<4, 0, 0, 1>{"swing", Pendulum{}, tension, Vec<double, 1>{1.0}, exactly(1.0)}
      .definition();
}

/// Robertson's kinetics. Conservation of mass replaces the third equation: z = y3.
struct Robertson {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& y, const Vec<S, 1>& z, const Vec<S, 0>&,
                       const Vec<S, 3>& p) const {
    const S slow = p[0] * y[0], back = p[1] * y[1] * z[0], fast = p[2] * y[1] * y[1];
    return {back - slow, slow - back - fast};
  }
};
inline PhaseDefinition robertson_with_conservation() {
  const auto mass = [](const auto&, const auto& y, const auto& z) {
    return y[0] + y[1] + z[0] - 1.0;
  };
  Phase<2, 0, 3, 1> phase{"reaction", Robertson{}, mass, Vec<double, 1>{0.0}, exactly(0.4)};
  phase.data("rates", Vec<double, 3>{0.04, 1e4, 3e7})
      .nominal(Vec<double, 2>{1.0, 1e-5}, VectorXd());
  return phase.definition();
}

}  // namespace saltus::testing_support
