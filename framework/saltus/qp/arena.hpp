// Memory that is allocated once and reused by every solve.
#pragma once

#include <cstddef>

namespace saltus::qp {

/// Hands out consecutive pieces of an array. With T = double and aligned storage, every piece
/// starts on a 64-byte boundary.
template <class T, class Storage>
class Arena {
 public:
  Arena() = default;
  explicit Arena(std::size_t capacity) : storage_(capacity), capacity_(capacity) {}
  void reset() { used_ = 0; }
  /// Number of elements in total.
  std::size_t capacity() const { return capacity_; }
  /// Returns the next `count` elements, or nullptr if the capacity is exhausted.
  T* take(int count) {
    const std::size_t step = (static_cast<std::size_t>(count) + 7) / 8 * 8;
    if (used_ + step > capacity_) return nullptr;
    T* result = storage_.data() + used_;
    used_ += step;
    return result;
  }

 private:
  Storage storage_;
  std::size_t used_ = 0, capacity_ = 0;
};

}  // namespace saltus::qp
