// Initial value problems with published or independently computed answers, for the simulations of
// the library and the tests of the integrators.
#pragma once

#include <cmath>

#include "saltus/model/integrator.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::library {

/// End state and running costs; NaN if the integration fails.
inline VectorXd integrate(Integrator& integrator, const VectorXd& w) {
  VectorXd end(integrator.outputs());
  if (integrator.value(w.data(), end.data()) != IntegrationStatus::success)
    end.setConstant(std::nan(""));
  return end;
}

/// Derivatives of the above with respect to w; NaN if the integration fails.
inline MatrixXd sensitivities(Integrator& integrator, const VectorXd& w) {
  VectorXd end(integrator.outputs());
  MatrixXd derivative(integrator.outputs(), w.size());
  if (integrator.jacobian(w.data(), end.data(), derivative) != IntegrationStatus::success)
    derivative.setConstant(std::nan(""));
  return derivative;
}

/// y1' = y2, y2' = a (1 - y1^2) y2 - b y1; stiff for large a. Not differentiated.
inline IntervalProblem van_der_pol(double b, double a) {
  IntervalProblem problem;
  problem.arguments = {2, 0, 0};
  problem.dynamics = make_function<2, 0, 0>([a, b](const auto&, const auto& y) {
    using S = std::decay_t<decltype(y[0])>;
    return Vec<S, 2>(y[1], a * (1.0 - y[0] * y[0]) * y[1] - b * y[0]);
  });
  return problem;
}

struct RobertsonKinetics {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& y, const Vec<S, 0>&, const Vec<S, 3>& p) const {
    const S slow = p[0] * y[0], fast = p[1] * y[1] * y[2], middle = p[2] * y[1] * y[1];
    return {fast - slow, slow - fast - middle, middle};
  }
};

/// Chemical kinetics with a component of 1e-5: its nominal magnitude makes the absolute tolerance
/// of that component small enough.
inline IntervalProblem robertson() {
  IntervalProblem problem;
  problem.arguments = {3, 0, 3};
  problem.dynamics = make_function<3, 0, 3>(RobertsonKinetics{});
  problem.differentiate_parameter = {true, true, true};
  problem.nominal_state = (VectorXd(3) << 1.0, 1e-5, 1.0).finished();
  return problem;
}

inline VectorXd robertson_point(double time) {
  return (VectorXd(8) << 1.0, 0.0, 0.0, 0.04, 1e4, 3e7, 0.0, time).finished();
}

/// Restricted three-body problem; the orbit closes after one period.
struct RestrictedThreeBody {
  double mu = 0.012277471;
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& y) const {
    const double rest = 1.0 - mu;
    const S a = y[0] + mu, b = y[0] - rest;
    const S d1 = a * a + y[1] * y[1], d2 = b * b + y[1] * y[1];
    const S r1 = d1 * sqrt(d1), r2 = d2 * sqrt(d2);
    return {y[2], y[3], y[0] + 2.0 * y[3] - rest * a / r1 - mu * b / r2,
            y[1] - 2.0 * y[2] - rest * y[1] / r1 - mu * y[1] / r2};
  }
};

inline IntervalProblem arenstorf() {
  IntervalProblem problem;
  problem.arguments = {4, 0, 0};
  problem.dynamics = make_function<4, 0, 0>(RestrictedThreeBody{});
  return problem;
}

inline VectorXd arenstorf_point() {
  return (VectorXd(6) << 0.994, 0.0, 0.0, -2.00158510637908252240537862224, 0.0,
          17.0652165601579625588917206249)
      .finished();
}

}  // namespace saltus::library
