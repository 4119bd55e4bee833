// A solution between nodes, at events and as CSV.
#include "saltus/transcription/solution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

struct Growth {  // x' = x + u
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return x + u;
  }
};

struct Carried {  // the state of the second phase has two entries
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1] + u[0], u[1]};
  }
};

class Course : public testing::Test {
 protected:
  Course() : shooting(problem(), {.intervals = {4, 2}, .integrator = runge_kutta8()}) {
    solution = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  }
  static OptimalControlProblem problem() {
    Phase<1, 1> first{"growth", Growth{}, exactly(1.0)};
    first.track("effort", input, Vec<double, 1>{1.0})
        .inputs(InputParametrisation::piecewise_linear);
    Phase<2, 2> then{"carried", Carried{}, exactly(0.5)};
    then.track("effort", input, Vec<double, 2>{1.0, 1.0})
        .reach("end", state, {exactly(1.0), exactly(0.0)});
    OptimalControlProblem ocp("trajectory");
    ocp.start_time(2.0).start_at({0.5}).then(first).then(
        then, jump<1>("split", [](const auto&, const auto& x) {
          return std::decay_t<decltype(x)>(x).template replicate<2, 1>().eval();
        }));
    return ocp;
  }
  MultipleShooting shooting;
  Solution solution;
};

TEST_F(Course, DenseOutputSatisfiesTheDifferentialEquation) {
  ASSERT_TRUE(solution.ok()) << solution.message;
  const Trajectory& c = solution.trajectory;
  const double h = 1e-5;  // central differences: 1e-10
  for (double t = 2.03; t < 2.99; t += 0.0371) {
    const double rate = (c.state(t + h)[0] - c.state(t - h)[0]) / (2.0 * h);
    EXPECT_NEAR(rate, c.state(t)[0] + c.input(t)[0], 1e-6) << t;  // kinks of u at nodes: h |du|
  }
}

TEST_F(Course, PassesThroughItsNodesFromBothSides) {
  const Trajectory& c = solution.trajectory;
  for (const Trajectory::Piece& piece : c.pieces()) {
    EXPECT_LT((c.state(piece.start) - piece.state).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_LT((c.state_before(piece.end()) - piece.end_state).cwiseAbs().maxCoeff(), 1e-15);
  }
  for (double t = 2.1; t < 2.99; t += 0.1)
    EXPECT_LT((c.state_before(t) - c.state(t)).cwiseAbs().maxCoeff(), 1e-8) << t;
}

TEST_F(Course, IsRightContinuousAtTheEvent) {
  const Trajectory& c = solution.trajectory;
  EXPECT_EQ(c.state_before(3.0).size(), 1);
  EXPECT_EQ(c.state(3.0).size(), 2);
  EXPECT_EQ(c.input(3.0).size(), 2);
  EXPECT_NEAR(c.state(3.0)[1], c.state_before(3.0)[0], 1e-9);
}

TEST_F(Course, IsConstantOutsideItsEnds) {
  const Trajectory& c = solution.trajectory;
  EXPECT_EQ(c.state(-5.0), c.pieces().front().state);
  EXPECT_EQ(c.state(99.0), c.final_state());
  EXPECT_EQ(c.input(-5.0), c.input(2.0));
}

TEST_F(Course, CsvHasEveryNodeAndBothSidesOfTheEvent) {
  std::ostringstream out;
  solution.trajectory.write_csv(out, 2);
  std::istringstream in(out.str());
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  EXPECT_EQ(lines.front(), "t,phase,x0,x1,u0,u1");
  ASSERT_EQ(lines.size(), 1u + (4 * 2 + 1) + (2 * 2 + 1));
  EXPECT_EQ(lines[1].substr(0, 9), "2,growth,");
  EXPECT_EQ(lines[9].substr(0, 9), "3,growth,");
  EXPECT_EQ(lines[10].substr(0, 10), "3,carried,");
  for (const std::string& line : lines)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 5) << line;
  // Numbers that are read back equal those that were written.
  EXPECT_EQ(std::stod(lines[1].substr(9)), 0.5);
}

// On a clock that counts from the epoch, times have a resolution of 0.2 us. That is much less than
// these intervals of 2 ms.
TEST(TrajectoryOnAClock, IsIndependentOfTheClockOrigin) {
  const auto problem = [](double start) {
    Phase<1, 1> phase{"growth", Growth{}, exactly(0.012)};
    phase.track("effort", input, Vec<double, 1>{1.0}).reach("end", state, {exactly(1.0)});
    OptimalControlProblem ocp("clock");
    ocp.start_time(start).start_at({0.5}).then(phase);
    return ocp;
  };
  const ShootingOptions options{.intervals_per_phase = 6, .integrator = runge_kutta8()};
  std::vector<VectorXd> inputs;
  for (const double start : {0.0, 1.7e9}) {
    MultipleShooting shooting(problem(start), options);
    const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
    ASSERT_TRUE(s.ok()) << s.message;
    VectorXd& u = inputs.emplace_back(6);
    for (int k = 0; k < 6; ++k) {
      u[k] = s.trajectory.input(start + 0.002 * (k + 0.5))[0];
      EXPECT_EQ(u[k], s.trajectory.pieces()[k].coefficients[0]) << "interval " << k;
      EXPECT_EQ(s.trajectory.state(start + 0.002 * k), s.trajectory.pieces()[k].state) << k;
    }
    const NlpPoint guess = shooting.guess_from(s.trajectory);
    EXPECT_LT((guess.w - s.point.w).cwiseAbs().maxCoeff(), 1e-9);
  }
  // Lengths of intervals are offsets and do not depend on the clock. Only the tolerance of the
  // solver remains.
  EXPECT_LT((inputs[0] - inputs[1]).cwiseAbs().maxCoeff(), 1e-6 * inputs[0].norm());
}

}  // namespace
}  // namespace saltus
