#include "saltus/solver/variable_scale.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/scaled_program.hpp"

namespace saltus {
namespace {

constexpr int rounds = 3;  // from one quantity of unknown size to the next
// Estimates within are not trusted: over one interval states move by a part of what they are.
constexpr double smallest_estimate = 1e-5, largest_estimate = 1e5;

}  // namespace

VectorXd measure_variables(NonlinearProgram& program, const VectorXd& w,
                           const std::vector<std::vector<int>>& quantities) {
  const int n = program.variables();
  VectorXd scale = VectorXd::Ones(n);
  std::vector<double> entries(program.jacobian_pattern().entries());
  if (w.size() != n || !program.jacobian(w.data(), entries.data())) return scale;

  const std::size_t count = quantities.size();
  std::vector<int> quantity_of(n, -1);
  std::vector<double> size(count, 0.0), bound(count, infinity);
  for (std::size_t q = 0; q < count; ++q) {
    double largest = 0.0;
    for (const int v : quantities[q]) {
      quantity_of[v] = static_cast<int>(q);
      size[q] = std::max(size[q], std::abs(w[v]));
      for (const double b : {program.lower()[v], program.upper()[v]})
        if (std::isfinite(b)) largest = std::max(largest, std::abs(b));
    }
    if (largest > 0.0) bound[q] = largest;
  }
  std::vector<char> is_estimated(count, 0);
  for (std::size_t q = 0; q < count; ++q) is_estimated[q] = size[q] == 0.0;
  const auto size_of = [&](int v) { return quantity_of[v] < 0 ? 1.0 : size[quantity_of[v]]; };
  for (int round = 0; round < rounds; ++round) {
    VectorXd known = VectorXd::Zero(program.rows());
    program.jacobian_pattern().for_each([&](int r, int c, int e) {
      known[r] = std::max(known[r], std::abs(entries[e]) * size_of(c));
    });
    std::vector<double> found(count, infinity);
    program.jacobian_pattern().for_each([&](int r, int c, int e) {
      const int q = quantity_of[c];
      if (q < 0 || size[q] > 0.0 || entries[e] == 0.0 || known[r] == 0.0) return;
      found[q] = std::min(found[q], known[r] / std::abs(entries[e]));
    });
    for (std::size_t q = 0; q < count; ++q)
      if (std::isfinite(found[q])) size[q] = std::min(found[q], bound[q]);
  }
  for (std::size_t q = 0; q < count; ++q) {
    if (size[q] == 0.0 && std::isfinite(bound[q])) size[q] = bound[q];
    if (is_estimated[q] && size[q] >= smallest_estimate && size[q] <= largest_estimate) continue;
    for (const int v : quantities[q]) scale[v] = scale_for(size[q]);
  }
  return scale;
}

}  // namespace saltus
