// Differential-algebraic phases: known answers with every scheme, events and jumps, optimal control
// with algebraic states in costs and bounds, and messages for algebraic states that cannot be
// computed.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/model/algebraic.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "tests/support/algebraic_problems.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;

VectorXd end_of(Integrator& integrator, const VectorXd& start, const VectorXd& p, double length) {
  VectorXd w(integrator.arguments().size()), end(integrator.outputs());
  w << start, p, 0.0, length;
  EXPECT_EQ(integrator.value(w.data(), end.data()), IntegrationStatus::success)
      << integrator.failure();
  return end;
}

double algebraic(const PhaseDefinition& phase, const VectorXd& x) {
  VectorXd argument(phase.sizes.size());
  argument << 0.0, x;
  return algebraic_states(phase.algebraic.equations)(argument)[0];
}

// The reference of the test set, with 16 digits as printed there. Our results by CVODES and IDAS at
// 1e-12, and by Radau IIA on intervals that grow from the fast start, agree with it.
TEST(KnownAnswers, MatchForChemicalAkzoNobel) {
  const PhaseDefinition phase = akzo_nobel();
  const VectorXd known = (VectorXd(5) << 0.1150794920661702, 0.1203831471567715e-2,
                          0.1611562887407974, 0.3656156421249283e-3, 0.1708010885264404e-1)
                             .finished();
  constexpr int intervals = 60;
  for (const IntegratorChoice& scheme : {cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14}),
                                         idas({.tolerance = 1e-12, .absolute_tolerance = 1e-14}),
                                         radau_iia({.stages = 4, .steps = 10})}) {
    const auto integrator = scheme->make(differentiable_interval_of(phase));
    VectorXd end = akzo_nobel_start;
    for (int k = 0; k < intervals; ++k)
      end =
          end_of(*integrator, end, VectorXd(),
                 180.0 * (std::pow((k + 1.0) / intervals, 4) - std::pow(k / double{intervals}, 4)));
    for (int i = 0; i < 5; ++i)
      EXPECT_NEAR(end[i] / known[i], 1.0, 1e-9) << scheme->name() << ", " << i;
    EXPECT_NEAR(algebraic(phase, end) / 0.4873531310307455e-2, 1.0, 1e-9) << scheme->name();
  }
}

double energy(const VectorXd& x) {
  return 0.5 * x.tail(2).squaredNorm() + Pendulum::gravity * x[1];
}

TEST(KnownAnswers, ThePendulumKeepsItsEnergyAndLength) {
  const VectorXd start = (VectorXd(4) << 1.0, 0.0, 0.0, 0.0).finished();
  for (const IntegratorChoice& scheme :
       {cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
        idas({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
        gauss_legendre({.stages = 4, .steps = 200}), radau_iia({.stages = 4, .steps = 400}),
        runge_kutta8({.steps = 800})}) {
    const auto integrator = scheme->make(differentiable_interval_of(pendulum()));
    const VectorXd end = end_of(*integrator, start, VectorXd(), 10.0);
    // Backward differentiation has the largest drift: 2e-8 in 17 swings.
    EXPECT_NEAR(energy(end), 0.0, 5e-8) << scheme->name();
    EXPECT_NEAR(end.head(2).norm(), 1.0, 5e-9) << scheme->name();
    EXPECT_LT(std::abs(end[0]), 0.999);
  }
}

// Equals its ordinary form (problems/library/d02_robertson_kinetics.cpp has the numbers).
TEST(KnownAnswers, MatchForRobertsonWithConservationOfMass) {
  const PhaseDefinition phase = robertson_with_conservation();
  const VectorXd p = phase.parameters.front().value;
  const Vec<double, 2> known{0.985172113861, 3.38639537898e-5};
  Mat<double, 2, 3> slopes;
  slopes << -0.355952565984, 9.54238142759e-8, -1.58317663551e-11,  //
      3.90254405381e-4, -2.13096103022e-10, -5.29004109321e-13;
  for (const IntegratorChoice& scheme : {cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
                                         idas({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
                                         radau_iia({.stages = 4, .steps = 2000})}) {
    const auto integrator = scheme->make(differentiable_interval_of(phase));
    VectorXd w(7), end(2);
    w << 1.0, 0.0, p, 0.0, 0.4;
    MatrixXd derivative(2, 7);
    ASSERT_EQ(integrator->jacobian(w.data(), end.data(), derivative), IntegrationStatus::success);
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(end[i] / known[i], 1.0, 1e-9) << scheme->name();
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(derivative(i, 2 + k) / slopes(i, k), 1.0, 1e-8) << scheme->name();
    }
  }
}

// Time, a ramp input, a parameter and a cost that depends on z. All sensitivities of IDAS match
// those of a scheme of order 8.
TEST(KnownAnswers, SensitivitiesOfIdasMatchImplicitRungeKutta) {
  Phase<2, 1, 1, 2> phase{
      "all",
      [](const auto& t, const auto& x, const auto& z, const auto& u, const auto& p) {
        return std::decay_t<decltype(x)>{x[1] * z[0] + 0.1 * t, u[0] - p[0] * z[1]};
      },
      [](const auto& t, const auto& x, const auto& z, const auto& u, const auto& p) {
        return std::decay_t<decltype(z)>{z[0] * z[0] - 1.0 - x[0] * x[0] - 0.1 * u[0] * t,
                                         z[1] + 0.5 * sin(z[1]) - x[0] * z[0] - p[0]};
      },
      Vec<double, 2>{1.0, 0.0}, exactly(1.0)};
  phase.data("p", Vec<double, 1>{0.7})
      .inputs(InputParametrisation::piecewise_linear)
      .minimise("cost", [](const auto&, const auto& x, const auto& z, const auto& u) {
        return z[1] * z[1] * x[0] + u[0] * z[0];
      });
  IntervalProblem interval = differentiable_interval_of(phase.definition());
  interval.running_cost = phase.definition().terms.front().function;
  interval.shape = InputShape::linear;
  interval.differentiate_time = true;
  const VectorXd w = (VectorXd(7) << 0.4, -0.3, 0.5, -0.2, 0.7, 0.1, 0.8).finished();
  const auto reference = gauss_legendre({.stages = 4, .steps = 8})->make(interval);
  const auto adaptive = idas({.tolerance = 1e-11})->make(interval);
  VectorXd end(3), end_of_reference(3);
  MatrixXd derivative(3, 7), derivative_of_reference(3, 7);
  ASSERT_EQ(reference->jacobian(w.data(), end_of_reference.data(), derivative_of_reference),
            IntegrationStatus::success);
  for (int call = 0; call < 2; ++call) {
    ASSERT_EQ(adaptive->jacobian(w.data(), end.data(), derivative), IntegrationStatus::success);
    EXPECT_LE((end - end_of_reference).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((derivative - derivative_of_reference).cwiseAbs().maxCoeff(), 1e-8);
    ASSERT_EQ(adaptive->value(w.data(), end.data()), IntegrationStatus::success);
    EXPECT_LE((end - end_of_reference).cwiseAbs().maxCoeff(), 1e-9);
  }
  VectorXd none = w;
  none[6] = 0.0;  // length zero: the identity
  ASSERT_EQ(adaptive->jacobian(none.data(), end.data(), derivative), IntegrationStatus::success);
  ASSERT_EQ(reference->jacobian(none.data(), end_of_reference.data(), derivative_of_reference),
            IntegrationStatus::success);
  EXPECT_EQ(end.head(2), none.head(2));
  EXPECT_LE((derivative - derivative_of_reference).cwiseAbs().maxCoeff(), 1e-12);
  // Nothing allocates after the first calls, in which IDAS receives its tolerances.
  const saltus::testing::AllocationCount count;
  adaptive->jacobian(none.data(), end.data(), derivative);
  adaptive->value(none.data(), end.data());
  EXPECT_EQ(count.made(), 0);
}

TEST(KnownAnswers, IdasRejectsInvalidTolerances) {
  EXPECT_THROW(idas({.tolerance = 0.0}), DefinitionError);
  EXPECT_THROW(idas({.absolute_tolerance = -1.0}), DefinitionError);
  EXPECT_THROW(idas({.max_steps = 0}), DefinitionError);
  EXPECT_EQ(idas({.tolerance = 1e-9})->name(), "IDAS, tolerance 1e-09");
}

// --- optimal control -----------------------------------------------------------------------------
// Algebraic equations determine the stiffness of a spring and its force on the mass:
//   x1' = x2, x2' = z1 - 0.1 x2,   0 = z0^2 - (1 + x1^2),   0 = z1 + z0 x1 - u.
// z appears in cost and bounds. Elimination of z by hand gives an ordinary problem.
struct Mass {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& z, const Vec<S, 1>&) const {
    return {x[1], z[1] - 0.1 * x[1]};
  }
};
struct Spring {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& z, const Vec<S, 1>& u) const {
    return {z[0] * z[0] - 1.0 - x[0] * x[0], z[1] + z[0] * x[0] - u[0]};
  }
};
const auto force = [](const auto& x, const auto& u) {
  using std::sqrt;
  return u[0] - sqrt(1.0 + x[0] * x[0]) * x[0];
};
const auto at_rest = [](const auto&, const auto& x) {
  return Vec<std::decay_t<decltype(x[0])>, 2>{x[0], x[1]};
};

OptimalControlProblem with_algebraic_states(CostRule rule) {
  Phase<2, 1, 0, 2> phase{"pull", Mass{}, Spring{}, Vec<double, 2>{1.0, 0.0}, exactly(2.0)};
  phase
      .minimise("cost",
                [](const auto&, const auto& x, const auto& z, const auto& u) {
                  return z[0] * x[0] * x[0] + 0.1 * z[1] * z[1] + 0.01 * u[0] * u[0];
                })
      .bound_algebraic(1, between(-1.5, 1.5))
      .keep(
          "stiffness", [](const auto&, const auto&, const auto& z) { return z[0]; }, at_most(1.4))
      .reach("at rest", at_rest, exactly(0.0));
  OptimalControlProblem ocp("with algebraic states");
  ocp.start_at({0.9, 0.0}).then(phase).costs(rule);
  return ocp;
}

OptimalControlProblem solved_by_hand(CostRule rule) {
  Phase<2, 1> phase{"pull",
                    [](const auto&, const auto& x, const auto& u) {
                      return std::decay_t<decltype(x)>{x[1], force(x, u) - 0.1 * x[1]};
                    },
                    exactly(2.0)};
  phase
      .minimise("cost",
                [](const auto&, const auto& x, const auto& u) {
                  using std::sqrt;
                  const auto f = force(x, u);
                  return sqrt(1.0 + x[0] * x[0]) * x[0] * x[0] + 0.1 * f * f + 0.01 * u[0] * u[0];
                })
      .keep(
          "force", [](const auto&, const auto& x, const auto& u) { return force(x, u); },
          between(-1.5, 1.5))
      .keep(
          "stiffness",
          [](const auto&, const auto& x) {
            using std::sqrt;
            return sqrt(1.0 + x[0] * x[0]);
          },
          at_most(1.4))
      .reach("at rest", at_rest, exactly(0.0));
  OptimalControlProblem ocp("solved by hand");
  ocp.start_at({0.9, 0.0}).then(phase).costs(rule);
  return ocp;
}

class AlgebraicControl : public ::testing::TestWithParam<CostRule> {};
INSTANTIATE_TEST_SUITE_P(Rules, AlgebraicControl,
                         ::testing::Values(CostRule::nodes, CostRule::integrated),
                         [](const auto& rule) {
                           return rule.param == CostRule::nodes ? "nodes" : "integrated";
                         });

TEST_P(AlgebraicControl, MatchesTheOptimumOfTheOdeForm) {
  const ShootingOptions options{.intervals_per_phase = 20,
                                .integrator = gauss_legendre({.stages = 3})};
  MultipleShooting shooting(with_algebraic_states(GetParam()), options);
  MultipleShooting ordinary(solved_by_hand(GetParam()), options);
  const auto ipopt = make_ipopt({.tolerance = 1e-11});
  const Solution reference = solve(ordinary, *ipopt);
  const Solution plan = solve(shooting, *ipopt);
  ASSERT_TRUE(reference.ok() && plan.ok()) << reference.message << "; " << plan.message;
  EXPECT_NEAR(plan.cost, reference.cost, 1e-9 * reference.cost);
  EXPECT_LE((plan.point.w - reference.point.w).cwiseAbs().maxCoeff(), 1e-7);
  double largest = 0.0;
  for (const Trajectory::Piece& piece : plan.trajectory.pieces())
    largest = std::max(largest, std::abs(plan.trajectory.algebraic(piece.start)[1]));
  EXPECT_NEAR(largest, 1.5, 1e-7);  // the bound is active
  std::ostringstream table;
  plan.trajectory.write_csv(table);
  EXPECT_EQ(table.str().substr(0, table.str().find('\n')), "t,phase,x0,x1,u0,z0,z1");
  for (const SolverChoice choice : {SolverChoice::sparse, SolverChoice::riccati}) {
    const Solution own = solve(shooting, *make_solver(choice, {.tolerance = 1e-10}));
    EXPECT_TRUE(own.ok()) << own.message;
    EXPECT_NEAR(own.cost, reference.cost, 1e-8 * reference.cost) << name_of(choice);
  }
  for (const IntegratorChoice& scheme :
       {cvodes({.tolerance = 1e-11}), idas({.tolerance = 1e-11})}) {
    const ReplayReport again = replay(with_algebraic_states(GetParam()), plan.trajectory, scheme);
    EXPECT_TRUE(again.completed) << scheme->name();
    EXPECT_LE(again.from_start, 1e-7) << scheme->name();
  }
}

TEST_P(AlgebraicControl, DerivativesOfTheProgramAreExact) {
  for (const IntegratorChoice& scheme :
       {runge_kutta4({.steps = 2}), radau_iia({.stages = 2}), gauss_legendre({.stages = 3})}) {
    MultipleShooting shooting(with_algebraic_states(GetParam()),
                              {.intervals_per_phase = 4, .integrator = scheme});
    const NlpPoint point = perturbed(shooting.nlp(), shooting.initial_guess().w, 3, 0.2);
    const DerivativeErrors errors =
        derivative_errors(shooting.nlp(), point, Curvature::exact, 1e-5);
    EXPECT_LT(errors.gradient, 1e-7) << scheme->name();
    EXPECT_LT(errors.jacobian, 1e-7) << scheme->name();
    EXPECT_LT(errors.hessian, 1e-6) << scheme->name();
  }
}

// --- events and jumps ----------------------------------------------------------------------------
// A pendulum is released when the tension of its string vanishes. A guard that depends on z ends
// the phase, and a ball in free flight follows.
TEST(AlgebraicEvents, PhaseEndsAtAGuardOfAlgebraicStates) {
  const auto tension = [](const auto&, const auto& x, const auto& z) {
    return x[2] * x[2] + x[3] * x[3] - z[0] * (x[0] * x[0] + x[1] * x[1]) -
           Pendulum::gravity * x[1];
  };
  Phase<4, 0, 0, 1> swing{"swing", Pendulum{}, tension, Vec<double, 1>{1.0}, between(0.1, 2.0)};
  swing.ends_when(
      "slack", [](const auto&, const auto&, const auto& z) { return z[0]; }, Crossing::falling);
  swing.guess_duration(0.5).guess_state(Guess::simulate());
  Phase<4, 0> flight{
      "flight",
      [](const auto&, const auto& x) {
        return std::decay_t<decltype(x)>{x[2], x[3], 0.0 * x[0], 0.0 * x[0] - Pendulum::gravity};
      },
      exactly(0.1)};
  OptimalControlProblem ocp("let go");
  const double speed = 6.0;  // speed at the bottom, enough to rise above the pivot
  ocp.start_at({0.0, -1.0, speed, 0.0})
      .then(swing)
      .then(flight, jump<4>("half the speed", [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{x[0], x[1], 0.5 * x[2], 0.5 * x[3]};
            }));
  MultipleShooting shooting(
      ocp, {.intervals_per_phase = 10, .integrator = gauss_legendre({.stages = 4, .steps = 2})});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  // There v^2 = g h with h the height above the pivot, and v^2 = speed^2 - 2 g (1 + h).
  const double height = (speed * speed - 2.0 * Pendulum::gravity) / (3.0 * Pendulum::gravity);
  EXPECT_NEAR(s.trajectory.state_before(s.durations[0])[1], height, 1e-8);
  EXPECT_NEAR(s.trajectory.state(s.durations[0]).tail(2).squaredNorm(),
              0.25 * Pendulum::gravity * height, 1e-7);
  EXPECT_EQ(s.trajectory.algebraic(s.durations[0] + 0.05).size(), 0);
  ASSERT_EQ(s.crossings.size(), 1u);
  EXPECT_TRUE(s.crossings[0].is_as_declared());
}

// An event inside a phase: at a given tension of the string, half the speed is lost. The guard
// depends on z, and derivatives pass through the event.
TEST(AlgebraicEvents, ResetsInsideAPhase) {
  const auto tension = [](const auto&, const auto& x, const auto& z) {
    return x[2] * x[2] + x[3] * x[3] - z[0] * (x[0] * x[0] + x[1] * x[1]) -
           Pendulum::gravity * x[1];
  };
  constexpr double limit = 25.0;
  Phase<4, 0, 0, 1> phase{"swing", Pendulum{}, tension, Vec<double, 1>{1.0}, exactly(1.0)};
  const auto pulled = [](const auto&, const auto&, const auto& z) { return z[0] - limit; };
  const auto halved = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0], x[1], 0.5 * x[2], 0.5 * x[3]};
  };
  phase.on("pulled", pulled, Crossing::rising, halved);
  Automaton<4, 0, 0, 1> swings{tension, Vec<double, 1>{1.0}};  // the same with modes
  swings.mode("fast", Pendulum{})
      .mode("slow", Pendulum{})
      .event("pulled", "fast", "slow", pulled, Crossing::rising, halved);
  const Phase<4, 0, 0, 1> modes{"swing", swings, exactly(1.0)};
  for (const auto& mode :
       interval_problem_of(modes.definition()).switching.modes)  // IDAS supports these
    ASSERT_TRUE(dae_before_elimination(mode.dynamics)) << mode.name;
  const VectorXd start = (VectorXd(4) << 1.0, 0.0, 0.0, 0.0).finished();
  for (const IntegratorChoice& scheme :
       {cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
        idas({.tolerance = 1e-12, .absolute_tolerance = 1e-13}), runge_kutta8({.steps = 100}),
        radau_iia({.stages = 4, .steps = 60})}) {
    const auto integrator = scheme->make(differentiable_interval_of(phase.definition()));
    const VectorXd end = end_of(*integrator, start, VectorXd(), 0.7);
    const auto by_modes = scheme->make(interval_problem_of(modes.definition()));
    EXPECT_EQ(end_of(*by_modes, start, VectorXd(), 0.7), end) << scheme->name();
    const double fall = limit / (3.0 * Pendulum::gravity);  // z = 3 g fall before
    EXPECT_NEAR(energy(end), -0.75 * Pendulum::gravity * fall, 1e-8) << scheme->name();
    VectorXd w(6), value(4);
    w << start, 0.0, 0.7;
    MatrixXd derivative(4, 6);
    ASSERT_EQ(integrator->jacobian(w.data(), value.data(), derivative), IntegrationStatus::success);
    constexpr double step = 1e-4;
    for (int i = 0; i < 4; ++i) {
      VectorXd shift = VectorXd::Zero(4);
      shift[i] = step;
      const VectorXd slope = (end_of(*integrator, start + shift, VectorXd(), 0.7) -
                              end_of(*integrator, start - shift, VectorXd(), 0.7)) /
                             (2.0 * step);
      EXPECT_LE((slope - derivative.col(i)).cwiseAbs().maxCoeff(), 1e-5) << scheme->name();
    }
  }
}

// --- messages ------------------------------------------------------------------------------------
TEST(AlgebraicMessages, NamePhaseAndEquationIfTheIndexExceedsOne) {
  try {
    const Phase<4, 0, 0, 1> phase{
        "swing", Pendulum{},
        [](const auto&, const auto& x, const auto&) { return x[0] * x[0] + x[1] * x[1] - 1.0; },
        Vec<double, 1>{1.0}, exactly(1.0)};
    FAIL();
  } catch (const DefinitionError& e) {
    EXPECT_STREQ(
        e.what(),
        "phase 'swing': algebraic equation 0 of 1, counted from 0, contains no algebraic state: "
        "g_z is singular and the index exceeds 1; replace the equation by its time derivative.");
  }
}

TEST(AlgebraicMessages, ReportsAnInconsistentStart) {
  Phase<1, 1, 0, 1> phase{
      "drain", [](const auto&, const auto&, const auto& z) { return -z[0]; },
      [](const auto&, const auto& x, const auto& z) { return z[0] * z[0] - x[0]; },
      Vec<double, 1>{1.0}, exactly(1.0)};
  phase.minimise("effort",
                 [](const auto&, const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  OptimalControlProblem ocp("outflow");
  ocp.start_at({-1.0}).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt());
  EXPECT_FALSE(s.ok());
  EXPECT_NE(s.message.find("phase 'drain', interval 0 from t = 0 s: the algebraic equations have "
                           "no solution near the guess at t = 0 s: algebraic equation 0 of 1"),
            std::string::npos)
      << s.message;
  EXPECT_THROW((Phase<1, 1, 0, 1>(phase).bound_algebraic(1, at_most(1.0))), DefinitionError);
}

}  // namespace
}  // namespace saltus
