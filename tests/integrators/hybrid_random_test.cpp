// Compares derivatives through events with differences and with each other on random hybrid
// systems.
//
// Fields are affine. Guards are quadratic in the state and depend on time, input and parameter.
// Resets are nonlinear. In an accepted system, every event is transversal: |g_x f-| >= 0.1 |g_x|
// |f-|. Its events are at least 10 ms apart from each other and from the ends of the interval.
// Other systems are counted and redrawn.
#include <array>
#include <random>

#include "saltus/integrators/hybrid_integrator.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "tests/integrators/hybrid_problems.hpp"
#include "tests/integrators/support.hpp"
#include "tests/support/sanitized.hpp"

namespace saltus {
namespace {

using namespace test;

constexpr int nx = 3, nu = 1, np = 1;

// The coefficients of one system. Formulas that are made once read them.
struct Draw {
  std::array<Eigen::Matrix3d, 2> A;
  std::array<Eigen::Vector3d, 2> a, b;
  Eigen::Matrix3d Q;     // guard: x'Qx + n'x + 0.2 t - 0.3 u + 0.4 p - level
  Eigen::Vector3d n, r;  // reset: x + 0.1 r (sin(x_0) + x_1 x_2 + 0.5 t u p)
  double level = 0.0;
};

struct Field {
  const Draw* draw;
  int mode;
  template <class S>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u,
                        const Vec<S, np>& p) const {
    Vec<S, nx> rate;
    for (int i = 0; i < nx; ++i) {
      rate[i] = draw->a[mode][i] * p[0] + draw->b[mode][i] * u[0];
      for (int j = 0; j < nx; ++j) rate[i] += draw->A[mode](i, j) * x[j];
    }
    return rate;
  }
};

struct Guard {
  const Draw* draw;
  template <class S>
  S operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u, const Vec<S, np>& p) const {
    S g = 0.2 * t - 0.3 * u[0] + 0.4 * p[0] - draw->level;
    for (int i = 0; i < nx; ++i) {
      g += draw->n[i] * x[i];
      for (int j = 0; j < nx; ++j) g += draw->Q(i, j) * x[i] * x[j];
    }
    return g;
  }
};

struct Reset {
  const Draw* draw;
  template <class S>
  Vec<S, nx> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u,
                        const Vec<S, np>& p) const {
    const S kick = 0.1 * (sin(x[0]) + x[1] * x[2] + 0.5 * t * u[0] * p[0]);
    Vec<S, nx> after;
    for (int i = 0; i < nx; ++i) after[i] = x[i] + kick * draw->r[i];
    return after;
  }
};

// There is one mode change, so the reset may lead to any state.
IntervalProblem random_problem(const Draw* draw, InputShape shape) {
  Automaton<nx, nu, np> system;
  system.mode("first", Field{draw, 0})
      .mode("second", Field{draw, 1})
      .event("jump", "first", "second", Guard{draw}, Crossing::rising, Reset{draw});
  return hybrid_problem(system, shape);
}

class RandomSystem {
 public:
  explicit RandomSystem(unsigned seed) : random_(seed) {}

  void draw(Draw& d, VectorXd& w, InputShape shape) {
    for (int m = 0; m < 2; ++m) {
      d.A[m] = Eigen::Matrix3d::NullaryExpr([&] { return any(); });
      d.a[m] = Eigen::Vector3d::NullaryExpr([&] { return any(); });
      d.b[m] = Eigen::Vector3d::NullaryExpr([&] { return any(); });
    }
    d.Q = Eigen::Matrix3d::NullaryExpr([&] { return 0.5 * any(); });
    d.n = Eigen::Vector3d::NullaryExpr([&] { return any(); });
    d.r = Eigen::Vector3d::NullaryExpr([&] { return any(); });
    w = VectorXd::NullaryExpr(shape == InputShape::constant ? 7 : 8, [&] { return any(); });
    w.tail(2) << 0.5 + 0.3 * any(), 0.6 + 0.2 * any();
    d.level = 0.5 + 0.5 * any();
  }

 private:
  double any() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }
  std::mt19937 random_;
};

constexpr double margin = 0.01;  // s

TEST(HybridRandom, DerivativesOfAThousandSystemsMatchDifferences) {
  constexpr unsigned seed = 20261121;
  constexpr int wanted = sanitized ? 100 : 1000;  // the tests are not optimised under sanitizers
  Draw d;
  int accepted = 0, rejected = 0, failed = 0;
  double worst_rk = 0.0, worst_cvodes = 0.0, worst_state = 0.0;
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    RandomSystem source(seed + (shape == InputShape::linear));
    VectorXd w, end(nx), end_cvodes(nx);
    source.draw(d, w, shape);
    const IntervalProblem problem = random_problem(&d, shape);
    // 24 steps of order eight: the local error is below 1e-13 for these fields, as measured below.
    const auto rk = runge_kutta8({.steps = 24})->make(problem);
    const auto multistep = cvodes({.method = CvodesOptions::Method::Adams,
                                   .tolerance = 1e-13,
                                   .absolute_tolerance = 1e-13})
                               ->make(problem);
    auto& hybrid = dynamic_cast<HybridIntegrator&>(*rk);
    std::vector<HybridEvent> events;
    for (int i = 0; i < wanted / 2;) {
      source.draw(d, w, shape);
      events.clear();
      hybrid.record(&events);
      hybrid.start_in(0);
      const IntegrationStatus status = rk->value(w.data(), end.data());
      hybrid.record(nullptr);
      // One event, away from both ends, that crosses the guard transversally.
      const double t0 = w[w.size() - 2], h = w[w.size() - 1];
      bool usable = status == IntegrationStatus::success && events.size() == 1 &&
                    events[0].time > t0 + margin && events[0].time < t0 + h - margin &&
                    end.norm() < 20.0;
      if (usable) {
        VectorXd z(problem.arguments.size());
        const double s = (events[0].time - t0) / h;
        const double u = shape == InputShape::constant ? w[nx] : (1 - s) * w[nx] + s * w[nx + 1];
        z << events[0].time, events[0].before, u, w[w.size() - 3];
        const VectorXd f = problem.switching.modes[0].dynamics(z);
        const VectorXd g_x =
            problem.switching.transitions[0].guard.dense_jacobian(z).middleCols(1, nx).transpose();
        usable = std::abs(g_x.dot(f)) >= 0.1 * g_x.norm() * f.norm();
      }
      if (!usable) {
        ++rejected;
        ASSERT_LT(rejected, 100 * wanted);
        continue;
      }
      ++i;
      ++accepted;
      // Far below the change that moves an event over a margin, and far above rounding: 1e-14 /
      // 5e-5.
      const MatrixXd expected = differences(
          [&](const VectorXd& at) {
            VectorXd x(nx);
            if (rk->value(at.data(), x.data()) != IntegrationStatus::success) ++failed;
            return x;
          },
          w, 5e-5);
      const MatrixXd by_rk = jacobian_of(*rk, w);
      dynamic_cast<HybridIntegrator&>(*multistep).start_in(0);
      MatrixXd by_cvodes(nx, w.size());
      ASSERT_EQ(multistep->jacobian(w.data(), end_cvodes.data(), by_cvodes),
                IntegrationStatus::success)
          << multistep->failure();
      const double size = std::max(1.0, expected.cwiseAbs().maxCoeff());
      worst_rk = std::max(worst_rk, (by_rk - expected).cwiseAbs().maxCoeff() / size);
      worst_cvodes = std::max(worst_cvodes, (by_cvodes - expected).cwiseAbs().maxCoeff() / size);
      worst_state = std::max(worst_state, (end - end_cvodes).cwiseAbs().maxCoeff());
      EXPECT_LE((by_rk - expected).cwiseAbs().maxCoeff(), 1e-7 * size)
          << "seed " << seed << ", system " << accepted << "\ngiven\n"
          << by_rk << "\ndifferences\n"
          << expected;
      EXPECT_LE((by_cvodes - expected).cwiseAbs().maxCoeff(), 1e-7 * size)
          << "seed " << seed << ", system " << accepted;
    }
  }
  EXPECT_EQ(accepted, wanted);
  EXPECT_EQ(failed, 0);
  std::printf(
      "seed %u: %d systems, %d draws rejected; worst relative error of derivatives %.1e (Runge-"
      "Kutta 8), %.1e (CVODES); end states differ by %.1e\n",
      seed, accepted, rejected, worst_rk, worst_cvodes, worst_state);
}

class HybridDiscrete : public testing::TestWithParam<HybridScheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, HybridDiscrete,
                         testing::Values(HybridScheme{"rk4", runge_kutta4({.steps = 2})},
                                         HybridScheme{"gauss4", gauss_legendre({.steps = 2})},
                                         HybridScheme{"radau5",
                                                      radau_iia({.stages = 3, .steps = 2})}),
                         [](const auto& param) { return param.param.name; });

TEST_P(HybridDiscrete, DerivativesOfFirstAndSecondOrderAreExact) {
  // With two coarse steps, the scheme is far from the flow. Its derivatives are those of the
  // discrete map.
  constexpr unsigned seed = 7;
  Draw d;
  RandomSystem source(seed);
  VectorXd w, end(nx);
  source.draw(d, w, InputShape::linear);
  const IntervalProblem problem = random_problem(&d, InputShape::linear);
  const auto rk = GetParam().choice->make(problem);
  ASSERT_TRUE(rk->has_hessian());
  auto& hybrid = dynamic_cast<HybridIntegrator&>(*rk);
  std::vector<HybridEvent> events;
  int accepted = 0;
  double worst = 0.0, worst_second = 0.0;
  for (int i = 0; i < 2000 && accepted < 50; ++i) {
    source.draw(d, w, InputShape::linear);
    events.clear();
    hybrid.record(&events);
    hybrid.start_in(0);
    const bool ok = rk->value(w.data(), end.data()) == IntegrationStatus::success;
    hybrid.record(nullptr);
    const double t0 = w[w.size() - 2], h = w[w.size() - 1];
    if (!ok || events.size() != 1 || events[0].time < t0 + 0.05 || events[0].time > t0 + h - 0.05 ||
        std::abs(events[0].time - t0 - 0.5 * h) < 0.05)
      continue;
    const MatrixXd given = jacobian_of(*rk, w);
    if (given.cwiseAbs().maxCoeff() > 20.0) continue;  // nearly tangent: differences are inaccurate
    ++accepted;
    const MatrixXd expected =
        differences([&](const VectorXd& at) { return end_of(*rk, at); }, w, 5e-4);
    worst = std::max(worst, (given - expected).cwiseAbs().maxCoeff());
    EXPECT_LE((given - expected).cwiseAbs().maxCoeff(), 1e-8) << "seed " << seed << ", draw " << i;

    const VectorXd weights = vec({0.7, -1.3, 0.4});
    const MatrixXd second = hessian_of(*rk, w, weights);
    const MatrixXd expected_second = differences(
        [&](const VectorXd& at) -> VectorXd { return jacobian_of(*rk, at).transpose() * weights; },
        w, 2e-4);
    const double size = std::max(1.0, second.cwiseAbs().maxCoeff());
    worst_second = std::max(worst_second, (second - expected_second).cwiseAbs().maxCoeff() / size);
    EXPECT_LE((second - expected_second).cwiseAbs().maxCoeff(), 1e-6 * size)
        << "seed " << seed << ", draw " << i << "\ngiven\n"
        << second << "\ndifferences\n"
        << expected_second;
  }
  EXPECT_EQ(accepted, 50);
  std::printf("seed %u: worst error %.1e, of second derivatives %.1e relative\n", seed, worst,
              worst_second);
}

}  // namespace
}  // namespace saltus
