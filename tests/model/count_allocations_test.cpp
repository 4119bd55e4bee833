// Tests the allocation counter used by tests of real-time code.
#include "tests/support/count_allocations.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {
namespace {

TEST(CountAllocations, CountsAllocationsOfTheStandardLibraryAndEigen) {
  std::string text(100, 'a');
  std::vector<VectorXd> vectors;
  testing::AllocationCount by_string;
  text.append(1000, 'b');  // allocates within the shared library
  EXPECT_EQ(by_string.made(), 1);
  testing::AllocationCount by_vector;
  vectors.reserve(text.size());
  EXPECT_EQ(by_vector.made(), 1);
  testing::AllocationCount by_eigen;
  vectors.emplace_back(VectorXd::Zero(static_cast<Eigen::Index>(text.size())));
  EXPECT_EQ(by_eigen.made(), 1);
}

}  // namespace
}  // namespace saltus
