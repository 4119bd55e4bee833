// Presolve removes rows without free variables, duplicated rows, and bounds that represent
// infinity, for every solver. If such a row is infeasible, the message names it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solve/check.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/presolve.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

const std::vector<std::string>& solver_names() {
  static const std::vector<std::string> names{"sparse", "riccati", "Ipopt"};
  return names;
}
std::unique_ptr<Solver> solver_named(const std::string& name) {
  if (name == "Ipopt") return make_ipopt();
  return name == "riccati" ? make_native_solver({.qp = riccati_qp()}) : make_native_solver();
}
MultipleShooting shooting_of(OptimalControlProblem problem, int intervals = 10) {
  return MultipleShooting(std::move(problem),
                          {.intervals_per_phase = intervals,
                           .integrator = runge_kutta4(),
                           .accuracy = {.verify = false}});  // this test compares rows at nodes
}
Solution solved(const OptimalControlProblem& problem, const std::string& name) {
  MultipleShooting shooting = shooting_of(problem);
  const auto solver = solver_named(name);
  return solve(shooting, *solver);
}

template <int np = 0>
struct Cart {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, np>&) const {
    return {x[1], u[0]};
  }
};
struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    using std::sin;
    return {x[1], u[0] - sin(x[0])};
  }
};
struct Plane {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {x[2], x[3], u[0], u[1]};
  }
};

// --- rows without free variables ------------------------------------------------------------

// A cart that moves 1 m in 1 s, with a hard row that does not depend on the variables.
enum class Row {
  data_kept,
  data_reached,
  data_begun,
  time_kept,
  fixed_input,
  start_only,
  zero_slope
};
struct Constant {
  Row row;
  double lower;  // a huge one must not hide a violation of the upper bound, which is 0
};
std::string name_of(const Constant& c) {
  static constexpr std::array names{"data kept",   "data reached", "data begun", "time kept",
                                    "fixed input", "start only",   "zero slope"};
  return fmt::format("{}, lower bound {}", names[static_cast<std::size_t>(c.row)], c.lower);
}
// The row is q - 1, so its violation is 1 for q = 2.
OptimalControlProblem with_constant_row(const Constant& c, double q) {
  Phase<2, 1, 1> phase{"drive", Cart<1>{}, exactly(1.0)};
  phase.data("q", VectorXd::Constant(1, q))
      .track(
          "effort", [](auto, auto, auto u) { return u; }, VectorXd::Ones(1))
      .reach(
          "place", [](auto, auto x) { return x[0]; }, exactly(1.0));
  const Bounds b = between(c.lower, 0.0);
  const auto datum = [](auto, auto, auto, auto p) { return p[0] - 1.0; };
  switch (c.row) {
    case Row::data_kept:
      phase.keep("limit", datum, b);
      break;
    case Row::data_reached:
      phase.reach("limit", datum, b);
      break;
    case Row::data_begun:
      phase.begin_with("limit", datum, b);
      break;
    case Row::time_kept:
      phase.keep(
          "limit", [](auto t, auto, auto, auto p) { return (p[0] - 1.0) * (1.0 + 0.0 * t); }, b);
      break;
    case Row::fixed_input:
      phase.bound_input(0, exactly(0.5), {.from = 0.5})
          .keep("limit", [](auto, auto, auto u, auto p) { return u[0] - 1.5 + p[0]; }, b,
                {.from = 0.5});
      // u is 0.5 there, so the row equals q - 1.
      break;
    case Row::start_only:
      phase.begin_with(
          "limit", [](auto, auto x, auto, auto p) { return x[0] + p[0] - 1.0; }, b);
      break;
    case Row::zero_slope:
      phase.keep(
          "limit", [](auto, auto x, auto, auto p) { return (p[0] - p[0]) * x[0] + p[0] - 1.0; }, b);
      break;
  }
  OptimalControlProblem problem("constant row");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}
std::vector<Constant> constants() {
  std::vector<Constant> all;
  for (const Row row : {Row::data_kept, Row::data_reached, Row::data_begun, Row::time_kept,
                        Row::fixed_input, Row::start_only, Row::zero_slope})
    for (const double lower : {-infinity, -1e10, 0.0}) all.push_back({row, lower});
  return all;
}
void expect_named(const std::string& message, const std::string& amount) {
  EXPECT_NE(message.find("phase 'drive', term 'limit', row 0 at t = "), std::string::npos)
      << message;
  EXPECT_NE(message.find("violates its bounds by " + amount), std::string::npos) << message;
}

TEST(Presolve, ConstantRowIsDroppedOrNamedInfeasible) {
  for (const Constant& c : constants())
    for (const std::string& name : solver_names()) {
      SCOPED_TRACE(name_of(c) + ", " + name);
      const Solution met = solved(with_constant_row(c, 1.0), name);
      EXPECT_TRUE(met.ok()) << met.message;
      // Within 1e-6, the tolerance of a row whose bounds are zero.
      EXPECT_TRUE(solved(with_constant_row(c, 1.0 + 5e-7), name).ok());
      const Solution missed = solved(with_constant_row(c, 2.0), name);
      EXPECT_EQ(missed.status, SolveStatus::infeasible) << missed.message;
      expect_named(missed.message, "1");
      EXPECT_EQ(solved(with_constant_row(c, 1.0 + 1e-5), name).status, SolveStatus::infeasible);
    }
}

TEST(Presolve, EveryControllerReportsIt) {
  using Make = std::function<std::unique_ptr<RealTimeSolver>(NonlinearProgram&)>;
  const std::vector<std::pair<std::string, Make>> methods{
      {"iteration in stages", [](NonlinearProgram& p) { return make_real_time_iteration(p); }},
      {"iteration, riccati",
       [](NonlinearProgram& p) { return make_real_time_iteration(p, {.qp = riccati_qp()}); }},
      {"iteration, sparse",
       [](NonlinearProgram& p) { return make_real_time_iteration(p, {.qp = sparse_qp()}); }},
      {"sparse", [](NonlinearProgram&) { return make_real_time_solver(make_native_solver()); }},
      {"riccati",
       [](NonlinearProgram&) {
         return make_real_time_solver(make_native_solver({.qp = riccati_qp()}));
       }},
      {"Ipopt", [](NonlinearProgram&) { return make_real_time_solver(make_ipopt()); }}};
  for (const Constant& c : constants())
    for (const auto& [name, make] : methods) {
      SCOPED_TRACE(name_of(c) + ", " + name);
      MultipleShooting shooting = shooting_of(with_constant_row(c, 1.0));
      auto solver = make(shooting.nlp());
      RecedingHorizonController controller(std::move(shooting), std::move(solver),
                                           {.period = 0.02});
      const VectorXd at_rest = VectorXd::Zero(2);
      EXPECT_EQ(controller.tick(0.0, at_rest).status, SolveStatus::optimal);
      controller.set_data("q", VectorXd::Constant(1, 2.0));
      const ControlTick& tick = controller.tick(0.02, at_rest);
      EXPECT_EQ(tick.status, SolveStatus::infeasible);
      EXPECT_FALSE(is_of_this_tick(tick.provenance));
      expect_named(controller.report().message, "1");
      controller.set_data("q", VectorXd::Constant(1, 1.0));
      EXPECT_EQ(controller.tick(0.04, at_rest).status, SolveStatus::optimal);
    }
}

// --- duplicated rows ------------------------------------------------------------------------

struct Twice {
  std::string name;
  std::function<OptimalControlProblem(bool)> make;  // true: with the redundant constraints
};

template <int nx, int nu>
void add_effort(Phase<nx, nu>& phase) {
  phase.track(
      "effort", [](auto, auto, auto u) { return u; }, VectorXd::Ones(nu));
}

OptimalControlProblem in_phases(int phases, VectorXd start,
                                const std::function<void(OptimalControlProblem&, int)>& add) {
  OptimalControlProblem problem("said twice");
  problem.start_at(std::move(start));
  for (int j = 0; j < phases; ++j) add(problem, j);
  return problem;
}
std::string phase_name(int j) { return fmt::format("part {}", j); }

std::vector<Twice> twices() {
  std::vector<Twice> all;
  for (const int phases : {2, 3}) {
    const auto add = [&](const std::string& name, std::function<OptimalControlProblem(bool)> make) {
      all.push_back({fmt::format("{}, {} phases", name, phases), std::move(make)});
    };
    const double far = 0.35 * phases;
    // Kept in all phases. Without the redundant rows, the constraint in later phases begins after
    // their first node.
    add("speed kept", [=](bool twice) {
      return in_phases(phases, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
        Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
        add_effort(p);
        const Window window = twice || j == 0 ? Window{} : Window{.from = 0.1};
        p.keep(
            "speed", [](auto, auto x) { return x[1] * x[1]; }, at_most(0.16), window);
        if (j == phases - 1)
          p.reach(
              "place", [](auto, auto x) { return x[0]; }, exactly(far));
        problem.then(p);
      });
    });
    add("circle kept", [=](bool twice) {
      const VectorXd start = (VectorXd(4) << 1.0, 0.0, 0.0, 0.0).finished();
      return in_phases(phases, start, [&](OptimalControlProblem& problem, int j) {
        Phase<4, 2> p{phase_name(j), Plane{}, exactly(1.0)};
        add_effort(p);
        const Window window = twice || j == 0 ? Window{} : Window{.from = 0.1};
        p.keep(
            "circle", [](auto, auto x) { return x[0] * x[0] + x[1] * x[1]; }, exactly(1.0), window);
        if (j == phases - 1)
          p.reach(
              "height", [](auto, auto x) { return x[1]; }, exactly(0.25 * phases));
        problem.then(p);
      });
    });
    // The redundant rows are no multiples of the first one, but they are constant on the circle.
    add("circle kept in another form", [=](bool twice) {
      const VectorXd start = (VectorXd(4) << 1.0, 0.0, 0.0, 0.0).finished();
      return in_phases(phases, start, [&](OptimalControlProblem& problem, int j) {
        Phase<4, 2> p{phase_name(j), Plane{}, exactly(1.0)};
        add_effort(p);
        const auto square = [](auto, auto x) { return x[0] * x[0] + x[1] * x[1]; };
        p.keep("circle", square, exactly(1.0));
        if (twice)
          p.keep(
               "radius", [=](auto t, auto x) { return sqrt(square(t, x)); }, exactly(1.0))
              .keep(
                  "times a factor",
                  [=](auto t, auto x) { return (square(t, x) - 1.0) * (2.0 + x[0]); }, exactly(0.0))
              .keep(
                  "squared",
                  [=](auto t, auto x) {
                    const auto miss = square(t, x) - 1.0;
                    return miss * miss;
                  },
                  at_most(0.0));
        if (j == phases - 1)
          p.reach(
              "height", [](auto, auto x) { return x[1]; }, exactly(0.25 * phases));
        problem.then(p);
      });
    });
    add("bounds and an equal row", [=](bool twice) {
      return in_phases(phases, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
        Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
        add_effort(p);
        p.bound_state(1, between(-0.4, 0.4));
        if (twice)
          p.keep(
               "speed", [](auto, auto x) { return 2.0 * x[1]; }, between(-0.8, 0.8))
              .keep(
                  "other way", [](auto, auto x) { return 1.0 - x[1]; }, at_least(0.6));
        if (j == phases - 1)
          p.reach(
              "place", [](auto, auto x) { return x[0]; }, exactly(far));
        problem.then(p);
      });
    });
    add("gate at an end and at the next start", [=](bool twice) {
      return in_phases(phases, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
        Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
        add_effort(p);
        const auto place = [](auto, auto x) { return x[0]; };
        p.reach("gate", place, exactly(0.3 * (j + 1)));
        if (twice && j > 0) p.begin_with("gate behind", place, exactly(0.3 * j));
        problem.then(p);
      });
    });
    add("curved gate at an end and at the next start", [=](bool twice) {
      return in_phases(phases, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
        Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
        add_effort(p);
        const auto gate = [](auto, auto x) { return x[0] + x[1] * x[1]; };
        p.reach("gate", gate, exactly(0.3 * (j + 1)));
        if (twice && j > 0) p.begin_with("gate behind", gate, exactly(0.3 * j));
        problem.then(p);
      });
    });
    add("written twice", [=](bool twice) {
      return in_phases(
          phases, (VectorXd(2) << 0.0, 0.1).finished(), [&](OptimalControlProblem& problem, int j) {
            Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
            add_effort(p);
            for (int k = 0; k < (twice ? 2 : 1); ++k) {
              p.keep(
                  fmt::format("speed {}", k), [](auto, auto x) { return x[1]; }, at_most(0.4));
              p.keep(
                  fmt::format("power {}", k), [](auto, auto x, auto u) { return x[1] * u[0]; },
                  at_most(0.5));
              if (j == phases - 1)
                p.reach(
                    fmt::format("place {}", k), [](auto, auto x) { return x; },
                    std::vector<Bounds>{exactly(far), exactly(0.0)});
            }
            problem.then(p);
          });
    });
    add("minimum time, bounded speed", [=](bool twice) {
      return in_phases(phases, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
        Phase<2, 1> p{phase_name(j), Cart<>{}, between(0.3, 4.0)};
        p.bound_input(0, between(-1.0, 1.0));
        p.track(
            "effort", [](auto, auto, auto u) { return u; }, VectorXd::Constant(1, 0.1));
        p.bound_state(1, between(-0.5, 0.5));
        if (twice)
          p.keep(
              "speed", [](auto, auto x) { return x[1]; }, between(-0.5, 0.5));
        if (j == phases - 1)
          p.reach(
               "place", [](auto, auto x) { return x; },
               std::vector<Bounds>{exactly(2.0), exactly(0.0)})
              .minimise_at_end("time", [](auto t, auto) { return t; });
        problem.then(p);
      });
    });
  }
  return all;
}

TEST(Presolve, DuplicateRowsChangeNothing) {
  for (const Twice& c : twices())
    for (const std::string& name : solver_names()) {
      SCOPED_TRACE(c.name + ", " + name);
      const Solution once = solved(c.make(false), name);
      MultipleShooting shooting = shooting_of(c.make(true));
      const auto solver = solver_named(name);
      const Solution twice = solve(shooting, *solver);
      ASSERT_TRUE(once.ok()) << once.message;
      ASSERT_TRUE(twice.ok()) << twice.message;
      // Both solves have a scaled residual of 1e-8.
      EXPECT_NEAR(twice.cost, once.cost, 1e-6 * (1.0 + std::abs(once.cost)));
      // Multipliers refer to the original program.
      const KktCheck::Residual kkt = kkt_residual(shooting.nlp(), twice.point);
      EXPECT_LE(kkt.scaled(), 1e-7);
    }
}

TEST(Presolve, KeepsOneRowOfEachPair) {
  for (const Twice& c : twices()) {
    SCOPED_TRACE(c.name);
    const auto rows_in_force = [](OptimalControlProblem problem, bool reduces) {
      MultipleShooting shooting = shooting_of(std::move(problem));
      const VectorXd w = shooting.initial_guess().w;
      const Presolve sides = presolve(shooting.nlp(), w);
      EXPECT_FALSE(sides.contradiction);
      int count = 0;
      for (int r = 0; r < shooting.nlp().rows(); ++r) {
        const VectorXd& lower = reduces ? sides.row_lower : shooting.nlp().row_lower();
        const VectorXd& upper = reduces ? sides.row_upper : shooting.nlp().row_upper();
        if (lower[r] > -infinity || upper[r] < infinity) ++count;
      }
      return count;
    };
    EXPECT_GT(rows_in_force(c.make(true), false), rows_in_force(c.make(false), false));
    EXPECT_EQ(rows_in_force(c.make(true), true), rows_in_force(c.make(false), true));
  }
}

TEST(Presolve, NamesBothContradictoryRows) {
  struct Case {
    std::string name;
    std::function<void(Phase<2, 1>&, int)> add;  // adds rows to one of two phases
    std::vector<std::string> named;
  };
  const auto place = [](auto, auto x) { return x[0]; };
  const auto curved = [](auto, auto x) { return x[0] + x[1] * x[1]; };
  const auto two_parts = [](const std::function<void(Phase<2, 1>&, int)>& add) {
    return in_phases(2, VectorXd::Zero(2), [&](OptimalControlProblem& problem, int j) {
      Phase<2, 1> p{phase_name(j), Pendulum{}, exactly(1.0)};
      add_effort(p);
      add(p, j);
      problem.then(p);
    });
  };
  const std::vector<Case> cases{
      {"equalities at a jump",
       [&](Phase<2, 1>& p, int j) {
         if (j == 0) p.reach("gate", place, exactly(0.3));
         if (j == 1) p.begin_with("gate behind", place, exactly(0.5));
       },
       {"term 'gate behind'", "term 'gate'", "by 0.2"}},
      {"inequalities at a jump",
       [&](Phase<2, 1>& p, int j) {
         if (j == 0) p.reach("gate", place, at_most(0.3));
         if (j == 1) p.begin_with("gate behind", place, at_least(0.5));
       },
       {"term 'gate behind'", "term 'gate'", "by 0.2"}},
      {"curved rows at a jump",
       [&](Phase<2, 1>& p, int j) {
         if (j == 0) p.reach("gate", curved, exactly(0.3));
         if (j == 1) p.begin_with("gate behind", curved, exactly(0.5));
       },
       {"term 'gate behind'", "term 'gate'", "by 0.2"}},
      {"a row and bounds",
       [&](Phase<2, 1>& p, int j) {
         if (j == 0) p.bound_state(1, at_most(0.4));
         if (j == 0)
           p.reach(
               "fast", [](auto, auto x) { return x[1]; }, at_least(0.6));
       },
       {"term 'fast'", "state 1", "by 0.2"}},
      {"two rows of inputs",
       [&](Phase<2, 1>& p, int) {
         p.keep(
              "pull", [](auto, auto x, auto u) { return u[0] + x[1]; }, exactly(0.3))
             .keep(
                 "twice the pull", [](auto, auto x, auto u) { return 2.0 * (u[0] + x[1]); },
                 exactly(1.0));
       },
       {"term 'twice the pull'", "term 'pull'", "by 0.4"}}};
  for (const Case& c : cases)
    for (const std::string& name : solver_names()) {
      SCOPED_TRACE(c.name + ", " + name);
      const Solution none = solved(two_parts(c.add), name);
      EXPECT_EQ(none.status, SolveStatus::infeasible);
      for (const std::string& text : c.named)
        EXPECT_NE(none.message.find(text), std::string::npos) << text << ": " << none.message;
    }
}

// The rows coincide near the guess but differ at the optimum.
TEST(Presolve, KeepsRowsThatAgreeNearTheGuessOnly) {
  const auto make = [](bool with_second) {
    Phase<2, 1> p{"push", Pendulum{}, exactly(1.0)};
    add_effort(p);
    p.reach(
        "first", [](auto, auto x) { return x[0] * x[0] + x[1]; }, at_least(1.5));
    if (with_second)
      p.reach(
          "second",
          [](auto, auto x) {
            using std::max;
            const auto far = max(x[1] - 1.0, 0.0 * x[1]);
            return x[0] * x[0] + x[1] - far * far;
          },
          at_least(1.5));
    OptimalControlProblem problem("nearly twice");
    problem.start_at({0.0, 0.0}).then(p);
    return problem;
  };
  for (const std::string& name : {std::string("sparse"), std::string("riccati")}) {
    SCOPED_TRACE(name);
    MultipleShooting shooting = shooting_of(make(true));
    const auto solver = solver_named(name);
    const Solution plan = solve(shooting, *solver);
    EXPECT_TRUE(plan.ok()) << plan.message;
    EXPECT_LE(kkt_residual(shooting.nlp(), plan.point).feasibility, 1e-6);
  }
}

// --- bounds that represent infinity ---------------------------------------------------------

OptimalControlProblem bounded_by(double side) {
  Phase<2, 1> p{"drive", Cart<>{}, exactly(1.0)};
  add_effort(p);
  const Bounds b = between(-side, side);
  p.bound_state(0, b)
      .bound_state(1, b)
      .bound_input(0, b)
      .keep(
          "far", [](auto, auto x, auto u) { return x[0] + x[1] * u[0]; }, b)
      .reach(
          "place", [](auto, auto x) { return x[0]; }, exactly(1.0))
      .bound_integral(
          "used", [](auto, auto, auto u) { return u[0]; }, b);
  OptimalControlProblem problem("sentinels");
  problem.start_at({0.0, 0.0}).total_time(between(0.0, side)).then(p);
  return problem;
}

TEST(Presolve, BoundsBeyond1e19AreInfinite) {
  for (const std::string& name : solver_names()) {
    SCOPED_TRACE(name);
    const Solution free = solved(bounded_by(infinity), name);
    ASSERT_TRUE(free.ok()) << free.message;
    for (const double side : {1e19, 1e20, 1e30, 1e300}) {
      const Solution same = solved(bounded_by(side), name);
      ASSERT_TRUE(same.ok()) << same.message;
      EXPECT_EQ(same.cost, free.cost);  // the same program, bit for bit
    }
  }
  EXPECT_EQ(without_sentinels(exactly(1e20)), exactly(1e20));
}

TEST(Presolve, FiniteBoundsFrom1e8OnGiveAWarning) {
  const ShootingOptions grid{.intervals_per_phase = 5, .integrator = runge_kutta4()};
  EXPECT_EQ(check(bounded_by(9e7), grid).line("bounds").verdict, ProblemCheck::Verdict::good);
  EXPECT_EQ(check(bounded_by(1e20), grid).line("bounds").verdict, ProblemCheck::Verdict::good);
  for (const double side : {1e8, 1e10, 9e18}) {
    const ProblemCheck seen = check(bounded_by(side), grid);
    const ProblemCheck::Line& line = seen.line("bounds");
    EXPECT_EQ(line.verdict, ProblemCheck::Verdict::doubtful);
    EXPECT_NE(line.text.find("phase 'drive', state 0"), std::string::npos) << line.text;
    EXPECT_NE(line.text.find("leave out"), std::string::npos) << line.text;
  }
}

// In these units the input moves the position by 1e-16 per unit, which is no reason to call the
// position fixed: inputs of 1e11 reach the goal.
TEST(PresolveUnits, TinyCoefficientsAreNotZero) {
  constexpr double lever = 1e-14;
  for (const double goal : {4e-6, 4e-3, 1.0}) {
    Phase<2, 1> phase{"move",
                      [](auto, auto x, auto u) {
                        return decltype(x){x[1], lever * u[0]};
                      },
                      exactly(1.0)};
    phase.reach(
        "there", [](auto, auto x) { return x; }, std::vector<Bounds>{exactly(goal), exactly(0.0)});
    phase.minimise("effort", [](auto, auto, auto u) { return lever * lever * u[0] * u[0]; });
    OptimalControlProblem ocp("tiny");
    ocp.start_at({0, 0}).then(phase);
    const Solution s = solve(ocp);
    EXPECT_NE(s.status, SolveStatus::infeasible) << goal << ": " << s.message;
  }
}

}  // namespace
}  // namespace saltus
