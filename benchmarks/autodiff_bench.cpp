// Measures the cost of Jacobians and Hessians of user formulas: three formulas of different
// structure, with make_function (sparse passes) and with every input seeded (without the passes).
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "saltus/model/make_function.hpp"

namespace {

using namespace saltus;

/// Two feet push a rigid body: x = (com 3, velocity 3, angular momentum 3), u = two wrenches
/// (force 3, torque 3). Sparse: every second derivative is one of com times force.
struct CentroidalDynamics {
  static constexpr int nx = 9, nu = 12;
  double mass = 33.06;  // kg
  Eigen::Vector3d left{0.0, 0.07, 0.0}, right{0.1, -0.15, 0.0}, gravity{0.0, 0.0, -9.81};

  template <class S>
  Vec<S, 9> operator()(const S&, const Vec<S, 9>& x, const Vec<S, 12>& u) const {
    const Vec<S, 3> com = x.template head<3>();
    const Vec<S, 3> f1 = u.template head<3>(), f2 = u.template segment<3>(6);
    Vec<S, 9> dx;
    dx.template head<3>() = x.template segment<3>(3);
    dx.template segment<3>(3) = (f1 + f2) / mass + gravity;
    dx.template tail<3>() = (left - com).cross(f1) + (right - com).cross(f2) +
                            u.template segment<3>(3) + u.template segment<3>(9);
    return dx;
  }
};

/// Three masses on springs under an anchor: x = (positions 9, velocities 9), u = force on the last.
/// Every neighbouring pair of positions interacts through a square root.
struct HangingChain {
  static constexpr int nx = 18, nu = 3;
  double mass = 0.03, stiffness = 1.0, length = 0.033;  // kg, N, m

  template <class S>
  Vec<S, 18> operator()(const S&, const Vec<S, 18>& x, const Vec<S, 3>& u) const {
    Vec<S, 3> pull[4];
    Vec<S, 3> above = Vec<S, 3>::Zero();
    for (int i = 0; i < 3; ++i) {
      const Vec<S, 3> here = x.template segment<3>(3 * i);
      const Vec<S, 3> along = here - above;
      pull[i] = along * (stiffness / mass * (1.0 - length / norm(along)));
      above = here;
    }
    pull[3] = u / mass;
    Vec<S, 18> dx;
    dx.template head<9>() = x.template tail<9>();
    for (int i = 0; i < 3; ++i) {
      dx.template segment<3>(9 + 3 * i) = pull[i + 1] - pull[i];
      dx[9 + 3 * i + 2] -= 9.81;
    }
    return dx;
  }
};

/// x = (position, angle, velocity, angular velocity), u = force: small, dense and trigonometric.
struct CartPole {
  static constexpr int nx = 4, nu = 1;
  double cart = 1.0, pole = 0.1, length = 0.8, gravity = 9.81;  // kg, kg, m, m/s^2

  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S s = sin(x[1]), c = cos(x[1]);
    const S den = cart + pole - pole * c * c;
    const S pull = pole * length * s * x[3] * x[3];
    return {x[2], x[3], (pole * gravity * c * s - pull + u[0]) / den,
            (u[0] * c - pull * c + (cart + pole) * gravity * s) / (length * den)};
  }
};

template <class Model>
VectorXd point() {
  return 0.5 * VectorXd::LinSpaced(1 + Model::nx + Model::nu, 0.2, 1.7);
}

template <class Model>
void value(benchmark::State& state) {
  const Function f = make_function<Model::nx, Model::nu, 0>(Model{});
  const VectorXd z = point<Model>();
  VectorXd y(f.outputs());
  for (auto _ : state) {
    f.value(z.data(), y.data());
    benchmark::DoNotOptimize(y.data());
    benchmark::ClobberMemory();
  }
}

template <class Model>
void jacobian(benchmark::State& state) {
  const Function f = make_function<Model::nx, Model::nu, 0>(Model{});
  const VectorXd z = point<Model>();
  VectorXd y(f.outputs());
  std::vector<double> entries(f.jacobian_pattern().entries());
  for (auto _ : state) {
    f.jacobian(z.data(), y.data(), entries.data());
    benchmark::DoNotOptimize(entries.data());
    benchmark::ClobberMemory();
  }
  state.counters["entries"] = f.jacobian_pattern().entries();
}

template <class Model>
void hessian(benchmark::State& state) {
  const Function f = make_function<Model::nx, Model::nu, 0>(Model{});
  const VectorXd z = point<Model>();
  const VectorXd weights = VectorXd::LinSpaced(f.outputs(), 0.5, 1.5);
  std::vector<double> entries(f.hessian_pattern().entries());
  for (auto _ : state) {
    f.hessian(z.data(), weights.data(), entries.data());
    benchmark::DoNotOptimize(entries.data());
    benchmark::ClobberMemory();
  }
  state.counters["entries"] = f.hessian_pattern().entries();
}

// One direction per state and input, as in a framework without patterns.
template <class Model>
void dense_jacobian(benchmark::State& state) {
  constexpr int nx = Model::nx, nu = Model::nu;
  using S = Dual<double, nx + nu>;
  const Model model;
  const VectorXd z = point<Model>();
  MatrixXd derivative(nx, nx + nu);
  for (auto _ : state) {
    Vec<S, nx> x;
    Vec<S, nu> u;
    for (int i = 0; i < nx; ++i) x[i] = S(z[1 + i], S::Tangent::unit(i));
    for (int i = 0; i < nu; ++i) u[i] = S(z[1 + nx + i], S::Tangent::unit(nx + i));
    const Vec<S, nx> dx = model(S(z[0]), x, u);
    for (int r = 0; r < nx; ++r)
      for (int c = 0; c < nx + nu; ++c) derivative(r, c) = dx[r].tangent[c];
    benchmark::DoNotOptimize(derivative.data());
    benchmark::ClobberMemory();
  }
}

template <class Model>
void dense_hessian(benchmark::State& state) {
  constexpr int nx = Model::nx, nu = Model::nu;
  using Inner = Dual<double, nx + nu>;
  using S = Dual<Inner, 1>;
  const Model model;
  const VectorXd z = point<Model>();
  MatrixXd derivative(nx + nu, nx + nu);
  for (auto _ : state) {
    for (int j = 0; j < nx + nu; ++j) {
      Vec<S, nx> x;
      Vec<S, nu> u;
      const auto seeded = [&](int i) {
        S s(Inner(z[1 + i], Inner::Tangent::unit(i)), S::Tangent::zero());
        s.tangent.set(0, i == j ? 1.0 : 0.0);
        return s;
      };
      for (int i = 0; i < nx; ++i) x[i] = seeded(i);
      for (int i = 0; i < nu; ++i) u[i] = seeded(nx + i);
      const Vec<S, nx> dx = model(S(z[0]), x, u);
      auto sum = dx[0].tangent[0].tangent;
      for (int r = 1; r < nx; ++r) sum += (0.5 + r) * dx[r].tangent[0].tangent;
      for (int i = 0; i < nx + nu; ++i) derivative(i, j) = sum[i];
    }
    benchmark::DoNotOptimize(derivative.data());
    benchmark::ClobberMemory();
  }
}

template <class Model>
void add(const std::string& name) {
  benchmark::RegisterBenchmark((name + "/value").c_str(), value<Model>);
  benchmark::RegisterBenchmark((name + "/jacobian").c_str(), jacobian<Model>);
  benchmark::RegisterBenchmark((name + "/hessian").c_str(), hessian<Model>);
  benchmark::RegisterBenchmark((name + "/jacobian, every input").c_str(), dense_jacobian<Model>);
  benchmark::RegisterBenchmark((name + "/hessian, every input").c_str(), dense_hessian<Model>);
}

}  // namespace

int main(int argc, char** argv) {
  add<CentroidalDynamics>("centroidal 9+12");
  add<HangingChain>("chain 18+3");
  add<CartPole>("cart-pole 4+1");
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
