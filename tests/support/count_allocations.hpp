// How many times memory was allocated since a point in a test: proves that a real-time path does
// not allocate. Eigen's own ban does not see std::vector; the global operator new sees both.
// A test that uses it adds tests/support/count_allocations.cpp to its sources.
#pragma once

namespace saltus::testing {

/// AllocationCount count; ...; EXPECT_EQ(count.made(), 0);
class AllocationCount {
 public:
  AllocationCount();
  /// Calls of operator new and of Eigen's malloc, in all threads, since construction.
  long made() const;
  /// Those of the calling thread, which is the one that constructed this.
  long made_by_this_thread() const;

 private:
  long start_, start_here_;
};

}  // namespace saltus::testing
