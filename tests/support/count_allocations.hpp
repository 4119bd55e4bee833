// Counts memory allocations from a point in a test on, to prove that a real-time path does not
// allocate. Eigen's own check does not detect allocations of std::vector; this counter detects
// both. A test that uses it adds tests/support/count_allocations.cpp to its sources.
#pragma once

namespace saltus::testing {

/// Usage: AllocationCount count; ...; EXPECT_EQ(count.made(), 0);
class AllocationCount {
 public:
  AllocationCount();
  /// Number of calls of operator new and of Eigen's malloc in all threads since construction.
  long made() const;
  /// Number of these calls in the calling thread, which must be the thread that constructed this
  /// object.
  long made_by_this_thread() const;

 private:
  long start_, start_here_;
};

}  // namespace saltus::testing
