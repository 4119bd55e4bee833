// The input that a controller applies until its next tick.
#pragma once

#include <utility>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

class MultipleShooting;

/// A constant input during [start, start + length).
struct InputPiece {
  double start = 0.0;   ///< absolute time in seconds
  double length = 0.0;  ///< duration in seconds
  int size = 0;         ///< dimension of the input
  VectorXd values;      ///< sized for the largest phase; the first `size` entries are valid

  /// The input of dimension `size`.
  Eigen::VectorBlock<const VectorXd> input() const { return values.head(size); }
};

/// Pieces that cover one tick without gaps, in order. There is one piece, or more if an event falls
/// inside the tick. The capacity is fixed. Empty before the first tick and after a move.
class HeldInput {
 public:
  HeldInput() = default;
  HeldInput(const HeldInput& other) = default;
  HeldInput& operator=(const HeldInput& other) = default;
  /// Leaves the other object empty.
  HeldInput(HeldInput&& other) noexcept
      : pieces_(std::move(other.pieces_)), count_(std::exchange(other.count_, 0)) {}
  /// Leaves the other object empty.
  HeldInput& operator=(HeldInput&& other) noexcept {
    pieces_ = std::move(other.pieces_);
    count_ = std::exchange(other.count_, 0);
    return *this;
  }
  ~HeldInput() = default;
  /// Allocates for the given number of pieces and input dimension. Later calls do not allocate.
  HeldInput(int pieces, int largest_input);

  /// Number of pieces.
  std::size_t size() const { return count_; }
  /// True if there is no piece.
  bool empty() const { return count_ == 0; }
  /// Piece i. Throws DefinitionError if it does not exist.
  const InputPiece& operator[](std::size_t i) const {
    if (i >= count_) refuse(i);
    return pieces_[i];
  }
  /// The last piece. Throws DefinitionError if there is none.
  const InputPiece& back() const { return (*this)[count_ - 1]; }
  /// First piece.
  std::vector<InputPiece>::const_iterator begin() const { return pieces_.begin(); }
  /// Past-the-end iterator.
  std::vector<InputPiece>::const_iterator end() const {
    return pieces_.begin() + static_cast<std::ptrdiff_t>(count_);
  }

  /// Removes all pieces.
  void clear() { count_ = 0; }
  /// Appends a piece to fill in. Throws DefinitionError if the capacity is exhausted.
  InputPiece& add() {
    if (count_ >= pieces_.size()) refuse(count_);
    return pieces_[count_++];
  }
  /// The last piece, mutable. Throws DefinitionError if there is none.
  InputPiece& last() {
    if (count_ == 0) refuse(0);
    return pieces_[count_ - 1];
  }
  /// True if all numbers are finite.
  bool all_finite() const;

 private:
  [[noreturn]] void refuse(std::size_t i) const;

  std::vector<InputPiece> pieces_;
  std::size_t count_ = 0;
};

/// Allocates enough pieces for a tick of any length.
HeldInput held_input_for(const MultipleShooting& shooting);

/// Extracts [t, t + period) from the plan w on the current grid: one piece for every shooting
/// interval that the tick touches. Linear inputs are sampled at the middle of their part. If the
/// plan ends before the tick, its last input is held. Does not allocate.
void hold(const MultipleShooting& shooting, const VectorXd& w, double t, double period,
          HeldInput& held);

}  // namespace saltus
