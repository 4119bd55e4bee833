#include "saltus/solver/convexify.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace saltus {
namespace {

// True if the lower triangle has a Cholesky factor; overwrites it. Zero pivots are accepted if the
// rest of their column is zero.
bool is_positive_semidefinite(MatrixXd& a, double rounding) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    const double pivot = a(j, j);
    if (pivot <= rounding) {
      for (Eigen::Index i = j; i < n; ++i)
        if (a(i, j) < -rounding || (i > j && a(i, j) > rounding)) return false;
      continue;
    }
    for (Eigen::Index k = j + 1; k < n; ++k) {
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

Convexification::Convexification(const SparsityPattern& pattern, int largest_block) {
  const int n = pattern.rows();
  std::vector<int> root(n);  // union-find tree of coupled variables
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  pattern.for_each([&](int r, int c, int) { root[find(r)] = find(c); });

  std::vector<int> block_of(n, -1), index_in_block(n);
  for (int i = 0; i < n; ++i) {
    int& block = block_of[find(i)];
    if (block < 0) {
      block = static_cast<int>(blocks_.size());
      blocks_.emplace_back();
    }
    index_in_block[i] = blocks_[block].size();
    blocks_[block].diagonal.push_back(pattern.find(i, i));
    diagonal_.push_back(pattern.find(i, i));
  }
  pattern.for_each([&](int r, int c, int e) {
    if (r != c)
      blocks_[block_of[find(r)]].below.push_back({index_in_block[r], index_in_block[c], e});
  });
  int most = 0;
  for (Block& block : blocks_) {
    most = std::max(most, block.size());
    if (block.size() > largest_block) continue;
    const auto known =
        std::find_if(workspaces_.begin(), workspaces_.end(),
                     [&](const Workspace& w) { return w.dense.rows() == block.size(); });
    block.workspace = static_cast<int>(known - workspaces_.begin());
    if (known == workspaces_.end()) workspaces_.emplace_back(block.size());
  }
  radius_.resize(most);
}

void Convexification::apply(VectorXd& entries, double floor) {
  for (const Block& block : blocks_) {
    if (block.below.empty()) {
      double& d = entries[block.diagonal.front()];
      d = std::abs(d);
    } else if (block.workspace < 0) {
      shift(block, entries, floor);
    } else {
      project(block, workspaces_[block.workspace], entries, floor);
    }
  }
}

void Convexification::project(const Block& block, Workspace& work, VectorXd& entries,
                              double floor) {
  const int n = block.size();
  MatrixXd& dense = work.dense;
  MatrixXd& rest = work.rest;
  dense.setZero();
  for (int i = 0; i < n; ++i) dense(i, i) = entries[block.diagonal[i]];
  for (const Entry& e : block.below)
    dense(e.row, e.col) = dense(e.col, e.row) = entries[e.position];
  if (!dense.allFinite()) return;
  const double rounding = 1e-12 * dense.cwiseAbs().maxCoeff();
  rest = dense;
  if (is_positive_semidefinite(rest, rounding)) return;
  MatrixXd& V = work.vectors;
  diagonalise(dense, V);
  const double largest = dense.diagonal().cwiseAbs().maxCoeff();
  rest.setZero();  // entries outside the pattern
  for (int k = 0; k < n; ++k) {
    const double d = dense(k, k);
    if (d >= floor * largest) continue;
    const double more = std::max(std::abs(d), floor * largest) - d;
    for (int j = 0; j < n; ++j)
      for (int i = j; i < n; ++i) rest(i, j) += more * V(i, k) * V(j, k);
  }
  for (int i = 0; i < n; ++i) entries[block.diagonal[i]] += rest(i, i);
  for (const Entry& e : block.below) {
    double& r = rest(std::max(e.row, e.col), std::min(e.row, e.col));
    entries[e.position] += r;
    r = 0.0;
  }
  for (int j = 0; j < n; ++j)
    for (int i = j + 1; i < n; ++i) {
      if (rest(i, j) == 0.0) continue;
      entries[block.diagonal[i]] += std::abs(rest(i, j));
      entries[block.diagonal[j]] += std::abs(rest(i, j));
    }
}

void Convexification::shift(const Block& block, VectorXd& entries, double floor) {
  auto radius = radius_.head(block.size());
  radius.setZero();
  for (const Entry& e : block.below) {
    radius[e.row] += std::abs(entries[e.position]);
    radius[e.col] += std::abs(entries[e.position]);
  }
  double lowest = 0.0, largest = 0.0;
  for (int i = 0; i < block.size(); ++i) {
    lowest = std::min(lowest, entries[block.diagonal[i]] - radius[i]);
    largest = std::max(largest, std::abs(entries[block.diagonal[i]]) + radius[i]);
  }
  if (lowest < 0.0)
    for (const int position : block.diagonal) entries[position] += floor * largest - lowest;
}

void Convexification::add_to_diagonal(VectorXd& entries, double shift) const {
  for (const int position : diagonal_) entries[position] += shift;
}

}  // namespace saltus
