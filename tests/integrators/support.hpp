// Problems and finite differences shared by the integrator tests.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::test {

/// A nonlinear, time-dependent problem with parameters, in which every kind of derivative is
/// nonzero somewhere. The arguments are (x, u, p) in R^3 x R^2 x R^3. It has two running costs;
/// p[1] is not differentiated.
IntervalProblem coupled_problem(InputShape shape);

/// The point (x0 | c | p | t0 | h) for coupled_problem().
VectorXd coupled_point(InputShape shape);

/// A problem affine in (x, u) in R^3 x R^2 for every p in R^2, with p in A, B and the constant
/// part. It has two running costs, quadratic in (x, u).
IntervalProblem affine_problem(InputShape shape, bool parameters, bool time);

/// The point (x0 | c | p | t0 | h) for affine_problem().
VectorXd affine_point(InputShape shape, double h);

VectorXd end_of(Integrator& integrator, const VectorXd& w);

MatrixXd jacobian_of(Integrator& integrator, const VectorXd& w);

MatrixXd hessian_of(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                    Curvature curvature = Curvature::exact);

/// The reversed point: starts at `end`, the result of integration over w, and leads back to the
/// start of w. coupled_problem() runs backwards in time with its inputs reversed.
VectorXd way_back(const Integrator& integrator, const VectorXd& w, const VectorXd& end);

/// Columns of w that the problem differentiates.
std::vector<int> differentiated_columns(const Integrator& integrator);

/// Central differences, extrapolated twice. For functions with derivatives of order one, the error
/// is near (step)^6 + 1e-16 / step.
MatrixXd differences(const std::function<VectorXd(const VectorXd&)>& function, const VectorXd& at,
                     double step = 4e-3);

/// Keeps the differentiated columns of a matrix and sets the others to zero.
MatrixXd only_differentiated(const Integrator& integrator, const MatrixXd& full);

/// Compares first derivatives with differences of value() in all columns. Columns that are not
/// requested are zero.
void expect_jacobian_matches(Integrator& integrator, const VectorXd& w, double tolerance);

/// Compares second derivatives with differences of the weighted jacobian().
void expect_hessian_matches(Integrator& integrator, const VectorXd& w, const VectorXd& weights,
                            double tolerance);

/// The reference of D02 at 0.4 s, with respect to the rates of its three reactions, for
/// robertson().
void expect_robertson_sensitivities(Integrator& integrator);

/// x' = log x from -1: the scheme reports `not_finite` for the value and all derivatives it has.
void expect_undefined(const IntegratorScheme& scheme);

double relative_error(double value, double reference);

}  // namespace saltus::test
