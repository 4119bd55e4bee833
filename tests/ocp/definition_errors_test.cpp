// An invalid definition is rejected at set-up. One sentence names the phase and the term, and the
// expected and the given value.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/errors.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

using Motion = Phase<1, 1>;
const double nan = std::nan("");

struct Mistake {
  const char* name;
  std::function<void()> make;
  std::vector<std::string> message;  ///< fragments that the message must contain
};
void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

// Adds a term to a sound phase and builds the problem.
std::function<void()> phase(std::function<void(Motion&)> change, Bounds duration = exactly(1.0)) {
  return [change = std::move(change), duration] {
    Motion motion{"motion", Velocity{}, duration};
    change(motion);
    OptimalControlProblem ocp("errors");
    ocp.schedule(Schedule({"a", "b"}, {{"impact", 0.5}})).start_at({1}).then(motion);
    const MultipleShooting shooting(ocp, ten);
  };
}
std::function<void()> free_phase(std::function<void(Motion&)> change) {
  return phase(std::move(change), between(0.5, 2.0));
}
template <class Dynamics>
std::function<void()> moving_by(Dynamics dynamics) {
  return [dynamics] { const Phase<2, 0> motion{"motion", dynamics, exactly(1.0)}; };
}

std::function<void()> problem(std::function<void(OptimalControlProblem&, Motion&)> define,
                              ShootingOptions options = ten) {
  return [define = std::move(define), options] {
    Motion motion{"motion", Velocity{}, exactly(1.0)};
    OptimalControlProblem ocp("errors");
    define(ocp, motion);
    const MultipleShooting shooting(ocp, options);
  };
}
std::function<void()> lasting(Bounds duration) {
  return problem([duration](OptimalControlProblem& ocp, Motion&) {
    const Motion motion{"motion", Velocity{}, duration};
    ocp.start_at({1}).then(motion);
  });
}

const auto two = [](const auto& t, const auto& x) {
  using S = std::decay_t<decltype(t)>;
  return Vec<S, 2>{x[0], x[0]};
};

struct Thrust {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};

const auto first = [](const auto&, const auto& x) { return x[0]; };

// A function whose patterns are set from outside, as an imported one may have them.
class Imported final : public FunctionBody {
 public:
  Imported(int inputs, SparsityPattern jacobian, SparsityPattern hessian)
      : FunctionBody(inputs, 1) {
    jacobian_pattern_ = std::move(jacobian);
    hessian_pattern_ = std::move(hessian);
  }
  void value(const double*, double* y) const override { *y = 0.0; }
  void jacobian(const double*, double* y, double*) const override { *y = 0.0; }
  void hessian(const double*, const double*, double*, Curvature) const override {}
};
Function imported(int inputs, SparsityPattern jacobian, SparsityPattern hessian) {
  return Function(
      std::make_shared<const Imported>(inputs, std::move(jacobian), std::move(hessian)));
}

struct Velocity1 {  // x' = p u
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return Vec<S, 1>(p[0] * u[0]);
  }
};

// Two modes whose number is stored in state 1. That state must not change by itself.
Automaton<2, 0> remembering(double rate) {
  const auto drift = [rate](const auto& t, const auto&) {
    using S = std::decay_t<decltype(t)>;
    return Vec<S, 2>{S(1.0), S(rate)};
  };
  Automaton<2, 0> automaton;
  automaton.mode("off", drift)
      .mode("on", drift)
      .event(
          "warm", "off", "on", [](const auto&, const auto& x) { return x[0] - 5.0; },
          Crossing::rising)
      .store_mode_in(1);
  return automaton;
}

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> list{
      // --- missing entries
      {"StateBeyondTheEnd",
       [] {
         Phase<2, 1> m{"motion", Thrust{}, exactly(1.0)};
         m.minimise("effort", [](auto, auto x, auto u) { return u[0] * x[2]; });
       },
       {"phase 'motion', term 'effort'", "x[2]", "2 states, x[0] to x[1]"}},
      {"InputBeyondTheEnd",
       phase([](Motion& m) {
         m.keep(
             "lane", [](auto, auto, auto u) { return u[1]; }, at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "u[1]", "1 input, u[0]"}},
      {"ParameterThatIsNotThere",
       phase([](Motion& m) {
         m.keep(
             "lane", [](auto, auto, auto, auto p) { return p[0]; }, at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "entry 0 of p", "which has none"}},
      {"PartBeyondTheEnd",
       phase([](Motion& m) {
         m.keep(
             "lane", [](auto, auto x) { return x.template head<2>().squaredNorm(); }, at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "x[1]", "1 state, x[0]"}},
      {"WrittenBeyondTheEnd",
       moving_by([](auto t, auto x) {
         Vec<decltype(t), 2> dx;
         dx[1] = x[0];
         dx[2] = x[1];
         return dx;
       }),
       {"phase 'motion', the dynamics", "entry 2 of a vector of 2"}},
      {"CoeffBeyondTheEnd",
       phase([](Motion& m) {
         m.keep(
             "lane", [](auto, auto x) { return x.coeff(1); }, at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "x[1]", "1 state, x[0]"}},
      {"DataReadBeyondTheEnd",
       phase([](Motion& m) {
         m.keep(
             "lane", [](auto, auto x) { return x[0] + x.data()[1]; }, at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "entry 0 of its result is never written"}},
      {"DataWrittenBeyondTheEnd",
       moving_by([](auto t, auto x) {
         Vec<decltype(t), 2> dx = x;
         dx.data()[2] = x[1];
         return dx;
       }),
       {"phase 'motion', the dynamics", "writes beyond the end of a vector through data()"}},
      {"TooManyAfterTheComma",
       moving_by([](auto t, auto x) {
         Vec<decltype(t), 2> dx;
         dx << x[1], x[0], 1.0;
         return dx;
       }),
       {"phase 'motion', the dynamics", "entry 2 of a vector of 2"}},
      {"TooFewAfterTheComma",
       moving_by([](auto t, auto x) {
         Vec<decltype(t), 2> dx;
         dx << x[1];
         return dx;
       }),
       {"phase 'motion', the dynamics", "entry 1 of its result is never written"}},
      {"EntryThatIsNeverWritten",
       moving_by([](auto t, auto x) {
         Vec<decltype(t), 2> dx;
         dx[0] = x[1];
         return dx;
       }),
       {"phase 'motion', the dynamics", "entry 1 of its result is never written"}},
      {"MatrixBeyondTheEnd",
       moving_by([](auto t, auto x) {
         Mat<decltype(t), 2, 2> rates = Mat<decltype(t), 2, 2>::Zero();
         rates(0, 2) = 1.0;
         return (rates * x).eval();
       }),
       {"phase 'motion', the dynamics", "entry (0, 2) of a 2 x 2 matrix"}},
      {"JumpBeyondTheEnd",
       [] { jump<1>("kick", [](auto, auto x) { return 2.0 * x[1]; }); },
       {"jump 'kick'", "x[1]", "1 state, x[0]"}},
      {"ModeBeyondTheEnd",
       [] { Automaton<1>().mode("left", [](auto, auto x) { return x[1]; }); },
       {"mode 'left'", "x[1]", "1 state, x[0]"}},
      {"GuardOfAnEventBeyondTheEnd",
       phase([](Motion& m) {
         m.on(
             "bounce", [](auto, auto x) { return x[1]; }, Crossing::falling, first);
       }),
       {"phase 'motion', the guard of event 'bounce'", "x[1]", "1 state, x[0]"}},
      // --- terms
      {"EmptyBounds",
       phase([](Motion& m) { m.keep("lane", state, between(2.0, 1.0)); }),
       {"phase 'motion'", "term 'lane'", "[2, 1]", "row 0"}},
      {"NanBounds",
       phase([](Motion& m) { m.keep("lane", state, at_most(nan)); }),
       {"phase 'motion'", "term 'lane'", "nan"}},
      {"BoundsWithoutAFiniteValue",
       phase([](Motion& m) { m.reach("far", state, at_least(infinity)); }),
       {"phase 'motion'", "term 'far'", "[inf, inf]", "row 0"}},
      {"NumberOfBounds",
       phase([](Motion& m) {
         m.keep("lane", two, {at_most(1.0), at_most(1.0), at_most(1.0)});
       }),
       {"phase 'motion'", "term 'lane'", "2 rows", "3 bounds"}},
      {"WeightSize",
       phase([](Motion& m) {
         m.track("speed", state, Vec<double, 3>{1.0, 1.0, 1.0});
       }),
       {"phase 'motion'", "term 'speed'", "1 entries", "3 x 3"}},
      {"NegativeWeight",
       phase([](Motion& m) { m.track("speed", state, Vec<double, 1>{-1.0}); }),
       {"phase 'motion'", "term 'speed'", "-1"}},
      {"NanWeight",
       phase([](Motion& m) { m.track("speed", state, Vec<double, 1>{nan}); }),
       {"phase 'motion'", "term 'speed'", "not finite"}},
      {"ReferenceSize",
       phase([](Motion& m) {
         m.track("speed", state, Vec<double, 1>{1.0}, {}, VectorXd(Vec<double, 2>{1.0, 2.0}));
       }),
       {"phase 'motion'", "term 'speed'", "1 entries", "reference has 2"}},
      {"ReferenceNan",
       phase([](Motion& m) {
         m.track("speed", state, Vec<double, 1>{1.0}, {}, VectorXd(Vec<double, 1>{nan}));
       }),
       {"phase 'motion'", "term 'speed'", "reference", "not finite"}},
      {"SameTermTwice",
       phase([](Motion& m) {
         m.keep("lane", state, at_most(1.0)).keep("lane", state, at_least(0.0));
       }),
       {"phase 'motion'", "'lane'"}},
      {"TermWithoutName",
       phase([](Motion& m) { m.keep("", state, at_most(1.0)); }),
       {"phase 'motion'", "no name"}},
      {"InputAtTheEnd",
       phase([](Motion& m) { m.reach("stop", input, exactly(0.0)); }),
       {"phase 'motion'", "term 'stop'", "input"}},
      {"PenaltyWeight",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {}, soft("lane", 0.0)); }),
       {"phase 'motion'", "term 'lane'", "'lane'", "positive"}},
      // --- functions in place of formulas
      {"EmptyFunction",
       phase([](Motion& m) { m.keep("lane", Function(), at_most(1.0)); }),
       {"phase 'motion', term 'lane'", "empty"}},
      {"InputsOfAFunction",
       phase([](Motion& m) { m.minimise("effort", make_function<2, 1, 0>(one)); }),
       {"phase 'motion', term 'effort'", "4 inputs", "1 + 1 + 1 + 0 = 3"}},
      {"InputsOfDynamics",
       [] { const Motion m("motion", make_function<2, 1, 0>(Thrust{}), exactly(1.0)); },
       {"phase 'motion', the dynamics", "4 inputs", "1 + 1 + 1 + 0 = 3"}},
      {"OutputsOfDynamics",
       [] {
         const Phase<2, 1> m("motion", make_function<2, 1, 0>(one), exactly(1.0));
         OptimalControlProblem ocp("errors");
         const MultipleShooting shooting(ocp.start_at({1, 0}).then(m), ten);
       },
       {"phase 'motion'", "the dynamics return 1 entries", "2 states"}},
      {"InputsOfAnAlgebraicFunction",
       [] {
         const auto z = [](const auto&, const auto& xz) { return xz[1]; };
         Phase<1, 1, 0, 1> m("motion", make_function<2, 1, 0>(first), make_function<2, 1, 0>(z),
                             VectorXd::Zero(1), exactly(1.0));
         m.keep("lane", make_function<4, 1, 0>(one), at_most(1.0));
       },
       {"phase 'motion', term 'lane'", "6 inputs", "1 + 2 + 1 + 0 = 4"}},
      {"FunctionAsCost",
       phase([](Motion& m) { m.minimise("effort", make_function<1, 1, 0>(two)); }),
       {"phase 'motion'", "term 'effort'", "a cost must be a scalar", "2 rows"}},
      {"FunctionAsIntegral",
       phase([](Motion& m) { m.bound_integral("way", make_function<1, 1, 0>(two), at_most(1.0)); }),
       {"phase 'motion'", "'way'", "scalar"}},
      {"FunctionAsGuard",
       free_phase([](Motion& m) {
         m.ends_when("landing", make_function<1, 1, 0>(two), Crossing::falling);
       }),
       {"phase 'motion'", "'landing'", "scalar"}},
      {"BoundsOfAFunction",
       phase([](Motion& m) {
         m.keep("lane", make_function<1, 1, 0>(two), {at_most(1.0), at_most(1.0), at_most(1.0)});
       }),
       {"phase 'motion'", "term 'lane'", "2 rows", "3 bounds"}},
      {"JacobianOfAFunction",
       phase([](Motion& m) {
         m.keep("lane", imported(3, {1, 2}, {3, 3}), at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "Jacobian is 1 x 2", "1 outputs and 3 inputs"}},
      {"HessianOfAFunction",
       phase([](Motion& m) {
         m.keep("lane", imported(3, {1, 3}, {}), at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "Hessian is 0 x 0", "3 inputs"}},
      {"UpperTriangleOfAFunction",
       phase([](Motion& m) {
         m.keep("lane", imported(3, {1, 3}, SparsityPattern::dense(3, 3)), at_most(1.0));
       }),
       {"phase 'motion', term 'lane'", "Hessian has entry (0, 1)", "lower triangle"}},
      // --- windows
      {"EmptyWindow",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.from = 0.6, .to = 0.3}); }),
       {"phase 'motion'", "term 'lane'", "[0.6, 0.3)"}},
      {"UnknownEvent",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.from = event("imapct")}); }),
       {"phase 'motion'", "term 'lane'", "'imapct'", "did you mean 'impact'"}},
      {"NanWindow",
       phase([](Motion& m) { m.bound_input(0, at_most(1.0), {.from = nan}); }),
       {"phase 'motion'", "input 0", "NaN"}},
      {"WindowAgainstTheOrderOfEvents",
       [] {
         Motion m{"motion", Velocity{}, exactly(1.0)};
         m.keep("lane", state, at_most(1.0), {.from = event("lift"), .to = event("land")});
         OptimalControlProblem ocp("errors");
         ocp.schedule(Schedule({"a", "b", "c"}, {{"land", 0.2}, {"lift", 0.4}}));
         const MultipleShooting shooting(ocp.start_at({1}).then(m), ten);
       },
       {"phase 'motion'", "term 'lane'", "'lift' to event 'land'", "the opposite order"}},
      {"WindowFromAnEventToItself",
       phase([](Motion& m) {
         m.bound_input(0, at_most(1.0), {.from = event("impact"), .to = event("impact")});
       }),
       {"phase 'motion'", "input 0", "'impact'", "always empty"}},
      {"WindowBeyondThePhase",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.from = 1.5}); }),
       {"phase 'motion'", "term 'lane'", "begins at 1.5 s", "lasts at most 1 s"}},
      {"WindowBeforeThePhase",
       phase([](Motion& m) { m.bound_state(0, at_most(1.0), {.to = -0.5}); }),
       {"phase 'motion'", "state 0", "ends at -0.5 s"}},
      {"WindowThatEndsAtTheStart",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.to = 0.0}); }),
       {"phase 'motion'", "term 'lane'", "ends at 0 s"}},
      {"WindowBetweenTheEndAndLater",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.from = 1.0, .to = 2.0}); }),
       {"phase 'motion'", "term 'lane'", "begins at 1 s", "lasts at most 1 s"}},
      {"EventsThatPassOneAnother",
       [] {
         const Schedule s({"a", "b", "c"}, {{"land", 0.4}, {"lift", 0.2}});
       },
       {"event 'lift' at 0.2 s", "event 'land' at 0.4 s"}},
      {"WindowBeyondTheShortestDuration",
       free_phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.to = 0.6}); }),
       {"phase 'motion'", "term 'lane'", "0.6", "0.5"}},
      {"EventInAFreePhase",
       free_phase([](Motion& m) { m.keep("lane", state, at_most(1.0), {.to = event("impact")}); }),
       {"phase 'motion'", "term 'lane'", "phase time"}},
      {"UnknownMode",
       phase([](Motion& m) { m.keep("lane", state, at_most(1.0), during("a", "bb")); }),
       {"phase 'motion'", "term 'lane'", "no mode 'bb'", "did you mean 'b'"}},
      {"ModeWithoutASchedule",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1}).then(m.bound_input(0, exactly(0.0), during("a")));
       }),
       {"phase 'motion'", "input 0", "no mode 'a'"}},
      {"ModeInAFreePhase",
       free_phase([](Motion& m) { m.keep("lane", state, at_most(1.0), during("a")); }),
       {"phase 'motion'", "term 'lane'", "mode 'a'", "phase time"}},
      // --- bounds of components
      {"InputIndex",
       phase([](Motion& m) { m.bound_input(1, at_most(1.0)); }),
       {"phase 'motion'", "no input 1", "the phase has 1,"}},
      {"StateIndex",
       phase([](Motion& m) { m.bound_state(-1, at_most(1.0)); }),
       {"phase 'motion'", "no state -1"}},
      {"EmptyInputBounds",
       phase([](Motion& m) { m.bound_input(0, between(1.0, 0.0)); }),
       {"phase 'motion'", "input 0", "[1, 0]"}},
      {"InfiniteStateBounds",
       phase([](Motion& m) { m.bound_state(0, exactly(infinity)); }),
       {"phase 'motion'", "state 0", "[inf, inf]"}},
      {"InputBoundsExcludeOneAnother",
       phase([](Motion& m) {
         m.bound_input(0, at_least(1.0)).bound_input(0, exactly(0.0), {.from = 0.5});
       }),
       {"phase 'motion'", "input 0", "contradict each other", "[1, inf] and [0, 0]"}},
      {"StateBoundsExcludeOneAnother",
       phase([](Motion& m) {
         m.bound_state(0, at_least(1.0)).bound_state(0, at_most(0.0), {.from = 0.5});
       }),
       {"phase 'motion'", "state 0", "contradict each other"}},
      // --- scaling, guesses, changes
      {"NominalSize",
       phase([](Motion& m) {
         m.nominal(Vec<double, 2>{1.0, 1.0}, Vec<double, 1>{1.0});
       }),
       {"phase 'motion'", "nominal state", "2 entries", "expected 1"}},
      {"NominalZero",
       phase([](Motion& m) { m.nominal(Vec<double, 1>{1.0}, Vec<double, 1>{0.0}); }),
       {"phase 'motion'", "nominal input", "positive"}},
      {"NominalDuration",
       free_phase([](Motion& m) { m.nominal_duration(-1.0); }),
       {"phase 'motion'", "nominal duration", "-1"}},
      {"StateGuessSize",
       phase([](Motion& m) {
         m.guess_state(Guess::constant(Vec<double, 3>{1.0, 2.0, 3.0}));
       }),
       {"phase 'motion'", "guess of the state", "3 entries", "expected 1"}},
      {"EndsOfAGuessWithOtherSizes",
       phase([](Motion& m) {
         m.guess_state(Guess::interpolate(Vec<double, 1>{1.0}, Vec<double, 2>{1.0, 2.0}));
       }),
       {"guess", "1 entries at the start and 2 at the end"}},
      {"InputGuessNan",
       phase([](Motion& m) { m.guess_input(Guess::constant(Vec<double, 1>{nan})); }),
       {"phase 'motion'", "guess of the input", "not finite"}},
      {"SimulatedInput",
       phase([](Motion& m) { m.guess_input(Guess::simulate()); }),
       {"phase 'motion'", "inputs cannot be simulated"}},
      {"ChangeWeights",
       phase([](Motion& m) {
         m.penalise_change(Vec<double, 2>{1.0, 1.0});
       }),
       {"phase 'motion'", "2 weights", "1 inputs"}},
      {"InfiniteChangeWeight",
       phase([](Motion& m) { m.penalise_change(Vec<double, 1>{infinity}); }),
       {"phase 'motion'", "penalise_change", "not finite"}},
      {"ChangeOfLinearInputs",
       phase([](Motion& m) {
         m.inputs(InputParametrisation::piecewise_linear).penalise_change(Vec<double, 1>{1.0});
       }),
       {"phase 'motion'", "piecewise constant"}},
      {"ResultantOfMissingInputs",
       phase([](Motion& m) { m.common_resultant({0}, 2); }),
       {"phase 'motion'", "common resultant needs 2 inputs from 0 on", "1 inputs"}},
      {"ResultantsOverlap",
       phase([](Motion& m) {
         m.common_resultant({0, 0}, 1);
       }),
       {"phase 'motion'", "input 0 is in two groups"}},
      {"ParameterTwice",
       [] {
         Phase<1, 1, 2> m{"motion", Velocity{}, exactly(1.0)};
         m.data("p", Vec<double, 1>{1.0}).data("p", Vec<double, 1>{1.0});
         OptimalControlProblem ocp("errors");
         const MultipleShooting shooting(ocp.start_at({1}).then(m), ten);
       },
       {"phase 'motion'", "parameter 'p'", "twice"}},
      {"ParametersMissing",
       [] {
         Phase<1, 1, 2> m{"motion", Velocity{}, exactly(1.0)};
         OptimalControlProblem ocp("errors");
         const MultipleShooting shooting(ocp.start_at({1}).then(m), ten);
       },
       {"phase 'motion'", "2 parameters", "declare 0"}},
      // --- durations
      {"NegativeDuration", lasting(exactly(-1.0)), {"phase 'motion'", "duration", "negative"}},
      {"ZeroDuration", lasting(exactly(0.0)), {"phase 'motion'", "duration"}},
      {"NanDuration", lasting(exactly(nan)), {"phase 'motion'", "duration"}},
      {"UnboundedDuration",
       lasting(unbounded()),
       {"phase 'motion'", "no lower bound", "at_least(0.0)", "guess_duration()"}},
      {"DurationBoundedOnlyAbove",
       lasting(at_most(3.0)),
       {"phase 'motion'", "no lower bound", "between(0.0, 3)"}},
      {"GuessOfAnOpenDuration", lasting(at_least(0.5)), {"phase 'motion'", "guess_duration()"}},
      {"GuessOutsideTheDuration",
       free_phase([](Motion& m) { m.guess_duration(7.0); }),
       {"phase 'motion'", "7", "[0.5, 2]"}},
      {"InfiniteDuration", lasting(exactly(infinity)), {"phase 'motion'", "finite"}},
      {"EmptyDuration",
       lasting(between(2.0, 1.0)),
       {"phase 'motion'", "duration [2, 1] s", "empty"}},
      // --- guards
      {"GuardOfAFixedPhase",
       phase([](Motion& m) { m.ends_when("landing", first, Crossing::falling); }),
       {"phase 'motion'", "event 'landing'", "fixed at 1 s", "reach()"}},
      {"GuardOfAnInput",
       free_phase([](Motion& m) { m.ends_when("landing", input, Crossing::falling); }),
       {"phase 'motion'", "'landing'", "input"}},
      {"TwoGuards",
       free_phase([](Motion& m) {
         m.ends_when("landing", first, Crossing::falling)
             .ends_when(
                 "noon", [](auto t, auto) { return t - 1.0; }, Crossing::rising);
       }),
       {"phase 'motion'", "'landing'", "'noon'", "reach()"}},
      {"GuardThatNothingMoves",
       free_phase([](Motion& m) {
         m.ends_when(
             "landing", [](auto, auto x) { return 0.0 * x[0] + 1.0; }, Crossing::falling);
       }),
       {"phase 'motion'", "event 'landing'", "the guard never crosses zero"}},
      {"GuardOfAConservedQuantity",
       [] {
         Phase<2, 0> swing{"swing",
                           [](auto, auto x) {
                             return decltype(x){x[1], -x[0]};
                           },
                           between(0.5, 2.0)};
         swing.ends_when(
             "energy", [](auto, auto x) { return x[0] * x[0] + x[1] * x[1] - 1.0; },
             Crossing::rising);
         OptimalControlProblem ocp("errors");
         const MultipleShooting shooting(ocp.start_at({0.5, 0}).then(swing), ten);
       },
       {"phase 'swing'", "event 'energy'", "the guard never crosses zero"}},
      {"GuardThatOnlyRises",
       free_phase([](Motion& m) {
         m.ends_when(
             "noon", [](auto t, auto) { return t - 1.0; }, Crossing::falling);
       }),
       {"phase 'motion'", "event 'noon'", "changes by 1 per second", "falling"}},
      {"GuardWithoutTimeToDecide",
       [] {
         Motion m{"motion", Velocity{}, between(0.5, 2.0)};
         m.ends_when("landing", first, Crossing::falling);
         OptimalControlProblem ocp("errors");
         const MultipleShooting shooting(ocp.start_at({1}).then(m).total_time(exactly(1.0)), ten);
       },
       {"phase 'motion'", "event 'landing'", "total time is fixed at 1 s"}},
      // --- problem
      {"NoPhase",
       problem([](OptimalControlProblem& ocp, Motion&) { ocp.start_at({1}); }),
       {"problem 'errors'", "no phase"}},
      {"NoStart",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.then(m); }),
       {"problem 'errors'", "0 entries", "1 states"}},
      {"StartSize",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1, 2}).then(m);
       }),
       {"problem 'errors'", "2 entries", "phase 'motion' has 1 states"}},
      {"StartNan",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({nan}).then(m); }),
       {"problem 'errors'", "start state 0"}},
      {"StartInfinite",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({infinity}).then(m); }),
       {"problem 'errors'", "start state 0", "[inf, inf]"}},
      {"JumpMissing",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         const Phase<2, 1> wide{"wide", [](const auto&, const auto& x) { return x; }, exactly(1.0)};
         ocp.start_at({1}).then(m).then(wide);
       }),
       {"phase 'motion' to phase 'wide'", "states changes from 1 to 2"}},
      {"JumpArguments",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1}).then(m).then(
             m, jump<2>("kick", [](const auto&, const auto& x) { return x[0]; }));
       }),
       {"jump 'kick'", "from phase 'motion'", "takes 2 states and 0 parameters", "has 1 states"}},
      {"JumpWithAsManyArguments",  // 1 + 2 + 1 = 1 + 3 + 0
       [] {
         Phase<3, 1> wide{"wide", [](auto, auto x, auto) { return x; }, exactly(1.0)};
         OptimalControlProblem ocp("errors");
         const auto kick = [](const auto&, const auto& x, const auto&, const auto& p) {
           using S = std::decay_t<decltype(x[0])>;
           return Vec<S, 3>{x[0], x[1], p[0]};
         };
         ocp.start_at({0, 0, 0}).then(wide).then(wide, jump<2, 1>("kick", kick));
         const MultipleShooting shooting(ocp, ten);
       },
       {"jump 'kick'", "from phase 'wide' to phase 'wide'", "2 states and 1 parameters",
        "3 states and 0 parameters"}},
      {"ClosingSizes",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         const Phase<2, 1> wide{"wide", [](const auto&, const auto& x) { return x; }, exactly(1.0)};
         ocp.start_at({1}).then(m).then(wide, jump<1>("split", two)).close();
       }),
       {"phase 'wide' to phase 'motion'", "states changes from 2 to 1", "jump map"}},
      {"ClosingResult",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1}).then(m).close(jump<1>("kick", two));
       }),
       {"jump 'kick'", "phase 'motion' to phase 'motion'", "returns 2 states", "has 1"}},
      {"JumpResult",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1}).then(m).then(m, jump<1>("kick", two));
       }),
       {"jump 'kick'", "returns 2 states", "has 1"}},
      {"StartGuessOfAnotherSize",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_within({between(0.0, 1.0)}, VectorXd::Zero(2)).then(m);
       }),
       {"guess of the start has 2 entries", "phase 'motion' has 1 states"}},
      {"StartThatIsNoNumber",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({nan}).then(m); }),
       {"start state 0 is NaN"}},
      {"StartGuessOutsideItsBounds",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_within({between(0.0, 1.0)}, VectorXd{{3.0}}).then(m);
       }),
       {"guess of start state 0, 3,", "bounds [0, 1]"}},
      {"DataOfTwoValues",
       problem([](OptimalControlProblem& ocp, Motion&) {
         Phase<1, 1, 1> a{"a", Velocity1{}, exactly(1.0)}, b{"b", Velocity1{}, exactly(1.0)};
         a.data("gain", VectorXd{{1.0}});
         b.data("gain", VectorXd{{2.0}});
         ocp.start_at({1}).then(a).then(b);
       }),
       {"data 'gain' is 1 in phase 'a' and 2 in phase 'b'"}},
      {"ModeThatIsNone",
       problem([](OptimalControlProblem& ocp, Motion&) {
         const Phase<2, 0> phase{"room", remembering(0.0), exactly(1.0)};
         ocp.start_at({1, 7}).then(phase);
       }),
       {"start state 1", "the mode of phase 'room', but it is 7", "0 to 1"}},
      {"RememberedModeThatMoves",
       problem([](OptimalControlProblem& ocp, Motion&) {
         const Phase<2, 0> phase{"room", remembering(1.0), exactly(1.0)};
         ocp.start_at({1, 0}).then(phase);
       }),
       {"phase 'room'", "state 1 stores the mode", "its rate must be the constant 0"}},
      {"TotalTime",
       problem([](OptimalControlProblem& ocp, Motion& m) {
         ocp.start_at({1}).then(m).total_time(exactly(3.0));
       }),
       {"problem 'errors'", "total time [3, 3]", "1 to 1 s"}},
      {"InfiniteTotalTime",
       problem([](OptimalControlProblem& ocp, Motion&) {
         Motion open{"motion", Velocity{}, at_least(1.0)};
         ocp.start_at({1}).then(open.guess_duration(2.0)).total_time(exactly(infinity));
       }),
       {"problem 'errors'", "total time [inf, inf]"}},
      {"NoIntegrator",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({1}).then(m); },
               {.intervals_per_phase = 10, .integrator = nullptr}),
       {"problem 'errors'", "no integrator"}},
      {"NoIntervals",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({1}).then(m); },
               {.intervals_per_phase = 0, .integrator = ten.integrator}),
       {"phase 'motion'", "0 intervals"}},
      {"IntervalsPerPhase",
       problem([](OptimalControlProblem& ocp, Motion& m) { ocp.start_at({1}).then(m); },
               {.intervals = {5, 5}, .integrator = ten.integrator}),
       {"problem 'errors'", "2 phases", "it has 1"}},
  };
  return list;
}

class Definition : public testing::TestWithParam<Mistake> {};

TEST_P(Definition, IsRejectedWithTheReason) {
#ifndef NDEBUG
  const std::string name = GetParam().name;
  const bool seen_by_us = name.starts_with("Coeff") || name.starts_with("Data");
  if ((name.ends_with("BeyondTheEnd") && !seen_by_us) || name == "ParameterThatIsNotThere" ||
      name == "TooManyAfterTheComma")
    GTEST_SKIP() << "an assertion of Eigen's comes first in this build";
#endif
  const std::string message = error_of<DefinitionError>(GetParam().make);
  for (const std::string& fragment : GetParam().message)
    EXPECT_NE(message.find(fragment), std::string::npos)
        << "'" << fragment << "' is not in: " << message;
}

INSTANTIATE_TEST_SUITE_P(Mistakes, Definition, testing::ValuesIn(mistakes()),
                         [](const auto& instance) { return instance.param.name; });

// Changes between solves are validated before they take effect.
TEST(Change, RejectedChangeLeavesTheProgramUnchanged) {
  Motion motion{"motion", Velocity{}, exactly(1.0)};
  motion.bound_input(0, exactly(0.0), {.to = event("impact")});
  MultipleShooting shooting(with_impact(motion, 0.43), ten);
  const VectorXd lower = shooting.nlp().lower(), rows = shooting.nlp().row_lower();
  EXPECT_THROW(shooting.start_at(0.1, Vec<double, 2>{1.0, 2.0}), DefinitionError);
  EXPECT_THROW(shooting.start_at(0.1, Vec<double, 1>{nan}), DefinitionError);
  EXPECT_THROW(shooting.start_at(nan, Vec<double, 1>{1.0}), DefinitionError);
  EXPECT_THROW(shooting.retime("imapct", 0.2), DefinitionError);
  EXPECT_THROW(shooting.retime("impact", nan), DefinitionError);
  EXPECT_THROW(shooting.set_penalty_weight("lane", 1.0), DefinitionError);
  EXPECT_THROW(shooting.set_previous_input(Vec<double, 2>{1.0, 2.0}), DefinitionError);
  EXPECT_EQ(shooting.data().schedule.time_of("impact"), 0.43);
  EXPECT_EQ(shooting.nlp().lower(), lower);
  EXPECT_EQ(shooting.nlp().row_lower(), rows);
}

}  // namespace
}  // namespace saltus
