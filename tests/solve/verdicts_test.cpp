// Verdicts do not depend on guesses, inactive bounds, penalty weights or units, and a point that is
// not optimal is not called optimal.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "saltus/saltus.hpp"
#include "saltus/solver/ipopt.hpp"

namespace saltus {
namespace {

const SolverChoice all_solvers[] = {SolverChoice::sparse, SolverChoice::riccati,
                                    SolverChoice::ipopt};

Solution solved(const OptimalControlProblem& problem, SolverChoice choice,
                double tolerance = 1e-8) {
  return solve(problem, {.solver = make_solver(choice, {.tolerance = tolerance})});
}

struct Gear {  // x = (position m, speed m/s), u = (throttle, brake)
  double thrust, braking;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], thrust * u[0] - braking * u[1] - 0.01 * x[1] * x[1]};
  }
};

OptimalControlProblem car(double first_speed) {
  const auto position = [](auto, auto x) { return x[0]; };
  const auto speed = [](auto, auto x) { return x[1]; };
  Phase<2, 2> first{"first gear", Gear{6.0, 8.0}, between(0.5, 10.0)};
  first.bound_input(0, between(0.0, 1.0)).bound_input(1, exactly(0.0));
  first.keep("rev limit", speed, at_most(12.0));
  Phase<2, 2> second{"second gear", Gear{3.0, 8.0}, between(0.5, 20.0)};
  second.bound_input(0, between(0.0, 1.0)).bound_input(1, between(0.0, 1.0));
  second.reach("finish line", position, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", [](auto t, auto) { return t; });
  OptimalControlProblem problem("car");
  problem.start_at({0.0, first_speed}).then(first).then(second);
  return problem;
}

// The time decreases by less than 0.2 s per m/s of initial speed.
TEST(Verdicts, StartNearRestIsNotAMagnitude) {
  for (const SolverChoice choice : all_solvers) {
    const Solution at_rest = solved(car(0.0), choice);
    ASSERT_TRUE(at_rest.ok()) << at_rest.message;
    for (const double speed : {1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 4e-3, 6e-3, 1e-2}) {
      const Solution plan = solved(car(speed), choice);
      EXPECT_TRUE(plan.ok()) << name_of(choice) << " at " << speed << ": " << plan.message;
      EXPECT_NEAR(plan.cost, at_rest.cost, 0.2 * speed + 1e-5) << name_of(choice) << " " << speed;
    }
  }
}

// From rest to rest with x'' = gain u - stiffness x and minimum effort.
OptimalControlProblem rest_to_rest(double gain, double stiffness, double way, double duration,
                                   double weight) {
  Phase<2, 1> move{"move",
                   [=](auto, auto x, auto u) {
                     return decltype(x){x[1], gain * u[0] - stiffness * x[0]};
                   },
                   exactly(duration)};
  move.reach("there", [](auto, auto x) { return x; }, {exactly(way), exactly(0.0)})
      .minimise("effort", [=](auto, auto, auto u) { return weight * u[0] * u[0]; });
  OptimalControlProblem problem("rest to rest");
  problem.start_at({0.0, 0.0}).then(move).costs(CostRule::integrated);
  return problem;
}

// Inputs of 4e3 move states of 4e-5: the violation hardly changes with an input of 1.
TEST(Verdicts, SmallEffectOfTheInputIsNoContradiction) {
  for (const SolverChoice choice : all_solvers) {
    const Solution plan = solved(rest_to_rest(7.8e-6, 1.18e4, 3.93e-5, 0.0365, 5.4e-8), choice);
    EXPECT_TRUE(plan.ok()) << name_of(choice) << ": " << plan.message;
    EXPECT_GT(plan.trajectory.input(0.0).norm(), 1e3) << name_of(choice);
  }
}

// Speeds of 2e5 that end at rest. An error of 1 is small, even where the state is zero.
TEST(Verdicts, IntegratesALargeStateToRest) {
  for (const SolverChoice choice : all_solvers) {
    const Solution plan = solved(rest_to_rest(1.0, 1e10, 1.5, 1e-5, 1e-22), choice);
    EXPECT_TRUE(plan.ok()) << name_of(choice) << ": " << plan.message;
  }
}

// 2 - t / 2 exceeds 2 - 0.03 before the first node only, and a given start has no rows on states.
TEST(Verdicts, RowOfTimeAloneHoldsAtAGivenStart) {
  for (const SolverChoice choice : all_solvers) {
    for (const bool is_met : {true, false}) {
      Phase<2, 1> push{"push",
                       [](auto, auto x, auto u) {
                         return decltype(x){x[1], u[0]};
                       },
                       exactly(1.0)};
      push.minimise("effort", [](auto, auto, auto u) { return 0.5 * u[0] * u[0]; })
          .reach(
              "there", [](auto, auto x) { return x[0]; }, exactly(0.5))
          .keep("limit",
                [](auto t, auto x) {
                  return decltype(x){x[0] * x[0], 2.0 - 0.5 * t};
                },
                {at_most(1.0), at_most(is_met ? 2.0 : 1.97)});
      OptimalControlProblem problem("push");
      problem.start_at({1.1, 0.0}).then(push);  // violates the row on the state, which is allowed
      const Solution plan = solved(problem, choice);
      EXPECT_EQ(plan.status == SolveStatus::infeasible, !is_met) << plan.message;
      if (!is_met) {
        EXPECT_NE(plan.message.find("term 'limit'"), std::string::npos) << plan.message;
      }
    }
  }
}

struct DoubleIntegrator {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.1 * x[1] * x[1] * is_nonlinear};
  }
  double is_nonlinear = 0.0;
};

OptimalControlProblem with_idle_bounds(double bound, double is_nonlinear) {
  const auto position = [](auto, auto x) { return x[0]; };
  Phase<2, 1> phase{"move", DoubleIntegrator{is_nonlinear}, exactly(1.0)};
  phase.track(
      "effort", [](auto, auto, auto u) { return u[0]; }, VectorXd::Ones(1));
  phase.reach("there", position, exactly(1.0));
  if (bound < infinity)
    phase.bound_input(0, between(-bound, bound))
        .bound_state(1, between(-bound, bound))
        .keep("above", position, between(-bound, 2.0));
  OptimalControlProblem problem("idle");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}

TEST(Verdicts, InactiveBoundsAreNotMagnitudes) {
  for (const double is_nonlinear : {0.0, 1.0})
    for (const SolverChoice choice : all_solvers) {
      const Solution free = solved(with_idle_bounds(infinity, is_nonlinear), choice);
      ASSERT_TRUE(free.ok()) << free.message;
      for (const double bound : {1e3, 1e6, 1e8, 1e10, 1e15, 1e20, 1e30}) {
        const Solution plan = solved(with_idle_bounds(bound, is_nonlinear), choice);
        EXPECT_TRUE(plan.ok()) << name_of(choice) << " with " << bound << ": " << plan.message;
        EXPECT_NEAR(plan.cost, free.cost, 1e-6 * free.cost) << name_of(choice) << " " << bound;
      }
    }
}

// A soft target and a soft path limit.
OptimalControlProblem with_weights(double weight, Penalty::Kind kind, Bounds duration) {
  const auto position = [](auto, auto x) { return x[0]; };
  Phase<1, 1> phase{"move", [](auto, const auto&, const auto& u) { return u; }, duration};
  phase.guess_duration(1.0)
      .bound_input(0, between(-3.0, 3.0))
      .reach("there", position, exactly(1.0), soft("there", weight, kind))
      .keep(
          "slowly", [](auto, auto, auto u) { return u[0]; }, at_most(1.5), Window{},
          soft("slowly", weight, kind))
      .track(
          "effort", [](auto, auto, auto u) { return u[0]; }, VectorXd::Ones(1))
      .minimise_at_end("time", [](auto t, auto) { return 2.0 * t; });
  OptimalControlProblem problem("soft");
  problem.start_at(VectorXd::Zero(1)).then(phase);
  return problem;
}

// With hard constraints the cost is 1/(2 T) + 2 T: 2.5 for 1 s and 2 for the optimal duration of
// 0.5 s. The limit of 1.5 excludes that, so the optimum is 2.083333 for 2/3 s. An L2 penalty has an
// error of about 1 / weight.
TEST(Verdicts, PenaltyWeightsAreNotMagnitudes) {
  for (const bool is_free : {false, true})
    for (const Penalty::Kind kind : {Penalty::L1, Penalty::L2})
      for (const double weight : {1e4, 1e6, 1e8, 1e10, 1e12, 1e14})
        for (const SolverChoice choice : all_solvers) {
          const OptimalControlProblem problem =
              with_weights(weight, kind, is_free ? between(0.1, 3.0) : exactly(1.0));
          const Solution plan = solved(problem, choice);
          const double hard = is_free ? 0.75 + 4.0 / 3.0 : 2.5;
          EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << weight << ": " << plan.message;
          EXPECT_NEAR(plan.cost, hard, 2e-6 * hard + (kind == Penalty::L2 ? 10.0 / weight : 0.0))
              << name_of(choice) << " " << weight << (is_free ? ", free" : "");
        }
}

// An L1 penalty on an infeasible constraint is paid in full, for any weight.
TEST(Verdicts, ViolatedLargeWeightIsInTheCost) {
  const auto position = [](auto, auto x) { return x[0]; };
  for (const double weight : {1e2, 1e6, 1e10})
    for (const SolverChoice choice : all_solvers) {
      Phase<1, 1> phase{"move", [](auto, const auto&, const auto& u) { return u; }, exactly(1.0)};
      phase.bound_input(0, between(-1.0, 1.0))
          .reach("too far", position, exactly(3.0), soft("far", weight))
          .track(
              "effort", [](auto, auto, auto u) { return u[0]; }, VectorXd::Ones(1));
      OptimalControlProblem problem("soft");
      problem.start_at(VectorXd::Zero(1)).then(phase);
      const Solution plan = solved(problem, choice);
      EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << weight << ": " << plan.message;
      EXPECT_NEAR(plan.cost, 2.0 * weight + 0.5, 1e-6 * weight) << name_of(choice) << " " << weight;
    }
}

// An L2 penalty on a limit that cannot be kept, for weights that hide all other numbers. With the
// largest input of 1, the violation at time t is 2 - t. The start is given and not penalised.
TEST(Verdicts, UnavoidableQuadraticPenaltyIsSolvedForAnyWeight) {
  const auto position = [](auto, auto x) { return x[0]; };
  for (const double weight : {1e6, 1e10, 1e12, 1e14}) {
    for (const SolverChoice choice : all_solvers) {
      Phase<1, 1> phase{"move", [](auto, const auto&, const auto& u) { return u; }, exactly(1.0)};
      phase.bound_input(0, between(-1.0, 1.0))
          .keep("far", position, at_least(2.0), {}, soft("far", weight, Penalty::L2))
          .track(
              "effort", [](auto, auto, auto u) { return u[0]; }, VectorXd::Ones(1));
      OptimalControlProblem problem("soft");
      problem.start_at(VectorXd::Zero(1)).then(phase);
      const Solution plan = solved(problem, choice);
      ASSERT_TRUE(plan.ok()) << name_of(choice) << " " << weight << ": " << plan.message;
      double squares = 0.0;
      for (const Trajectory::Piece& piece : plan.trajectory.pieces())
        squares += 0.5 * piece.length * std::pow(2.0 - piece.end(), 2);
      EXPECT_NEAR(plan.cost, weight * squares + 0.5, 1e-7 * weight) << name_of(choice);
      for (const Trajectory::Piece& piece : plan.trajectory.pieces())
        EXPECT_NEAR(piece.coefficients[0], 1.0, 1e-6) << name_of(choice) << " " << weight;
    }
  }
}

// The end and the upper bounds leave only one input, and the lower bounds are placeholders.
TEST(Verdicts, ConstraintsWithoutInteriorAreSolvedForAnyPlaceholder) {
  const auto position = [](auto, auto x, auto...) { return x[0]; };
  for (const double far : {1e2, 1e7, 1e10, 1e12, 1e15})
    for (const double factor : {1.0, 2.0})
      for (const SolverChoice choice : all_solvers) {
        Phase<1, 1> phase{"move", [](auto, const auto&, const auto& u) { return u; }, exactly(1.0)};
        phase.bound_input(0, between(-far, 1.0))
            .keep(
                "scaled", [factor](auto, auto, auto u) { return factor * u[0]; },
                between(-far, 2.0))
            .reach("end", position, exactly(1.0))
            .track(
                "effort", [](auto, auto, auto u) { return u[0]; }, VectorXd::Ones(1));
        OptimalControlProblem problem("narrow");
        problem.start_at(VectorXd::Zero(1)).then(phase);
        const Solution plan = solved(problem, choice);
        EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << far << ": " << plan.message;
        EXPECT_NEAR(plan.cost, 0.5, 1e-6) << name_of(choice) << " " << far;
      }
}

// Stops at once, as on request of a user, and counts the solves.
class Stopped final : public Solver {
 public:
  explicit Stopped(SolveStatus status) : status_(status) {}
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool) override {
    ++solves;
    NlpResult result;
    result.status = status_;
    result.point = {start.w, VectorXd::Zero(program.rows()), VectorXd::Zero(program.variables())};
    result.iterations = 3;
    return result;
  }
  std::string name() const override { return "stopped"; }
  int solves = 0;

 private:
  SolveStatus status_;
};

TEST(Verdicts, StoppedSolveIsNotRestarted) {
  for (const SolveStatus status :
       {SolveStatus::time_limit, SolveStatus::interrupted, SolveStatus::infeasible}) {
    MultipleShooting shooting(with_weights(1e10, Penalty::L1, exactly(1.0)),
                              {.integrator = runge_kutta4(), .automatic_scale = false});
    Stopped solver(status);
    const Solution s = solve(shooting, solver);
    EXPECT_EQ(s.status, status);
    EXPECT_EQ(solver.solves, 1);
    EXPECT_EQ(s.iterations, 3);
    double cost = 0.0;
    shooting.nlp().objective(s.point.w.data(), cost);
    EXPECT_EQ(s.cost, cost);  // with the weights of the problem
  }
}

// Forces of up to 2 N per kg are at their bounds for any mass. The guess of zero gives no magnitude
// of a force, and the native solvers cycle in the units of large masses: they must detect the cycle
// (the limit is 500 iterations).
OptimalControlProblem push(double mass) {
  Phase<2, 1> phase{"push",
                    [=](auto, auto x, auto u) {
                      return decltype(x){x[1], u[0] / mass - 1e-3 * sin(x[0])};
                    },
                    exactly(1.5)};
  phase.bound_input(0, between(-2.0 * mass, 2.0 * mass))
      .minimise("effort", [=](auto, auto, auto u) { return u[0] * u[0] / (mass * mass); })
      .reach("there", [](auto, auto x) { return x; }, {exactly(1.0), exactly(0.0)});
  OptimalControlProblem problem("push");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}

TEST(Verdicts, SolvesForceBoundsForAnyMass) {
  const double cost = solved(push(1.0), SolverChoice::ipopt).cost;
  for (const double mass : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e4, 1e5, 1e6, 1e7})
    for (const SolverChoice choice : all_solvers) {
      const Solution plan = solved(push(mass), choice);
      if (choice != SolverChoice::ipopt) {
        EXPECT_LT(plan.iterations, 300) << name_of(choice) << " " << mass;
      }
      EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << mass << ": " << plan.message;
      EXPECT_NEAR(plan.cost, cost, 1e-6 * cost) << name_of(choice) << " " << mass;
    }
}

// The step towards the rows must respect the bounds of many inputs at once.
TEST(Verdicts, SolvesForceBoundsOnFineGrids) {
  for (const int intervals : {40, 80}) {
    const auto solved_on_grid = [&](double mass, SolverChoice choice) {
      return solve(push(mass), {.intervals_per_phase = intervals,
                                .solver = make_solver(choice, {.tolerance = 1e-8})});
    };
    const double cost = solved_on_grid(1.0, SolverChoice::sparse).cost;
    for (const double mass : {1e5, 1e7})
      for (const SolverChoice choice : {SolverChoice::sparse, SolverChoice::riccati}) {
        const Solution plan = solved_on_grid(mass, choice);
        EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << mass << ": " << plan.message;
        EXPECT_NEAR(plan.cost, cost, 1e-6 * cost) << name_of(choice) << " " << mass;
      }
  }
}

// Rest to rest over 1 m in minimum time, 2 s with |u| <= 1, with a unit of time of 1 / unit s.
TEST(Verdicts, OptimumIsIndependentOfUnits) {
  for (const double unit : {1e-8, 1e-4, 1.0, 1e4, 1e8})
    for (const SolverChoice choice : all_solvers) {
      Phase<2, 1> phase{"move",
                        [=](auto, const auto& x, const auto& u) {
                          return std::decay_t<decltype(x)>{x[1] / unit, u[0] / unit};
                        },
                        between(0.1 * unit, 10.0 * unit)};
      phase.guess_duration(unit)
          .bound_input(0, between(-1.0, 1.0))
          .reach(
              "rest", [](auto, auto x) { return x; },
              std::vector<Bounds>{exactly(1.0), exactly(0.0)})
          .minimise_at_end("time", [](auto t, auto) { return t; });
      OptimalControlProblem problem("least time");
      problem.start_at({0.0, 0.0}).then(phase);
      const Solution plan = solved(problem, choice, 1e-9);
      EXPECT_TRUE(plan.ok()) << name_of(choice) << " " << unit << ": " << plan.message;
      EXPECT_NEAR(plan.cost / unit, 2.0, 1e-5) << name_of(choice) << " " << unit;
    }
}

// An arm of two links whose hand stays on a line. The equations contain sines and cosines, as in
// whole-body problems, and the guess is a state at rest.
OptimalControlProblem arm() {
  const auto hand = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    return Vec<S, 2>{cos(x[0]) + 0.8 * cos(x[0] + x[1]), sin(x[0]) + 0.8 * sin(x[0] + x[1])};
  };
  const double elbow = 1.2, turn = 0.3;
  const double x0 = std::cos(turn) + 0.8 * std::cos(turn + elbow),
               y0 = std::sin(turn) + 0.8 * std::sin(turn + elbow);
  Phase<2, 2> phase{"arm", [](auto, auto, auto u) { return decltype(u){u}; }, between(0.5, 4.0)};
  phase.bound_input(0, between(-2.0, 2.0))
      .bound_input(1, between(-2.0, 2.0))
      .keep(
          "line", [=](auto, auto x) { return hand(x)[1] - 0.5 * (hand(x)[0] - x0); }, exactly(y0))
      .reach(
          "there", [=](auto, auto x) { return hand(x)[0]; }, exactly(x0 - 1.2))
      .minimise("effort", [](auto, auto, auto u) { return u.dot(u) + 0.1; })
      .guess_state(Guess::constant(Vec<double, 2>{turn, elbow}))
      .guess_duration(1.0);
  OptimalControlProblem problem("arm");
  problem.start_at({turn, elbow}).then(phase);
  return problem;
}

// A solve may stop anywhere. The reported residual decides whether it is called an optimum, and all
// of its iterations are counted.
TEST(Verdicts, StoppedSolveStatusFollowsItsResidual) {
  constexpr double tolerance = 1e-6, acceptable = 100.0 * tolerance;
  for (const SolverChoice choice : all_solvers)
    for (const Curvature curvature : {Curvature::exact, Curvature::gauss_newton})
      for (const int most : {1, 2, 3, 5, 7, 9, 12, 15, 20, 30, 50}) {
        const auto solver =
            choice == SolverChoice::ipopt
                ? make_ipopt(
                      {.tolerance = tolerance, .max_iterations = most, .curvature = curvature})
                : make_native_solver(
                      {.tolerance = tolerance,
                       .max_iterations = most,
                       .curvature = curvature,
                       .qp = choice == SolverChoice::sparse ? sparse_qp() : riccati_qp()});
        int iterations = 0;
        solver->set_observer({.report = [&](const SolveObserver::Iteration& now) {
          iterations += now.number > 0 && !now.is_restoring ? 1 : 0;
        }});
        MultipleShooting shooting(arm(), {.intervals_per_phase = 12, .integrator = runge_kutta4()});
        const Solution plan = solve(shooting, *solver);
        SCOPED_TRACE(std::string(name_of(choice)) + " " + std::to_string(most) + ": " +
                     plan.message);
        const bool is_called_stationary = plan.ok() || plan.status == SolveStatus::coarse_grid ||
                                          plan.status == SolveStatus::no_minimum ||
                                          plan.status == SolveStatus::wrong_crossing;
        if (is_called_stationary) {
          EXPECT_LE(plan.kkt.scaled(), acceptable);
        }
        if (plan.status == SolveStatus::iteration_limit) {
          EXPECT_EQ(plan.message.find("the iteration limit was reached"), 0u);
        }
        // The first report of each attempt describes its start.
        EXPECT_GE(plan.iterations, iterations - 4);
      }
}

}  // namespace
}  // namespace saltus
