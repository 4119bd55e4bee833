// Estimate of the swing foot's contact.
#include "saltus/robots/whole_body/contact_estimator.hpp"

#include <gtest/gtest.h>

namespace saltus::robots {
namespace {

constexpr double earliest = 1.0, landing = 1.2, ground = 0.01;  // s, s, m

ContactEstimator expecting(bool is_estimated) {
  ContactEstimator estimator({.is_estimated = is_estimated});
  estimator.expect(earliest, landing, ground);
  return estimator;
}

bool has_landed(ContactEstimator estimator, const ContactEstimator::Evidence& now) {
  estimator.update(now);
  return estimator.has_landed();
}

TEST(ContactEstimator, ForceAloneDecidesWithoutAnEstimate) {
  const ContactEstimator estimator = expecting(false);
  EXPECT_FALSE(has_landed(estimator, {0.99, 500.0, ground, 0.0}));  // too early
  EXPECT_TRUE(has_landed(estimator, {1.0, 20.0, 0.05, 0.5}));
  EXPECT_FALSE(has_landed(estimator, {1.0, 19.9, 0.05, 0.5}));
}

TEST(ContactEstimator, HeightTimeAndSpeedSpeakAgainstAContact) {
  const ContactEstimator estimator = expecting(true);
  EXPECT_TRUE(has_landed(estimator, {1.2, 20.0, ground, 0.05}));
  EXPECT_TRUE(has_landed(estimator, {1.3, 20.0, ground - 0.01, 0.05}));  // late, below
  // Each unit of height, time and speed needs 5 N more.
  for (const ContactEstimator::Evidence& now :
       {ContactEstimator::Evidence{1.2, 0.0, ground + 0.01, 0.05},
        {1.15, 0.0, ground, 0.05},
        {1.2, 0.0, ground, 0.15}}) {
    ContactEstimator::Evidence felt = now;
    felt.force = 24.9;
    EXPECT_FALSE(has_landed(estimator, felt));
    felt.force = 25.1;
    EXPECT_TRUE(has_landed(estimator, felt));
  }
  // Enough force convinces on any ground.
  EXPECT_TRUE(has_landed(estimator, {1.0, 66.0, ground + 0.1, 1.0}));
}

TEST(ContactEstimator, ProbabilityRisesWithTheForce) {
  ContactEstimator estimator = expecting(true);
  EXPECT_EQ(estimator.probability(), 0.0);
  estimator.update({1.2, 20.0, ground, 0.0});
  EXPECT_EQ(estimator.probability(), 0.5);
  estimator.update({1.201, 25.0, ground, 0.0});
  EXPECT_NEAR(estimator.probability(), 0.731059, 1e-6);  // odds e to 1
}

TEST(ContactEstimator, LosesAContactAfterAGrace) {
  ContactEstimator estimator = expecting(true);
  double t = 1.2;
  const auto update = [&](double force, int steps) {
    for (int i = 0; i < steps; ++i) estimator.update({t += 1e-3, force, ground, 0.0});
  };
  update(100.0, 5);
  update(0.0, 4);  // a bounce
  update(100.0, 1);
  update(0.0, 4);
  EXPECT_FALSE(estimator.is_lost());
  update(0.0, 2);
  EXPECT_TRUE(estimator.is_lost());
}

}  // namespace
}  // namespace saltus::robots
