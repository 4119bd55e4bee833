// Memory that is sized once and handed out anew in every solve.
#pragma once

#include <cstddef>

namespace saltus::qp {

/// Hands out pieces of an array, each on a boundary of 64 bytes where T is double and the storage
/// begins on one.
template <class T, class Storage>
class Arena {
 public:
  Arena() = default;
  explicit Arena(std::size_t capacity) : storage_(capacity), capacity_(capacity) {}
  void reset() { used_ = 0; }
  /// nullptr where the capacity does not suffice.
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
