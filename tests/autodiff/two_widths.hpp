// A formula and its derivatives for objects of different vector widths in one program.
#pragma once

#include <string>
#include <typeinfo>
#include <vector>

#include "saltus/model/make_function.hpp"

namespace saltus::two_widths {

/// Products of six inputs. The Jacobian takes several passes at narrow widths and one at the
/// widest.
struct Product {
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {x[0] * x[1] * x[2] * x[3] * u[0] * u[1], x[0] * x[2] + t * u[1]};
  }
};

struct Derivatives {
  int lanes = 0;
  std::string scalar;  // mangled name of the scalar type
  double value[2];
  std::vector<double> jacobian, hessian;  // entries of the patterns
};

// Each object defines its own version.
static Derivatives derivatives_here() {
  const Function f = make_function<4, 2, 0>(Product{});
  const double z[7] = {0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, weights[2] = {1.0, -1.0};
  Derivatives d;
  d.lanes = native_lanes;
  d.scalar = typeid(Dual<double, 3>).name();
  d.jacobian.resize(f.jacobian_pattern().entries());
  d.hessian.resize(f.hessian_pattern().entries());
  f.jacobian(z, d.value, d.jacobian.data());
  f.hessian(z, weights, d.hessian.data(), Curvature::exact);
  return d;
}

Derivatives derivatives_narrow();
Derivatives derivatives_wide();

}  // namespace saltus::two_widths
