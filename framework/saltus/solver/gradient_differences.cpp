#include "saltus/solver/gradient_differences.hpp"

#include <algorithm>

namespace saltus {
namespace {

constexpr double step = 1e-4;  // in scaled variables

// Neighbours in both triangles, by rows, including the diagonal.
std::vector<std::vector<int>> neighbours_of(const SparsityPattern& lower) {
  std::vector<std::vector<int>> neighbours(lower.rows());
  lower.for_each([&](int r, int c, int) {
    neighbours[r].push_back(c);
    if (r != c) neighbours[c].push_back(r);
  });
  return neighbours;
}

// Assigns each variable the first colour not used in a shared row.
std::vector<int> colour(const std::vector<std::vector<int>>& neighbours, int& colours) {
  std::vector<int> colour_of(neighbours.size(), -1), taken_by;
  colours = 0;
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    taken_by.resize(colours + 1, -1);
    for (const int row : neighbours[i])
      for (const int other : neighbours[row])
        if (colour_of[other] >= 0) taken_by[colour_of[other]] = static_cast<int>(i);
    int c = 0;
    while (c < colours && taken_by[c] == static_cast<int>(i)) ++c;
    colour_of[i] = c;
    colours = std::max(colours, c + 1);
  }
  return colour_of;
}

}  // namespace

bool difference_gradients(NonlinearProgram& program, const NlpPoint& point,
                          const SparsityPattern& pattern, std::vector<double>& hessian) {
  const int n = program.variables();
  std::vector<double> jacobian(program.jacobian_pattern().entries());
  const auto gradient = [&](const VectorXd& w, VectorXd& result) {
    result.resize(n);
    if (!program.gradient(w.data(), result.data()) || !program.jacobian(w.data(), jacobian.data()))
      return false;
    program.jacobian_pattern().for_each(
        [&](int r, int c, int e) { result[c] += point.lambda[r] * jacobian[e]; });
    return true;
  };

  int colours = 0;
  const std::vector<int> colour_of = colour(neighbours_of(pattern), colours);
  std::fill(hessian.begin(), hessian.end(), 0.0);
  VectorXd w = point.w, above, below;
  for (int c = 0; c < colours; ++c) {
    for (int i = 0; i < n; ++i)
      if (colour_of[i] == c) w[i] = point.w[i] + step;
    if (!gradient(w, above)) return false;
    for (int i = 0; i < n; ++i)
      if (colour_of[i] == c) w[i] = point.w[i] - step;
    if (!gradient(w, below)) return false;
    for (int i = 0; i < n; ++i)
      if (colour_of[i] == c) w[i] = point.w[i];
    // An entry appears in the difference of its column and of its row; the mean is symmetric.
    pattern.for_each([&](int row, int col, int e) {
      if (colour_of[col] == c) hessian[e] += 0.5 * (above[row] - below[row]) / (2.0 * step);
      if (colour_of[row] == c) hessian[e] += 0.5 * (above[col] - below[col]) / (2.0 * step);
    });
  }
  return true;
}

}  // namespace saltus
