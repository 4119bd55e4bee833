// The input that a controller hands over until its next tick.
#pragma once

#include <utility>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

class MultipleShooting;

/// A constant input during [start, start + length), absolute time in s.
struct InputPiece {
  double start = 0.0;   ///< of the time from the plan's start, s
  double length = 0.0;  ///< s
  int size = 0;         ///< how many numbers the input has
  VectorXd values;      ///< of the largest phase; `size` of them count

  /// The input, `size` numbers.
  Eigen::VectorBlock<const VectorXd> input() const { return values.head(size); }
};

/// Pieces that cover one tick without gap, in order: one, or more when an event falls inside. Has
/// room for as many as will ever be needed. Empty before the first tick and once it was moved from.
class HeldInput {
 public:
  HeldInput() = default;
  HeldInput(const HeldInput& other) = default;
  HeldInput& operator=(const HeldInput& other) = default;
  /// Leaves the other one empty.
  HeldInput(HeldInput&& other) noexcept
      : pieces_(std::move(other.pieces_)), count_(std::exchange(other.count_, 0)) {}
  /// Leaves the other one empty.
  HeldInput& operator=(HeldInput&& other) noexcept {
    pieces_ = std::move(other.pieces_);
    count_ = std::exchange(other.count_, 0);
    return *this;
  }
  ~HeldInput() = default;
  /// Room for so many pieces and inputs so large; nothing is allocated afterwards.
  HeldInput(int pieces, int largest_input);

  /// How many pieces.
  std::size_t size() const { return count_; }
  /// Whether there is none.
  bool empty() const { return count_ == 0; }
  /// Piece i. Throws DefinitionError unless there is one.
  const InputPiece& operator[](std::size_t i) const {
    if (i >= count_) refuse(i);
    return pieces_[i];
  }
  /// The last piece. Throws DefinitionError if there is none.
  const InputPiece& back() const { return (*this)[count_ - 1]; }
  /// First piece.
  std::vector<InputPiece>::const_iterator begin() const { return pieces_.begin(); }
  /// One behind the last piece.
  std::vector<InputPiece>::const_iterator end() const {
    return pieces_.begin() + static_cast<std::ptrdiff_t>(count_);
  }

  /// Forgets all pieces.
  void clear() { count_ = 0; }
  /// A piece to be filled in. Throws DefinitionError where there is no room for one.
  InputPiece& add() {
    if (count_ >= pieces_.size()) refuse(count_);
    return pieces_[count_++];
  }
  /// The last piece, to be changed. Throws DefinitionError if there is none.
  InputPiece& last() {
    if (count_ == 0) refuse(0);
    return pieces_[count_ - 1];
  }
  /// Whether every number is finite.
  bool all_finite() const;

 private:
  [[noreturn]] void refuse(std::size_t i) const;

  std::vector<InputPiece> pieces_;
  std::size_t count_ = 0;
};

/// As many pieces as a tick of any length can need.
HeldInput held_input_for(const MultipleShooting& shooting);

/// Cuts [t, t + period) out of the plan w on the present grid: a piece for every shooting interval
/// that the tick touches (linear inputs are sampled at the middle of their part). Where the plan
/// ends before the tick does, its last input goes on. Does not allocate.
void hold(const MultipleShooting& shooting, const VectorXd& w, double t, double period,
          HeldInput& held);

}  // namespace saltus
