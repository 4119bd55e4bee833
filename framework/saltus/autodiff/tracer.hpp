// Determines the inputs that a result depends on and the pairs of inputs that enter nonlinearly.
// The formula runs once on numbers that carry only these two sets.
//
// The sets are structural: x - x still depends on x. abs, min, max and select treat all their
// arguments as nonlinear, so an empty pair set safely means "affine". Only constants have values.
// Products with a constant zero are zero, so zeros of a constant matrix are exact zeros of the
// Jacobian. A formula must therefore not change its constants after tracing.
//
// A tracer also stores whether it was written: results computed from an unwritten entry are
// unwritten.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/autodiff/dual.hpp"
#include "saltus/autodiff/math.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

namespace detail {

// A small set of indices, used for the inputs that a formula depends on.

/// A set of small non-negative integers that allocates only when it is not empty.
class IndexSet {
 public:
  /// Adds an index.
  void insert(int i) {
    grow(i / 64 + 1);
    words_[i / 64] |= std::uint64_t{1} << (i % 64);
  }
  /// Adds all indices of the other set.
  void insert(const IndexSet& other) {
    grow(static_cast<int>(other.words_.size()));
    for (std::size_t w = 0; w < other.words_.size(); ++w) words_[w] |= other.words_[w];
  }
  /// True if the set contains i.
  bool contains(int i) const {
    return i / 64 < static_cast<int>(words_.size()) && ((words_[i / 64] >> (i % 64)) & 1u) != 0;
  }
  /// True if the set is empty.
  bool empty() const { return words_.empty(); }
  /// Calls visit(i) for each index in ascending order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t rest = words_[w]; rest != 0; rest &= rest - 1)
        visit(static_cast<int>(64 * w) + std::countr_zero(rest));
  }

 private:
  void grow(int words) {
    if (words > static_cast<int>(words_.size())) words_.resize(words, 0);
  }
  std::vector<std::uint64_t> words_;
};

}  // namespace detail

class Tracer;
template <>
inline constexpr bool is_active_scalar<Tracer> = true;  ///< a tracer tracks dependence

/// Replaces double in a formula that is traced. Allocates, so use it at set-up only. Its arithmetic
/// is compiled once in tracer.cpp, not with every formula.
class Tracer {
 public:
  Tracer() = default;  // the constant zero
  /// A constant, without dependence.
  Tracer(double constant) : value_(constant) {}  // NOLINT: implicit
  Tracer(const Tracer& other);
  Tracer(Tracer&& other) noexcept;
  Tracer& operator=(const Tracer& other);
  Tracer& operator=(Tracer&& other) noexcept;
  ~Tracer();
  /// An input.
  static Tracer input(int index);
  /// The value of an entry before its first write.
  static Tracer unwritten();

  /// True unless it is an unwritten entry or was computed from one.
  bool is_written() const { return written_; }
  /// True if it depends on no input.
  bool is_constant() const { return written_ && inputs_.empty(); }
  /// True if it is the constant 0.
  bool is_zero() const { return is_constant() && value_ == 0.0; }
  /// The value of a constant.
  double constant() const { return value_; }
  /// The inputs this result depends on.
  const detail::IndexSet& inputs() const { return inputs_; }
  /// Calls visit(i, j), i >= j, for each pair whose second derivative may be non-zero.
  template <class Visit>
  void for_each_pair(Visit&& visit) const {
    pairs_.for_each([&](int index) {
      int i = 0;  // index = i (i + 1) / 2 + j
      while ((i + 1) * (i + 2) / 2 <= index) ++i;
      visit(i, index - i * (i + 1) / 2);
    });
  }

  /// f(a) for a nonlinear f.
  static Tracer nonlinear(const Tracer& a);
  /// f(a, b) for an f without known structure.
  static Tracer nonlinear(const Tracer& a, const Tracer& b);
  /// Either a or b. Depends on all inputs of both and of the condition.
  static Tracer select(const Tracer& condition, const Tracer& a, const Tracer& b);

  Tracer& operator+=(const Tracer& b);
  Tracer& operator-=(const Tracer& b);
  Tracer& operator*=(const Tracer& b);
  Tracer& operator/=(const Tracer& b);

  friend Tracer operator+(const Tracer& a);
  friend Tracer operator-(const Tracer& a);
  friend Tracer operator+(const Tracer& a, const Tracer& b);
  friend Tracer operator-(const Tracer& a, const Tracer& b);
  friend Tracer operator*(const Tracer& a, const Tracer& b);
  friend Tracer operator/(const Tracer& a, const Tracer& b);
  friend Tracer operator+(const Tracer& a, double b) { return a + Tracer(b); }
  friend Tracer operator+(double a, const Tracer& b) { return Tracer(a) + b; }
  friend Tracer operator-(const Tracer& a, double b) { return a - Tracer(b); }
  friend Tracer operator-(double a, const Tracer& b) { return Tracer(a) - b; }
  friend Tracer operator*(const Tracer& a, double b) { return a * Tracer(b); }
  friend Tracer operator*(double a, const Tracer& b) { return Tracer(a) * b; }
  friend Tracer operator/(const Tracer& a, double b) { return a / Tracer(b); }
  friend Tracer operator/(double a, const Tracer& b) { return Tracer(a) / b; }

  /// Declared for a clear compiler error (dual.hpp), like the next two.
  template <class Index>
  const Tracer& operator[](const Index&) const {
    detail::advise_scalar_index<(sizeof(Index) > 0)>();
    return *this;
  }
  /// A scalar has no entries.
  template <class Index>
  const Tracer& operator()(const Index&) const {
    detail::advise_scalar_index<(sizeof(Index) > 0)>();
    return *this;
  }
  /// A traced value does not convert to a number.
  template <std::same_as<double> Number>
  explicit operator Number() const {
    return detail::advise_double_conversion<(sizeof(Number) > 0)>();
  }
  /// Only functions of <cmath> select this conversion, because they have an overload for long
  /// double. As a template it converts to no other type, so `condition ? x[0] : 1.0` stays
  /// unambiguous.
  template <std::same_as<long double> Number>
  operator Number() const {  // NOLINT: implicit
    return detail::advise_standard_function<(sizeof(Number) > 0)>();
  }

 private:
  static Tracer linear(const Tracer& a, const Tracer& b);
  void interact(const Tracer& a, const Tracer& b);

  double value_ = 0.0;  // valid for constants only
  bool written_ = true;
  detail::IndexSet inputs_;
  detail::IndexSet pairs_;
};

Tracer sin(const Tracer& x);
Tracer cos(const Tracer& x);
Tracer tan(const Tracer& x);
Tracer asin(const Tracer& x);
Tracer acos(const Tracer& x);
Tracer atan(const Tracer& x);
Tracer sinh(const Tracer& x);
Tracer cosh(const Tracer& x);
Tracer tanh(const Tracer& x);
Tracer exp(const Tracer& x);
Tracer log(const Tracer& x);
Tracer sqrt(const Tracer& x);
Tracer abs(const Tracer& x);
Tracer min(const Tracer& a, const Tracer& b);
Tracer max(const Tracer& a, const Tracer& b);
Tracer atan2(const Tracer& a, const Tracer& b);
Tracer hypot(const Tracer& a, const Tracer& b);
Tracer pow(const Tracer& a, const Tracer& b);
Tracer pow(const Tracer& a, double exponent);

}  // namespace saltus

// Every file with vectors of tracers needs the following specialisations for Eigen.

namespace saltus {

// Bounds-checked vectors and matrices of tracers, also in Release builds. A formula that accesses
// an entry out of range throws IndexError when it is traced at set-up. Evaluation uses other
// scalars and costs nothing extra. Entries without a value are marked as unwritten.
//
// Eigen accesses the entries of a matrix through its evaluator, and those of a block (head<2>(),
// row(1)) through the block's evaluator. Both are specialised for tracers, as is the comma
// initialiser. coeff() reads the storage, which also checks. The storage behind data() has extra
// entries at both ends. They stay unwritten, so writes to them are detected.

namespace detail {

/// Thrown when a formula accesses an entry that a vector or matrix of tracers does not have.
struct IndexError {
  long row = 0, col = 0;    ///< accessed entry, counted from 0; a vector uses row
  long rows = 0, cols = 1;  ///< size of the vector or matrix
  int first_input = -1;     ///< first input if entries are consecutive inputs, else -1
};

template <class Expression>
concept Traced =
    std::same_as<typename Eigen::internal::traits<std::remove_const_t<Expression>>::Scalar, Tracer>;

/// Size of a vector or matrix.
struct TracedBounds {
  long rows = 0, cols = 0;
  const Tracer* first = nullptr;

  void check(long row, long col) const {
    if (row < 0 || row >= rows || col < 0 || col >= cols) refuse(row, col);
  }
  /// Checks an entry of a column or row vector.
  void check(long index) const {
    if (index < 0 || index >= rows * cols) refuse(index);
  }
  /// Checks that a block starting at (row, col) lies inside.
  void check_part(long row, long col, long part_rows, long part_cols) const {
    if (row < 0 || row + part_rows > rows || col < 0 || col + part_cols > cols)
      refuse(row < 0 ? row : row + part_rows - 1, col < 0 ? col : col + part_cols - 1);
  }
  [[noreturn]] void refuse(long row, long col) const;
  [[noreturn]] void refuse(long index) const;
};

/// An Eigen evaluator that checks each access.
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
/// True if a write through data() went beyond a vector in this thread since the last call. Detected
/// in the destructor of the vector.
bool was_written_beyond();
void detect_writes(const Tracer* beyond, int count);

/// A pointer to entries that checks accesses against their number.
template <class Entry>
struct TracedPointer {
  using iterator_category = std::random_access_iterator_tag;
  using value_type = Tracer;
  using difference_type = std::ptrdiff_t;
  using pointer = Entry*;
  using reference = Entry&;

  Entry* at;
  const Tracer* first;
  long rows, cols;

  operator Entry*() const { return at; }  // NOLINT: implicit, as Eigen's data() returns one
  Entry& operator[](Eigen::Index index) const {
    TracedBounds{rows, cols, first}.check(index);
    return at[index];
  }
  Entry& operator*() const { return *at; }
  TracedPointer& operator++() {
    ++at;
    return *this;
  }
};

/// Entries of a vector or matrix of fixed size, initially unwritten.
template <int size>
class TracedEntries {
 public:
  TracedEntries() { mark_unwritten(all_, beyond + size + beyond); }
  TracedEntries(const TracedEntries&) = default;
  TracedEntries& operator=(const TracedEntries&) = default;
  TracedEntries(TracedEntries&&) = default;
  TracedEntries& operator=(TracedEntries&&) = default;
  ~TracedEntries() {
    detect_writes(all_, beyond);
    detect_writes(all_ + beyond + size, beyond);
  }

  Tracer* data() { return all_ + beyond; }
  const Tracer* data() const { return all_ + beyond; }

 private:
  static constexpr int beyond = 4;
  Tracer all_[beyond + size + beyond];
};

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

}  // namespace internal

template <int size, int row_count, int col_count, int options>
  requires(size > 0 && row_count > 0 && col_count > 0)
class DenseStorage<saltus::Tracer, size, row_count, col_count, options> {
 public:
  DenseStorage() = default;
  explicit DenseStorage(internal::constructor_without_unaligned_array_assert) {}
  DenseStorage(Index, Index, Index) {}
  void swap(DenseStorage& other) { std::swap(entries_, other.entries_); }
  static constexpr Index rows() { return row_count; }
  static constexpr Index cols() { return col_count; }
  void resize(Index, Index, Index) {}
  void conservativeResize(Index, Index, Index) {}
  saltus::detail::TracedPointer<saltus::Tracer> data() {
    return {entries_.data(), entries_.data(), row_count, col_count};
  }
  saltus::detail::TracedPointer<const saltus::Tracer> data() const {
    return {entries_.data(), entries_.data(), row_count, col_count};
  }

 private:
  saltus::detail::TracedEntries<size> entries_;
};

// v << a, b, c with the rules of Eigen. Missing entries stay unwritten.
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
