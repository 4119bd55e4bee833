#include "tests/integrators/support.hpp"

#include "problems/library/initial_value_problems.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::test {
namespace {

struct CoupledDynamics {
  template <class S>
  Vec<S, 3> operator()(const S& t, const Vec<S, 3>& x, const Vec<S, 2>& u,
                       const Vec<S, 3>& p) const {
    Vec<S, 3> rate;
    rate[0] = x[1] + p[0] * sin(t) * u[0];
    rate[1] = -p[1] * sin(x[0]) - 0.2 * x[1] * x[1] * x[1] + u[0] * cos(x[2]) * p[2];
    rate[2] = x[0] * x[1] * exp(-0.3 * t) + u[1] * u[1] * p[2] - x[2];
    return rate;
  }
};

struct CoupledCosts {
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 3>& x, const Vec<S, 2>& u,
                       const Vec<S, 3>& p) const {
    Vec<S, 2> cost;
    cost[0] = (x[0] - 0.3 * t) * (x[0] - 0.3 * t) + u[0] * u[0] * x[1] * x[1];
    cost[1] = exp(0.2 * x[2]) * u[1] + p[0] * x[0] * p[2];
    return cost;
  }
};

struct AffineDynamics {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 2>& u, const Vec<S, 2>& p) const {
    return {x[1] + 0.3, -p[0] * p[0] * x[0] - 0.4 * x[1] + u[0] * sin(p[1]) + p[1],
            0.5 * x[0] - p[1] * x[2] + 2.0 * u[1] - 0.7 * u[0]};
  }
};

struct QuadraticCosts {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 2>& u, const Vec<S, 2>& p) const {
    return {(x[0] - p[0]) * (x[0] - p[0]) + p[1] * x[1] * u[0] + 0.1 * u[1] * u[1] * p[0],
            x[2] * x[2] * p[0] * p[0] - 3.0 * x[0] + exp(p[1]) + u[0] * x[2]};
  }
};

}  // namespace

IntervalProblem coupled_problem(InputShape shape) {
  IntervalProblem problem;
  problem.arguments = {3, 2, 3};
  problem.dynamics = make_function<3, 2, 3>(CoupledDynamics{});
  problem.running_cost = make_function<3, 2, 3>(CoupledCosts{});
  problem.shape = shape;
  problem.differentiate_parameter = {true, false, true};
  problem.differentiate_time = true;
  return problem;
}

VectorXd coupled_point(InputShape shape) {
  VectorXd w(shape == InputShape::constant ? 10 : 12);
  if (shape == InputShape::constant)
    w << 0.4, -0.7, 0.2, 0.5, -0.8, 1.1, 0.9, 0.7, 0.3, 0.6;
  else
    w << 0.4, -0.7, 0.2, 0.5, -0.8, -0.3, 0.6, 1.1, 0.9, 0.7, 0.3, 0.6;
  return w;
}

IntervalProblem affine_problem(InputShape shape, bool parameters, bool time) {
  IntervalProblem problem;
  problem.arguments = {3, 2, 2};
  problem.dynamics = make_function<3, 2, 2>(AffineDynamics{});
  problem.running_cost = make_function<3, 2, 2>(QuadraticCosts{});
  problem.shape = shape;
  if (parameters) problem.differentiate_parameter = {true, true};
  problem.differentiate_time = time;
  return problem;
}

VectorXd affine_point(InputShape shape, double h) {
  VectorXd w(shape == InputShape::constant ? 9 : 11);
  if (shape == InputShape::constant)
    w << 0.4, -0.7, 0.2, 0.5, -0.8, 1.1, 0.9, 5.0, h;
  else
    w << 0.4, -0.7, 0.2, 0.5, -0.8, 0.1, 1.6, 1.1, 0.9, 5.0, h;
  return w;
}

VectorXd end_of(Integrator& integrator, const VectorXd& w) {
  VectorXd end(integrator.outputs());
  EXPECT_EQ(integrator.value(w.data(), end.data()), IntegrationStatus::success);
  return end;
}

MatrixXd jacobian_of(Integrator& integrator, const VectorXd& w) {
  VectorXd end(integrator.outputs());
  MatrixXd derivative = MatrixXd::Constant(integrator.outputs(), w.size(), -1e3);
  EXPECT_EQ(integrator.jacobian(w.data(), end.data(), derivative), IntegrationStatus::success);
  return derivative;
}

VectorXd way_back(const Integrator& integrator, const VectorXd& w, const VectorXd& end) {
  const IntervalArguments index = integrator.arguments();
  VectorXd back = w;
  back.head(3) = end.head(3);
  back[index.t0()] += w[index.h()];
  back[index.h()] = -w[index.h()];
  if (integrator.problem().shape == InputShape::linear) {
    back.segment(index.c(), 2) = w.segment(index.c(2), 2);
    back.segment(index.c(2), 2) = w.segment(index.c(), 2);
  }
  return back;
}

MatrixXd hessian_of(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                    Curvature curvature) {
  MatrixXd hessian = MatrixXd::Constant(w.size(), w.size(), -1e3);
  EXPECT_EQ(integrator.hessian(w.data(), weights.data(), hessian, curvature),
            IntegrationStatus::success);
  return hessian;
}

std::vector<int> differentiated_columns(const Integrator& integrator) {
  const IntervalProblem& problem = integrator.problem();
  const IntervalArguments index = integrator.arguments();
  std::vector<int> columns;
  columns.reserve(index.size());
  for (int i = 0; i < index.p(); ++i) columns.push_back(i);
  for (int i = 0; i < index.np; ++i)
    if (problem.differentiate_parameter[i]) columns.push_back(index.p(i));
  if (problem.differentiate_time) {
    columns.push_back(index.t0());
    columns.push_back(index.h());
  }
  return columns;
}

MatrixXd differences(const std::function<VectorXd(const VectorXd&)>& function, const VectorXd& at,
                     double step) {
  const auto central = [&](int column, double h) -> VectorXd {
    VectorXd above = at, below = at;
    above[column] += h;
    below[column] -= h;
    return (function(above) - function(below)) / (2.0 * h);
  };
  MatrixXd derivative(function(at).size(), at.size());
  for (int c = 0; c < at.size(); ++c) {
    const VectorXd d1 = central(c, step), d2 = central(c, step / 2), d3 = central(c, step / 4);
    const VectorXd e1 = (4.0 * d2 - d1) / 3.0, e2 = (4.0 * d3 - d2) / 3.0;
    derivative.col(c) = (16.0 * e2 - e1) / 15.0;
  }
  return derivative;
}

MatrixXd only_differentiated(const Integrator& integrator, const MatrixXd& full) {
  MatrixXd kept = MatrixXd::Zero(full.rows(), full.cols());
  for (const int c : differentiated_columns(integrator)) kept.col(c) = full.col(c);
  return kept;
}

void expect_jacobian_matches(Integrator& integrator, const VectorXd& w, double tolerance) {
  const MatrixXd expected = only_differentiated(
      integrator, differences([&](const VectorXd& at) { return end_of(integrator, at); }, w));
  const MatrixXd given = jacobian_of(integrator, w);
  EXPECT_LE((given - expected).cwiseAbs().maxCoeff(), tolerance) << "given\n"
                                                                 << given << "\ndifferences\n"
                                                                 << expected;
}

void expect_hessian_matches(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                            double tolerance) {
  ASSERT_TRUE(integrator.has_hessian());
  const MatrixXd expected = only_differentiated(
      integrator, differences(
                      [&](const VectorXd& at) -> VectorXd {
                        return jacobian_of(integrator, at).transpose() * weights;
                      },
                      w));
  const MatrixXd given = hessian_of(integrator, w, weights);
  EXPECT_LE((given - expected).cwiseAbs().maxCoeff(), tolerance) << "given\n"
                                                                 << given << "\ndifferences\n"
                                                                 << expected;
  EXPECT_EQ((given - given.transpose()).cwiseAbs().maxCoeff(), 0.0);
}

void expect_robertson_sensitivities(Integrator& integrator) {
  Mat<double, 3, 3> expected;
  expected << -0.355952565984, 9.54238142759e-8, -1.58317663551e-11,  //
      3.90254405381e-4, -2.13096103022e-10, -5.29004109321e-13,       //
      0.355562311578, -9.52107181728e-8, 1.63607704645e-11;
  const MatrixXd derivative = jacobian_of(integrator, library::robertson_point(0.4));
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(relative_error(derivative(i, 3 + k), expected(i, k)), 1e-8) << i << " " << k;
}

void expect_undefined(const IntegratorScheme& scheme) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics =
      make_function<1, 0, 0>([](const auto&, const auto& x) { return log(x[0]) * 1.0; });
  const auto integrator = scheme.make(problem);
  const VectorXd w = (VectorXd(3) << -1.0, 0.0, 1.0).finished(), weight = VectorXd::Ones(1);
  VectorXd end(1);
  MatrixXd derivative(1, 3), hessian(3, 3);
  EXPECT_EQ(integrator->value(w.data(), end.data()), IntegrationStatus::not_finite);
  EXPECT_EQ(integrator->failure(), "");  // only failures of Newton's method are explained
  EXPECT_EQ(integrator->jacobian(w.data(), end.data(), derivative), IntegrationStatus::not_finite);
  if (integrator->has_hessian()) {
    EXPECT_EQ(integrator->hessian(w.data(), weight.data(), hessian, Curvature::exact),
              IntegrationStatus::not_finite);
  }
}

double relative_error(double value, double reference) {
  return std::abs(value - reference) / std::abs(reference);
}

}  // namespace saltus::test
