// Common mistakes of beginners and the one-sentence error of each. The error names the place, the
// given value and the remedy. tests/autodiff/refused.cpp covers mistakes that the compiler detects;
// tests/ocp/definition_errors_test.cpp covers further errors in definitions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "saltus/saltus.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// A cart of unit mass: x = (position m, speed m/s), u = force.
using Ride = Phase<2, 1>;

const auto both = [](auto, auto x) { return x; };
const double nan = std::nan("");

Ride sound() {
  Ride ride{"ride", Cart{}, exactly(1.0)};
  ride.minimise("effort", effort)
      .reach("there", position, exactly(1.0))
      .reach("at rest", speed, exactly(0.0));
  return ride;
}

struct Mistake {
  const char* name;
  std::function<std::string()> said;
  std::vector<std::string> fragments;
};
void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

std::string message_of(const OptimalControlProblem& ocp, const SolveOptions& options = {}) {
  try {
    return solve(ocp, options).message;
  } catch (const DefinitionError& e) {
    return e.what();
  }
}

// The correct ride after a change.
std::function<std::string()> ride(std::function<void(Ride&)> change, SolveOptions options = {}) {
  return [change = std::move(change), options] {
    try {
      Ride ride = sound();
      change(ride);
      return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(ride), options);
    } catch (const DefinitionError& e) {  // from the definition itself
      return std::string(e.what());
    }
  };
}

template <class Dynamics>
std::function<std::string()> with_dynamics(Dynamics dynamics) {
  return [dynamics] {
    try {
      Ride ride{"ride", dynamics, exactly(1.0)};
      ride.minimise("effort", effort).reach("there", position, exactly(1.0));
      return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(ride));
    } catch (const DefinitionError& e) {
      return std::string(e.what());
    }
  };
}

SolveOptions by_ipopt() { return {.solver = make_ipopt()}; }

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> list{
      // --- formulas
      {"CountsFromOne",
       ride([](Ride& r) { r.minimise("drift", [](auto, auto x) { return x[2]; }); }),
       {"phase 'ride', term 'drift': it uses x[2], but there are 2 states, x[0] to x[1]"}},
      {"SecondInputOfOne",
       ride([](Ride& r) {
         r.keep(
             "brake", [](auto, auto, auto u) { return u[1]; }, at_most(1));
       }),
       {"phase 'ride', term 'brake': it uses u[1], but there is 1 input, u[0]"}},
      {"ForgottenDerivative",
       with_dynamics([](auto t, auto x, auto) {
         Vec<decltype(t), 2> rates;
         rates[0] = x[1];
         return rates;
       }),
       {"phase 'ride', the dynamics: entry 1 of its result is never written"}},
      {"IntegerQuotient",
       ride([](Ride& r) {
         r.minimise("energy", [](auto, auto, auto u) { return 1 / 2 * u[0] * u[0]; });
       }),
       {"phase 'ride', term 'energy': this cost is zero for every trajectory", "write 0.5"}},
      {"ConstraintWithoutValue",
       ride([](Ride& r) {
         r.keep(
             "logarithm", [](auto, auto x) { return log(x[0] - 5.0); }, at_most(10.0));
       }),
       {"could not be evaluated; phase 'ride', term 'logarithm', row 0 at t = 0",
        "has no finite value"}},
      {"CostWithoutValue",
       ride([](Ride& r) {
         r.minimise("logarithm", [](auto, auto x, auto u) { return log(x[0] - 5.0) + u[0]; });
       }),
       {"could not be evaluated; phase 'ride', term 'logarithm' in interval 0 has no finite "
        "value"}},
      {"CostOfNothing",
       ride([](Ride& r) { r.minimise("time", [](auto, auto) { return 1.0; }); }),
       {"phase 'ride', term 'time': this cost is the same for every trajectory"}},
      {"ConstraintOnNothing",
       ride([](Ride& r) {
         r.keep(
             "day", [](auto t, auto) { return t; }, at_most(2.0));
       }),
       {"phase 'ride', term 'day': it depends on no state, input or unknown"}},
      {"InputThatActsOnNothing",
       [] {
         Phase<2, 2> r{"ride",
                       [](auto t, auto x, auto u) {
                         return Vec<decltype(t), 2>{x[1], u[0]};
                       },
                       exactly(1.0)};
         r.minimise("effort", effort).reach("there", position, exactly(1.0));
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': nothing depends on input 1"}},
      {"StateThatNobodyReads",
       [] {
         Phase<3, 1> r{"ride",
                       [](auto t, auto x, auto u) {
                         return Vec<decltype(t), 3>{x[1], u[0], x[0]};
                       },
                       exactly(1.0)};
         r.minimise("effort", effort).reach("there", position, exactly(1.0));
         return message_of(OptimalControlProblem("cart").start_at({0, 0, 0}).then(r));
       },
       {"phase 'ride': nothing depends on state 2"}},
      {"DynamicsOfConstants",
       with_dynamics([](auto t, auto) {
         return Vec<decltype(t), 2>{1.0, 0.0};
       }),
       {"phase 'ride': the dynamics do not depend on x, u or p"}},
      {"ParameterThatNobodyReads",
       [] {
         Phase<2, 1, 1> r{"ride", Cart{}, exactly(1.0)};
         r.minimise("effort", effort).data("mass", Vec<double, 1>{2.0});
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': no formula reads parameter 'mass'"}},
      {"ParameterWithoutNumbers",
       [] {
         Phase<2, 1, 1> r{"ride", Cart{}, exactly(1.0)};
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': it has 1 parameters, but data() and unknown() declare 0"}},
      {"NanInData",
       [] {
         Phase<2, 1, 1> r{"ride", Cart{}, exactly(1.0)};
         r.data("mass", Vec<double, 1>{nan});
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': parameter 'mass' is not finite"}},
      // --- terms
      {"BoundsTheWrongWayRound",
       ride([](Ride& r) { r.keep("lane", position, between(2.0, -2.0)); }),
       {"phase 'ride', term 'lane': the bounds [2, -2] of row 0 are empty"}},
      {"ValueWithinItsTolerance",
       ride([](Ride& r) { r.reach("near", speed, exactly(1e-8)); }),
       {"phase 'ride', term 'near': row 0 must equal 1e-08, but its tolerance is 1e-06"}},
      {"SameNameTwice",
       ride([](Ride& r) { r.minimise("effort", effort); }),
       {"phase 'ride': two terms are called 'effort'"}},
      {"InputAtTheEnd",
       ride([](Ride& r) { r.reach("no force", effort, exactly(0.0)); }),
       {"phase 'ride', term 'no force': it applies at one end of the phase and reads an input",
        "use keep(), minimise() or track()"}},
      {"OneWeightForTwoRows",
       ride([](Ride& r) { r.track("home", both, Vec<double, 1>{1.0}); }),
       {"phase 'ride', term 'home': the residual has 2 entries, but the weight is 1 x 1"}},
      {"NegativeWeight",
       ride([](Ride& r) {
         r.track("home", both, Vec<double, 2>{1.0, -1.0});
       }),
       {"phase 'ride', term 'home': weight 1 is -1, but weights must not be negative"}},
      {"PenaltyOfNothing",
       ride([](Ride& r) { r.keep("lane", position, at_most(0.5), {}, soft("lane", 0.0)); }),
       {"phase 'ride', term 'lane': the penalty weight 'lane' is 0, expected a positive number"}},
      {"WindowAfterTheEnd",
       ride([](Ride& r) { r.keep("lane", position, at_most(2.0), {.from = 2.0}); }),
       {"phase 'ride', term 'lane': the window begins at 2 s, but the phase lasts at most 1 s"}},
      {"WindowOfAnUnknownEvent",
       ride([](Ride& r) { r.keep("lane", position, at_most(2.0), {.from = event("imapct")}); }),
       {"phase 'ride', term 'lane'", "'imapct'"}},
      {"BoundOnAMissingInput",
       ride([](Ride& r) { r.bound_input(1, between(-1.0, 1.0)); }),
       {"phase 'ride': there is no input 1; the phase has 1, counted from 0"}},
      // --- start, phases, times
      {"NoStart",
       [] { return message_of(OptimalControlProblem("cart").then(sound())); },
       {"problem 'cart': the start has 0 entries, but phase 'ride' has 2 states; use start_at()"}},
      {"StartOfAnotherSize",
       [] { return message_of(OptimalControlProblem("cart").start_at({0}).then(sound())); },
       {"problem 'cart': the start has 1 entries, but phase 'ride' has 2 states"}},
      {"NoPhase",
       [] {
         return message_of(OptimalControlProblem("cart").start_at({0, 0}));
       },
       {"problem 'cart' has no phase; add one with then()"}},
      {"JumpForgotten",
       [] {
         Phase<1, 1> slide{"slide", [](auto, auto, auto u) { return u; }, exactly(1.0)};
         return message_of(
             OptimalControlProblem("cart").start_at({0, 0}).then(sound()).then(slide));
       },
       {"the number of states changes from 2 to 1, so a jump map is needed"}},
      {"TotalTimeOutOfReach",
       [] {
         return message_of(
             OptimalControlProblem("cart").start_at({0, 0}).then(sound()).total_time(exactly(5.0)));
       },
       {"problem 'cart': the total time [5, 5] s is impossible for phases that last 1 to 1 s in "
        "total"}},
      {"OpenDurationWithoutGuess",
       [] {
         Ride r{"ride", Cart{}, at_least(0.1)};
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': the free duration needs a positive guess", "use guess_duration()"}},
      {"GuessOfAnotherSize",
       ride([](Ride& r) {
         r.guess_input(Guess::constant(Vec<double, 2>{0.0, 0.0}));
       }),
       {"phase 'ride': the guess of the input has 2 entries, expected 1"}},
      {"NegativeIntervals",
       ride([](Ride&) {}, {.intervals_per_phase = -5}),
       {"phase 'ride'", "-5 intervals"}},
      {"MoreIntervalsThanMemory",
       ride([](Ride&) {}, {.intervals_per_phase = 2000000000}),
       {"phase 'ride'", "2000000000 intervals, expected 1 to 1000000"}},
      {"MoreThreadsThanAnySystem",
       ride([](Ride&) {}, {.threads = 2000000000}),
       {"number of threads", "2000000000"}},
      {"GuessOfAFailedSolve",
       ride([](Ride&) {}, {.guess = Trajectory()}),
       {"problem 'cart'", "the guess is an empty trajectory"}},
      {"EmptyGuess",
       ride([](Ride& r) { r.guess_state(Guess::constant(VectorXd())); }),
       {"phase 'ride': the guess of the state has 0 entries, expected 2"}},
      {"StartThatOverflows",
       [] {
         return message_of(OptimalControlProblem("cart").start_at({0, 1e300}).then(sound()));
       },
       {"problem 'cart': start state 1 is 1e+300", "overflow", "use other units"}},
      {"InfiniteStart",
       [] {
         return message_of(OptimalControlProblem("cart").start_at({infinity, 0}).then(sound()));
       },
       {"problem 'cart': start state 0 has the empty bounds [inf, inf]"}},
      {"GuessThatOverflows",
       ride([](Ride& r) {
         r.keep(
              "lane", [](auto, auto x) { return x[0] * x[0] * x[0]; }, at_most(8.0))
             .guess_state(Guess::constant(Vec<double, 2>{1e200, 0.0}));
       }),
       {"phase 'ride', node", "is 1e+200 at the start", "overflow"}},
      {"MisspeltData",
       [] {
         Phase<2, 1, 1> r{"ride", Cart{}, exactly(1.0)};
         r.minimise("effort", effort).data("mass", Vec<double, 1>{2.0});
         MultipleShooting shooting{OptimalControlProblem("cart").start_at({0, 0}).then(r),
                                   {.intervals_per_phase = 5, .integrator = runge_kutta4()}};
         return error_of<DefinitionError>([&] { shooting.set_data("mas", Vec<double, 1>{1.0}); });
       },
       {"'mas'", "'mass'"}},
      // --- problems without an answer
      {"TheSameEquationTwice",
       ride(
           [](Ride& r) {
             r.keep("held", position, exactly(0.0)).keep("held still", speed, exactly(0.0));
           },
           by_ipopt()),
       {"the constraints cannot all be satisfied", "phase 'ride'", "violates its bounds by"}},
      {"OutOfReach",
       ride(
           [](Ride& r) { r.bound_input(0, between(-1.0, 1.0)).keep("slow", speed, at_most(0.5)); }),
       {"the constraints cannot all be satisfied", "phase 'ride', term '",
        "violates its bounds by"}},
      {"OutOfReachOfWhatIsNotConvex",
       [] {
         Ride r{"ride",
                [](auto, auto x, auto u) {
                  return decltype(x){x[1], u[0] - 0.2 * x[1] * sqrt(x[1] * x[1] + 0.01)};
                },
                exactly(2.0)};
         r.bound_input(0, between(-3.0, 3.0))
             .minimise("effort", effort)
             .reach("there", position, exactly(5.0));
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"no point that meets all constraints was found", "apparent local minimum", "term 'there'"}},
      {"OutOfReachWithEvents",
       [] {
         const auto bounce = [](auto, auto x) { return decltype(x){x[0], -0.5 * x[1]}; };
         Ride r{"ride", Cart{}, exactly(1.0)};
         r.bound_input(0, between(-1.0, 1.0))
             .minimise("effort", effort)
             .on(
                 "wall", [](auto, auto x) { return x[0] - 10.0; }, Crossing::rising, bounce)
             .reach("there", position, exactly(5.0));
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"phase 'ride': its events make the problem discontinuous", "fewer intervals"}},
      {"DurationThatNothingPaysFor",
       [] {
         Ride r{"ride", Cart{}, between(1.0, 3.0)};
         r.bound_input(0, between(-9.0, 9.0)).reach("there", position, exactly(1.0));
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"there is no cost, so the duration of phase 'ride' is arbitrary"}},
      {"CostWithoutLowerLimit",
       [] {
         Ride r{"ride", Cart{}, exactly(1.0)};
         r.minimise("push", [](auto, auto, auto u) { return -u[0]; });
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r));
       },
       {"the cost decreased from 0 to", "add bounds on the inputs and states that reduce it"}},
      {"CostWithoutLowerLimitByIpopt",
       [] {
         Ride r{"ride", Cart{}, exactly(1.0)};
         r.minimise("push", [](auto, auto, auto u) { return -u[0]; });
         return message_of(OptimalControlProblem("cart").start_at({0, 0}).then(r), by_ipopt());
       },
       {"the cost decreased from 0 to", "add bounds on the inputs and states that reduce it"}},
      {"NearlyTheSameEquation",
       ride([](Ride& r) { r.reach("there too", position, exactly(1.0 + 1e-5)); }),
       {"phase 'ride', term 'there", "violates its bounds by"}},
      {"NearlyTheSameEquationByIpopt",
       ride([](Ride& r) { r.reach("there too", position, exactly(1.0 + 1e-5)); }, by_ipopt()),
       {"phase 'ride', term 'there", "violates its bounds by"}},
  };
  return list;
}

class Beginner : public testing::TestWithParam<Mistake> {};

TEST_P(Beginner, SeesOneSentencePerMistake) {
#ifndef NDEBUG
  const std::string name = GetParam().name;
  if (name == "CountsFromOne" || name == "SecondInputOfOne")
    GTEST_SKIP() << "an assertion of Eigen's comes first in this build";
#endif
  const std::string said = GetParam().said();
  for (const std::string& fragment : GetParam().fragments)
    EXPECT_NE(said.find(fragment), std::string::npos) << "'" << fragment << "' is not in: " << said;
  EXPECT_EQ(std::ranges::count(said, '\n'), 0) << said;
}

INSTANTIATE_TEST_SUITE_P(Mistakes, Beginner, testing::ValuesIn(mistakes()),
                         [](const auto& instance) { return instance.param.name; });

TEST(Beginner, SeesNoWarningsForASoundProblem) {
  const OptimalControlProblem cart = OptimalControlProblem("cart").start_at({0, 0}).then(sound());
  const Solution solution = solve(cart);
  EXPECT_TRUE(solution.ok()) << solution.message;
  EXPECT_TRUE(solution.warnings.empty());
}

}  // namespace
}  // namespace saltus
