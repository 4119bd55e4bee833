// Scalars for the Eigen tests. The tests are in two files, because a single file takes 850 MB to
// compile.
#pragma once

#include <gtest/gtest.h>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/types.hpp"
#include "tests/autodiff/compare_scalars.hpp"

namespace saltus::test {

template <class S>
class InEigen : public ::testing::Test {};
using Scalars = ::testing::Types<Dual<double, 0>, Dual<double, 8>, Dual<Dual<double, 4>, 1>>;
TYPED_TEST_SUITE(InEigen, Scalars);

}  // namespace saltus::test
