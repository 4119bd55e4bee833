// Tests every public feature with every argument that its formula may read, by the fast and the
// slow paths. The pairs are stages and a sparse factor, one and several quadratic programs, the
// exact hold and Runge-Kutta, and stages that a controller's program writes itself. All paths must
// give the same answer.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::test {
namespace {

constexpr int nx = 2, nu = 1, np = 2;
// Arguments that a formula reads.
enum Argument : unsigned { none = 0, time = 1, state = 2, input = 4, parameter = 8 };
std::string name_of(unsigned reads) {
  std::string text;
  for (const auto& [argument, name] :
       {std::pair{time, "t"}, {state, "x"}, {input, "u"}, {parameter, "p"}})
    if ((reads & argument) != 0) text += name;
  return text.empty() ? "nothing" : text;
}

// 0.1 + 0.3 t + 0.5 x0 - 0.2 x1 + 0.4 u + 0.6 p0, restricted to the arguments that it reads.
struct Row {
  unsigned reads = none;
  double offset = 0.1;

  template <class S, class X, class U, class P>
  S sum(const S& t, const X& x, const U& u, const P& p) const {
    S value = S(offset);
    if ((reads & time) != 0) value += 0.3 * t;
    if ((reads & state) != 0) value += 0.5 * x[0] - 0.2 * x[1];
    if ((reads & input) != 0) value += 0.4 * u[0];
    if ((reads & parameter) != 0) value += 0.6 * p[0];
    return value;
  }
  template <class S>
  S operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u, const Vec<S, np>& p) const {
    return sum(t, x, u, p);
  }
};
// A strictly convex function of the row, and a product of the parameter and the state.
struct Cost {
  Row row;
  template <class S>
  S operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u, const Vec<S, np>& p) const {
    const S r = row.sum(t, x, u, p);
    return 0.5 * r * r + 0.3 * r;
  }
};
// x0' = x1, x1' = u - x0 / 2, and a row.
struct Dynamics {
  Row row;
  // Adds zero in a form that a trace cannot simplify, so the program is not detected as
  // linear-quadratic.
  bool hides = false;
  template <class S>
  Vec<S, nx> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u,
                        const Vec<S, np>& p) const {
    using std::cos;
    using std::sin;
    S force = u[0] - 0.5 * x[0] + row.sum(t, x, u, p);
    if (hides) force += sin(x[0]) * sin(x[0]) + cos(x[0]) * cos(x[0]) - 1.0;
    return {x[1], force};
  }
};
// A jump: passes the state on and adds the row to its first entry.
struct Handed {
  Row row;
  template <class S>
  Vec<S, nx> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, 0>& u,
                        const Vec<S, np>& p) const {
    return {0.9 * x[0] + 0.2 * row.sum(t, x, u, p), x[1]};
  }
};

// A problem of two phases to which features are added.
struct Draft {
  Draft(bool hides, bool is_free, bool is_unknown, const Row& forced)
      : phases{part("first", hides, is_free, is_unknown, forced),
               part("second", hides, is_free, is_unknown, forced)} {}

  static Phase<nx, nu, np> part(const char* name, bool hides, bool is_free, bool is_unknown,
                                const Row& forced) {
    Phase<nx, nu, np> phase(name, Dynamics{forced, hides},
                            is_free ? between(0.6, 1.4) : exactly(1.0));
    const VectorXd p = (VectorXd(np) << 0.4, -0.3).finished();
    if (is_unknown)
      phase.unknown("p", p, between(-1.0, 1.0));
    else
      phase.data("p", p);
    // Makes the optimum unique.
    phase
        .track(
            "state", [](auto, auto x, auto, auto) { return x; }, VectorXd::Ones(nx))
        .track(
            "input", [](auto, auto, auto u, auto) { return u; }, VectorXd::Constant(nu, 0.5));
    if (is_unknown)
      phase.track_at_end(
          "p", [](auto, auto, auto, auto parameters) { return parameters; }, VectorXd::Ones(np));
    if (is_free)
      phase.track_at_end(
          "clock", [](auto t, auto, auto, auto) { return Vec<decltype(t), 1>{t}; },
          VectorXd::Constant(1, 4.0), Reference(VectorXd::Constant(1, 1.0)));
    return phase;
  }

  std::vector<Phase<nx, nu, np>> phases;
  std::optional<Jump> jump;
  std::function<void(OptimalControlProblem&)> more = [](OptimalControlProblem&) {};

  OptimalControlProblem problem(CostRule rule) const {
    OptimalControlProblem result("every argument");
    result.start_at({0.5, -0.2}).costs(rule).then(phases[0]);
    if (jump)
      result.then(phases[1], *jump);
    else
      result.then(phases[1]);
    more(result);
    return result;
  }
};

struct Feature {
  std::string name;
  unsigned may_read;
  std::function<void(Draft&, const Row&)> add;
  bool needs_free_times = false;
  bool needs_given_start = true;
};

const std::vector<Feature>& features() {
  static const std::vector<Feature> all = [] {
    constexpr unsigned whole = time | state | input | parameter, end = time | state | parameter;
    const Bounds low = at_most(0.25);
    const auto both = [](const auto& add) {
      return [add](Draft& d, const Row& row) {
        for (Phase<nx, nu, np>& phase : d.phases) add(phase, row);
      };
    };
    const auto weight = VectorXd::Constant(1, 0.7);
    std::vector<Feature> list{
        {"dynamics", whole, [](Draft&, const Row&) {}},
        {"minimise", whole, both([](auto& p, const Row& row) { p.minimise("f", Cost{row}); })},
        {"minimise in a window", whole, both([](auto& p, const Row& row) {
           p.minimise("f", Cost{row}, {.from = 0.2, .to = 0.5});
         })},
        {"track", whole, both([weight](auto& p, const Row& row) { p.track("f", row, weight); })},
        {"minimise_at_end", end,
         both([](auto& p, const Row& row) { p.minimise_at_end("f", Cost{row}); })},
        {"track_at_end", end,
         both([weight](auto& p, const Row& row) { p.track_at_end("f", row, weight); })},
        {"keep", whole, both([low](auto& p, const Row& row) {
           // With this offset, the bound leaves the optimiser some freedom.
           p.keep("f", Row{row.reads, -0.9}, low);
         })},
        {"keep in a window", whole, both([low](auto& p, const Row& row) {
           p.keep("f", Row{row.reads, -0.7}, low, {.from = 0.4});
         })},
        {"keep softly, L1", whole, both([low](auto& p, const Row& row) {
           p.keep("f", row, low, {}, soft("w", 0.8, Penalty::L1));
         })},
        {"keep softly, L2", whole, both([low](auto& p, const Row& row) {
           p.keep("f", row, low, {}, soft("w", 3.0, Penalty::L2));
         })},
        {"keep softly, Huber", whole,
         both([low](auto& p, const Row& row) { p.keep("f", row, low, {}, huber("w", 2.0, 0.1)); })},
        {"reach", end, both([low](auto& p, const Row& row) {
           p.reach("f", Row{row.reads, -0.7}, low);
         })},
        {"reach softly", end, both([low](auto& p, const Row& row) {
           p.reach("f", row, low, soft("w", 0.5, Penalty::L1));
         })},
        {"begin_with", end,
         [low](Draft& d, const Row& row) {
           d.phases[1].begin_with("f", Row{row.reads, -0.5}, low);
         }},
        {"bound_integral", whole,
         both([](auto& p, const Row& row) { p.bound_integral("f", row, at_most(0.9)); })},
        {"bound_integral softly", whole, both([](auto& p, const Row& row) {
           p.bound_integral("f", row, Limits(at_most(0.1), soft("w", 0.5, Penalty::L2)));
         })},
        {"jump", end, [](Draft& d, const Row& row) { d.jump = jump<nx, np>("f", Handed{row}); }},
        {"link", end,
         [low](Draft& d, const Row& row) {
           const auto ends = std::pair{end_of(d.phases[0]), end_of(d.phases[1])};
           d.more = [=](OptimalControlProblem& problem) {
             problem.link(
                 "f",
                 [reads = row.reads](const auto& a, const auto& b) {
                   const Vec<std::decay_t<decltype(a.t)>, nu> nothing{a.t};
                   const Row half{reads & ~unsigned{input}, -0.4};
                   return half.sum(a.t, a.x, nothing, a.p) + half.sum(b.t, b.x, nothing, b.p);
                 },
                 low, ends.first, ends.second);
           };
         }},
        {"state bounds in a window", none,
         both([](auto& p, const Row&) { p.bound_state(1, between(-0.4, 0.3), {.from = 0.3}); })},
        {"input bounds", none,
         both([](auto& p, const Row&) { p.bound_input(0, between(-0.3, 0.2)); })},
        {"input bounds until a time", none,
         both([](auto& p, const Row&) { p.bound_input(0, exactly(0.1), {.to = 0.5}); })},
        {"penalise_change", none,
         both([](auto& p, const Row&) { p.penalise_change(VectorXd::Constant(nu, 0.5)); })},
        {"linear inputs", none,
         both([](auto& p, const Row&) { p.inputs(InputParametrisation::piecewise_linear); })},
        {"continuous linear inputs", none, both([](auto& p, const Row&) {
           p.inputs(InputParametrisation::piecewise_linear_continuous);
         })},
        {"magnitudes", none, both([](auto& p, const Row&) {
           p.nominal((VectorXd(nx) << 10.0, 0.1).finished(), VectorXd::Constant(nu, 4.0));
         })},
        {"total_time", none,
         [](Draft& d, const Row&) {
           d.more = [](OptimalControlProblem& problem) { problem.total_time(between(1.5, 2.2)); };
         }},
        {.name = "start_within",
         .may_read = none,
         .add =
             [](Draft& d, const Row&) {
               d.more = [](OptimalControlProblem& problem) {
                 problem.start_within({between(0.3, 0.6), exactly(-0.2)},
                                      Vec<double, 2>{0.5, -0.2});
               };
             },
         .needs_given_start = false},
        {.name = "start_time",
         .may_read = none,
         .add =
             [](Draft& d, const Row&) {
               d.phases[0].minimise_at_end("f", Cost{{time | state}});
               d.more = [](OptimalControlProblem& problem) {
                 problem.start_time(between(-0.5, 0.5), 0.1);
               };
             }},
        {.name = "closing",
         .may_read = end,
         .add =
             [](Draft& d, const Row& row) {
               d.more = [row](OptimalControlProblem& problem) {
                 problem.start_within({between(-2.0, 2.0), between(-2.0, 2.0)},
                                      Vec<double, 2>{0.5, -0.2});
                 problem.close(jump<nx, np>("f", Handed{row}));
               };
             },
         .needs_given_start = false},
        {.name = "ends_when",
         .may_read = end,
         .add =
             [](Draft& d, const Row& row) {
               d.phases[0].ends_when(
                   "f",
                   [reads = row.reads](const auto& t, const auto& x, const auto&, const auto& p) {
                     const Vec<std::decay_t<decltype(t)>, nu> nothing{t};
                     return t - 0.9 +
                            0.2 * Row{reads & ~unsigned{input}, 0.0}.sum(t, x, nothing, p);
                   },
                   Crossing::rising);
             },
         .needs_free_times = true},
    };
    for (const bool is_event : {true, false})
      list.push_back({is_event ? "keep until an event" : "keep during a mode", whole,
                      [low, is_event](Draft& d, const Row& row) {
                        const Window window = is_event ? Window{.to = event("e")} : during("b");
                        d.phases[0].keep("f", Row{row.reads, -0.7}, low, window);
                        d.more = [](OptimalControlProblem& problem) {
                          problem.schedule(Schedule({"a", "b"}, {{"e", 0.45}}));
                        };
                      }});
    return list;
  }();
  return all;
}

// Each argument alone, and all of them.
std::vector<unsigned> choices_of(unsigned may_read) {
  std::vector<unsigned> all{none};
  for (const unsigned argument : {time, state, input, parameter})
    if ((may_read & argument) != 0) all.push_back(argument);
  if (all.size() > 2) all.push_back(may_read);
  return all;
}

struct Way {
  std::string name;
  bool hides = false;
  bool holds = false;  // uses the exact hold
  std::function<std::unique_ptr<Solver>()> make;
};
const std::vector<Way>& ways() {
  static const std::vector<Way> all{
      // The slow path comes first. All others are compared with it.
      {"sparse, nonlinear", true, false, [] { return make_native_solver({.tolerance = 1e-9}); }},
      {"Ipopt, nonlinear", true, false, [] { return make_ipopt({.tolerance = 1e-9}); }},
      {"riccati, nonlinear", true, false,
       [] { return make_native_solver({.tolerance = 1e-9, .qp = riccati_qp()}); }},
      {"sparse", false, false, [] { return make_native_solver({.tolerance = 1e-9}); }},
      {"riccati", false, false,
       [] { return make_native_solver({.tolerance = 1e-9, .qp = riccati_qp()}); }},
      {"Ipopt", false, false, [] { return make_ipopt({.tolerance = 1e-9}); }},
      {"sparse, exact hold", false, true, [] { return make_native_solver({.tolerance = 1e-9}); }},
      {"riccati, exact hold", false, true,
       [] { return make_native_solver({.tolerance = 1e-9, .qp = riccati_qp()}); }}};
  return all;
}

struct Case {
  const Feature* feature;
  unsigned reads;
  bool is_free, is_unknown;
  CostRule rule;

  std::string name() const {
    return fmt::format("{} that reads {}{}{}{}", feature->name, name_of(reads),
                       is_free ? ", free times" : "", is_unknown ? ", unknown parameters" : "",
                       rule == CostRule::integrated ? ", integrated" : "");
  }
  OptimalControlProblem problem(bool hides) const {
    const Row row{reads};
    const Row forced = feature->name == "dynamics" ? row : Row{none, 0.0};
    Draft draft(hides, is_free, is_unknown, forced);
    feature->add(draft, row);
    return draft.problem(rule);
  }
  // If the whole problem is one convex quadratic program, its optimum is unique.
  MultipleShooting shooting(bool hides, bool holds) const {
    return MultipleShooting(problem(hides),
                            {.intervals_per_phase = 6,
                             .integrator = holds ? zero_order_hold() : runge_kutta4({.steps = 6})});
  }
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Feature& feature : features())
    for (const unsigned reads : choices_of(feature.may_read))
      for (const bool is_free : {false, true})
        for (const bool is_unknown : {false, true})
          for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
            if (feature.needs_free_times && !is_free) continue;
            // A row that reads nothing is the same in every variant.
            if (reads == none && (is_free || is_unknown) && feature.may_read != none) continue;
            all.push_back({&feature, reads, is_free, is_unknown, rule});
          }
  return all;
}

VectorXd inputs_of(const Solution& s) {
  std::vector<double> all;
  for (const Trajectory::Piece& piece : s.trajectory.pieces())
    for (const double c : piece.coefficients) all.push_back(c);
  return Eigen::Map<VectorXd>(all.data(), static_cast<int>(all.size()));
}

TEST(SearchFeatures, FastAndGeneralPathsAgree) {
  int compared = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name());
    std::optional<Solution> slow;
    for (const Way& way : ways()) {
      SCOPED_TRACE(way.name);
      std::optional<MultipleShooting> shooting;
      try {
        shooting.emplace(c.shooting(way.hides, way.holds));
      } catch (const DefinitionError& e) {
        // The exact hold accepts linear dynamics only and reports the rest. Windows by event and by
        // mode require fixed times.
        EXPECT_TRUE(way.holds || c.is_free) << e.what();
        continue;
      }
      const auto solver = way.make();
      const Solution s = solve(*shooting, *solver);
      if (!slow) {
        slow = s;
        EXPECT_TRUE(s.ok() || s.status == SolveStatus::infeasible) << s.message;
        continue;
      }
      ++compared;
      EXPECT_EQ(s.ok(), slow->ok()) << s.message << " | " << slow->message;
      if (!s.ok() || !slow->ok()) continue;
      // The error of Runge-Kutta with six steps per interval is 1e-8 here, that of the solves 1e-9.
      EXPECT_NEAR(s.cost, slow->cost, 1e-6 * (1.0 + std::abs(slow->cost)));
      const VectorXd u = inputs_of(s), other = inputs_of(*slow);
      ASSERT_EQ(u.size(), other.size());
      // The curvature of the cost is 0.5 times the interval length: a cost error of 1e-7 is an
      // input error of 1e-3.
      EXPECT_LE((u - other).lpNorm<Eigen::Infinity>(), 2e-3);
    }
    if (c.is_free || c.is_unknown || !c.feature->needs_given_start || !slow) continue;
    if (std::string(c.feature->name) == "start_time") continue;  // a tick has its own start time
    // The controller writes its stages itself.
    RecedingHorizonController controller(c.shooting(false, false), {.period = 0.1});
    const ControlTick& tick = controller.tick(0.0, Vec<double, 2>{0.5, -0.2});
    EXPECT_EQ(tick.status == SolveStatus::optimal, slow->ok()) << describe(tick.status);
    if (tick.status == SolveStatus::optimal && slow->ok()) {
      EXPECT_NEAR(tick.objective, slow->cost, 1e-6 * (1.0 + std::abs(slow->cost)));
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace saltus::test
