// Settling of forces, and the progress line.
#include "saltus/robots/walking/settling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "saltus/core/error.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/walking/progress.hpp"

namespace saltus::robots::walking {
namespace {

constexpr double period = 0.01;  // s
// Times and values are sums of hundreds of numbers of order 1.
constexpr double rounding = 1e-9;

struct Signal {
  std::vector<double> times, values;
  double settling(double begin, double band) const {
    return settling_time(times, values, begin, band);
  }
};

template <class F>
Signal sampled(double end, const F& f) {
  Signal s;
  for (int i = 0; i * period < end + 0.5 * period; ++i) {
    s.times.push_back(i * period);
    s.values.push_back(f(i * period));
  }
  return s;
}

TEST(Settling, ExponentialDecaySettlesAtTheExpectedTime) {
  const Signal s = sampled(12.0, [](double t) { return 100.0 + 50.0 * std::exp(-t); });
  // 50 exp(-t) = 5 at t = ln 10; the mean of the last second is 100 to within 6e-4.
  EXPECT_NEAR(s.settling(0.0, 5.0), std::log(10.0), period);
  EXPECT_NEAR(s.settling(1.0, 5.0), std::log(10.0) - 1.0, period);
  EXPECT_EQ(s.settling(0.0, 60.0), 0.0);
}

TEST(Settling, UsesTheLastEntryIntoTheBand) {
  // Inside the band, outside for one sample at 3.0 s, inside again.
  const Signal s = sampled(6.0, [](double t) { return std::abs(t - 3.0) < 1e-6 ? 2.0 : 0.0; });
  EXPECT_NEAR(s.settling(1.0, 1.0), 2.0 + period, rounding);
}

TEST(Settling, MeanIsWeightedByDuration) {
  // 0 is held for 0.9 s and 10 for 0.1 s: the mean is 1, and 0 lies within 2 of it. The plain mean
  // of the samples would be far away.
  Signal s{{0.0, 1.0, 2.0, 2.9, 2.95, 3.0}, {0.0, 0.0, 0.0, 10.0, 10.0, 0.0}};
  EXPECT_EQ(s.settling(0.0, 9.5), 0.0);
  EXPECT_EQ(s.settling(0.0, 8.9), infinity);
}

TEST(Settling, NeverSettlingIsInfinite) {
  const Signal s = sampled(6.0, [](double t) { return std::sin(20.0 * t); });
  EXPECT_EQ(s.settling(1.0, 0.5), infinity);
  EXPECT_EQ((Signal{{0.0}, {1.0}}).settling(0.0, 1.0), infinity);
}

TEST(Settling, RejectsMismatchedSizes) {
  EXPECT_THROW((Signal{{0.0, 1.0}, {1.0}}).settling(0.0, 1.0), DefinitionError);
}

RunLog landing_at(double touchdown) {
  RunLog log;
  log.robot.mass = 30.0;
  log.touchdown = touchdown;
  for (int i = 0; i < 600; ++i) {
    BipedSample s;
    s.time = i * period;
    s.gamma.setZero();
    s.capture_point.setZero();
    s.wrenches.setZero();
    s.push.setZero();
    // 5 % of the weight are 14.7 N; the left foot is outside the band until 0.5 s after the
    // landing.
    s.wrenches[2] = s.time < touchdown + 0.5 - same_instant ? 300.0 : 150.0;
    s.wrenches[8] = s.time < touchdown + 0.2 - same_instant ? 0.0 : 140.0;
    log.samples.push_back(s);
  }
  return log;
}

TEST(Settling, ForcesOfACentroidalRunCountFromTheGivenTime) {
  RunLog log = landing_at(2.0);
  ForceSettling settling = force_settling(log, 2.0);
  EXPECT_NEAR(settling.planned[0], 0.5, rounding);
  EXPECT_NEAR(settling.planned[1], 0.2, rounding);
  const ForceSettling later = force_settling(log, 2.3);  // after another landing, or a push
  EXPECT_NEAR(later.planned[0], 0.2, rounding);
  EXPECT_EQ(later.planned[1], 0.0);
  EXPECT_EQ(settling.measured[0], infinity);  // nothing is measured without a body
  settling.measured << 0.7, 0.9;
  const auto json = to_json(settling);
  EXPECT_EQ(json["planned_left_s"], settling.planned[0]);
  EXPECT_EQ(json["planned_right_s"], settling.planned[1]);
  EXPECT_EQ(json["measured_left_s"], 0.7);
  EXPECT_EQ(json["measured_right_s"], 0.9);
  log.stopped_early = true;
  EXPECT_EQ(force_settling(log, 2.0).planned[0], infinity);
  log.stopped_early = false;
  log.touchdown = infinity;
  EXPECT_EQ(force_settling(log, 2.0).planned[0], infinity);
}

// The log of a whole-body run contains planned forces and filtered means of the measured forces.
// The torques and all other forces never settle.
TEST(Settling, WholeBodyHasPlannedAndMeasuredForces) {
  RunLog log = landing_at(2.0);
  for (std::size_t i = 0; i < log.samples.size(); ++i) {
    const double t = log.samples[i].time, restless = i % 2 == 0 ? 1e3 : -1e3;
    const auto from = [&](double settled, double force) {
      return t < 2.0 + settled - same_instant ? 0.0 : force;
    };
    RunLog::BodySample b;
    b.planned.setConstant(restless);
    b.left.setConstant(restless);
    b.right.setConstant(restless);
    b.planned[2] = from(0.3, 150.0);
    b.planned[8] = from(0.4, 140.0);
    b.left[2] = from(0.5, 150.0);
    b.right[2] = from(0.6, 140.0);
    b.left_sole = b.right_sole = Eigen::Isometry3d::Identity();
    log.body.push_back(b);
  }
  const ForceSettling settling = force_settling(log, 2.0);
  // The filter averages two samples. With the second one the mean is in the band.
  EXPECT_NEAR(settling.planned[0], 0.3, rounding);
  EXPECT_NEAR(settling.planned[1], 0.4, rounding);
  EXPECT_NEAR(settling.measured[0], 0.5 + period, rounding);
  EXPECT_NEAR(settling.measured[1], 0.6 + period, rounding);
}

TEST(Progress, LineShowsTheSideOfTheCapturePoint) {
  EXPECT_EQ(progress_line({3.1, 0.534, -0.0213, LoopState::Footing::stepping}, 2.0),
            "t =  3.10 s |  1.6 x real time | CoM 0.534 m | capture point  21 mm outside | "
            "stepping");
  EXPECT_EQ(progress_line({0.0, 0.534, 0.0213, LoopState::Footing::standing}, 0.0),
            "t =  0.00 s |  0.0 x real time | CoM 0.534 m | capture point  21 mm inside | "
            "standing");
}

std::string shown(bool terminal) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* out = open_memstream(&text, &size);
  Progress progress(out, terminal);
  for (int i = 0; i <= 250; ++i)
    progress.show({i * period, 0.5, 0.01, LoopState::Footing::standing});
  progress.finish();
  std::fclose(out);
  const std::string all(text, size);
  std::free(text);
  return all;
}

TEST(Progress, PrintsOneLinePerSimulatedSecondWithoutATerminal) {
  const std::string text = shown(false);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);  // at 0, 1, 2 and the end, 2.5 s
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_NE(text.find("t =  2.50 s"), std::string::npos);
}

TEST(Progress, RewritesOneLineOnATerminal) {
  const std::string text = shown(true);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_EQ(text.front(), '\r');
  EXPECT_GT(text.find_last_of('\r'), 0u);  // the end is always shown, despite the limited rate
  EXPECT_NE(text.find("t =  2.50 s"), std::string::npos);
}

}  // namespace
}  // namespace saltus::robots::walking
