// Vectors and matrices of tracers know their ends, in Release too: what a formula reads or writes
// beyond one throws IndexError where it is traced, at set-up. Evaluation has other scalars and pays
// nothing. What was not written yet is marked as such.
//
// Eigen reaches every entry of a matrix through its evaluator, and those of a part of a matrix
// (head<2>(), row(1)) through the part's; both are specialised for tracers, and so is what puts
// entries after `<<`. Entries behind coeff() and data() are the caller's own affair.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <type_traits>

#include "saltus/autodiff/eigen_scalar.hpp"
#include "saltus/autodiff/tracer.hpp"

namespace saltus {

/// An entry was asked for that a vector or matrix of tracers does not have.
struct IndexError {
  long row = 0, col = 0;    ///< counted from 0; of a vector: row
  long rows = 0, cols = 1;  ///< what there is
  int first_input = -1;     ///< if its entries are inputs in their order: which one is first
};

namespace detail {

template <class Expression>
concept Traced =
    std::same_as<typename Eigen::internal::traits<std::remove_const_t<Expression>>::Scalar, Tracer>;

/// The bounds of a vector or matrix.
struct TracedBounds {
  long rows = 0, cols = 0;
  const Tracer* first = nullptr;

  void check(long row, long col) const {
    if (row < 0 || row >= rows || col < 0 || col >= cols) refuse(row, col);
  }
  /// Entry of a column or row vector.
  void check(long index) const {
    if (index < 0 || index >= rows * cols) refuse(index);
  }
  /// That the part from (row, col) on lies inside.
  void check_part(long row, long col, long part_rows, long part_cols) const {
    if (row < 0 || row + part_rows > rows || col < 0 || col + part_cols > cols)
      refuse(row < 0 ? row : row + part_rows - 1, col < 0 ? col : col + part_cols - 1);
  }
  [[noreturn]] void refuse(long row, long col) const;
  [[noreturn]] void refuse(long index) const;
};

/// Eigen's evaluator of something with entries, asking first.
template <class Evaluator>
struct CheckedEvaluator : Evaluator {
  TracedBounds bounds;

  CheckedEvaluator() = default;
  template <class Expression>
  explicit CheckedEvaluator(const Expression& e)
      : Evaluator(e), bounds{e.rows(), e.cols(), e.data()} {}

  typename Evaluator::CoeffReturnType coeff(long row, long col) const {
    bounds.check(row, col);
    return Evaluator::coeff(row, col);
  }
  typename Evaluator::CoeffReturnType coeff(long index) const {
    bounds.check(index);
    return Evaluator::coeff(index);
  }
  Tracer& coeffRef(long row, long col) {
    bounds.check(row, col);
    return Evaluator::coeffRef(row, col);
  }
  Tracer& coeffRef(long index) {
    bounds.check(index);
    return Evaluator::coeffRef(index);
  }
};

void mark_unwritten(Tracer* entries, int count);

}  // namespace detail
}  // namespace saltus

namespace Eigen {
namespace internal {

template <int rows, int cols, int options, int max_rows, int max_cols>
struct evaluator<Matrix<saltus::Tracer, rows, cols, options, max_rows, max_cols>>
    : saltus::detail::CheckedEvaluator<evaluator<
          PlainObjectBase<Matrix<saltus::Tracer, rows, cols, options, max_rows, max_cols>>>> {
  using XprType = Matrix<saltus::Tracer, rows, cols, options, max_rows, max_cols>;
  using Checked = saltus::detail::CheckedEvaluator<evaluator<PlainObjectBase<XprType>>>;

  evaluator() = default;
  explicit evaluator(const XprType& m) : Checked(m) {}
};

template <class Whole, int rows, int cols, bool inner_panel>
  requires saltus::detail::Traced<Whole>
struct block_evaluator<Whole, rows, cols, inner_panel, true>
    : saltus::detail::CheckedEvaluator<
          mapbase_evaluator<Block<Whole, rows, cols, inner_panel>,
                            typename Block<Whole, rows, cols, inner_panel>::PlainObject>> {
  using XprType = Block<Whole, rows, cols, inner_panel>;
  using Checked =
      saltus::detail::CheckedEvaluator<mapbase_evaluator<XprType, typename XprType::PlainObject>>;

  explicit block_evaluator(const XprType& part) : Checked(part) {
    const auto& whole = part.nestedExpression();
    saltus::detail::TracedBounds{whole.rows(), whole.cols(), whole.data()}.check_part(
        part.startRow(), part.startCol(), part.rows(), part.cols());
  }
};

// Entries of fixed-size vectors and matrices, which begin unwritten.
template <int size, int options>
  requires(size > 0)
struct plain_array<saltus::Tracer, size, options, 16> {
  EIGEN_ALIGN_TO_BOUNDARY(16) saltus::Tracer array[size];

  plain_array() { saltus::detail::mark_unwritten(array, size); }
  explicit plain_array(constructor_without_unaligned_array_assert) : plain_array() {}
};

}  // namespace internal

// v << a, b, c: Eigen's rules; what is missing stays unwritten.
template <saltus::detail::Traced Whole>
struct CommaInitializer<Whole> {
  CommaInitializer(Whole& whole, const saltus::Tracer& entry) : whole_(whole), col_(1), height_(1) {
    whole_(0, 0) = entry;
  }
  template <class Part>
  CommaInitializer(Whole& whole, const DenseBase<Part>& part)
      : whole_(whole), col_(part.cols()), height_(part.rows()) {
    whole_.block(0, 0, part.rows(), part.cols()) = part;
  }

  CommaInitializer& operator,(const saltus::Tracer& entry) {
    if (col_ == whole_.cols()) next_row(1);
    whole_(row_, col_++) = entry;
    return *this;
  }
  template <class Part>
  CommaInitializer& operator,(const DenseBase<Part>& part) {
    if (col_ == whole_.cols() && (part.cols() != 0 || part.rows() != height_))
      next_row(part.rows());
    whole_.block(row_, col_, part.rows(), part.cols()) = part;
    col_ += part.cols();
    return *this;
  }
  Whole& finished() { return whole_; }

 private:
  void next_row(Index height) {
    row_ += height_;
    col_ = 0;
    height_ = height;
  }

  Whole& whole_;
  Index row_ = 0, col_, height_;
};

}  // namespace Eigen
