// Derivatives of the optima of known problems: the impact time of the push recovery, costates of a
// switched system with free switching times, and an integrator without second derivatives.
#include <gtest/gtest.h>

#include "benchmarks/push_recovery_cases.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/optimum_derivatives.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/resolved_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;

const IpoptOptions tight{.tolerance = 1e-10};

TEST(OptimumExamples, PushRecoveryFollowsTheImpactTime) {
  push_recovery::QpCase c = push_recovery::read_case("ICUB-1");
  c.weights.capture_point_penalty = 1e4;
  c.weights.wrench_change = 1e-4;
  for (const double impact : {0.0336, 0.0744, 0.1163}) {
    c.impact_time = impact;
    MultipleShooting shooting = transcribe(c);
    const Solution s = solve(shooting, *make_ipopt(tight));
    ASSERT_TRUE(s.ok()) << s.message;
    OptimumDerivatives derivatives(shooting, s);
    const OptimumDerivatives::Derivative ours = derivatives.wrt_event("impact");
    EXPECT_TRUE(ours.reliable) << impact << ": " << ours.message;
    const double h = 2e-4;  // s; the same rows are active within it
    const Resolved resolved = resolve(
        [&](double d) -> MultipleShooting& {
          shooting.retime("impact", impact + d);
          return shooting;
        },
        h);
    EXPECT_NEAR(ours.cost, resolved.cost, 1e-6 * std::abs(resolved.cost)) << impact;
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(ours.first_input[i], resolved.first_input[i],
                  1e-5 * resolved.first_input.cwiseAbs().maxCoeff())
          << impact << ", wrench " << i;
  }
}

// Xu and Antsaklis, IEEE TAC 49, 2004: three modes, two free switching times.
template <int mode>
struct Switched {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    using std::cos, std::sin;
    if constexpr (mode == 1)
      return {x[0] + u[0] * sin(x[0]), -x[1] - u[0] * cos(x[1])};
    else if constexpr (mode == 2)
      return {x[1] + u[0] * sin(x[1]), -x[0] - u[0] * cos(x[0])};
    else
      return {-x[0] - u[0] * sin(x[0]), x[1] + u[0] * cos(x[1])};
  }
};

TEST(OptimumExamples, FreeSwitchingTimesGiveTheInitialCostates) {
  Phase<2, 1> one{"1", Switched<1>{}, between(0.05, 2.0)},
      two{"2", Switched<2>{}, between(0.05, 2.5)}, three{"3", Switched<3>{}, between(0.05, 2.9)};
  one.guess_duration(0.5);
  two.guess_duration(0.5);
  three.guess_duration(2.0);
  const Vec<double, 2> target{1.0, -1.0};
  for (auto* phase : {&one, &two, &three})
    phase->track("state", state, Vec<double, 2>::Ones(), {}, Reference(target))
        .track("effort", input, Vec<double, 1>::Ones())
        .inputs(InputParametrisation::piecewise_linear);
  three.track_at_end("end", state, Vec<double, 2>::Ones(), Reference(target));
  OptimalControlProblem ocp("switched");
  ocp.start_at({2, 3})
      .costs(CostRule::integrated)
      .total_time(exactly(3.0))
      .then(one)
      .then(two)
      .then(three);
  MultipleShooting shooting(ocp, {.intervals = {6, 12, 24}, .integrator = runge_kutta8()});
  const Solution s = solve(shooting, *make_ipopt(tight));
  ASSERT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  // The reference is from an indirect method. Our inputs are piecewise.
  EXPECT_NEAR(s.cost, 5.440973502, 1e-6);
  EXPECT_NEAR(derivatives.wrt_start(0).cost, 0.21802723, 1e-6);
  EXPECT_NEAR(derivatives.wrt_start(1).cost, 1.9607058, 1e-6);
  EXPECT_TRUE(derivatives.wrt_start(0).reliable) << derivatives.message();
  // The total time is fixed. If one duration is held, the others share the rest.
  const OptimumDerivatives::Derivative first = derivatives.wrt_duration(0);
  EXPECT_TRUE(first.reliable) << first.message;
  EXPECT_NEAR(first.cost, 0.0, 1e-9);
  EXPECT_NEAR(first.w[shooting.layout().duration(0)] + first.w[shooting.layout().duration(1)] +
                  first.w[shooting.layout().duration(2)],
              0.0, 1e-9);
}

struct Spring {  // x'' = u - k x (1 + x^2)
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& k) const {
    return {x[1], u[0] - k[0] * x[0] * (1.0 + x[0] * x[0])};
  }
};

OptimumDerivatives::Derivative of_stiffness(const IntegratorChoice& integrator,
                                            std::string& hessian) {
  Phase<2, 1, 1> phase{"spring", Spring{}, exactly(1.5)};
  phase.data("k", Vec<double, 1>{2.0})
      .track("state", state, Vec<double, 2>{2.0, 1.0})
      .track("effort", input, Vec<double, 1>{0.1});
  OptimalControlProblem ocp("spring");
  ocp.start_at({1, 0}).costs(CostRule::integrated).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 6, .integrator = integrator});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-8}));
  EXPECT_TRUE(s.ok()) << s.message;
  OptimumDerivatives derivatives(shooting, s);
  hessian = derivatives.hessian();
  return derivatives.wrt_parameter("k");
}

TEST(OptimumExamples, AdaptiveIntegratorsUseGradientDifferences) {
  std::string exact, differences;
  const OptimumDerivatives::Derivative fixed = of_stiffness(runge_kutta8({.steps = 4}), exact);
  const OptimumDerivatives::Derivative adaptive =
      of_stiffness(cvodes({.tolerance = 1e-10, .absolute_tolerance = 1e-12}), differences);
  EXPECT_EQ(exact, "exact");
  EXPECT_EQ(differences, "differences of gradients");
  EXPECT_TRUE(adaptive.reliable) << adaptive.message;
  // Tolerance of the integrator divided by the steps of the differences.
  EXPECT_NEAR(adaptive.cost, fixed.cost, 1e-6);
  EXPECT_NEAR(adaptive.first_input[0], fixed.first_input[0], 1e-4);
}

}  // namespace
}  // namespace saltus
