// Capacity and memory of a packed program, and the order of packing.
#include "saltus/qp/packed_qp.hpp"

#include <algorithm>
#include <cstring>

#include "saltus/qp/packing.hpp"

namespace saltus::qp {
bool same(const MatrixXd& a, const MatrixXd& b, int rows, int columns) {
  if (rows == 0 || columns == 0) return true;
  if (a.rows() == rows && b.rows() == rows)
    return std::memcmp(a.data(), b.data(), sizeof(double) * rows * columns) == 0;
  for (int j = 0; j < columns; ++j)
    if (std::memcmp(&a.coeffRef(0, j), &b.coeffRef(0, j), sizeof(double) * rows) != 0) return false;
  return true;
}

bool same(const VectorXd& a, const VectorXd& b, int rows) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * rows) == 0;
}

PackedQp::PackedQp(const StageQp& largest, std::span<const RiccatiKernel> kernels)
    : stages(largest.stages.size()) {
  std::size_t doubles = 0, ints = 0;
  int blocks = 0, work = capacity.work;
  for (const Stage& s : largest.stages) {
    const int nx = static_cast<int>(s.q.size()), nu = static_cast<int>(s.r.size());
    const int next = static_cast<int>(s.b.size());
    const int n = nx + nu, ld = padded(n), spare = 8;
    const auto matrix = [&](int rows, int columns) {
      return static_cast<std::size_t>(padded(rows) + spare) * static_cast<std::size_t>(columns + 1);
    };
    // Stage matrices. Those of parts are bounded by the full input matrices.
    doubles += matrix(next, n) + matrix(n, next) + 3 * matrix(n, n) + 4 * matrix(n, 1) +
               matrix(next, 1) + 8 * matrix(nu, nu) + matrix(next, nu) +
               8 * max_parts * matrix(nu, 1);
    ints += static_cast<std::size_t>(8 * (n + next + 16));
    int v = ld + max_parts * lanes + padded(nu), y = padded(next), all_sides = 2 * (ld + lanes);
    const auto rows = [&](int count, int columns) {
      const int c = std::max(columns, nu);
      doubles += 2 * (matrix(count, c) + matrix(c, count) + matrix(count, 1) +
                      (c <= max_pair_columns ? matrix(padded_pairs_of(c), count) : matrix(1, 1)));
      // Blocks with few columns store the products of pairs even if other blocks need less memory.
      doubles += 2 * matrix(padded_pairs_of(max_pair_columns), count);
      ints += static_cast<std::size_t>(2 * (count + 2 * c + pairs_of(c) + 64));
      y += padded(count) + lanes;
      all_sides += 2 * (padded(count) + lanes);
      blocks += 2;
      work = std::max(work, padded(count) * (c + 2) + padded(c) * (c + 2));
    };
    for (const RowGroup& g : s.groups)
      rows(static_cast<int>(g.M.rows()), static_cast<int>(g.M.cols()));
    for (int part = 0; part < max_parts && (part == 0 || part < nu); ++part)
      rows(part == 0 ? n : nu, part == 0 ? n : nu);
    work = std::max({work, (padded(next) + 8) * (n + 2), 8 * (padded(nu) + 8) * (nu + 2)});
    capacity.variables += v;
    capacity.equalities += y;
    capacity.sides += all_sides;
  }
  capacity.work = work;
  storage.kernels.assign(kernels.begin(), kernels.end());
  storage.blocks.resize(blocks);
  storage.splits.resize((max_parts - 1) * stages.size());
  storage.numbers = Arena<double, AlignedArray>(doubles);
  storage.integers = Arena<int, std::vector<int>>(ints);
  for (AlignedArray* of_sides : {&active, &beta, &l1, &l2})
    *of_sides = AlignedArray(capacity.sides);
  wanted = AlignedArray(capacity.equalities);
}

bool PackedQp::pack(const StageQp& qp) {
  if (stages.empty() || qp.stages.size() != stages.size()) return false;
  storage.numbers.reset();
  storage.integers.reset();
  has_equality_rows = false;
  contradiction = false;
  reduced_stages = 0;
  Packing packing{*this, qp};
  const int count = static_cast<int>(stages.size());
  for (int k = 0; k < count; ++k)
    if (!packing.stage(k)) return false;
  if (!packing.allocate_recursion()) return false;
  for (int k = 0; k < count; ++k)
    if (!packing.rows(k)) return false;
  // The offset of the soft sides is known only now.
  first_soft = packing.hard;
  for (int i = 0; i < packing.blocks; ++i) {
    RowBlock& b = storage.blocks[i];
    if (!b.soft) continue;
    if (b.lower_at >= 0) b.lower_at += first_soft;
    if (b.upper_at >= 0) b.upper_at += first_soft;
  }
  variables = packing.v;
  equalities = packing.y;
  sides = packing.hard + packing.soft;
  if (variables > capacity.variables || equalities > capacity.equalities || sides > capacity.sides)
    return false;
  packing.fill_sides();
  return true;
}

void PackedQp::pack_vectors(const StageQp& qp) {
  Packing packing{*this, qp};
  for (int k = 0; k < static_cast<int>(stages.size()); ++k) packing.vectors(k);
  packing.fill_sides();
}

void PackedQp::pack_start(const StageQp& qp) {
  if (stages.front().constant_states == 0) return;
  contradiction = false;
  Packing{*this, qp}.start();
}

Packing::Column Packing::column_of(int k, int j) const {
  const Stage& s = qp.stages[k];
  const PackedStage& p = to.stages[k];
  if (j < s.nx) return starts_fixed(k) ? Column{-1, 0} : Column{0, j};
  const int input = j - s.nx;
  if (p.parts == 1) return {0, (starts_fixed(k) ? 0 : s.nx) + input};
  const int size = p.sweep.nu;
  return {input / size, (input < size ? p.sweep.nx : 0) + input % size};
}

}  // namespace saltus::qp
