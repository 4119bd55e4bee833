// A small set of indices, used for the inputs that a formula depends on.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace saltus {

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

}  // namespace saltus
