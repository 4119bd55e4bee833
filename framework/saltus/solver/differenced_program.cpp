// Sparse differences after A. R. Curtis, M. J. D. Powell, J. K. Reid, On the estimation of sparse
// Jacobian matrices, 1974. Rows of hubs are read from the columns of the hubs (symmetry).
#include "saltus/solver/differenced_program.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {
namespace {

constexpr double step = 1e-4;  // in scaled variables
// A hub is coupled to this many times more variables than the median, and to more than least_hub.
constexpr int hub_factor = 4, least_hub = 12;
// Relative to the largest entry: smaller entries are rounding errors and would couple unrelated
// stages.
constexpr double noise = 1e-9;

}  // namespace

std::optional<Curvature> supported_curvature(const NonlinearProgram& program, Curvature asked) {
  for (const Curvature curvature : {asked, Curvature::exact})
    if (program.supports(curvature)) return curvature;
  return std::nullopt;
}

DifferencedProgram::DifferencedProgram(NonlinearProgram& program)
    : program_(program),
      hessian_pattern_(program.curvature_pattern()),
      colour_of_(program.variables(), -1),
      is_hub_(program.variables(), 0),
      above_(program.variables()),
      below_(program.variables()),
      jacobian_(program.jacobian_pattern().entries()) {
  const int n = program.variables();
  std::vector<std::vector<int>> neighbours(n);
  hessian_pattern_.for_each([&](int r, int c, int) {
    neighbours[r].push_back(c);
    if (r != c) neighbours[c].push_back(r);
  });
  std::vector<std::size_t> degrees;
  degrees.reserve(neighbours.size());
  for (const std::vector<int>& list : neighbours) degrees.push_back(list.size());
  if (n > 0) std::nth_element(degrees.begin(), degrees.begin() + n / 2, degrees.end());
  const std::size_t usual = n > 0 ? degrees[n / 2] : 0;
  for (int i = 0; i < n; ++i)
    is_hub_[i] = neighbours[i].size() > std::max<std::size_t>(hub_factor * usual, least_hub);
  // Hubs have their own colour. Other variables get the first colour not used in a shared row.
  std::vector<int> taken_by;
  for (int i = 0; i < n; ++i)
    if (is_hub_[i]) colour_of_[i] = colours_++;
  const int first = colours_;
  for (int i = 0; i < n; ++i) {
    if (is_hub_[i] || neighbours[i].empty()) continue;
    taken_by.resize(colours_ + 1, -1);
    for (const int row : neighbours[i]) {
      if (is_hub_[row]) continue;
      for (const int other : neighbours[row])
        if (!is_hub_[other] && colour_of_[other] >= 0) taken_by[colour_of_[other]] = i;
    }
    int c = first;
    while (c < colours_ && taken_by[c] == i) ++c;
    colour_of_[i] = c;
    colours_ = std::max(colours_, c + 1);
  }
}

bool DifferencedProgram::lagrangian_gradient(double sigma, const double* lambda, VectorXd& result) {
  if (!program_.gradient(w_.data(), result.data()) ||
      !program_.jacobian(w_.data(), jacobian_.data()))
    return false;
  result *= sigma;
  program_.jacobian_pattern().for_each(
      [&](int r, int c, int e) { result[c] += lambda[r] * jacobian_[e]; });
  return result.allFinite();
}

bool DifferencedProgram::hessian(const double* w, double sigma, const double* lambda,
                                 double* entries, Curvature) {
  const int n = variables();
  const Eigen::Map<const VectorXd> at(w, n);
  std::fill(entries, entries + hessian_pattern_.entries(), 0.0);
  w_ = at;
  for (int c = 0; c < colours_; ++c) {
    for (int i = 0; i < n; ++i)
      if (colour_of_[i] == c) w_[i] = at[i] + step;
    const bool has_above = lagrangian_gradient(sigma, lambda, above_);
    for (int i = 0; i < n; ++i)
      if (colour_of_[i] == c) w_[i] = at[i] - step;
    const bool has_below = lagrangian_gradient(sigma, lambda, below_);
    w_ = at;
    if (!has_above || !has_below) {  // one-sided at the edge of the domain of the functions
      if (!has_above && !has_below) return false;
      VectorXd& missing = has_above ? below_ : above_;
      if (!lagrangian_gradient(sigma, lambda, missing)) return false;
    }
    const double width = has_above && has_below ? 2.0 * step : step;
    // An entry appears in the difference of its column and of its row. The result is the mean,
    // except for hubs, whose rows mix the variables of a colour.
    hessian_pattern_.for_each([&](int row, int col, int e) {
      const bool from_col = colour_of_[col] == c && !(is_hub_[row] && !is_hub_[col]);
      const bool from_row = colour_of_[row] == c && !(is_hub_[col] && !is_hub_[row]);
      const double share = is_hub_[row] != is_hub_[col] ? 1.0 : 0.5;
      if (from_col) entries[e] += share * (above_[row] - below_[row]) / width;
      if (from_row) entries[e] += share * (above_[col] - below_[col]) / width;
    });
  }
  double most = 0.0;
  for (int e = 0; e < hessian_pattern_.entries(); ++e) most = std::max(most, std::abs(entries[e]));
  for (int e = 0; e < hessian_pattern_.entries(); ++e)
    if (std::abs(entries[e]) <= noise * most) entries[e] = 0.0;
  return true;
}

}  // namespace saltus
