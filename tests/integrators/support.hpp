// The problems and the differencing that the integrator tests share.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::test {

/// Nonlinear, time-dependent, with parameters: every kind of derivative is non-zero somewhere. Of
/// (x, u, p) in R^3 x R^2 x R^3, with two running costs; p[1] is not differentiated.
IntervalProblem coupled_problem(InputShape shape);

/// (x0 | c | p | t0 | h) for coupled_problem().
VectorXd coupled_point(InputShape shape);

/// Affine in (x, u) in R^3 x R^2 for every p in R^2, with p in A, B and the constant part; two
/// running costs, quadratic in (x, u).
IntervalProblem affine_problem(InputShape shape, bool parameters, bool time);

/// (x0 | c | p | t0 | h) for affine_problem().
VectorXd affine_point(InputShape shape, double h);

VectorXd end_of(Integrator& integrator, const VectorXd& w);

MatrixXd jacobian_of(Integrator& integrator, const VectorXd& w);

MatrixXd hessian_of(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                    Curvature curvature = Curvature::exact);

/// From `end`, which integrating over w gives, back to the start of w: where coupled_problem() is
/// integrated backwards in time, its inputs in reverse.
VectorXd way_back(const Integrator& integrator, const VectorXd& w, const VectorXd& end);

/// Columns of w that the problem differentiates.
std::vector<int> differentiated_columns(const Integrator& integrator);

/// Central differences, extrapolated twice: for functions with derivatives of order one the error
/// is near (step)^6 + 1e-16 / step.
MatrixXd differences(const std::function<VectorXd(const VectorXd&)>& function, const VectorXd& at,
                     double step = 4e-3);

/// Keeps the differentiated columns of a matrix and sets the others to zero.
MatrixXd only_differentiated(const Integrator& integrator, const MatrixXd& full);

/// First derivatives against differences of value(), all columns (those not asked for: zero).
void expect_jacobian_matches(Integrator& integrator, const VectorXd& w, double tolerance);

/// Second derivatives against differences of the weighted jacobian().
void expect_hessian_matches(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                            double tolerance);

/// What D02 gives at 0.4 s, to the rates of its three reactions, where robertson() is integrated.
void expect_robertson_sensitivities(Integrator& integrator);

double relative_error(double value, double reference);

}  // namespace saltus::test
