// Data are given by the name of a block of parameters ("road") or of one entry ("road.slope").
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus {

/// What a name stands for in p of one phase.
struct ParameterRange {
  int first = 0, size = 0;                ///< place of the first number in p, and how many
  const ParameterBlock* block = nullptr;  ///< what was declared; owned by the phase
};
/// Nothing where the phase has no such block or entry. Does not allocate.
std::optional<ParameterRange> find_parameter(const PhaseDefinition& phase, std::string_view name);

/// Throws DefinitionError unless `name` is data of the problem with `size` numbers and, of a block
/// whose entries have names, the names `entries` (empty: whatever it has). The message names what
/// there is. Allocates only for it.
void check_data(const OptimalControlProblem& problem, std::string_view name, int size,
                std::span<const ParameterEntry> entries);

/// The ways to give data, for a class Self with set_entries(name, values, entries).
template <class Self>
class DataByName {
 public:
  /// A block or one entry of it, in the order of p: matrices row by row.
  void set_data(std::string_view name, const VectorRef& values) {
    self().set_entries(name, values, {});
  }
  /// A single number.
  void set_data(std::string_view name, double value) { set_data(name, Vec<double, 1>(value)); }
  template <class Matrix>
  /// A vector or a matrix (column by column).
    requires(Matrix::RowsAtCompileTime > 0 && Matrix::ColsAtCompileTime > 1)
  void set_data(std::string_view name, const Eigen::MatrixBase<Matrix>& value) {
    constexpr int rows = Matrix::RowsAtCompileTime, cols = Matrix::ColsAtCompileTime;
    const Mat<double, cols, rows> by_rows = value.transpose();
    set_data(name, by_rows.template reshaped<Eigen::AutoOrder>().eval());
  }
  /// A block that was declared by this struct.
  template <NamedParameters Block>
  void set_data(std::string_view block, const Block& value) {
    self().set_entries(block, packed(value), entries_of<Block>());
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

}  // namespace saltus
