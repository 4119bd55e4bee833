// Free durations. The derivatives of the whole program are exact for every integrator, with time in
// dynamics, costs and constraints, and the total time is correct.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using testing_support::derivative_errors;
using testing_support::DerivativeErrors;
using testing_support::perturbed;

struct Swing {  // depends on time, nonlinear, with an unknown
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    return {x[1], u[0] * cos(t) - p[0] * sin(x[0]) + t};
  }
};
struct Drive {  // affine, as the exact zero-order hold requires
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    return {x[1], u[0] - 0.3 * x[0] + 0.5};
  }
};
const auto cost = [](const auto& t, const auto& x, const auto& u) {
  return 0.5 * u[0] * u[0] + t * x[0] * x[0];
};
const auto lane = [](const auto& t, const auto& x) { return x[0] - sin(t); };
const auto thrust = [](const auto& t, const auto& x, const auto& u) { return u[0] * t + x[1]; };

// Two free phases. Time enters every kind of term, a window divides the second phase, soft rows
// have a cost per unit of free time, and the jump depends on time.
template <class Dynamics>
OptimalControlProblem free_time(const Dynamics& dynamics, CostRule rule,
                                InputParametrisation parametrisation) {
  OptimalControlProblem ocp("free time");
  Phase<2, 1, 1> first{"first", dynamics, between(0.3, 2.0)};
  Phase<2, 1, 1> second{"second", dynamics, between(0.6, 2.0)};
  first.guess_duration(0.7).nominal_duration(0.5).ends_when("gate", lane, Crossing::rising);
  second.guess_duration(1.1)
      .keep("window", lane, between(-2.0, 2.0), Window{.from = 0.25})
      .reach("late", lane, between(-1.0, 1.0));
  for (auto* phase : {&first, &second})
    phase->inputs(parametrisation)
        .unknown("stiffness", Vec<double, 1>{0.8}, between(0.1, 3.0))
        .minimise("cost", cost)
        .track("follow", lane, Vec<double, 1>{0.6})
        .minimise_at_end("end", [](auto t, auto x) { return t * t + x[1] * t; })
        .keep("thrust", thrust, between(-5.0, 5.0))
        .keep("soft lane", lane, at_most(0.1), {}, soft("lane", 0.8))
        .keep("soft thrust", thrust, at_most(0.1), {}, soft("square", 0.8, Penalty::L2));
  ocp.start_within({unbounded(), unbounded()}, Vec<double, 2>{0.4, 0.1});
  ocp.then(first).then(second, jump<2>("kick", [](auto t, auto x) {
                         return decltype(x){x[0] + t, x[1] * t};
                       }));
  return ocp.costs(rule).total_time(between(1.0, 3.0));
}

/// Form of the problem for a method: all terms, the affine terms only, or the one case that covers
/// most.
enum class Form { all, affine, slow };
struct Method {
  const char* name;
  IntegratorChoice integrator;
  Form form;
  double tolerance;  ///< tolerance of first and second derivatives, with its reason
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.name; }

class FreeTime : public ::testing::TestWithParam<Method> {};

TEST_P(FreeTime, HasExactDerivatives) {
  const Method& method = GetParam();
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated})
    for (const InputParametrisation parametrisation :
         {InputParametrisation::piecewise_constant, InputParametrisation::piecewise_linear}) {
      const bool ramps = parametrisation == InputParametrisation::piecewise_linear;
      const bool integrated = rule == CostRule::integrated;
      if (method.form == Form::affine && (ramps || integrated)) continue;
      if (method.form == Form::slow && !(ramps && integrated)) continue;
      SCOPED_TRACE(rule == CostRule::nodes ? "nodes" : "integrated");
      const OptimalControlProblem ocp = method.form == Form::affine
                                            ? free_time(Drive{}, rule, parametrisation)
                                            : free_time(Swing{}, rule, parametrisation);
      MultipleShooting shooting(ocp, {.intervals_per_phase = 2, .integrator = method.integrator});
      NonlinearProgram& nlp = shooting.nlp();
      NlpPoint at = perturbed(nlp, shooting.initial_guess().w, 11, 0.1);
      // A program without a Hessian is compared without one.
      const bool exact = nlp.supports(Curvature::exact);
      const DerivativeErrors e =
          derivative_errors(nlp, at, exact ? Curvature::exact : Curvature::gauss_newton);
      EXPECT_LT(e.gradient, method.tolerance);
      EXPECT_LT(e.jacobian, method.tolerance);
      if (exact) {
        EXPECT_LT(e.hessian, 10.0 * method.tolerance);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Integrators, FreeTime,
                         ::testing::Values(
                             // Accuracy of central differences with a step of 1e-5.
                             Method{"runge_kutta4", runge_kutta4(), Form::all, 2e-8},
                             Method{"runge_kutta8", runge_kutta8(), Form::all, 2e-8},
                             Method{"zero_order_hold", zero_order_hold(), Form::affine, 2e-8},
                             Method{"arkode", arkode({.fixed_steps = 4}), Form::all, 2e-8},
                             // Steps change with the argument, so values jump by about the global
                             // error of 1e-11. Divided by twice 1e-5, that is 1e-6.
                             Method{"cvodes",
                                    cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13}),
                                    Form::slow, 1e-5}),
                         [](const auto& instance) { return instance.param.name; });

// --- total time ---------------------------------------------------------------------------------

struct Velocity {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};

// Two legs of length 1 and 2 with effort 1/2 u^2 cost d^2 / (2 T) each. For a given total T the
// legs take T/3 and 2T/3, and the cost is 9 / (2 T).
OptimalControlProblem two_legs() {
  const auto effort = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
  const auto position = [](const auto&, const auto& x) { return x[0]; };
  Phase<1, 1> one{"one", Velocity{}, between(0.1, 50.0)},
      two{"two", Velocity{}, between(0.1, 50.0)};
  one.guess_duration(1.0).minimise("effort", effort).reach("mark", position, exactly(1.0));
  two.guess_duration(1.0).minimise("effort", effort).reach("end", position, exactly(3.0));
  OptimalControlProblem ocp("two legs");
  return ocp.start_at({0}).then(one).then(two);
}

TEST(TotalTime, MayBeFixedBoundedOrFree) {
  for (const Bounds total : {exactly(6.0), at_most(6.0), between(2.0, 6.0)}) {
    OptimalControlProblem ocp = two_legs();
    MultipleShooting shooting(ocp.total_time(total),
                              {.intervals_per_phase = 4, .integrator = runge_kutta4()});
    const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.durations[0], 2.0, 1e-6);
    EXPECT_NEAR(s.durations[1], 4.0, 1e-6);
    EXPECT_NEAR(s.cost, 0.75, 1e-8);
  }
  MultipleShooting shooting(two_legs(), {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.durations[0], 50.0, 1e-5);  // effort is minimal when both take the maximum time
  EXPECT_NEAR(s.durations[1], 50.0, 1e-5);
}

}  // namespace
}  // namespace saltus
