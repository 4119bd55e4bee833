// Events inside the intervals of a multiple-shooting problem: definition, optimum, derivatives,
// messages.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

struct Speed {
  double value;
  template <class S>
  S operator()(const S&, const Vec<S, 1>&) const {
    return S(value);
  }
};

// A17: x' = 3 below zero and 1 above; J = int_0^2 x^2 dt + (x(2) - 5/3)^2 over x(0).
OptimalControlProblem switch_of_speed(double guess) {
  const auto zero = [](const auto&, const auto& x) { return x[0]; };
  Phase<1, 0> phase("drive", Speed{3.0}, exactly(2.0));
  phase.switch_at("zero", zero, Speed{1.0})
      .minimise("square", [](const auto&, const auto& x) { return x[0] * x[0]; })
      .minimise_at_end(
          "end", [](const auto&, const auto& x) { return (x[0] - 5.0 / 3.0) * (x[0] - 5.0 / 3.0); })
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("switch of speed");
  ocp.start_within({between(-6.0, 0.0)}, VectorXd::Constant(1, guess)).then(phase);
  ocp.costs(CostRule::integrated);
  return ocp;
}

TEST(InnerEvents, FindTheOptimumThroughASwitch) {  // A17
  for (const auto& scheme : {runge_kutta4({.steps = 4}), gauss_legendre({.stages = 2, .steps = 2}),
                             cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14})})
    for (const double guess : {-5.0, -3.0, -1.1})
      for (const int intervals : {1, 7}) {
        MultipleShooting shooting(switch_of_speed(guess),
                                  {.intervals_per_phase = intervals, .integrator = scheme});
        const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-9}));
        ASSERT_TRUE(s.ok()) << s.message << " from " << guess;
        EXPECT_NEAR(s.trajectory.state(0.0)[0], -1.427572232082767, 1e-6) << guess;
        EXPECT_NEAR(s.cost, 1.523772775374957, 1e-9) << guess;
      }
}

struct Medium {
  double speed;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>&, const Vec<S, 1>& u) const {
    return {speed * sin(u[0]), -speed * cos(u[0])};
  }
};

// Minimum time from one medium into another that is twice as fast. No cost is a sum of squares, so
// a Gauss-Newton Hessian would be zero.
OptimalControlProblem refraction() {
  Phase<2, 1> way{"way", Medium{1.0}, between(0.1, 10.0)};
  way.switch_at(
         "surface", [](const auto&, const auto& x) { return -x[1]; }, Medium{2.0})
      .reach("there", [](const auto&, const auto& x) { return x; }, {exactly(2.0), exactly(-1.0)})
      .minimise_at_end("time", [](const auto& t, const auto&) { return t; })
      .guess_duration(2.0)
      .bound_input(0, between(-1.5, 1.5))
      .guess_state(Guess::simulate())
      .guess_input(Guess::constant(VectorXd::Constant(1, 0.8)));
  OptimalControlProblem ocp("refraction");
  return ocp.start_at({0.0, 1.0}).then(way);
}

TEST(InnerEvents, MinimumTimeIsSolvedWithDifferencedSecondDerivatives) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated})
    for (const int intervals : {2, 3, 5, 10}) {
      OptimalControlProblem ocp = refraction();
      ocp.costs(rule);
      MultipleShooting shooting(ocp,
                                {.intervals_per_phase = intervals, .integrator = runge_kutta4()});
      const Solution expected = solve(shooting, *make_ipopt());
      ASSERT_TRUE(expected.ok()) << expected.message;
      EXPECT_NE(expected.method.find("limited-memory BFGS Hessian"), std::string::npos);
      for (const QpMethod& qp : {sparse_qp(), riccati_qp()}) {
        const Solution s = solve(shooting, *make_native_solver({.qp = qp}));
        ASSERT_TRUE(s.ok()) << s.message << " with intervals: " << intervals;
        EXPECT_NEAR(s.cost, expected.cost, 1e-7);
        EXPECT_LE(s.iterations, 50);
        EXPECT_NE(s.method.find("differenced Hessian"), std::string::npos) << s.method;
        EXPECT_NE(s.message.find("differenced Hessian, because the integration has no "
                                 "second derivatives in phase 'way'"),
                  std::string::npos)
            << s.message;
      }
    }
}

TEST(InnerEvents, RealTimeIterationsReportTheirHessian) {
  MultipleShooting with_event(refraction(),
                              {.intervals_per_phase = 3, .integrator = runge_kutta4()});
  const auto solver = make_real_time_iteration(with_event.nlp());
  EXPECT_TRUE(solver->name().ends_with(", differenced Hessian")) << solver->name();
  NlpPoint point = with_event.initial_guess();
  for (int tick = 0; tick < 20; ++tick) {
    solver->prepare(with_event.nlp(), point);
    const RealTimeSolver::Result r =
        solver->feedback(with_event.nlp(), point, tick > 0, WallClock::time_point::max());
    ASSERT_EQ(r.status, SolveStatus::step_taken);
  }
  EXPECT_LT(kkt_residual(with_event.nlp(), point).scaled(), 1e-6);

  MultipleShooting curved(switch_of_speed(-3.0),
                          {.intervals_per_phase = 2, .integrator = runge_kutta4()});
  EXPECT_TRUE(make_real_time_iteration(curved.nlp(), {.curvature = Curvature::exact})
                  ->name()
                  .ends_with(", differenced Hessian"));
}

// A ball with a thruster above a moving floor. Guard and reset depend on input and time, and all
// are free.
OptimalControlProblem thrusted_ball(InputParametrisation parametrisation) {
  Phase<2, 1, 1> phase(
      "flight",
      [](const auto& t, const auto& x, const auto& u, const auto& p) {
        using V = std::decay_t<decltype(x)>;
        return V{x[1], u[0] - p[0] + 0.1 * sin(t)};
      },
      between(0.5, 3.0));
  phase.unknown("gravity", VectorXd::Constant(1, 9.81), between(5.0, 12.0))
      .on(
          "impact",
          [](const auto& t, const auto& x, const auto& u) {
            return x[0] - 0.05 * sin(3.0 * t) + 0.01 * u[0];
          },
          Crossing::falling,
          [](const auto& t, const auto& x, const auto& u, const auto& p) {
            using V = std::decay_t<decltype(x)>;
            return V{x[0], -0.8 * x[1] + 0.15 * cos(3.0 * t) + 0.02 * u[0] * p[0]};
          })
      .inputs(parametrisation)
      .minimise("effort", [](const auto&, const auto& x,
                             const auto& u) { return u[0] * u[0] + 0.1 * x[0] * x[0]; })
      .guess_duration(1.3)
      .guess_state(Guess::simulate())
      .guess_input(Guess::constant(VectorXd::Constant(1, 0.7)));
  OptimalControlProblem ocp("thrusted ball");
  ocp.start_at({1.0, 0.0}).start_time(0.2).then(phase).costs(CostRule::integrated);
  return ocp;
}

// Jacobian and gradient against central differences, entry by entry.
void expect_first_derivatives_match(NonlinearProgram& program, const VectorXd& at) {
  const int n = program.variables(), m = program.rows();
  constexpr double step = 1e-5, tolerance = 1e-7;  // truncation 1e-9 here, rounding 1e-10
  std::vector<double> entries(program.jacobian_pattern().entries());
  VectorXd slope(n), w = at, above(m), below(m);
  ASSERT_TRUE(program.jacobian(at.data(), entries.data()));
  ASSERT_TRUE(program.gradient(at.data(), slope.data()));
  MatrixXd jacobian = MatrixXd::Zero(m, n);
  program.jacobian_pattern().for_each([&](int r, int c, int e) { jacobian(r, c) = entries[e]; });
  for (int i = 0; i < n; ++i) {
    double f_above = 0.0, f_below = 0.0;
    w[i] = at[i] + step;
    ASSERT_TRUE(program.objective(w.data(), f_above));
    ASSERT_TRUE(program.constraints(w.data(), above.data()));
    w[i] = at[i] - step;
    ASSERT_TRUE(program.objective(w.data(), f_below));
    ASSERT_TRUE(program.constraints(w.data(), below.data()));
    w[i] = at[i];
    EXPECT_NEAR(slope[i], (f_above - f_below) / (2 * step), tolerance * (1 + std::abs(slope[i])));
    for (int r = 0; r < m; ++r)
      EXPECT_NEAR(jacobian(r, i), (above[r] - below[r]) / (2 * step),
                  tolerance * (1 + std::abs(jacobian(r, i))))
          << "row " << r << ", variable " << i;
  }
}

TEST(InnerEvents, DerivativesOfTheProgramAreExact) {
  for (const auto parametrisation :
       {InputParametrisation::piecewise_constant, InputParametrisation::piecewise_linear}) {
    MultipleShooting shooting(thrusted_ball(parametrisation),
                              {.intervals_per_phase = 4, .integrator = runge_kutta4({.steps = 3})});
    expect_first_derivatives_match(shooting.nlp(), shooting.initial_guess().w);
  }
}

TEST(InnerEvents, SecondDerivativesOfTheProgramAreExact) {
  for (const auto& scheme : {runge_kutta4({.steps = 3}), gauss_legendre({.stages = 2})}) {
    MultipleShooting shooting(thrusted_ball(InputParametrisation::piecewise_linear),
                              {.intervals_per_phase = 4, .integrator = scheme});
    ASSERT_TRUE(shooting.nlp().supports(Curvature::exact));
    const auto errors = testing_support::derivative_errors(
        shooting.nlp(), testing_support::perturbed(shooting.nlp(), shooting.initial_guess().w, 3));
    EXPECT_LE(errors.jacobian, 1e-7);
    EXPECT_LE(errors.hessian, 1e-6);
  }
}

template <class F>
std::string refusal(const F& define) {
  return error_of<DefinitionError>(define, "accepted");
}

TEST(InnerEvents, RejectsInvalidDefinitions) {
  const auto zero = [](const auto&, const auto& x) { return x[0]; };
  const auto shoot = [](const Phase<1, 0>& phase, const IntegratorChoice& scheme) {
    OptimalControlProblem ocp;
    ocp.start_at({-1.0}).then(phase);
    MultipleShooting shooting(ocp, {.intervals_per_phase = 2, .integrator = scheme});
  };
  const std::string twice = refusal([&] {
    Phase<1, 0> phase("drive", Speed{1.0}, exactly(1.0));
    phase.switch_at("first", zero, Speed{2.0}).switch_at("second", zero, Speed{3.0});
  });
  EXPECT_NE(twice.find("phase 'drive', event 'second'"), std::string::npos) << twice;
  const std::string flat = refusal([&] {
    Phase<1, 0> phase("drive", Speed{1.0}, exactly(1.0));
    phase.switch_at(
        "never", [](const auto&, const auto&) { return 1.0; }, Speed{2.0});
    shoot(phase, runge_kutta4());
  });
  EXPECT_NE(flat.find("'never'"), std::string::npos) << flat;
  EXPECT_NE(flat.find("depends on neither state, time nor input"), std::string::npos) << flat;
  const std::string scheme = refusal([&] {
    Phase<1, 0> phase("drive", Speed{1.0}, exactly(1.0));
    phase.switch_at("zero", zero, Speed{2.0});
    shoot(phase, zero_order_hold());
  });
  EXPECT_NE(scheme.find("phase 'drive'"), std::string::npos) << scheme;
  EXPECT_NE(scheme.find("use cvodes"), std::string::npos) << scheme;
  EXPECT_NE(refusal([&] {
              Automaton<1> automaton;
              automaton.mode("a", Speed{1.0}).event("go", "a", "b", zero, Crossing::rising);
            }).find("no mode 'b'"),
            std::string::npos);
}

TEST(InnerEvents, TheMessageNamesTimeAndEvent) {
  // Both fields point away from the start.
  const auto zero = [](const auto&, const auto& x) { return x[0]; };
  Phase<1, 0> phase("drive", Speed{-1.0}, exactly(1.0));
  phase.switch_at("zero", zero, Speed{1.0}).reach("somewhere", zero, between(-5.0, 5.0));
  OptimalControlProblem ocp;
  ocp.start_within({between(-1.0, 1.0)}, VectorXd::Zero(1)).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 2, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt());
  EXPECT_EQ(s.status, SolveStatus::evaluation_failed);
  EXPECT_NE(s.message.find("phase 'drive', interval 0 from t = 0 s: at t = 0 s"), std::string::npos)
      << s.message;
  EXPECT_NE(s.message.find("event 'zero'"), std::string::npos) << s.message;
}

}  // namespace
}  // namespace saltus
