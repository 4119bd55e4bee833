// Verdicts of solve() on plans that satisfy their program but violate their problem.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

const auto drift = [](auto, const auto&, const auto& u) { return u; };
const auto input = [](auto, auto, auto u) { return u; };

// A path of `length` metres past a pillar that lies between nodes, slightly off the straight line.
OptimalControlProblem past_pillar(double length, double radius) {
  const double at = length / 2.0 + length / 60.0;
  Phase<2, 2> phase{"drive", drift, exactly(10.0)};
  phase
      .keep(
          "pillar",
          [=](auto, auto x) { return (x[0] - at) * (x[0] - at) + (x[1] - 0.01) * (x[1] - 0.01); },
          at_least(radius * radius))
      .reach("goal", [](auto, auto x) { return x; }, {exactly(length), exactly(0.0)})
      .track("effort", input, VectorXd{{1.0, 1.0}});
  OptimalControlProblem ocp("robot");
  ocp.start_at({0, 0}).then(phase);
  return ocp;
}

TEST(Verdict, RejectsAPlanThatPassesAPillarBetweenNodes) {
  for (const double length : {20.0, 50.0, 200.0}) {
    const Solution s = solve(past_pillar(length, 0.01 * length));
    EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
    ASSERT_TRUE(s.verification.has_value());
    const Verification::Miss& miss = s.verification->between_nodes;
    EXPECT_EQ(miss.term, "pillar");
    // The plan is a straight line that passes 0.01 m from the centre.
    EXPECT_NEAR(miss.amount, 1e-4 * length * length - 1e-4, 2e-3 * miss.amount) << length;
    EXPECT_NE(s.message.find("'pillar' of phase 'drive'"), std::string::npos) << s.message;
  }
}

// A wall of 5 to 12 mm half width and 1 m height on a path of 50 m. An interval is 1.67 m long.
TEST(Verdict, LocatesAThinWall) {
  for (const double half_width : {0.005, 0.008, 0.012}) {
    for (const int shape : {0, 1, 2}) {
      const double at = 25.0 + 0.731;
      Phase<2, 2> phase{"drive", drift, exactly(10.0)};
      phase
          .keep(
              "wall",
              [=](auto, auto x) {
                const auto d = (x[0] - at) / half_width;
                if (shape == 0) return x[1] - exp(-d * d);
                if (shape == 1) return x[1] - 1.0 / (1.0 + d * d * d * d);
                return x[1] - max(0.0 * d, 1.0 - abs(d));
              },
              at_least(-0.1))
          .reach("goal", [](auto, auto x) { return x; }, {exactly(50.0), exactly(0.0)})
          .track("effort", input, VectorXd{{1.0, 1.0}});
      OptimalControlProblem ocp("robot");
      ocp.start_at({0, 0}).then(phase);
      const Solution s = solve(ocp);
      EXPECT_EQ(s.status, SolveStatus::coarse_grid) << shape << " " << s.message;
      ASSERT_TRUE(s.verification.has_value());
      EXPECT_NEAR(s.verification->between_nodes.amount, 0.9, 0.02) << half_width << " " << shape;
      // The speed is 5 m/s. The tolerance is the time over the half width.
      EXPECT_NEAR(s.verification->between_nodes.time, at / 5.0, half_width / 5.0);
    }
  }
}

// x' = x + u over 30 s: errors of rounding and integration grow by e^30.
TEST(Verdict, ReportsAnUnstableHorizon) {
  Phase<1, 1> phase{
      "a",
      [](auto, const auto& x, const auto& u) { return std::decay_t<decltype(x)>(x[0] + u[0]); },
      exactly(30.0)};
  phase
      .reach(
          "r", [](auto, auto x) { return x[0]; }, exactly(0.0))
      .track("u", input, VectorXd{{1.0}});
  OptimalControlProblem ocp("unstable");
  ocp.start_at({1}).then(phase);
  const Solution s = solve(ocp, {.integrator = runge_kutta8({.steps = 4})});
  EXPECT_TRUE(s.ok()) << s.message;
  ASSERT_TRUE(s.verification.has_value());
  const Verification::OpenLoop& loop = s.verification->open_loop;
  EXPECT_NEAR(loop.growth, std::exp(30.0), 1e-3 * std::exp(30.0));
  double x = 1.0;
  for (int k = 0; k < 30; ++k)
    x = std::exp(1.0) * x + (std::exp(1.0) - 1.0) * s.trajectory.input(k + 0.5)[0];
  EXPECT_GT(std::abs(x), 1.0);
  EXPECT_NEAR(loop.end.amount, std::abs(x), 0.2 * std::abs(x));
  EXPECT_EQ(loop.end.term, "r");
  EXPECT_NE(s.message.find("the inputs, integrated from the start"), std::string::npos)
      << s.message;
  EXPECT_NE(s.message.find("e+13"), std::string::npos) << s.message;
}

// A moderate growth also moves the end, far beyond its tolerance of 1e-6. Without growth, the same
// scheme misses the end by less than its integration error.
TEST(Verdict, ReportsAModerateGrowthOfErrors) {
  for (const double rate : {1.0, 2.0})
    for (const double growth : {1.0, 1e3, 1e4, 1e5}) {
      const double T = growth > 1.0 ? std::log(growth) / rate : 1.0;
      const double slope = growth > 1.0 ? rate : -rate;
      Phase<1, 1> phase{"a",
                        [slope](auto, const auto& x, const auto& u) {
                          return std::decay_t<decltype(x)>(slope * x[0] + u[0]);
                        },
                        exactly(T)};
      phase
          .reach(
              "r", [](auto, auto x) { return x[0]; }, exactly(0.0))
          .track("u", input, VectorXd{{1.0}});
      OptimalControlProblem ocp("unstable");
      ocp.start_at({1}).then(phase);
      const Solution s = solve(ocp);
      ASSERT_TRUE(s.ok()) << s.message;
      double x = 1.0;
      for (const Trajectory::Piece& piece : s.trajectory.pieces()) {
        const double e = std::exp(slope * piece.length);
        x = e * x + (e - 1.0) / slope * piece.coefficients[0];
      }
      const bool misses = s.message.find("miss 'r' of phase 'a' by") != std::string::npos;
      EXPECT_EQ(misses, growth > 1.0) << growth << ": " << x << ", " << s.message;
      if (growth == 1e3) {
        EXPECT_LT(std::abs(x), GridAccuracy{}.open_loop);  // stated in the units of the end
      }
    }
}

// x' = u + size sin^2(frequency pi t) to x = 1, with least effort.
Solution solve_forced(double size, double frequency) {
  Phase<1, 1> phase{"a",
                    [=](auto t, const auto& x, const auto& u) {
                      const auto s = sin(std::numbers::pi * frequency * t);
                      return std::decay_t<decltype(x)>(u[0] + size * s * s);
                    },
                    exactly(1.0)};
  phase
      .reach(
          "r", [](auto, auto x) { return x[0]; }, exactly(1.0))
      .track("u", input, VectorXd{{1.0}});
  OptimalControlProblem ocp("aliased");
  ocp.start_at({0}).then(phase);
  return solve(ocp);
}

// A small forcing that every sample misses: no interval has a large error, and their sum moves the
// end. The system does not amplify it.
TEST(Verdict, RejectsIntegrationErrorsThatMoveTheEnd) {
  for (const double size : {1e-3, 3e-3}) {
    const Solution s = solve_forced(size, 120.0);
    ASSERT_TRUE(s.verification.has_value());
    EXPECT_NEAR(s.verification->open_loop.end.amount, size / 2.0, 1e-2 * size);
    EXPECT_LT(s.verification->defect.largest, GridAccuracy{}.defect);
    EXPECT_EQ(s.ok(), size / 2.0 < GridAccuracy{}.integration) << s.message;
    EXPECT_NE(s.message.find(s.ok() ? "optimum" : "miss 'r' of phase 'a'"), std::string::npos)
        << s.message;
  }
}

// The same in two phases. The errors of each phase alone are within the tolerance.
TEST(Verdict, RejectsIntegrationErrorsOfSeveralPhases) {
  const auto part = [](const char* name) {
    return Phase<1, 1>{name,
                       [](auto t, const auto& x, const auto& u) {
                         const auto s = sin(std::numbers::pi * 120.0 * t);
                         return std::decay_t<decltype(x)>(u[0] + 1.6e-3 * s * s);
                       },
                       exactly(1.0)};
  };
  Phase<1, 1> first = part("a"), second = part("b");
  first.track("u", input, VectorXd{{1.0}});
  second
      .reach(
          "r", [](auto, auto x) { return x[0]; }, exactly(1.0))
      .track("u", input, VectorXd{{1.0}});
  OptimalControlProblem ocp("aliased twice");
  ocp.start_at({0}).then(first).then(second);
  const Solution s = solve(ocp);
  EXPECT_NEAR(s.verification.value_or(Verification{}).open_loop.end.amount, 1.6e-3, 2e-5);
  EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
}

// The forcing has whole periods in an interval of the grid and in an integrator step, so all
// samples have the same phase.
TEST(Verdict, DetectsForcingAtTheGridFrequency) {
  for (const double per_interval : {2.0, 4.0, 8.0}) {
    const Solution s = solve_forced(1.0, 30.0 * per_interval);
    EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.cost << " " << s.message;
    EXPECT_GT(s.verification->defect.largest, 1e-3);
  }
}

// The same for a cost whose quadrature samples only one phase.
TEST(Verdict, DetectsACostAtTheGridFrequency) {
  Phase<1, 1> phase{"a", drift, exactly(1.0)};
  phase
      .reach(
          "r", [](auto, auto x) { return x[0]; }, exactly(1.0))
      .minimise("u", [](auto t, auto, auto u) {
        const auto s = sin(std::numbers::pi * 120.0 * t);
        return 0.5 * u[0] * u[0] + s * s;
      });
  OptimalControlProblem ocp("aliased cost");
  ocp.start_at({0}).then(phase).costs(CostRule::integrated);
  const Solution s = solve(ocp);
  EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
  EXPECT_NEAR(s.cost, 0.5, 1e-6);
  EXPECT_NEAR(s.verification->cost.value, 1.0, 1e-5);
  EXPECT_NE(s.message.find("cost"), std::string::npos) << s.message;
}

// A peak in the dynamics or in the cost, which no stage of any scheme touches. Its area is 1.
TEST(Verdict, DetectsAPeakBetweenTheStages) {
  const auto peak = [](double width) {
    return [width](const auto& t) {
      const auto z = (t - 0.5123) / width;
      return exp(-0.5 * z * z) / (width * std::sqrt(2.0 * std::numbers::pi));
    };
  };
  for (const double width : {1e-3, 1e-4, 1e-5, 1e-7})
    for (const bool is_cost : {false, true}) {
      const auto f = peak(width);
      Phase<1, 1> phase{"a",
                        [f, is_cost](auto t, const auto& x, const auto& u) {
                          return std::decay_t<decltype(x)>(u[0] + (is_cost ? 0.0 : 1.0) * f(t));
                        },
                        exactly(1.0)};
      phase
          .reach(
              "r", [](auto, auto x) { return x[0]; }, exactly(2.0))
          .minimise("u", [f, is_cost](auto t, auto, auto u) {
            return 0.5 * u[0] * u[0] + (is_cost ? 1.0 : 0.0) * f(t);
          });
      OptimalControlProblem ocp("peak");
      ocp.start_at({0}).then(phase);
      const Solution s = solve(ocp);
      EXPECT_EQ(s.status, SolveStatus::coarse_grid) << width << ": " << s.message;
      if (is_cost) {
        EXPECT_NEAR(s.verification.value().cost.value, 3.0, 1e-4) << width;
      } else {
        EXPECT_NEAR(s.verification.value().defect.absolute, 1.0, 1e-2) << width;
      }
    }
}

// The brachistochrone along a wall. The heading makes many turns within the first interval.
struct Bead {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    return {x[2] * cos(u[0]), x[2] * sin(u[0]), sin(u[0])};
  }
};

TEST(Verdict, DetectsAHeadingThatTurnsWithinAnInterval) {
  // From rest to (1, 1) in 2 s with an input that turns by 76 rad in one interval.
  Phase<3, 1> phase{"bead", Bead{}, exactly(1.0)};
  phase.inputs(InputParametrisation::piecewise_linear)
      .bound_input(0, unbounded())
      .minimise("nothing", [](auto, auto, auto u) { return 1e-9 * u[0] * u[0]; })
      .guess_input(Guess::interpolate(VectorXd{{0.0}}, VectorXd{{76.0}}));
  OptimalControlProblem ocp("bead");
  ocp.start_at({0, 0, 1}).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 1, .integrator = runge_kutta8()});
  // The plan is the guess itself, with one interval that the transcription integrates.
  NlpPoint point = shooting.initial_guess();
  Trajectory guess = shooting.trajectory(point.w);
  Trajectory::Piece piece = guess.pieces().front();
  piece.coefficients = VectorXd{{0.0, 76.0}};
  Trajectory steep(guess.phases(), {piece});
  piece.end_state = steep.state_in(piece, piece.end() - 1e-12);
  const Solution s = [&] {
    const auto solver = make_native_solver({.max_iterations = 1});
    return solve(shooting, *solver, shooting.guess_from(Trajectory(guess.phases(), {piece})));
  }();
  ASSERT_TRUE(s.verification.has_value());
  EXPECT_GT(s.verification->defect.largest, 1e-3) << s.message;
}

TEST(Verdict, AllowWidensOneTermAndFactorsWidenAll) {
  Phase<2, 1> phase{"block",
                    [](const auto&, const auto& x, const auto& u) {
                      return std::decay_t<decltype(x)>{x[1], u[0]};
                    },
                    exactly(1.0)};
  phase.inputs(InputParametrisation::piecewise_linear_continuous)
      .minimise("effort", [](auto, auto, auto u) { return 0.5 * u[0] * u[0]; })
      .keep(
          "ceiling", [](auto, auto x) { return x[0]; }, at_most(0.2))
      .reach("ground", [](auto, auto x) { return x; }, {exactly(0.0), exactly(-1.0)});
  const auto solved = [&](const Phase<2, 1>& p, GridAccuracy accuracy) {
    OptimalControlProblem ocp("Bryson-Denham");
    ocp.start_at({0, 1}).then(p).costs(CostRule::integrated);
    MultipleShooting shooting(
        ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4(), .accuracy = accuracy});
    return solve(shooting, *make_native_solver());
  };
  const Solution strict = solved(phase, {});
  EXPECT_EQ(strict.status, SolveStatus::coarse_grid) << strict.message;
  const Verification::Miss miss = strict.verification->between_nodes;
  EXPECT_EQ(miss.term, "ceiling");
  EXPECT_NEAR(miss.tolerance, 1e-6, 1e-18);
  EXPECT_NEAR(miss.time, 0.5, 5e-3);  // the top is flat
  EXPECT_NEAR(miss.amount, strict.trajectory.state(0.5)[0] - 0.2, 1e-2 * miss.amount);
  EXPECT_TRUE(solved(phase, {.between_nodes = 1.1 * miss.amount / 1e-6}).ok());
  EXPECT_FALSE(solved(phase, {.between_nodes = 0.9 * miss.amount / 1e-6}).ok());
  EXPECT_FALSE(solved(phase, {.verify = false}).verification.has_value());
  Phase<2, 1> widened = phase;
  widened.allow("ceiling", 1.1 * miss.amount);
  EXPECT_TRUE(solved(widened, {}).ok());
  EXPECT_THROW(widened.allow("cieling", 0.1), DefinitionError);
  EXPECT_THROW(widened.allow("ceiling", -0.1), DefinitionError);
}

}  // namespace
}  // namespace saltus
