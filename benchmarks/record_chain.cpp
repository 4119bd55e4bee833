// Writes data/hanging_chain.json: the chain at rest with its end at the reference, and the same
// chain after the robot has moved its end with the velocity (-1, 1, 1) m/s for one second.
//
// Usage: record_chain FILE
#include <fmt/format.h>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "benchmarks/hanging_chain.hpp"
#include "saltus/app/program.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/make_function.hpp"

namespace {

using namespace saltus;
using namespace saltus::bench;

constexpr int nx = HangingChain::nx, nu = HangingChain::nu, unknowns = 3 * HangingChain::between;
using State = Vec<double, nx>;

// Newton's method for the equilibrium positions, from a slightly hanging chain.
State at_rest(const Function& dynamics) {
  VectorXd z = VectorXd::Zero(1 + nx + nu);
  for (int i = 0; i <= HangingChain::between; ++i) {
    const double fraction = (i + 1.0) / (HangingChain::between + 1.0);
    z[1 + 3 * i] = HangingChain::end_position * fraction;
    z[1 + 3 * i + 2] = -2.0 * fraction * (1.0 - fraction);
  }
  constexpr double still = 1e-13;  // m/s^2: rounding of terms of the size of gravity
  for (int step = 0; step < 50; ++step) {
    const VectorXd acceleration = dynamics(z).tail(unknowns);
    if (acceleration.cwiseAbs().maxCoeff() < still) return z.segment(1, nx);
    const MatrixXd jacobian =
        dynamics.dense_jacobian(z).block(HangingChain::end + 3, 1, unknowns, unknowns);
    z.segment(1, unknowns) -= jacobian.partialPivLu().solve(acceleration);
  }
  throw std::runtime_error("the equilibrium of the chain was not found");
}

std::string line_of(const State& x) {
  return nlohmann::json(std::vector<double>(x.begin(), x.end())).dump();
}

std::string record() {
  IntervalProblem interval;
  interval.arguments = {nx, nu, 0};
  interval.dynamics = make_function<nx, nu, 0>(HangingChain{});
  const State reference = at_rest(interval.dynamics);
  // Much finer than the model of the benchmark.
  const auto integrator = runge_kutta4({.steps = 1000})->make(interval);
  VectorXd w(integrator->arguments().size()), end(nx);
  w << reference, Vec<double, 3>(-1.0, 1.0, 1.0), 0.0, 1.0;
  if (integrator->value(w.data(), end.data()) != IntegrationStatus::success)
    throw std::runtime_error("the chain could not be integrated");
  return fmt::format(
      "{{\n  \"about\": \"The hanging chain of five masses, written by record_chain: positions of "
      "masses 1 to 4 (m), velocities of masses 1 to 3 (m/s).\",\n  \"reference\": {},\n"
      "  \"start\": {}\n}}\n",
      line_of(reference), line_of(end));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw InputError("record_chain needs one argument, the file to write");
  const std::filesystem::path file = argv[1];
  const OutputFolder folder(file.has_parent_path() ? file.parent_path() : ".");
  folder.write(file.filename().string(), std::string_view(record()));
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "record_chain: {}\n", error.what());
  return 1;
}
