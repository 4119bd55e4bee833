// The units of cost and rows do not decide what is found: library problems with their cost and rows
// multiplied by factors far from one have the same optimum and the same status.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "problems/library/catalogue.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/sqp.hpp"

namespace saltus {
namespace {

const char* const cases[] = {"A01", "A02", "A04", "A06", "A08", "A09", "A11", "A14", "A20", "B03",
                             "B05", "B07", "B10", "B11", "B15", "B18", "B21", "B22", "B25", "C03"};

class Units : public testing::TestWithParam<const char*> {};

// Cost times `factor`, every row of a term times it or its inverse, as it comes.
void expect_same(const ReferenceCase& c, Solver& solver, double factor, double tolerance) {
  SCOPED_TRACE(solver.name() + " at " + std::to_string(factor));
  MultipleShooting shooting(c.problem(), c.options);
  NonlinearProgram& program = shooting.nlp();
  const NlpPoint start = shooting.initial_guess();
  const NlpResult expected = solver.solve(program, start, false);
  ASSERT_EQ(expected.status, SolveStatus::optimal);
  ProgramScale units{factor, VectorXd::Ones(program.rows())};
  int at = 0;
  for (double& row : units.rows) row = ++at % 3 == 0 ? factor : at % 3 == 1 ? 1.0 / factor : 1.0;
  ScaledProgram other(program, units);
  KktResidual in_scale;
  const NlpResult r = solve_in_scale(solver, other, start, false, in_scale);
  EXPECT_EQ(r.status, SolveStatus::optimal);
  EXPECT_NEAR(r.objective / factor, expected.objective,
              tolerance * (1.0 + std::abs(expected.objective)));
  EXPECT_LE(in_scale.scaled(), 1e-7);
}

TEST_P(Units, DoNotDecideWhatIsFound) {
  const ReferenceCase& c = reference_case(GetParam());
  for (const double factor : {1e-4, 1e4})
    expect_same(c, *make_ipopt({.tolerance = 1e-9}), factor, 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Library, Units, testing::ValuesIn(cases),
                         [](const auto& of) { return std::string(of.param); });

struct Cart {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.1 * x[1] * x[1]};
  }
};

OptimalControlProblem cart(double cost) {
  Phase<2, 1> phase{"cart", Cart{}, exactly(1.0)};
  phase
      .minimise("effort",
                [cost](auto, auto x, auto u) { return cost * (u[0] * u[0] + x[0] * x[0]); })
      .bound_input(0, between(-5.0, 5.0))
      .reach(
          "there", [](auto, auto x) { return x[0]; }, exactly(1.0));
  OptimalControlProblem ocp("cart");
  ocp.start_at({0, 0}).then(phase);
  return ocp;
}

TEST(Scale, OfACostIsFoundByEverySolver) {
  const auto cost = [](Solver& solver, double factor, bool automatic) {
    MultipleShooting shooting(
        cart(factor),
        {.intervals_per_phase = 20, .integrator = runge_kutta4(), .automatic_scale = automatic});
    const Solution s = solve(shooting, solver);
    EXPECT_TRUE(s.ok()) << solver.name() << " at " << factor << ": " << s.message;
    EXPECT_LE(s.kkt_in_scale.scaled(), 1e-7);
    return s.cost / factor;
  };
  for (const auto& make : {+[] { return make_ipopt(); }, +[] { return make_sqp(); },
                           +[] { return make_sqp({.qp = riccati_qp()}); }}) {
    const double right = cost(*make(), 1.0, true);
    for (const double factor : {1e-8, 1e-4, 1e4, 1e8})
      EXPECT_NEAR(cost(*make(), factor, true), right, 1e-6 * right) << factor;
    EXPECT_NE(cost(*make(), 1e-8, false), cost(*make(), 1e-8, true));
  }
}

TEST(Scale, MultipliersAreThoseOfTheProgram) {
  MultipleShooting shooting(cart(1e6), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  const KktResidual residual = kkt_residual(shooting.nlp(), s.point);
  EXPECT_EQ(residual.stationarity, s.kkt.stationarity);
  EXPECT_LE(residual.stationarity, 1e-7 * 1e6);
}

TEST(Scale, WhatIsWellStatedStaysAsItIs) {
  MultipleShooting shooting(cart(1.0), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  EXPECT_TRUE(measure_scale(shooting.nlp(), shooting.initial_guess().w).is_one());
}

TEST(IpoptOptionsByName, AreCheckedAndPassedThrough) {
  MultipleShooting shooting(cart(1.0), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  const Solution s =
      solve(shooting, *make_ipopt({.named = {{"max_iter", "1"}, {"mu_init", "1e-2"}}}));
  EXPECT_EQ(s.status, SolveStatus::iteration_limit);
  EXPECT_EQ(s.iterations, 1);
  try {
    make_ipopt({.named = {{"no_such_option", "yes"}}});
    FAIL();
  } catch (const DefinitionError& e) {
    EXPECT_NE(std::string(e.what()).find("'no_such_option'"), std::string::npos) << e.what();
  }
  EXPECT_THROW(make_ipopt({.named = {{"mu_strategy", "fast"}}}), DefinitionError);
}

}  // namespace
}  // namespace saltus
