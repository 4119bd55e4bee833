// A model with estimated mass and CoM, against a robot whose mass and CoM are known.
#include "saltus/robots/whole_body/corrected_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "saltus/robots/model/capture_point.hpp"
#include "tests/robots/synthetic_balance.hpp"
#include "tests/robots/tree_dynamics.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::robots {
namespace {

constexpr double step = 0.002;  // s

// The robot has a larger mass than the model, and its CoM is shifted in the axes of the base.
struct Balance {
  Balance(double factor, const Vec<double, 3>& shift, const MassEstimateOptions& options = {})
      : truth(with_com_shifted(with_masses_scaled(biped.robot, factor), shift)),
        corrected(std::make_unique<TreeDynamics>(biped.robot), biped.robot, options),
        state(biped.start) {
    update();
  }

  void update() {
    truth.update(state);
    corrected.update(state);
  }
  // Accelerates sideways (m/s^2) without turning, pushed at the CoM (N).
  void advance(double acceleration, double push) {
    CorrectedModel::GroundForce ground;
    ground.force = {0.0, truth.mass() * acceleration - push, truth.mass() * standard_gravity};
    ground.torque = truth.com().cross(ground.force);
    corrected.observe(step, ground);
    state.base.translation()[1] += step * (state.base_twist[4] + 0.5 * step * acceleration);
    state.base_twist[4] += step * acceleration;
    update();
  }
  void stand(double time) {
    for (double t = 0.0; t < time; t += step) advance(0.0, 0.0);
  }
  double com_error() const { return (corrected.com() - truth.com()).head<2>().norm(); }
  double mass_error() const { return std::abs(corrected.mass() / truth.mass() - 1.0); }

  walking::SyntheticBalance biped;
  TreeDynamics truth;
  CorrectedModel corrected;
  WholeBodyState state;
};

// exp(-12) of the error remains after 12 time constants.
constexpr double remaining = 1e-5;
// Sums of fourteen bodies in double precision, and at most exp(-25) of the error.
constexpr double rounding = 1e-9;

TEST(CorrectedModel, FindsMassAndCom) {
  Balance b(1.1, {0.01, -0.008, 0.0});
  EXPECT_NEAR(b.mass_error(), 0.1 / 1.1, 1e-6);
  EXPECT_NEAR(b.com_error(), 0.0128, 1e-4);
  b.stand(13.0);
  EXPECT_LT(b.mass_error(), remaining * 0.1);
  EXPECT_LT(b.com_error(), remaining * 0.0128);
}

// Only the inertia about the CoM of a robot with a shifted CoM is unknown.
TEST(CorrectedModel, HasTheDynamicsOfTheRobot) {
  for (const Vec<double, 3>& shift :
       {Vec<double, 3>(0.0, 0.0, 0.0), Vec<double, 3>(0.01, 0.02, 0.0)}) {
    Balance b(0.9, shift, {.longest = 0.2});
    b.stand(6.0);
    ASSERT_LT(b.com_error(), rounding);
    const bool turns = shift.isZero(0.0);
    for (int i = 0; i < 6; ++i) b.state.base_twist[i] = i < 3 && !turns ? 0.0 : 0.3 * (i - 2);
    for (int i = 0; i < b.state.dq.size(); ++i) b.state.dq[i] = std::sin(1.0 + i);
    b.update();
    const MatrixXd M = b.corrected.mass_matrix() - b.truth.mass_matrix();
    const double scale = b.truth.mass_matrix().cwiseAbs().maxCoeff();
    EXPECT_LT(M.rightCols(M.cols() - (turns ? 0 : 3)).cwiseAbs().maxCoeff(), rounding * scale);
    EXPECT_LT((b.corrected.bias() - b.truth.bias()).cwiseAbs().maxCoeff(),
              rounding * standard_gravity * scale);
    EXPECT_LT((b.corrected.com() - b.truth.com()).norm(), rounding);
    EXPECT_LT((b.corrected.com_velocity() - b.truth.com_velocity()).norm(), rounding);
    EXPECT_LT((b.corrected.angular_momentum() - b.truth.angular_momentum()).norm(), rounding);
  }
}

// The centre of pressure moves by 11 mm, the CoM at up to 0.05 m/s.
TEST(CorrectedModel, AllowsForAccelerations) {
  Balance b(1.0, Vec<double, 3>::Zero());
  for (double t = 0.0; t < 5.0; t += step) b.advance(0.2 * std::cos(4.0 * t), 0.0);
  EXPECT_LT(b.com_error(), 1e-4);  // first order in the step
  EXPECT_LT(b.mass_error(), 1e-4);
}

TEST(CorrectedModel, IgnoresPushes) {
  Balance b(1.0, Vec<double, 3>::Zero());
  b.stand(2.0);
  const double push = 70.0, acceleration = push / b.truth.mass();
  for (double t = 0.0; t < 0.1; t += step) b.advance(acceleration, push);
  EXPECT_LT(b.com_error(), rounding);
  for (double t = 0.0; t < 0.1; t += step) b.advance(-acceleration, -push);
  b.stand(1.0);
  EXPECT_LT(b.com_error(), rounding);
  EXPECT_LT(b.mass_error(), rounding);
}

TEST(CorrectedModel, KeepsItsBounds) {
  Balance b(1.5, {0.06, -0.05, 0.0});
  b.stand(5.0);
  const MassEstimateOptions options;
  EXPECT_NEAR(b.corrected.mass_factor(), 1.0 + options.most_mass, rounding);
  EXPECT_NEAR(b.corrected.com_shift().x(), options.most_offset, rounding);
  EXPECT_NEAR(b.corrected.com_shift().y(), -options.most_offset, rounding);
}

TEST(CorrectedModel, ForgetsTheEstimate) {
  Balance b(1.1, {0.01, -0.008, 0.0});
  b.stand(2.0);
  b.corrected.reset();
  EXPECT_EQ(b.corrected.mass_factor(), 1.0);
  EXPECT_TRUE(b.corrected.com_shift().isZero(0.0));
}

TEST(CorrectedModel, DoesNotAllocate) {
  Balance b(1.1, {0.01, -0.008, 0.0});
  const saltus::testing::AllocationCount count;
  b.stand(0.5);
  EXPECT_EQ(count.made(), 0);
}

}  // namespace
}  // namespace saltus::robots
