// Shared helpers for the tests of events.
#pragma once

#include <gtest/gtest.h>

#include "problems/library/hybrid_systems.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/simulate.hpp"
#include "saltus/integrators/sundials.hpp"

namespace saltus::test {

using namespace library;

inline const CvodesOptions tight_options{
    .method = CvodesOptions::Method::Adams, .tolerance = 1e-12, .absolute_tolerance = 1e-14};

inline VectorXd vec(std::initializer_list<double> values) { return numbers(values); }

struct HybridScheme {
  const char* name;
  IntegratorChoice choice;
};
inline void PrintTo(const HybridScheme& scheme, std::ostream* out) { *out << scheme.name; }

/// Simulations without inputs by several schemes.
class HybridSchemeTest : public testing::TestWithParam<HybridScheme> {
 protected:
  HybridSimulation run(const IntervalProblem& problem, const VectorXd& x0, const VectorXd& times,
                       const VectorXd& p = VectorXd(), const std::string& mode = {}) const {
    return simulate_hybrid(GetParam().choice, problem, x0, times, MatrixXd(0, times.size() - 1), p,
                           mode);
  }
};

}  // namespace saltus::test
