#include "benchmarks/random_programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : generator_(seed) {}
  // The numbers of std::uniform_real_distribution would depend on the standard library.
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(generator_() >> 11) * 0x1.0p-53);
  }
  int one_of(int count) { return static_cast<int>(between(0.0, count)); }
  bool says(double probability) { return between(0.0, 1.0) < probability; }

 private:
  std::mt19937_64 generator_;
};

// x_i' = A x + B u + c + amplitude sin(wave' x) + product x_j u_k
template <int nx, int nu>
struct Field {
  std::array<std::array<double, nx>, nx> A{}, wave{};
  std::array<std::array<double, nu>, nx> B{};
  std::array<double, nx> c{}, amplitude{}, product{};
  std::array<int, nx> j{}, k{};

  template <class S>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    Vec<S, nx> rate;
    for (int i = 0; i < nx; ++i) {
      S sum = c[i] + product[i] * x[j[i]] * u[k[i]], phase = wave[i][0] * x[0];
      for (int l = 0; l < nx; ++l) sum = sum + A[i][l] * x[l];
      for (int l = 0; l < nu; ++l) sum = sum + B[i][l] * u[l];
      for (int l = 1; l < nx; ++l) phase = phase + wave[i][l] * x[l];
      rate[i] = sum + amplitude[i] * sin(phase);
    }
    return rate;
  }
};

template <int nx, int nu>
Field<nx, nu> random_field(Dice& dice) {
  Field<nx, nu> f;
  for (int i = 0; i < nx; ++i) {
    for (int l = 0; l < nx; ++l) {
      f.A[i][l] = dice.between(-0.8, 0.8);
      f.wave[i][l] = dice.between(-1.5, 1.5);
    }
    for (int l = 0; l < nu; ++l) f.B[i][l] = dice.between(-1.5, 1.5);
    f.c[i] = dice.between(-0.5, 0.5);
    f.amplitude[i] = dice.between(-1.0, 1.0);
    f.product[i] = dice.between(-0.5, 0.5);
    f.j[i] = dice.one_of(nx);
    f.k[i] = dice.one_of(nu);
  }
  return f;
}

// x+ = x + shift + bend sin(x), entry by entry
template <int nx>
struct Reset {
  std::array<double, nx> shift{}, bend{};

  template <class S, class X>
  auto operator()(const S&, const X& x) const {
    auto after = x.eval();
    for (int i = 0; i < nx; ++i) after[i] = x[i] + shift[i] + bend[i] * sin(x[i]);
    return after;
  }
};

template <int nx, int nu>
RandomProgram make(Dice& dice, bool contradicts) {
  using State = Vec<double, nx>;
  using Input = Vec<double, nu>;
  const int phases = 1 + dice.one_of(3), intervals = 8 + dice.one_of(13);
  const int contradicting = contradicts ? dice.one_of(phases) : -1;
  const int kind = dice.one_of(3);
  const bool total_is_given = dice.says(0.5);
  RandomProgram result;
  result.options = {.intervals_per_phase = intervals, .integrator = runge_kutta4()};

  State x;
  for (int i = 0; i < nx; ++i) x[i] = dice.between(-1.0, 1.0);
  OptimalControlProblem ocp("random");
  ocp.start_at(VectorXd(x)).costs(dice.says(0.5) ? CostRule::integrated : CostRule::nodes);
  double total = 0.0;
  for (int p = 0; p < phases; ++p) {
    const auto field = random_field<nx, nu>(dice);
    const double T = dice.between(0.4, 1.5);
    total += T;
    Reset<nx> reset;
    for (int i = 0; i < nx; ++i) {
      reset.shift[i] = dice.between(-0.3, 0.3);
      reset.bend[i] = dice.between(-0.5, 0.5);
    }
    const bool jumps = p > 0 && dice.says(0.7);
    if (jumps) x = reset(0.0, x);

    // A feasible trajectory, with the scheme and the grid of the program.
    std::vector<State> nodes{x};
    const double h = T / intervals;
    for (int n = 0; n < intervals; ++n) {
      Input u;
      for (int i = 0; i < nu; ++i) u[i] = dice.between(-0.8, 0.8);
      const State k1 = field(0.0, x, u), k2 = field(0.0, State(x + 0.5 * h * k1), u);
      const State k3 = field(0.0, State(x + 0.5 * h * k2), u);
      const State k4 = field(0.0, State(x + h * k3), u);
      x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      nodes.push_back(x);
    }
    const bool is_free = dice.says(0.6);
    Phase<nx, nu> phase{fmt::format("phase {}", p + 1), field,
                        is_free ? between(0.5 * T, 1.5 * T) : exactly(T)};
    phase.guess_duration(is_free ? dice.between(0.7, 1.3) * T : T);
    for (int i = 0; i < nu; ++i) phase.bound_input(i, between(-1.0, 1.0));

    State aim;
    std::array<double, nx> weight{}, ripple{};
    for (int i = 0; i < nx; ++i) {
      aim[i] = dice.between(-1.5, 1.5);
      weight[i] = dice.between(0.0, 2.0);
      ripple[i] = dice.says(0.3) ? dice.between(0.0, 0.5) : 0.0;
    }
    const double effort = dice.between(0.01, 1.0), rent = total_is_given ? 0.0 : 0.5;
    phase.minimise("cost", [=](const auto&, const auto& state, const auto& u) {
      auto sum = rent + 0.5 * effort * u[0] * u[0];
      for (int i = 1; i < nu; ++i) sum = sum + 0.5 * effort * u[i] * u[i];
      for (int i = 0; i < nx; ++i) {
        const auto off = state[i] - aim[i];
        sum = sum + 0.5 * weight[i] * off * off + ripple[i] * cos(3.0 * state[i]);
      }
      return sum;
    });

    for (int i = 0; i < nx; ++i) {
      if (!dice.says(0.3)) continue;
      double low = nodes[0][i], high = nodes[0][i];
      for (const State& node : nodes) {
        low = std::min(low, node[i]);
        high = std::max(high, node[i]);
      }
      phase.bound_state(i, between(low - dice.between(0.05, 0.5), high + dice.between(0.05, 0.5)));
    }
    if (dice.says(0.5)) {  // outside a disc
      const double a = dice.between(-1.0, 1.0), b = dice.between(-1.0, 1.0);
      const auto distance = [=](const auto&, const auto& state) {
        return (state[0] - a) * (state[0] - a) + (state[1] - b) * (state[1] - b);
      };
      double least = std::numeric_limits<double>::infinity();
      for (const State& node : nodes) least = std::min(least, distance(0.0, node));
      phase.keep("disc", distance, at_least(dice.between(0.3, 0.95) * least));
    }
    if (dice.says(0.5)) {  // inside a curved region
      const double a = dice.between(-1.0, 1.0), b = dice.between(-1.0, 1.0);
      const auto edge = [=](const auto&, const auto& state) {
        return state[0] + a * state[1] * state[1] + b * sin(2.0 * state[nx - 1]);
      };
      double most = -std::numeric_limits<double>::infinity();
      for (const State& node : nodes) most = std::max(most, edge(0.0, node));
      phase.keep("edge", edge, at_most(most + dice.between(0.02, 0.5)));
    }
    if (p + 1 == phases)
      for (int i = 0; i < nx; ++i)
        if (dice.says(0.4))
          phase.reach(
              fmt::format("end {}", i), [i](const auto&, const auto& state) { return state[i]; },
              exactly(x[i]));

    if (p == contradicting) {
      result.contradiction = "contradiction";
      if (kind == 0)  // beyond the reach of the inputs
        phase.reach(
            "contradiction", [](const auto&, const auto& state) { return state[0]; },
            at_least(200.0));
      else if (kind == 1)  // a circle with a negative radius
        phase.keep(
            "contradiction",
            [](const auto&, const auto& state) {
              return state[0] * state[0] + state[1] * state[1];
            },
            at_most(-0.1));
      else  // a sine above 1
        phase.reach(
            "contradiction", [](const auto&, const auto& state) { return sin(state[1]); },
            exactly(1.2));
    }
    if (jumps)
      ocp.then(phase, jump<nx>("reset", reset));
    else
      ocp.then(phase);
  }
  if (total_is_given) ocp.total_time(exactly(total));
  result.problem = std::move(ocp);
  return result;
}

RandomProgram any_size(unsigned seed, bool contradicts) {
  Dice dice(seed);
  return dice.says(0.5) ? make<2, 1>(dice, contradicts) : make<4, 2>(dice, contradicts);
}

}  // namespace

RandomProgram random_program(unsigned seed) { return any_size(seed, false); }
RandomProgram contradictory_program(unsigned seed) { return any_size(seed, true); }

}  // namespace saltus
