// Results do not depend on units. Library problems with states, inputs, times, costs and rows
// multiplied by factors far from one have the same optimum and the same status.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "problems/library/catalogue.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/transcription/quantities.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

const char* const cases[] = {"A01", "A02", "A04", "A06", "A08", "A09", "A11", "A14", "A20", "B03",
                             "B05", "B07", "B10", "B11", "B15", "B18", "B21", "B22", "B25", "C03"};

class Units : public testing::TestWithParam<const char*> {};

// Multiplies the cost by `factor`, and every row of a term by the factor or its inverse at random.
ProgramScale scale_of_cost_and_rows(const NonlinearProgram& program, double factor) {
  ProgramScale units{factor, VectorXd::Ones(program.rows()), VectorXd::Ones(program.variables())};
  int at = 0;
  for (double& row : units.rows) row = ++at % 3 == 0 ? factor : at % 3 == 1 ? 1.0 / factor : 1.0;
  return units;
}

TEST_P(Units, CostAndRowUnitsDoNotChangeTheResult) {
  const ReferenceCase& c = reference_case(GetParam());
  MultipleShooting shooting(c.problem(), c.options);
  NonlinearProgram& program = shooting.nlp();
  const NlpPoint start = shooting.initial_guess();
  const auto solver = make_ipopt({.tolerance = 1e-9});
  const NlpResult expected = solver->solve(program, start, false);
  ASSERT_EQ(expected.status, SolveStatus::optimal);
  for (const double factor : {1e-4, 1e4}) {
    ScaledProgram other(program, scale_of_cost_and_rows(program, factor));
    const ScaledResult r = solve_in_scale(*solver, other, start, false);
    EXPECT_EQ(r.nlp.status, SolveStatus::optimal) << factor;
    EXPECT_NEAR(r.nlp.objective / factor, expected.objective,
                1e-6 * (1.0 + std::abs(expected.objective)))
        << factor;
    EXPECT_LE(r.in_scale.scaled(), 1e-7) << factor;
  }
}

// One unit for each component of state and input and for each parameter, and one for all durations.
ProgramScale other_units(const MultipleShooting& shooting, const Quantities& quantities,
                         NonlinearProgram& program, int set) {
  ProgramScale units = scale_of_cost_and_rows(program, set % 2 == 0 ? 1e4 : 1e-4);
  const bool are_alike = set < 2;
  Random random(set);
  const auto unit = [&] { return are_alike ? units.cost : random.log_uniform(1e-4, 1e4); };
  const double of_time = unit();
  for (const std::vector<int>& quantity : quantities) {
    const bool is_duration =
        shooting.layout().describe(quantity.front()).find("duration") != std::string::npos;
    const double factor = is_duration ? of_time : unit();
    for (const int v : quantity) units.variables[v] = factor;
  }
  return units;
}

// Problems with several local optima. In other units the solvers take other paths, and may reach
// another optimum.
bool has_other_optima(const std::string& id) { return id == "B15" || id == "C03"; }

// Twenty problems in four other sets of units: all times 1e4, all times 1e-4, and two with a
// separate factor for each quantity.
TEST_P(Units, StateInputAndTimeUnitsDoNotChangeTheResult) {
  const ReferenceCase& c = reference_case(GetParam());
  MultipleShooting shooting(c.problem(), c.options);
  NonlinearProgram& program = shooting.nlp();
  const Quantities quantities = undeclared_quantities(shooting.program());
  const NlpPoint start = shooting.initial_guess();
  for (const auto choice : {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
    SCOPED_TRACE(name_of(choice));
    const auto solver = make_solver(choice, {.tolerance = 1e-9});
    const ScaledResult expected = solve_in_scale(*solver, program, start, false, quantities);
    ASSERT_EQ(expected.nlp.status, SolveStatus::optimal);
    for (int set = 0; set < 4; ++set) {
      const ProgramScale units = other_units(shooting, quantities, program, set);
      ScaledProgram other(program, units);
      const ScaledResult r =
          solve_in_scale(*solver, other, other.to_scaled(start), false, quantities);
      EXPECT_TRUE(is_success(r.nlp.status)) << set;
      EXPECT_FALSE(r.is_doubtful) << set;
      EXPECT_NE(r.check.curvature, OptimumCheck::Curvature::descent) << set;
      const double allowed = 1e-6 * (1.0 + std::abs(expected.nlp.objective));
      const double cost = r.nlp.objective / units.cost;
      if (has_other_optima(c.id))
        EXPECT_GE(cost, expected.nlp.objective - allowed) << set;
      else
        EXPECT_NEAR(cost, expected.nlp.objective, allowed) << set;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Library, Units, testing::ValuesIn(cases),
                         [](const auto& of) { return std::string(of.param); });

// A distant, slow cart without a guess of its force.
OptimalControlProblem far_cart(bool with_nominal) {
  Phase<2, 1> phase{"cart",
                    [](const auto&, const auto& x, const auto& u) {
                      return decltype(x.eval()){x[1], 1e-9 * u[0]};
                    },
                    exactly(1.0)};
  phase.minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; })
      .guess_state(Guess::constant(Vec<double, 2>{1e6, 1e-6}));
  if (with_nominal) phase.nominal(Vec<double, 2>{1e6, 1e-6}, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("cart");
  ocp.start_at({1e6, 1e-6}).then(phase);
  return ocp;
}

TEST(ProgramSize, FollowsTheGuessOrTheQuantities) {
  const ShootingOptions options{.intervals_per_phase = 10, .integrator = runge_kutta4()};
  const auto size_of = [](MultipleShooting& shooting) {
    ProgramSize size(shooting.nlp(), undeclared_quantities(shooting.program()));
    EXPECT_TRUE(size.look_at(shooting.initial_guess().w));
    return size;
  };
  MultipleShooting shooting(far_cart(false), options);
  const ProgramSize size = size_of(shooting);
  EXPECT_FALSE(size.is_well_scaled_where_known(size.usual()));
  const VectorXd scale = size.to_one().variables;
  const Layout& layout = shooting.layout();
  EXPECT_EQ(scale[layout.state(0, 0)], 1e-6);
  EXPECT_EQ(scale[layout.state(0, 10)], 1e-6);
  EXPECT_NEAR(scale[layout.state(0, 3) + 1], 1e6, 1e-9);
  EXPECT_NEAR(scale[layout.input(0, 0)], 1e-4, 1e-13);  // 1e-6 / (0.1 1e-9) = 1e4

  MultipleShooting declared(far_cart(true), options);
  const VectorXd kept = size_of(declared).to_one().variables;
  EXPECT_EQ(kept[layout.state(0, 0)], 1.0);
  EXPECT_EQ(kept[layout.state(0, 3) + 1], 1.0);
}

// The guess is zero and the rows determine no size either.
TEST(ProgramSize, UsesBoundsIfNothingElseIsKnown) {
  Phase<1, 1> phase{"cart", [](const auto&, const auto&, const auto& u) { return u; },
                    exactly(1.0)};
  phase.bound_input(0, between(-2e3, 1e3)).bound_state(0, between(-1e12, 50.0));
  OptimalControlProblem ocp("cart");
  ocp.start_at(VectorXd::Zero(1)).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
  ProgramSize size(shooting.nlp(), undeclared_quantities(shooting.program()));
  ASSERT_TRUE(size.look_at(shooting.initial_guess().w));
  const VectorXd scale = size.to_one().variables;
  EXPECT_NEAR(scale[shooting.layout().state(0, 1)], 1.0 / 50.0, 1e-15);
  EXPECT_NEAR(scale[shooting.layout().input(0, 0)], 1.0 / 2e3, 1e-15);
}

TEST(ProgramSize, MagnitudeOfOneCountsAsDeclared) {
  for (const bool is_declared : {false, true}) {
    Phase<2, 1> phase{"cart",
                      [](const auto&, const auto& x, const auto& u) {
                        return decltype(x.eval()){x[1], u[0]};
                      },
                      between(0.5, 2.0)};
    phase.guess_state(Guess::constant(Vec<double, 2>{1e6, 1e-6}));
    if (is_declared) phase.nominal(VectorXd::Ones(2), VectorXd::Ones(1)).nominal_duration(1.0);
    OptimalControlProblem ocp("cart");
    ocp.start_at({1e6, 1e-6}).then(phase);
    const MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
    EXPECT_EQ(undeclared_quantities(shooting.program()).empty(), is_declared);
  }
}

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

TEST(Scale, EverySolverScalesTheCost) {
  const auto cost = [](Solver& solver, double factor, bool automatic) {
    MultipleShooting shooting(
        cart(factor),
        {.intervals_per_phase = 20, .integrator = runge_kutta4(), .automatic_scale = automatic});
    const Solution s = solve(shooting, solver);
    // Without scaling, a cost of 1e-8 meets the tolerance of a solver anywhere, and the optimum
    // check reports that.
    EXPECT_EQ(s.ok(), automatic) << solver.name() << " at " << factor << ": " << s.message;
    EXPECT_LE(s.kkt_in_scale.scaled(), 1e-7);
    return s.cost / factor;
  };
  for (const auto& make : {+[] { return make_ipopt(); }, +[] { return make_native_solver(); },
                           +[] { return make_native_solver({.qp = riccati_qp()}); }}) {
    const double right = cost(*make(), 1.0, true);
    for (const double factor : {1e-8, 1e-4, 1e4, 1e8})
      EXPECT_NEAR(cost(*make(), factor, true), right, 1e-6 * right) << factor;
    EXPECT_NE(cost(*make(), 1e-8, false), cost(*make(), 1e-8, true));
  }
}

TEST(Scale, MultipliersAreUnscaled) {
  MultipleShooting shooting(cart(1e6), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  const KktCheck::Residual residual = kkt_residual(shooting.nlp(), s.point);
  EXPECT_EQ(residual.stationarity, s.kkt.stationarity);
  EXPECT_LE(residual.stationarity, 1e-7 * 1e6);
}

TEST(Scale, WellScaledProgramsAreUnchanged) {
  MultipleShooting shooting(cart(1.0), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  ProgramSize size(shooting.nlp(), undeclared_quantities(shooting.program()));
  ASSERT_TRUE(size.look_at(shooting.initial_guess().w));
  EXPECT_TRUE(size.usual().is_one());
  EXPECT_TRUE(size.is_well_scaled_where_known(size.usual()));
}

// A move of 0.3 mm in one second from rest, with at most 1.3 mm/s^2. With a guess of zeros, only
// the solution shows that the numbers are small.
OptimalControlProblem small_cart(double unit) {
  Phase<2, 1> phase{"cart",
                    [](const auto&, const auto& x, const auto& u) {
                      return decltype(x.eval()){x[1], u[0]};
                    },
                    exactly(1.0)};
  phase.minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; })
      .keep(
          "force", [](const auto&, const auto&, const auto& u) { return u[0]; },
          between(-1.3 * unit, 1.3 * unit))
      .reach("there", [](const auto&, const auto& x) { return x; },
             {exactly(0.3 * unit), exactly(0.0)});
  OptimalControlProblem ocp("cart");
  ocp.start_at({0, 0}).then(phase);
  return ocp;
}

// A solver that fails at the start from its second solve on.
class Once final : public Solver {
 public:
  explicit Once(std::unique_ptr<Solver> solver) : solver_(std::move(solver)) {}
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    NlpResult result = solver_->solve(program, start, warm);
    if (++solves > 1) {
      result.status = SolveStatus::numerical_failure;
      result.point = start;
    }
    return result;
  }
  std::string name() const override { return solver_->name(); }
  int solves = 0;

 private:
  std::unique_ptr<Solver> solver_;
};

// Ticks have no check afterwards, so presolve keeps a side that is far away at the guess.
TEST(Scale, BoundsAreOmittedOnlyOnRequest) {
  MultipleShooting shooting(small_cart(1e7),
                            {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  NonlinearProgram& program = shooting.nlp();
  const ProgramScale scale{1.0, VectorXd::Ones(program.rows()),
                           VectorXd::Constant(program.variables(), 0.5)};
  ScaledProgram scaled(program, scale);
  EXPECT_EQ(scaled.row_upper().array().isFinite().count(),
            program.row_upper().array().isFinite().count());
  EXPECT_GT(scaled.leave_out_idle_sides(), 0);
  for (int r = 0; r < program.rows(); ++r) {
    const bool is_equality = program.row_lower()[r] == program.row_upper()[r];
    EXPECT_EQ(scaled.row_lower()[r] == scaled.row_upper()[r], is_equality) << r;  // also 3e6
  }
  EXPECT_LT(scaled.row_upper().array().isFinite().count(),
            program.row_upper().array().isFinite().count());
  EXPECT_EQ(ScaledProgram(program, {1.0, VectorXd::Ones(program.rows())}).leave_out_idle_sides(),
            0);
}

TEST(Scale, ScaleFromTheSolutionIsUsedForAnotherAttempt) {
  const ShootingOptions options{.intervals_per_phase = 20, .integrator = runge_kutta4()};
  const auto solved = [&](double unit, Solver& solver) {
    MultipleShooting shooting(small_cart(unit), options);
    return solve(shooting, solver);
  };
  for (const auto choice : {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
    SCOPED_TRACE(name_of(choice));
    const double right = solved(1.0, *make_solver(choice)).cost;
    const Solution small = solved(1e-5, *make_solver(choice));
    EXPECT_TRUE(small.ok()) << small.message;
    EXPECT_NEAR(small.cost / 1e-10, right, 1e-6 * right);

    Once once(make_solver(choice));
    const Solution doubtful = solved(1e-5, once);
    EXPECT_GE(once.solves, 2);
    EXPECT_EQ(doubtful.status, SolveStatus::numerical_failure);
    EXPECT_NE(doubtful.message.find("nominal"), std::string::npos) << doubtful.message;
  }
}

TEST(IpoptOptionsByName, AreCheckedAndPassedThrough) {
  MultipleShooting shooting(cart(1.0), {.intervals_per_phase = 20, .integrator = runge_kutta4()});
  const Solution s =
      solve(shooting, *make_ipopt({.named = {{"max_iter", "1"}, {"mu_init", "1e-2"}}}));
  EXPECT_EQ(s.status, SolveStatus::iteration_limit);
  EXPECT_EQ(s.iterations, 1);
  expect_error<DefinitionError>(
      [] {
        make_ipopt({.named = {{"no_such_option", "yes"}}});
      },
      {"'no_such_option'"});
  EXPECT_THROW(make_ipopt({.named = {{"mu_strategy", "fast"}}}), DefinitionError);
}

}  // namespace
}  // namespace saltus
