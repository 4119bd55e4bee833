// Coefficients of collocation methods with nodes c_i and their Lagrange polynomials l_j:
//   a_ij = int_0^{c_i} l_j,   b_j = int_0^1 l_j.
// E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., sec. IV.5. Computed in
// long double, so that all digits of a double are correct.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {
namespace {

using Real = long double;

constexpr int most_stages = 4;

void check_stages(const char* scheme, int stages) {
  if (stages < 1 || stages > most_stages)
    throw DefinitionError(
        fmt::format("{} has 1 to {} stages, but stages = {}.", scheme, most_stages, stages));
}

// P_n(2 c - 1) by Bonnet's recursion.
Real legendre(int n, Real c) {
  const Real x = 2 * c - 1;
  Real before = 0, now = 1;
  for (int k = 0; k < n; ++k) {
    const Real next = ((2 * k + 1) * x * now - k * before) / (k + 1);
    before = now;
    now = next;
  }
  return now;
}

// The `count` simple zeros in (0, 1) in ascending order, by sampling and bisection.
template <class Polynomial>
std::vector<Real> zeros(int count, Polynomial polynomial) {
  constexpr int samples = 97, bisections = 70;  // to the last digit
  std::vector<Real> result;
  for (int i = 0; i < samples && static_cast<int>(result.size()) < count; ++i) {
    Real low = Real(i) / samples, high = Real(i + 1) / samples;
    if (polynomial(low) * polynomial(high) > 0) continue;
    for (int k = 0; k < bisections; ++k) {
      const Real middle = (low + high) / 2;
      (polynomial(low) * polynomial(middle) <= 0 ? high : low) = middle;
    }
    result.push_back((low + high) / 2);
  }
  return result;
}

// int_0^end of the Lagrange polynomial of node j.
Real integral(const std::vector<Real>& nodes, int j, Real end) {
  std::array<Real, most_stages> coefficients = {1};  // ascending powers
  int degree = 0;
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    if (i == j) continue;
    const Real scale = 1 / (nodes[j] - nodes[i]);
    for (int k = ++degree; k >= 0; --k)
      coefficients[k] = scale * ((k > 0 ? coefficients[k - 1] : 0) -
                                 (k < degree ? nodes[i] * coefficients[k] : 0));
  }
  Real sum = 0;
  for (int k = degree; k >= 0; --k) sum = sum * end + coefficients[k] / (k + 1);
  return sum * end;
}

ButcherTableau collocation(std::string name, int order, const std::vector<Real>& nodes) {
  const int stages = static_cast<int>(nodes.size());
  ButcherTableau tableau{std::move(name), order, MatrixXd(stages, stages), VectorXd(stages),
                         VectorXd(stages)};
  for (int i = 0; i < stages; ++i) {
    tableau.c[i] = static_cast<double>(nodes[i]);
    tableau.b[i] = static_cast<double>(integral(nodes, i, 1));
    for (int j = 0; j < stages; ++j)
      tableau.a(i, j) = static_cast<double>(integral(nodes, j, nodes[i]));
  }
  return tableau;
}

}  // namespace

ButcherTableau gauss_legendre_tableau(int stages) {
  check_stages("Gauss-Legendre", stages);
  return collocation(fmt::format("Gauss-Legendre {}", 2 * stages), 2 * stages,
                     zeros(stages, [&](Real c) { return legendre(stages, c); }));
}

ButcherTableau radau_iia_tableau(int stages) {
  check_stages("Radau IIA", stages);
  std::vector<Real> nodes =
      zeros(stages - 1, [&](Real c) { return legendre(stages, c) - legendre(stages - 1, c); });
  nodes.push_back(1);
  return collocation(fmt::format("Radau IIA {}", 2 * stages - 1), 2 * stages - 1, nodes);
}

}  // namespace saltus
