// The check finds the error in problems that each contain one deliberate error. It finds nothing in
// the correct problem. `saltus check` also finds nothing in the problems of the library
// (tests/problems).
#include "saltus/solve/check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {
namespace {

struct Cart {  // x = (position m, speed m/s), u = force
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.1 * x[1] * x[1]};
  }
};
using Ride = Phase<2, 1>;

const auto position = [](auto, auto x) { return x[0]; };
const auto speed = [](auto, auto x) { return x[1]; };
const auto effort = [](auto, auto, auto u) { return 0.5 * u[0] * u[0]; };

// Speed squared times force, with an upper limit, as user code would define it.
class Power final : public FunctionBody {
 public:
  enum class Mistake { none, derivative, pattern, second_derivative, not_a_number };
  explicit Power(Mistake mistake, double unit = 1.0)
      : FunctionBody(4, 1), mistake_(mistake), unit_(unit) {
    jacobian_pattern_ = mistake == Mistake::pattern
                            ? SparsityPattern::from_pairs(1, 4, {{0, 2}})
                            : SparsityPattern::from_pairs(1, 4, {{0, 2}, {0, 3}});
    hessian_pattern_ = SparsityPattern::from_pairs(4, 4, {{2, 2}, {3, 2}});
  }
  void value(const double* z, double* y) const override { y[0] = unit_ * z[2] * z[2] * z[3]; }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    entries[0] = unit_ * (mistake_ == Mistake::derivative ? 1.0 : 2.0) * z[2] * z[3];
    if (mistake_ == Mistake::not_a_number) entries[0] = std::nan("");
    if (mistake_ != Mistake::pattern) entries[1] = unit_ * z[2] * z[2];
  }
  void hessian(const double* z, const double* weights, double* entries, Curvature) const override {
    entries[0] = unit_ * weights[0] * 2.0 * z[3];
    entries[1] = unit_ * weights[0] * (mistake_ == Mistake::second_derivative ? -2.0 : 2.0) * z[2];
  }

 private:
  Mistake mistake_;
  double unit_;
};

Function power(Power::Mistake mistake, double unit = 1.0) {
  return Function(std::unique_ptr<const FunctionBody>(std::make_unique<Power>(mistake, unit)));
}

Ride sound() {
  Ride ride{"ride", Cart{}, exactly(2.0)};
  ride.minimise("effort", effort)
      .bound_input(0, between(-5.0, 5.0))
      .reach("there", position, exactly(1.0))
      .reach("at rest", speed, exactly(0.0))
      .guess_state(Guess::interpolate(VectorXd{{0.0, 0.3}}, VectorXd{{1.0, 0.5}}))
      .guess_input(Guess::constant(VectorXd::Constant(1, 0.4)));
  return ride;
}

OptimalControlProblem of(const Ride& ride) {
  OptimalControlProblem problem("cart");
  problem.start_at({0.0, 0.0}).then(ride);
  return problem;
}

OptimalControlProblem spoilt(const std::function<void(Ride&)>& spoil) {
  Ride ride = sound();
  spoil(ride);
  return of(ride);
}

TEST(Check, AcceptsACorrectProblem) {
  for (const ProblemCheck& page : {check(of(sound())), check(spoilt([](Ride& ride) {
                                     ride.keep("power", power(Power::Mistake::none), at_most(10.0));
                                   }))}) {
    EXPECT_TRUE(page.ok()) << page.text();
    for (const char* aspect : {"definition", "start", "derivatives", "sparsity", "jumps", "bounds",
                               "scaling", "ranks", "integration", "reach"})
      EXPECT_EQ(page.line(aspect).verdict, ProblemCheck::Verdict::good) << page.text();
  }
}

// A pendulum whose position is an arc length. The unit is one radius or ten thousand radii.
struct Swing {
  double radius;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], S(sin(x[0] / radius)) * radius + u[0]};
  }
};

TEST(Check, ChecksDerivativesInProblemUnits) {
  for (const double radius : {1.0, 1e-3, 1e-4, 1e-5})
    for (const bool is_declared : {true, false}) {
      Ride swing{"swing", Swing{radius}, exactly(1.0)};
      swing.bound_input(0, between(-12.0 * radius, 12.0 * radius))
          .track(
              "upright", [](auto, auto x) { return x; }, VectorXd::Ones(2))
          .minimise("effort", effort);
      if (is_declared) swing.nominal(VectorXd{{radius, radius}}, VectorXd{{radius}});
      OptimalControlProblem problem("swing");
      problem.start_at({0.5 * radius, 0.0}).then(swing);
      const ProblemCheck page = check(problem);
      EXPECT_EQ(page.line("derivatives").verdict, ProblemCheck::Verdict::good)
          << radius << (is_declared ? " declared\n" : "\n") << page.text();
    }
}

// Watts in place of megawatts: the check still finds the error.
TEST(Check, FindsAWrongDerivativeOfSmallNumbers) {
  for (const auto mistake :
       {Power::Mistake::derivative, Power::Mistake::second_derivative, Power::Mistake::none}) {
    const ProblemCheck page =
        check(spoilt([&](Ride& r) { r.keep("power", power(mistake, 1e-6), at_most(10.0)); }));
    EXPECT_EQ(page.line("derivatives").verdict, mistake == Power::Mistake::none
                                                    ? ProblemCheck::Verdict::good
                                                    : ProblemCheck::Verdict::doubtful)
        << page.text();
  }
}

struct Spoilt {
  const char* name;
  std::function<ProblemCheck()> page;
  const char* aspect;
  std::vector<std::string> fragments;
};
void PrintTo(const Spoilt& s, std::ostream* out) { *out << s.name; }

std::function<ProblemCheck()> ride(std::function<void(Ride&)> spoil, ShootingOptions options = {}) {
  return [=] { return check(spoilt(spoil), options); };
}

struct Wind {  // fast, with a stiff state
  double rate;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], -rate * rate * x[0] + u[0]};
  }
};

// A jump that halves the speed, like user code.
class Blow final : public FunctionBody {
 public:
  explicit Blow(double derivative) : FunctionBody(3, 2), derivative_(derivative) {
    jacobian_pattern_ = SparsityPattern::from_pairs(2, 3, {{0, 1}, {1, 2}});
    hessian_pattern_ = SparsityPattern::from_pairs(3, 3, {});
  }
  void value(const double* z, double* y) const override {
    y[0] = z[1];
    y[1] = 0.5 * z[2];
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    entries[0] = 1.0;
    entries[1] = derivative_;
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  double derivative_;
};

OptimalControlProblem two_rides(Jump jump) {
  const Ride second = sound();
  Ride first{"first", Cart{}, exactly(1.0)};
  first.minimise("effort", effort)
      .guess_state(Guess::interpolate(VectorXd{{0.0, 0.3}}, VectorXd{{0.5, 0.6}}))
      .guess_input(Guess::constant(VectorXd::Constant(1, 0.4)));
  OptimalControlProblem problem("two rides");
  problem.start_at({0.0, 0.0}).then(first).then(second, std::move(jump));
  return problem;
}

ProblemCheck check_blow(double derivative) {
  return check(two_rides(
      {"blow", Function(std::unique_ptr<const FunctionBody>(std::make_unique<Blow>(derivative))),
       2}));
}

// A cart with a second input. Its bounds fix it at 1, and a term requires another value.
ProblemCheck check_trim(double wanted) {
  Phase<2, 2> ride{"ride",
                   [](const auto&, const auto& x, const auto& u) {
                     return std::decay_t<decltype(x)>{x[1], u[0]};
                   },
                   exactly(1.0)};
  ride.minimise("effort", [](auto, auto, auto u) { return u[0] * u[0]; })
      .bound_input(1, exactly(1.0))
      .keep(
          "trim", [](auto, auto, auto u) { return u[1]; }, exactly(wanted));
  OptimalControlProblem problem("trimmed cart");
  problem.start_at({0.0, 0.0}).then(ride);
  return check(problem);
}

OptimalControlProblem oscillator(double rate, double seconds) {
  Ride swing{"swing", Wind{rate}, exactly(seconds)};
  swing.minimise("effort", effort).guess_state(Guess::constant(VectorXd{{1.0, 0.0}}));
  OptimalControlProblem problem("oscillator");
  problem.start_at({1.0, 0.0}).then(swing);
  return problem;
}

const Spoilt all_spoilt[] = {
    {"wrong_derivative",
     ride([](Ride& r) { r.keep("power", power(Power::Mistake::derivative), at_most(10.0)); }),
     "derivatives",
     {"term 'power'", "/ d x1 is"}},
    {"wrong_second_derivative",
     ride(
         [](Ride& r) { r.keep("power", power(Power::Mistake::second_derivative), at_most(10.0)); }),
     "derivatives",
     {"term 'power'", "second derivative by u0 and x1"}},
    {"entry_outside_its_pattern",
     ride([](Ride& r) { r.keep("power", power(Power::Mistake::pattern), at_most(10.0)); }),
     "sparsity",
     {"term 'power'", "d u0", "not in the pattern"}},
    {"missing_scaling",
     ride([](Ride& r) {
       r.guess_state(Guess::interpolate(VectorXd{{0.0, 0.3}}, VectorXd{{4e6, 0.5}}));
     }),
     "scaling",
     {"state 0", "4e+06", "nominal(...)"}},
    {"redundant_rows",
     ride([](Ride& r) { r.reach("there again", position, exactly(1.0)); }),
     "ranks",
     {"term 'there again'", "follows from the other equations"}},
    {"more_equations_than_unknowns",
     ride([](Ride& r) { r.bound_input(0, exactly(0.5)); }),
     "ranks",
     {"equations for", "term '"}},
    // The term contains a fixed input only and is violated. The check reports a contradiction from
    // above and from below.
    {"given_input_asked_to_be_more",
     [] { return check_trim(2.0); },
     "ranks",
     {"equations for", "term 'trim', row 0 at t = ", "contradict"}},
    {"given_input_asked_to_be_less",
     [] { return check_trim(0.5); },
     "ranks",
     {"equations for", "term 'trim', row 0 at t = ", "contradict"}},
    {"start_outside_its_domain",
     ride([](Ride& r) { r.minimise("power", [](auto, auto x) { return log(x[0] - 5.0); }); }),
     "start",
     {"term 'power'", "no finite value", "at the guess"}},
    {"derivative_that_is_no_number",
     ride([](Ride& r) { r.keep("power", power(Power::Mistake::not_a_number), at_most(10.0)); }),
     "start",
     {"term 'power'", "derivative that is not finite"}},
    {"grid_too_coarse",
     [] {
       return check(oscillator(12.0, 5.0),
                    {.intervals_per_phase = 6, .integrator = runge_kutta4()});
     },
     "integration",
     {"more intervals", "phase 'swing'"}},
    {"unreachable_end",
     ride([](Ride& r) { r.reach("far", position, at_least(100.0)); }),
     "reach",
     {"the constraints cannot all be satisfied", "phase 'ride', term 'far'"}},
    {"end_beyond_the_inputs",
     [] {
       Ride short_ride{"ride", Cart{}, exactly(0.5)};
       short_ride.minimise("effort", effort)
           .bound_input(0, between(-1.0, 1.0))
           .reach("there", position, exactly(1.0));
       return check(of(short_ride));
     },
     "reach",
     {"term 'there'"}},
    {"bulge_between_two_nodes",
     [] {
       Ride ride{"ride", Cart{}, exactly(1.0)};
       ride.minimise("effort", effort)
           .keep("wall", position, at_most(1.02))
           .reach("there", position, exactly(1.0))
           .reach("back", speed, exactly(-1.0));
       return check(of(ride), {.intervals_per_phase = 6, .integrator = runge_kutta4()});
     },
     "reach",
     {"between two nodes", "'wall' of phase 'ride'"}},
    {"event_passed_the_wrong_way",
     [] {
       Ride flight{"flight",
                   [](auto, auto x, auto u) {
                     return decltype(x){x[1], u[0] - 9.81};
                   },
                   between(0.01, 2.0)};
       flight.ends_when("ground", position, Crossing::rising)
           .guess_duration(0.3)
           .minimise("effort", effort)
           .bound_input(0, between(-1.0, 1.0));
       OptimalControlProblem problem("flight");
       problem.start_at({1.0, 0.0}).then(flight);
       return check(problem);
     },
     "reach",
     {"event 'ground' that ends phase 'flight'"}},
    {"start_outside_its_bounds",
     ride([](Ride& r) { r.bound_state(0, at_least(0.2)); }),
     "bounds",
     {"state 0 starts at 0", "[0.2, inf]"}},
    {"constant_cost",
     ride([](Ride& r) { r.minimise("half", [](auto, auto, auto u) { return (1 / 2) * u[0]; }); }),
     "definition",
     {"'half'"}},
    {"input_that_does_nothing",
     [] {
       Phase<1, 2> idle{"idle", [](auto, auto x, auto u) { return decltype(x){u[0]}; },
                        exactly(1.0)};
       idle.minimise("effort", effort).reach("there", position, exactly(1.0));
       OptimalControlProblem problem("idle");
       problem.start_at({0.0}).then(idle);
       return check(problem);
     },
     "definition",
     {"input", "phase 'idle'"}},
    {"wrong_size",
     ride([](Ride& r) { r.track("position", position, VectorXd::Ones(3)); }),
     "definition",
     {"'position'", "3"}},
    {"wrong_derivative_of_a_jump",
     [] { return check_blow(0.25); },
     "jumps",
     {"jump 'blow' out of phase 'first'", "d (row 1) / d x1 is 0.25, differences give 0.5"}},
    {"jump_outside_its_domain",
     [] {
       return check(two_rides(jump<2>("root", [](const auto&, const auto& x) {
         return std::decay_t<decltype(x)>{x[0], sqrt(x[1] - 2.0)};
       })));
     },
     "jumps",
     {"jump 'root' out of phase 'first' has no finite value at the guess"}},
    {"reset_outside_its_domain",
     [] {
       return check(spoilt([](Ride& r) {
         r.on(
             "bump", [](auto, auto x) { return x[0] - 0.7; }, Crossing::rising,
             [](const auto&, const auto& x) {
               return std::decay_t<decltype(x)>{x[0], log(x[1] - 5.0)};
             });
       }));
     },
     "jumps",
     {"the reset of event 'bump' has no finite value"}},
    {"dynamics_that_explode",
     [] {
       return check(oscillator(1e4, 5.0), {.intervals_per_phase = 6, .integrator = runge_kutta4()});
     },
     "integration",
     {"an integrator suited to such dynamics"}},
};

TEST(Check, AcceptsACorrectJump) {
  const ProblemCheck page = check_blow(0.5);
  EXPECT_TRUE(page.ok()) << page.text();
  EXPECT_EQ(page.line("jumps").text, "1 state maps checked: finite, in agreement with differences");
}

class FaultyProblem : public testing::TestWithParam<Spoilt> {};

TEST_P(FaultyProblem, IsFound) {
  const ProblemCheck page = GetParam().page();
  EXPECT_FALSE(page.ok()) << page.text();
  const ProblemCheck::Line& line = page.line(GetParam().aspect);
  EXPECT_EQ(line.verdict, ProblemCheck::Verdict::doubtful) << page.text();
  for (const std::string& fragment : GetParam().fragments)
    EXPECT_NE(line.text.find(fragment), std::string::npos) << fragment << " is not in\n"
                                                           << page.text();
}

INSTANTIATE_TEST_SUITE_P(Check, FaultyProblem, testing::ValuesIn(all_spoilt),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace saltus
