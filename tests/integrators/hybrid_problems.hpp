// What the tests of events share.
#pragma once

#include <gtest/gtest.h>

#include "integrators/cvodes.hpp"
#include "integrators/runge_kutta.hpp"
#include "problems/library/hybrid_systems.hpp"

namespace saltus::test {

using namespace library;

inline const CvodesOptions tight_options{
    .method = CvodesMethod::Adams, .tolerance = 1e-12, .absolute_tolerance = 1e-14};

inline VectorXd vec(std::initializer_list<double> values) { return numbers(values); }

}  // namespace saltus::test
