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

namespace {

// Memory and sizes that the packing of a stage, a group or the bounds needs at most.
struct Need {
  std::size_t numbers = 0, integers = 0;
  int variables = 0, equalities = 0, sides = 0, blocks = 0;

  Need& operator+=(const Need& n) {
    numbers += n.numbers;
    integers += n.integers;
    variables += n.variables;
    equalities += n.equalities;
    sides += n.sides;
    blocks += n.blocks;
    return *this;
  }
};

Need larger_of(const Need& a, const Need& b) {
  return {std::max(a.numbers, b.numbers),     std::max(a.integers, b.integers),
          std::max(a.variables, b.variables), std::max(a.equalities, b.equalities),
          std::max(a.sides, b.sides),         std::max(a.blocks, b.blocks)};
}

// What Arena::take() uses up for a piece.
std::size_t piece(int count) { return (static_cast<std::size_t>(count) + 7) / 8 * 8; }

// A block of up to these sizes. Blocks with few columns also store the products of pairs.
Need block(int rows, int columns) {
  const auto numbers = [rows](int n) {
    return piece(padded(rows) * n) + piece(padded(n) * rows) +
           (n <= max_pair_columns ? piece(padded_pairs_of(n) * rows) : 0);
  };
  const int few = std::min(columns, max_pair_columns);
  return {.numbers = piece(rows) + std::max(numbers(columns), numbers(few)),
          .integers = piece(pairs_of(columns)),
          .equalities = padded(rows),
          .sides = 2 * padded(rows),
          .blocks = 1};
}

// Equal bounds become rows with one column for each row.
Need block_of_bounds(int rows) {
  const int few = std::min(rows, max_pair_columns);
  Need need = block(few, few);
  need.numbers =
      std::max(need.numbers, piece(rows) + 2 * piece(padded(rows) * rows));  // without pairs
  need.integers = piece(pairs_of(rows));
  need.equalities = padded(rows);
  need.sides = 0;
  return need;
}

// Rows that are divided into equalities and inequalities.
Need two_blocks(int rows, int columns) {
  Need most;
  for (int equal = 0; equal <= rows; ++equal) {
    Need both = block(equal, columns);
    both += block(rows - equal, columns);
    most = larger_of(most, both);
  }
  most.equalities = padded(rows);
  most.sides = 2 * padded(rows);
  return most;
}

Need group(int rows, int columns, int inputs) {
  Need n = two_blocks(rows, std::max(columns, inputs / 2));  // a part has at most half the inputs
  n.integers += 2 * (piece(rows) + piece(columns) + piece(std::max(columns, inputs)));
  return n;
}

// Parts of a common resultant, and the bounds of a stage with them.
Need parts_and_bounds(int states, int inputs, int parts, int size) {
  const int n = states + size, ld = padded(size), further = parts - 1, entries = states + inputs;
  Need need{.numbers = piece(padded(n) * n) + 2 * piece(ld * further * size) + piece(further * ld) +
                       2 * piece(parts * ld * size) +
                       static_cast<std::size_t>(further) * piece(Split::size(size)),
            .integers = 2 * (piece(states) + piece(std::max(states, size)) + piece(entries)),
            .variables = padded(n) + further * ld,
            .sides = 2 * padded(n)};
  need.integers += 2 * (piece(inputs) + piece(entries));
  need += block_of_bounds(states);
  need += block_of_bounds(size);
  for (int part = 0; part < further; ++part) {
    need += two_blocks(size, size);
    need.integers += 2 * (piece(inputs) + piece(entries));
  }
  return need;
}

// Everything of a stage except for its groups and the recursion.
Need stage(int states, int inputs, int next, bool first) {
  const int n = states + inputs, ld = padded(n), sweep_inputs = first ? n : inputs;
  Need bounds = block_of_bounds(n);
  // A search for the maps of a common resultant that fails leaves its memory behind.
  std::size_t maps = 0;
  for (int parts = 2; parts <= max_parts; ++parts)
    maps = std::max(maps, 2 * piece(padded(inputs / parts) * (parts - 1) * (inputs / parts)));
  bounds.numbers += maps;
  bounds.integers += 2 * piece(n);
  bounds.variables = ld;
  bounds.sides = 2 * ld;
  for (int parts = 2; parts <= max_parts; ++parts)
    for (int size = 1; size * parts <= inputs; ++size)
      bounds = larger_of(bounds, parts_and_bounds(states, inputs, parts, size));
  bounds.numbers += piece(ld * sweep_inputs) + piece(padded(sweep_inputs)) + 2 * piece(ld) +
                    piece(padded(next) * n) + piece(ld * next) + piece(padded(next)) +
                    piece(ld * n);
  bounds.integers += piece(2 * ((n + 3) / 4));
  bounds.equalities += padded(next);
  return bounds;
}

}  // namespace

PackedQp::PackedQp(const StageQp& largest, std::span<const RiccatiKernel> kernels)
    : stages(largest.stages.size()) {
  Need all;
  int work = capacity.work, kept = 0, most = 0;
  for (const Stage& s : largest.stages) {
    const bool first = &s == &largest.stages.front();
    const int nx = static_cast<int>(s.q.size()), nu = static_cast<int>(s.r.size());
    const int next = static_cast<int>(s.b.size()), n = nx + nu;
    all += stage(nx, nu, next, first);
    kept += first ? 0 : nx * padded(n);
    most = std::max(most, (first ? n : nu) * padded(n));
    const auto work_of = [&](int rows, int columns) {
      const int c = std::max(columns, nu);
      work = std::max(work, padded(rows) * (c + 2) + padded(c) * (c + 2));
    };
    for (const RowGroup& g : s.groups) {
      const int rows = static_cast<int>(g.M.rows()), columns = static_cast<int>(g.M.cols());
      all += group(rows, columns, first ? n : nu);
      work_of(rows, columns);
    }
    work_of(n, n);
    work = std::max({work, (padded(next) + 8) * (n + 2), 8 * (padded(nu) + 8) * (nu + 2)});
  }
  // Kernels work on whole vectors and may touch a few entries behind the last one.
  constexpr int behind = 64;
  capacity = {all.variables + behind, all.equalities + behind, all.sides + behind, work};
  storage.kernels.assign(kernels.begin(), kernels.end());
  storage.blocks.resize(all.blocks);
  storage.splits.resize((max_parts - 1) * stages.size());
  storage.numbers = Arena<double, AlignedArray>(all.numbers + piece(kept + most) + behind);
  storage.integers = Arena<int, std::vector<int>>(all.integers);
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
