#include "saltus/robots/centroidal/centroidal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "saltus/autodiff/dual.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"

namespace saltus {
namespace {

using Vec3 = Vec<double, 3>;
using Mat3 = Mat<double, 3, 3>;

Mat3 hat(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

struct Sample {
  robots::SoleFrame left = robots::flat_sole({0.0, 0.07, 0.0}, 0.2);
  robots::SoleFrame right = robots::flat_sole({0.05, -0.15, 0.0}, -0.4);
  Vec<double, 9> gamma;
  Vec<double, 6> f_l, f_r;

  explicit Sample(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    for (double& e : gamma) e = u(random);
    gamma[2] += 0.53;
    for (double& e : f_l) e = 50 * u(random);
    for (double& e : f_r) e = 50 * u(random);
  }
  std::array<robots::Contact<double>, 2> contacts() const {
    return {contact(left, f_l), contact(right, f_r)};
  }
};

TEST(Centroidal, StandingStillIsAnEquilibrium) {
  const double mass = 33.0;
  Vec<double, 6> f = Vec<double, 6>::Zero();
  f[2] = mass * robots::standard_gravity / 2;
  Vec<double, 9> gamma = Vec<double, 9>::Zero();
  gamma[2] = 0.53;
  const std::array feet{contact(robots::flat_sole({0, 0.07, 0}), f),
                        contact(robots::flat_sole({0, -0.07, 0}), f)};
  EXPECT_LT(robots::centroidal_dynamics(mass, gamma, feet).norm(), 1e-13);
  const Vec<double, 9> pushed = robots::centroidal_dynamics(mass, gamma, feet, Vec3(0, -66, 0));
  EXPECT_NEAR(pushed[4], -2.0, 1e-13);
  EXPECT_NEAR(pushed.norm(), 2.0, 1e-13);  // no other component changes
}

TEST(Centroidal, ForceAtTheSoleHasAMomentAboutTheCom) {
  // 100 N along x at a point 0.5 m below the CoM: H' = (0, 0, -0.5) x (100, 0, 0) = (0, -50, 0).
  Vec<double, 6> f = Vec<double, 6>::Zero();
  f[0] = 100.0;
  const std::array foot{contact(robots::SoleFrame{}, f)};
  EXPECT_EQ(robots::angular_momentum_rate(Vec3(0, 0, 0.5), foot), Vec3(0, -50, 0));
  // The foot turned by 90 degrees pushes along world y: (0, 0, -0.5) x (0, 100, 0) = (50, 0, 0).
  const std::array turned{contact(robots::flat_sole({0, 0, 0}, 0.5 * 3.14159265358979323846), f)};
  EXPECT_LT((robots::angular_momentum_rate(Vec3(0, 0, 0.5), turned) - Vec3(50, 0, 0)).norm(),
            1e-12);
}

TEST(Centroidal, LinearisedFormMatchesThePaper) {
  const double mass = 33.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Sample s(seed);
    s.left = robots::flat_sole(s.left.position);
    s.right = robots::flat_sole(s.right.position);
    const Vec3 x0(0.015, 0.07, 0.53), fl0(3, -4, 300), fr0(-2, 1, 20);
    Mat<double, 9, 9> A = Mat<double, 9, 9>::Zero();
    A.block<3, 3>(0, 3).setIdentity();
    A.block<3, 3>(6, 0) = hat(fl0 + fr0);
    Mat<double, 9, 12> B = Mat<double, 9, 12>::Zero();
    B.block<3, 3>(3, 0) = Mat3::Identity() / mass;
    B.block<3, 3>(3, 6) = Mat3::Identity() / mass;
    B.block<3, 3>(6, 0) = hat(s.left.position - x0);
    B.block<3, 3>(6, 3).setIdentity();
    B.block<3, 3>(6, 6) = hat(s.right.position - x0);
    B.block<3, 3>(6, 9).setIdentity();
    Vec<double, 9> c = Vec<double, 9>::Zero();
    c[5] = -robots::standard_gravity;
    c.tail<3>() = -hat(fl0 + fr0) * x0;
    Vec<double, 12> f;
    f << s.f_l, s.f_r;
    const Vec<double, 9> ours = robots::linearised_centroidal_dynamics(
        mass, s.gamma, s.contacts(), robots::ExpansionPoint<double>{x0, fl0 + fr0});
    EXPECT_LT((ours - (A * s.gamma + B * f + c)).cwiseAbs().maxCoeff(), 1e-12) << "seed " << seed;
  }
}

TEST(Centroidal, LinearisationErrorIsTheProductOfTheDeviations) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Sample s(seed);
    const auto contacts = s.contacts();
    const Vec3 x = s.gamma.head<3>();
    const Vec3 total = contacts[0].force + contacts[1].force;
    const robots::ExpansionPoint<double> about{Vec3(0.01, 0.02, 0.5), Vec3(1, 2, 300)};
    const Vec3 difference = robots::angular_momentum_rate(x, contacts) -
                            robots::angular_momentum_rate(x, contacts, about);
    const Vec3 expected = -(x - about.com).cross(total - about.force);
    EXPECT_LT((difference - expected).norm(), 1e-11) << "seed " << seed;
    // With either deviation zero the two forms agree.
    EXPECT_LT(
        (robots::angular_momentum_rate(x, contacts) -
         robots::angular_momentum_rate(x, contacts, robots::ExpansionPoint<double>{x, about.force}))
            .norm(),
        1e-11);
  }
}

TEST(Centroidal, MomentumAboutAFixedPointObeysTheMomentBalance) {
  // d/dt (H + c x m v) = sum tau_i + x_i x f_i + c x m g about the origin, for any motion of the
  // CoM c.
  const double mass = 33.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Sample s(seed);
    const robots::CentroidalState<double> state(s.gamma);
    const robots::CentroidalState<double> rate(
        robots::centroidal_dynamics(mass, s.gamma, s.contacts()));
    const Vec3 about_origin = rate.angular_momentum + state.com.cross(mass * rate.velocity);
    Vec3 moments = state.com.cross(mass * Vec3(0, 0, -robots::standard_gravity));
    for (const auto& c : s.contacts()) moments += c.torque + c.position.cross(c.force);
    EXPECT_LT((about_origin - moments).norm(), 1e-11) << "seed " << seed;
    EXPECT_EQ(rate.com, state.velocity);
  }
}

// The left foot is rotated by 90 degrees: its x axis is the world's y axis. The right foot is in
// the air.
TEST(CentroidalPlant, StanceFootExertsTheCommandedWrenchInItsAxes) {
  const double mass = 2.0;
  Vec<double, 9> start = Vec<double, 9>::Zero();
  start[2] = 0.5;
  robots::CentroidalPlant plant(mass, start, runge_kutta4({.steps = 10}));
  plant.foot(robots::Side::left) = {robots::flat_sole({0.0, 0.0, 0.0}, std::acos(0.0)), true};
  EXPECT_EQ(&std::as_const(plant).foot(robots::Side::left), &plant.left);
  EXPECT_EQ(&plant.foot(robots::Side::right), &plant.right);
  Vec<double, 12> wrenches = Vec<double, 12>::Constant(7.0);
  wrenches.head<6>() << 4.0, 0.0, mass * robots::standard_gravity, 0.0, 3.0, 0.0;
  // Sums of two products, each rounded.
  constexpr double rounding = 1e-14;
  EXPECT_LT(
      (plant.contact_force(wrenches) - Vec3(0.0, 4.0, mass * robots::standard_gravity)).norm(),
      rounding);
  plant.push = Vec3(2.0, 0.0, 0.0);
  const double t = 0.1;
  ASSERT_EQ(plant.advance(t, wrenches), IntegrationStatus::success);
  const Vec3 acceleration(1.0, 2.0, 0.0);
  EXPECT_LT((plant.state().head<3>() - Vec3(0.0, 0.0, 0.5) - 0.5 * t * t * acceleration).norm(),
            rounding);
  EXPECT_LT((plant.state().segment<3>(3) - t * acceleration).norm(), rounding);
  // About the CoM, which moves by a t^2 / 2: (0, 0, -0.5) x (0, 4, .) = (2, 0, 0), the torque of
  // 3 about the world's -x, and the moment of the vertical force. The integral of t^2 / 2 is t^3
  // / 6.
  const Vec3 weight(0.0, 4.0, mass * robots::standard_gravity);
  const Vec3 momentum =
      t * Vec3(2.0 - 3.0, 0.0, 0.0) - t * t * t / 6.0 * acceleration.cross(weight);
  EXPECT_LT((plant.state().tail<3>() - momentum).norm(), rounding);
}

TEST(Centroidal, FlatFootHasTheSparsityOfThePaper) {
  Vec<Tracer, 9> gamma;
  Vec<Tracer, 6> wrench;
  Vec<Tracer, 3> com_0, force_0;
  for (int i = 0; i < 9; ++i) gamma[i] = Tracer::input(i);
  for (int i = 0; i < 6; ++i) wrench[i] = Tracer::input(9 + i);
  for (int i = 0; i < 3; ++i) {
    com_0[i] = Tracer::input(15 + i);
    force_0[i] = Tracer::input(18 + i);
  }
  const std::array foot{contact(robots::flat_sole({0.1, 0.07, 0}), wrench)};
  const auto inputs_of = [](const Tracer& result) {
    std::vector<int> list;
    result.inputs().for_each([&](int i) { list.push_back(i); });
    return list;
  };
  using List = std::vector<int>;
  const Vec<Tracer, 9> exact = robots::centroidal_dynamics(33.0, gamma, foot);
  EXPECT_EQ(inputs_of(exact[0]), List({3}));
  EXPECT_EQ(inputs_of(exact[4]), List({10}));
  EXPECT_EQ(inputs_of(exact[6]), List({1, 2, 10, 11, 12}));  // y, z; fy, fz; tx
  EXPECT_EQ(inputs_of(exact[8]), List({0, 1, 9, 10, 14}));   // x, y; fx, fy; tz

  const Vec<Tracer, 9> affine = robots::linearised_centroidal_dynamics(
      33.0, gamma, foot, robots::ExpansionPoint<Tracer>{com_0, force_0});
  EXPECT_EQ(inputs_of(affine[6]), List({1, 2, 10, 11, 12, 16, 17, 19, 20}));
  // Affine in state and wrench: they multiply parameters only.
  for (int row = 0; row < 9; ++row)
    affine[row].for_each_pair(
        [](int i, int j) { EXPECT_TRUE(i >= 15 && j < i) << i << ", " << j; });
}

TEST(Centroidal, YawedFootCouplesHorizontalForces) {
  Vec<Tracer, 6> wrench;
  for (int i = 0; i < 6; ++i) wrench[i] = Tracer::input(i);
  const robots::Contact<Tracer> yawed = contact(robots::flat_sole({0, 0, 0}, 0.3), wrench);
  EXPECT_TRUE(yawed.force[0].inputs().contains(1));
  EXPECT_FALSE(yawed.force[0].inputs().contains(2));
  EXPECT_FALSE(yawed.force[2].inputs().contains(0));
}

}  // namespace
}  // namespace saltus
