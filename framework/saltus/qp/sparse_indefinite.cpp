#include "saltus/qp/sparse_indefinite.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numeric>

namespace saltus::qp {
namespace {

// A front absorbs its child if the child is small or adds few zeros.
constexpr std::size_t small_front = 8;
constexpr double zeros_allowed = 0.3;
// Relative to the equilibrated matrix: smaller pivots are rounding errors.
constexpr double vanishing = 1e-15;
constexpr int equilibrations = 3;

// Minimum degree ordering. The graph is given by columns, upper triangle.
std::vector<int> minimum_degree(int n, const std::vector<std::vector<int>>& above) {
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_AMD;
  common.postorder = 1;
  std::size_t entries = 0;
  for (const auto& column : above) entries += column.size();
  cholmod_sparse* graph = cholmod_allocate_sparse(n, n, entries, /*sorted=*/0, /*packed=*/1,
                                                  /*stype=*/1, CHOLMOD_PATTERN, &common);
  if (graph == nullptr) throw std::bad_alloc();
  int* start = static_cast<int*>(graph->p);
  int* row = static_cast<int*>(graph->i);
  int at = 0;
  for (int j = 0; j < n; ++j) {
    start[j] = at;
    for (const int i : above[j]) row[at++] = i;
  }
  start[n] = at;
  cholmod_factor* factor = cholmod_analyze(graph, &common);
  if (factor == nullptr) throw std::bad_alloc();
  const int* permutation = static_cast<const int*>(factor->Perm);
  std::vector<int> order(permutation, permutation + n);
  cholmod_free_factor(&factor, &common);
  cholmod_free_sparse(&graph, &common);
  cholmod_finish(&common);
  return order;
}

}  // namespace

SparseIndefinite::SparseIndefinite(const SparsityPattern& lower,
                                   const std::vector<std::pair<int, int>>& pairs)
    : n_(lower.rows()),
      pattern_(lower),
      values_(lower.entries(), 0.0),
      scale_(lower.rows(), 1.0),
      where_(lower.rows(), -1),
      largest_(lower.rows(), 0.0) {
  order(lower, pairs);
  factors_.resize(fronts_.size());
}

void SparseIndefinite::order(const SparsityPattern& lower,
                             const std::vector<std::pair<int, int>>& pairs) {
  // Nodes are the pairs and all remaining single indices.
  std::vector<int> node_of(n_, -1);
  std::vector<std::vector<int>> members;
  for (const auto& [a, b] : pairs) {
    node_of[a] = node_of[b] = static_cast<int>(members.size());
    members.push_back({a, b});
  }
  for (int i = 0; i < n_; ++i)
    if (node_of[i] < 0) {
      node_of[i] = static_cast<int>(members.size());
      members.push_back({i});
    }
  const int nodes = static_cast<int>(members.size());
  const auto sort_unique = [](std::vector<int>& v) {
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
  };
  std::vector<std::vector<int>> above(nodes);
  lower.for_each([&](int i, int j, int) {
    const int a = node_of[i], b = node_of[j];
    above[std::max(a, b)].push_back(std::min(a, b));
  });
  for (int j = 0; j < nodes; ++j) {
    above[j].push_back(j);
    sort_unique(above[j]);
  }
  const std::vector<int> sequence = minimum_degree(nodes, above);
  std::vector<int> rank(nodes);
  for (int k = 0; k < nodes; ++k) rank[sequence[k]] = k;

  // Rows of every column as ranks, and the elimination tree.
  std::vector<std::vector<int>> rows(nodes), children(nodes);
  for (int j = 0; j < nodes; ++j)
    for (const int i : above[j])
      if (i != j) rows[std::min(rank[i], rank[j])].push_back(std::max(rank[i], rank[j]));
  std::vector<int> parent(nodes, -1);
  for (int k = 0; k < nodes; ++k) {
    for (const int child : children[k])
      for (const int r : rows[child])
        if (r != k) rows[k].push_back(r);
    sort_unique(rows[k]);
    if (rows[k].empty()) continue;
    parent[k] = rows[k].front();
    children[parent[k]].push_back(k);
  }

  // Fronts: a column and the children that it absorbs. rows[] of the last column are those of the
  // front.
  const auto size_of = [&](int k) { return members[sequence[k]].size(); };
  std::vector<std::vector<int>> columns(nodes);  // columns of the front that ends with this one
  std::vector<std::size_t> width(nodes, 0), height(nodes, 0);
  std::vector<char> is_taken(nodes, 0);
  for (int k = 0; k < nodes; ++k) {
    std::size_t below = 0;
    for (const int r : rows[k]) below += size_of(r);
    height[k] = below;
    width[k] = size_of(k);
    columns[k] = {k};
    for (const int child : children[k]) {
      const std::size_t full = width[k] + below;  // rows that the columns of the child would get
      const std::size_t zeros = full > height[child] ? (full - height[child]) * width[child] : 0;
      const std::size_t all = (width[child] + width[k] + below) * (width[child] + width[k]);
      const bool joins = zeros == 0 || (width[child] + width[k] <= small_front) ||
                         static_cast<double>(zeros) <= zeros_allowed * static_cast<double>(all);
      if (!joins || width[child] + width[k] > 32) continue;
      is_taken[child] = 1;
      columns[k].insert(columns[k].begin(), columns[child].begin(), columns[child].end());
      width[k] += width[child];
    }
  }
  std::vector<int> front_of_column(nodes, -1), front_of_end(nodes, -1);
  for (int k = 0; k < nodes; ++k) {
    if (is_taken[k]) continue;
    front_of_end[k] = static_cast<int>(fronts_.size());
    Front& front = fronts_.emplace_back();
    for (const int c : columns[k]) {
      front_of_column[c] = front_of_end[k];
      for (const int i : members[sequence[c]]) front.own.push_back(i);
    }
    for (const int r : rows[k])
      for (const int i : members[sequence[r]]) front.others.push_back(i);
    front.is_root = parent[k] < 0;
  }
  for (int k = 0; k < nodes; ++k)
    if (!is_taken[k] && parent[k] >= 0)
      fronts_[front_of_column[parent[k]]].children.push_back(front_of_end[k]);
  lower.for_each([&](int i, int j, int e) {
    const int first = std::min(rank[node_of[i]], rank[node_of[j]]);
    fronts_[front_of_column[first]].entries.push_back({e, i, j});
  });
}

// Symmetric scaling until the largest entry of every row is about one (D. Ruiz, 2001).
void SparseIndefinite::equilibrate() {
  std::fill(scale_.begin(), scale_.end(), 1.0);
  for (int round = 0; round < equilibrations; ++round) {
    std::fill(largest_.begin(), largest_.end(), 0.0);
    pattern_.for_each([&](int i, int j, int e) {
      const double size = std::abs(values_[e]) * scale_[i] * scale_[j];
      largest_[i] = std::max(largest_[i], size);
      largest_[j] = std::max(largest_[j], size);
    });
    for (int i = 0; i < n_; ++i)
      if (largest_[i] > 0.0) scale_[i] /= std::sqrt(largest_[i]);
  }
}

void SparseIndefinite::assemble(const Front& front, Factor& factor) {
  factor.index = front.own;
  delayed_ = 0;
  for (const int child : front.children) {
    const Factor& c = factors_[child];
    const int count = static_cast<int>(c.index.size() - fronts_[child].others.size()) - c.pivots;
    for (int k = 0; k < count; ++k) factor.index.push_back(c.index[c.pivots + k]);
    delayed_ += count;
  }
  factor.index.insert(factor.index.end(), front.others.begin(), front.others.end());
  const std::size_t size = factor.index.size();
  for (std::size_t k = 0; k < size; ++k) where_[factor.index[k]] = static_cast<int>(k);
  work_.assign(size * size, 0.0);
  for (const Entry& e : front.entries) {
    const std::size_t i = where_[e.i], j = where_[e.j];
    const double value = values_[e.position] * scale_[e.i] * scale_[e.j];
    work_[i + j * size] += value;
    if (i != j) work_[j + i * size] += value;
  }
  for (const int child : front.children) {
    Factor& c = factors_[child];
    const std::size_t left = c.index.size() - c.pivots;
    for (std::size_t j = 0; j < left; ++j) {
      double* to = work_.data() + where_[c.index[c.pivots + j]] * size;
      const double* from = c.rest.data() + j * left;
      for (std::size_t i = 0; i < left; ++i) to[where_[c.index[c.pivots + i]]] += from[i];
    }
    c.rest.clear();
  }
}

// Eliminates pivots among the first `candidates` rows of work_ while acceptable ones exist.
bool SparseIndefinite::eliminate(Factor& factor, int candidates, double threshold, bool is_root) {
  const int size = static_cast<int>(factor.index.size());
  double* A = work_.data();
  const auto at = [&](int i, int j) -> double& {
    return A[i + static_cast<std::size_t>(j) * size];
  };
  const auto exchange = [&](int a, int b) {
    if (a == b) return;
    std::swap(factor.index[a], factor.index[b]);
    for (int j = 0; j < size; ++j) std::swap(at(a, j), at(b, j));
    for (int i = 0; i < size; ++i) std::swap(at(i, a), at(i, b));
  };
  factor.diagonal.clear();
  factor.beside.clear();
  int k = 0, tried = 0;
  while (k < candidates) {
    const int left = candidates - k;
    if (tried == left && !is_root) break;
    // At the root the remaining pivots must be accepted.
    const double wanted = tried < left ? threshold : 0.0;
    const int j = k + tried % left;
    double most = 0.0, partner_size = 0.0;
    int partner = -1;
    for (int i = k; i < size; ++i) {
      if (i == j) continue;
      const double value = std::abs(at(i, j));
      most = std::max(most, value);
      if (i < candidates && value > partner_size) {
        partner_size = value;
        partner = i;
      }
    }
    const double pivot = at(j, j);
    if (!std::isfinite(pivot) || !std::isfinite(most)) return false;
    if (std::abs(pivot) >= wanted * most && std::abs(pivot) > vanishing) {
      exchange(k, j);
      const double inverse = 1.0 / pivot;
      double* column = A + static_cast<std::size_t>(k) * size;
      for (int c = k + 1; c < size; ++c) {
        const double factor_c = column[c] * inverse;
        if (factor_c == 0.0) continue;
        double* target = A + static_cast<std::size_t>(c) * size;
        for (int i = k + 1; i < size; ++i) target[i] -= column[i] * factor_c;
      }
      for (int i = k + 1; i < size; ++i) column[i] *= inverse;
      factor.diagonal.push_back(pivot);
      factor.beside.push_back(0.0);
      negative_ += pivot < 0.0;
      ++k;
      tried = 0;
      continue;
    }
    if (partner >= 0) {
      const int r = partner;
      const double b = at(r, j), c = at(r, r), determinant = pivot * c - b * b;
      double most_r = 0.0, most_j = 0.0;
      for (int i = k; i < size; ++i) {
        if (i == j || i == r) continue;
        most_j = std::max(most_j, std::abs(at(i, j)));
        most_r = std::max(most_r, std::abs(at(i, r)));
      }
      const double size_of_inverse = std::abs(determinant);
      const bool good =
          size_of_inverse > vanishing * vanishing &&
          (std::abs(c) * most_j + std::abs(b) * most_r) * wanted <= size_of_inverse &&
          (std::abs(b) * most_j + std::abs(pivot) * most_r) * wanted <= size_of_inverse;
      if (good) {
        exchange(k, j);
        exchange(k + 1, r == k ? j : r);
        double* first = A + static_cast<std::size_t>(k) * size;
        double* second = first + size;
        const double p = first[k], q = first[k + 1], s = second[k + 1], d = p * s - q * q;
        for (int col = k + 2; col < size; ++col) {
          const double f = first[col], g = second[col];
          if (f == 0.0 && g == 0.0) continue;
          const double x = (s * f - q * g) / d, y = (p * g - q * f) / d;
          double* target = A + static_cast<std::size_t>(col) * size;
          for (int i = k + 2; i < size; ++i) target[i] -= first[i] * x + second[i] * y;
        }
        for (int i = k + 2; i < size; ++i) {
          const double f = first[i], g = second[i];
          first[i] = (s * f - q * g) / d;
          second[i] = (p * g - q * f) / d;
        }
        first[k + 1] = 0.0;
        factor.diagonal.push_back(p);
        factor.diagonal.push_back(s);
        factor.beside.push_back(q);
        factor.beside.push_back(0.0);
        negative_ += d < 0.0 ? 1 : (p < 0.0 ? 2 : 0);
        k += 2;
        tried = 0;
        continue;
      }
    }
    if (++tried >= 2 * left) {  // no remaining pivot is acceptable
      is_singular_ = true;
      return false;
    }
  }
  factor.pivots = k;
  factor.columns.resize(static_cast<std::size_t>(k) * size);
  std::copy_n(A, factor.columns.size(), factor.columns.begin());
  const int rest = size - k;
  factor.rest.resize(static_cast<std::size_t>(rest) * rest);
  for (int j = 0; j < rest; ++j)
    std::copy_n(A + k + static_cast<std::size_t>(k + j) * size, rest,
                factor.rest.begin() + static_cast<std::size_t>(j) * rest);
  return true;
}

bool SparseIndefinite::factor(double threshold) {
  negative_ = 0;
  is_singular_ = false;
  equilibrate();
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    const Front& front = fronts_[f];
    assemble(front, factors_[f]);
    const int candidates = static_cast<int>(front.own.size()) + delayed_;
    if (!eliminate(factors_[f], candidates, threshold, front.is_root)) return false;
  }
  return true;
}

void SparseIndefinite::solve(double* x) {
  for (int i = 0; i < n_; ++i) x[i] *= scale_[i];
  for (const Factor& f : factors_) {
    const std::size_t size = f.index.size();
    for (int k = 0; k < f.pivots; ++k) {
      const double value = x[f.index[k]];
      const double* column = f.columns.data() + static_cast<std::size_t>(k) * size;
      for (std::size_t i = k + 1; i < size; ++i) x[f.index[i]] -= column[i] * value;
    }
    for (int k = 0; k < f.pivots; ++k) {
      double& a = x[f.index[k]];
      if (f.beside[k] == 0.0) {
        a /= f.diagonal[k];
        continue;
      }
      double& b = x[f.index[k + 1]];
      const double p = f.diagonal[k], q = f.beside[k], s = f.diagonal[k + 1], d = p * s - q * q;
      const double first = (s * a - q * b) / d;
      b = (p * b - q * a) / d;
      a = first;
      ++k;
    }
  }
  for (std::size_t at = factors_.size(); at-- > 0;) {
    const Factor& f = factors_[at];
    const std::size_t size = f.index.size();
    for (int k = f.pivots; k-- > 0;) {
      const double* column = f.columns.data() + static_cast<std::size_t>(k) * size;
      double sum = x[f.index[k]];
      for (std::size_t i = k + 1; i < size; ++i) sum -= column[i] * x[f.index[i]];
      x[f.index[k]] = sum;
    }
  }
  for (int i = 0; i < n_; ++i) x[i] *= scale_[i];
}

}  // namespace saltus::qp
