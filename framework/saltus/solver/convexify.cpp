#include "saltus/solver/convexify.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace saltus {
namespace {

constexpr int largest_dense = 512;  // variables of a part whose convexity is tested
// Negative pivots up to this size, relative to the largest entry, count as zero.
constexpr double zero_pivot = 1e-12, zero_coupled_pivot = 1e-10;

using Neighbours = std::vector<std::vector<int>>;

// Connected components of the variables after those of `without` are removed.
std::vector<std::vector<int>> components(const std::vector<int>& variables,
                                         const Neighbours& neighbours,
                                         const std::vector<int>& without) {
  std::vector<char> open(neighbours.size(), 0);
  for (const int i : variables) open[i] = 1;
  for (const int i : without) open[i] = 0;
  std::vector<std::vector<int>> found;
  for (const int first : variables) {
    if (!open[first]) continue;
    std::vector<int> members{first};
    open[first] = 0;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (const int i : neighbours[members[k]])
        if (open[i]) {
          open[i] = 0;
          members.push_back(i);
        }
    std::sort(members.begin(), members.end());
    found.push_back(std::move(members));
  }
  return found;
}

// Eliminates the first `count` variables of the lower triangle by Cholesky's method. False if they
// have negative curvature. Zero pivots are accepted if the rest of their column is zero.
bool eliminate(Eigen::Ref<MatrixXd> a, Eigen::Index count, double rounding) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index j = 0; j < count; ++j) {
    const double pivot = a(j, j);
    if (pivot <= rounding) {
      for (Eigen::Index i = j; i < n; ++i)
        if (a(i, j) < -rounding || (i > j && a(i, j) > rounding)) return false;
      continue;
    }
    for (Eigen::Index k = j + 1; k < n; ++k) {
      if (a(k, j) == 0.0) continue;
      const double factor = a(k, j) / pivot;
      for (Eigen::Index i = k; i < n; ++i) a(i, k) -= factor * a(i, j);
    }
  }
  return true;
}

// Jacobi's method: rotates until a is diagonal with the eigenvalues; V receives the eigenvectors.
// Eigen's solver is faster for large blocks, but allocates.
void diagonalise(MatrixXd& a, MatrixXd& V) {
  const Eigen::Index n = a.rows();
  constexpr int most_sweeps = 30;
  V.setIdentity();
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double off = 0.0;
    for (Eigen::Index q = 1; q < n; ++q)
      for (Eigen::Index p = 0; p < q; ++p) off = std::max(off, std::abs(a(p, q)));
    if (off <= 1e-15 * a.diagonal().cwiseAbs().maxCoeff()) return;
    for (Eigen::Index q = 1; q < n; ++q)
      for (Eigen::Index p = 0; p < q; ++p) {
        if (a(p, q) == 0.0) continue;
        const double cotangent = 0.5 * (a(q, q) - a(p, p)) / a(p, q);
        const double t =
            (cotangent < 0.0 ? -1.0 : 1.0) / (std::abs(cotangent) + std::hypot(cotangent, 1.0));
        const double c = 1.0 / std::hypot(t, 1.0), s = t * c;
        for (Eigen::Index i = 0; i < n; ++i) {
          const double ip = a(i, p), iq = a(i, q);
          a(i, p) = c * ip - s * iq;
          a(i, q) = s * ip + c * iq;
        }
        for (Eigen::Index i = 0; i < n; ++i) {
          const double pi = a(p, i), qi = a(q, i);
          a(p, i) = c * pi - s * qi;
          a(q, i) = s * pi + c * qi;
          const double vp = V(i, p), vq = V(i, q);
          V(i, p) = c * vp - s * vq;
          V(i, q) = s * vp + c * vq;
        }
      }
  }
}

}  // namespace

SparsityPattern with_diagonal(const SparsityPattern& pattern) {
  std::vector<std::pair<int, int>> pairs;
  pattern.for_each([&](int r, int c, int) { pairs.emplace_back(r, c); });
  for (int i = 0; i < pattern.rows(); ++i) pairs.emplace_back(i, i);
  return SparsityPattern::from_pairs(pattern.rows(), pattern.cols(), std::move(pairs));
}

Convexification::Convexification(const SparsityPattern& pattern, int largest_part)
    : largest_part_(largest_part), before_(VectorXd::Zero(pattern.entries())) {
  const int n = pattern.rows();
  std::vector<std::vector<int>> neighbours(n);
  pattern.for_each([&](int r, int c, int) {
    if (r == c) return;
    neighbours[r].push_back(c);
    neighbours[c].push_back(r);
  });
  std::vector<int> everything(n);
  std::iota(everything.begin(), everything.end(), 0);
  for (const std::vector<int>& variables : components(everything, neighbours, {}))
    add_block(pattern, variables, neighbours);
  for (int i = 0; i < n; ++i) diagonal_.push_back(pattern.find(i, i));
  int most = 0, coupling = 0;
  for (const Block& block : blocks_) {
    coupling = std::max(coupling, block.coupling());
    for (const Part& part : block.parts) {
      most = std::max(most, part.size());
      if (part.size() > 1 && part.size() <= largest_dense && workspace_of(part) == nullptr)
        workspaces_.emplace_back(part.size());
    }
  }
  coupling_.resize(coupling, coupling);
  radius_.resize(most);
}

void Convexification::add_block(const SparsityPattern& pattern, const std::vector<int>& variables,
                                const std::vector<std::vector<int>>& neighbours) {
  std::vector<int> coupling;
  if (static_cast<int>(variables.size()) > largest_part_) {
    std::vector<std::size_t> degrees;
    degrees.reserve(variables.size());
    for (const int i : variables) degrees.push_back(neighbours[i].size());
    const auto middle = degrees.begin() + static_cast<std::ptrdiff_t>(degrees.size() / 2);
    std::nth_element(degrees.begin(), middle, degrees.end());
    for (const int i : variables)
      if (neighbours[i].size() > 2 * *middle) coupling.push_back(i);
  }
  Block block;
  for (std::vector<int> members : components(variables, neighbours, coupling)) {
    Part part;
    part.own = static_cast<int>(members.size());
    members.insert(members.end(), coupling.begin(), coupling.end());
    for (int i = 0; i < static_cast<int>(members.size()); ++i) {
      part.diagonal.push_back(pattern.find(members[i], members[i]));
      for (int j = 0; j < i; ++j) {
        const auto [c, r] = std::minmax(members[i], members[j]);
        const int position = pattern.find(r, c);
        if (position >= 0) part.below.push_back({i, j, position});
      }
    }
    block.parts.push_back(std::move(part));
  }
  blocks_.push_back(std::move(block));
}

Convexification::Workspace* Convexification::workspace_of(const Part& part) {
  const auto known = std::find_if(workspaces_.begin(), workspaces_.end(), [&](const Workspace& w) {
    return w.dense.rows() == part.size();
  });
  return known == workspaces_.end() ? nullptr : &*known;
}

void Convexification::apply(VectorXd& entries, double floor) {
  before_ = entries;
  for (const Block& block : blocks_) {
    if (block.parts.size() == 1 && block.parts.front().size() == 1) {
      double& d = entries[block.parts.front().diagonal.front()];
      d = std::abs(d);
      continue;
    }
    if (is_convex(block)) continue;
    const double share = 1.0 / static_cast<double>(block.parts.size());
    for (const Part& part : block.parts) {
      if (part.size() <= largest_part_)
        project(part, share, floor, entries);
      else
        shift(part, share, floor, entries);
    }
  }
}

// Writes the lower triangle. Rows and columns of coupling variables are multiplied by `share`.
void Convexification::load(const Part& part, double share, MatrixXd& dense) const {
  dense.setZero();
  for (int i = 0; i < part.size(); ++i)
    dense(i, i) = (i < part.own ? 1.0 : share) * before_[part.diagonal[i]];
  for (const Entry& e : part.below)
    dense(e.row, e.col) = (e.col < part.own ? 1.0 : share) * before_[e.position];
}

// Cholesky's method: eliminates the variables of all parts, then the coupling variables.
bool Convexification::is_convex(const Block& block) {
  const int k = block.coupling();
  auto rest = coupling_.topLeftCorner(k, k);
  rest.setZero();
  double largest = 0.0;
  for (const Part& part : block.parts) {
    Workspace* work = workspace_of(part);
    if (work == nullptr) return false;
    MatrixXd& dense = work->dense;
    load(part, &part == &block.parts.front() ? 1.0 : 0.0, dense);
    if (!dense.allFinite()) return true;  // NaN and infinity cannot be convexified
    const double size = dense.cwiseAbs().maxCoeff();
    largest = std::max(largest, size);
    if (!eliminate(dense, part.own, zero_pivot * size)) return false;
    rest += dense.bottomRightCorner(k, k);
  }
  return eliminate(rest, k, zero_coupled_pivot * largest);
}

// Jacobi's method for parts that are not convex.
void Convexification::project(const Part& part, double share, double floor, VectorXd& entries) {
  const int n = part.size();
  Workspace& work = *workspace_of(part);
  MatrixXd &dense = work.dense, &rest = work.rest;
  load(part, share, dense);
  rest = dense;
  const bool is_whole_block = part.own == n;  // then it is known not to be convex
  if (!is_whole_block && eliminate(rest, n, zero_pivot * dense.cwiseAbs().maxCoeff())) return;
  dense.triangularView<Eigen::StrictlyUpper>() = dense.transpose();
  MatrixXd& V = work.vectors;
  diagonalise(dense, V);
  const double largest = dense.diagonal().cwiseAbs().maxCoeff();
  rest.setZero();
  for (int k = 0; k < n; ++k) {
    const double d = dense(k, k);
    if (d >= floor * largest) continue;
    const double more = std::max(std::abs(d), floor * largest) - d;
    for (int j = 0; j < n; ++j)
      for (int i = j; i < n; ++i) rest(i, j) += more * V(i, k) * V(j, k);
  }
  for (int i = 0; i < n; ++i) entries[part.diagonal[i]] += rest(i, i);
  for (const Entry& e : part.below) {
    entries[e.position] += rest(e.row, e.col);
    rest(e.row, e.col) = 0.0;
  }
  for (int j = 0; j < n; ++j)  // entries outside the pattern
    for (int i = j + 1; i < n; ++i) {
      if (rest(i, j) == 0.0) continue;
      entries[part.diagonal[i]] += std::abs(rest(i, j));
      entries[part.diagonal[j]] += std::abs(rest(i, j));
    }
}

void Convexification::shift(const Part& part, double share, double floor, VectorXd& entries) {
  const auto factor = [&](int i) { return i < part.own ? 1.0 : share; };
  auto radius = radius_.head(part.size());
  radius.setZero();
  for (const Entry& e : part.below) {
    const double size = factor(e.col) * std::abs(before_[e.position]);
    radius[e.row] += size;
    radius[e.col] += size;
  }
  double lowest = 0.0, largest = 0.0;
  for (int i = 0; i < part.size(); ++i) {
    const double d = factor(i) * before_[part.diagonal[i]];
    lowest = std::min(lowest, d - radius[i]);
    largest = std::max(largest, std::abs(d) + radius[i]);
  }
  if (lowest < 0.0)
    for (const int position : part.diagonal) entries[position] += floor * largest - lowest;
}

void Convexification::add_to_diagonal(VectorXd& entries, double shift) const {
  for (const int position : diagonal_) entries[position] += shift;
}

}  // namespace saltus
