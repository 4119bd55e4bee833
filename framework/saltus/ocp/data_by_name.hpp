// Sets data by the name of a parameter block ("road") or of one entry ("road.slope").
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus {

/// The range of p of one phase that a name refers to.
struct ParameterRange {
  int first = 0, size = 0;                ///< index of the first number, and number of entries
  const ParameterBlock* block = nullptr;  ///< the declared block, owned by the phase
};
/// Returns nullopt if the phase has no such block or entry. Does not allocate.
std::optional<ParameterRange> find_parameter(const PhaseDefinition& phase, std::string_view name);

/// Throws DefinitionError unless `name` is data of the problem with `size` numbers. If the block
/// has named entries, they must match `entries` (empty: no check). The message lists the valid
/// names. Allocates only on error.
void check_data(const OptimalControlProblem& problem, std::string_view name, int size,
                std::span<const ParameterEntry> entries);

/// Setters for data, for a class Self with set_entries(name, values, entries).
template <class Self>
class DataByName {
 public:
  /// Sets a block or one entry of it, in the order of p. Matrices are row-major.
  void set_data(std::string_view name, const VectorRef& values) {
    self().set_entries(name, values, {});
  }
  /// Sets a single number.
  void set_data(std::string_view name, double value) { set_data(name, Vec<double, 1>(value)); }
  template <class Matrix>
  /// Sets a matrix of fixed size.
    requires(Matrix::RowsAtCompileTime > 0 && Matrix::ColsAtCompileTime > 1)
  void set_data(std::string_view name, const Eigen::MatrixBase<Matrix>& value) {
    constexpr int rows = Matrix::RowsAtCompileTime, cols = Matrix::ColsAtCompileTime;
    const Mat<double, cols, rows> by_rows = value.transpose();
    set_data(name, by_rows.template reshaped<Eigen::AutoOrder>().eval());
  }
  /// Sets a block declared by this struct.
  template <NamedParameters Block>
  void set_data(std::string_view block, const Block& value) {
    self().set_entries(block, packed(value), entries_of<Block>());
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

}  // namespace saltus
