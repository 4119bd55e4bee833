// How often the heap was asked for memory, by whomever: for tests that ban allocation.
#pragma once

namespace saltus::test {

/// Counts malloc, calloc, realloc and aligned_alloc from its construction on, in all threads, and
/// with them operator new, Eigen (which calls malloc) and C libraries.
class AllocationCount {
 public:
  AllocationCount();
  long so_far() const;
  /// False under the address sanitizer, which has its own heap: so_far() is then always zero.
  static bool works();

 private:
  long start_;
};

}  // namespace saltus::test
