// Runs the calls of a solver to an integrator in one iteration: values, Jacobians and Hessians.
// compare_instructions.py counts the instructions:
//
//     scheme_instructions rk4|gauss4|rk8|gauss8
//
// The program prints the compiler and its vector width.
#include <fmt/format.h>

#include <cstdlib>
#include <map>
#include <string>
#include <type_traits>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/make_function.hpp"

namespace {

using namespace saltus;  // NOLINT(google-build-using-namespace): one file

/// A pendulum with a torque.
IntervalProblem pendulum() {
  IntervalProblem problem;
  problem.arguments = {2, 1, 0};
  problem.dynamics = make_function<2, 1, 0>([](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[1], u[0] - 9.81 * sin(x[0]) - 0.1 * x[1]};
  });
  return problem;
}

}  // namespace

/// The instruction counter finds this function by its name.
__attribute__((noinline)) void iterate(Integrator& integrator, int iterations) {
  const VectorXd w = (VectorXd(5) << 0.7, -1.2, 0.4, 0.0, 0.05).finished();
  const VectorXd weights = (VectorXd(2) << 0.3, -0.8).finished();
  VectorXd end(2);
  MatrixXd derivative(2, 5), hessian(5, 5);
  for (int i = 0; i < iterations; ++i) {
    integrator.value(w.data(), end.data());
    integrator.jacobian(w.data(), end.data(), derivative);
    integrator.hessian(w.data(), weights.data(), hessian, Curvature::exact);
  }
}

int main(int arguments, char** argument) {
  const std::map<std::string, IntegratorChoice> schemes{{"rk4", runge_kutta4()},
                                                        {"gauss4", gauss_legendre({.stages = 2})},
                                                        {"rk8", runge_kutta8()},
                                                        {"gauss8", gauss_legendre({.stages = 4})}};
  if (arguments != 2 || !schemes.contains(argument[1])) return EXIT_FAILURE;
  const auto integrator = schemes.at(argument[1])->make(pendulum());
  iterate(*integrator, 100);
  fmt::print("gcc {}, vectors of {}\n", __GNUC__, Eigen::internal::packet_traits<double>::size);
  return EXIT_SUCCESS;
}
