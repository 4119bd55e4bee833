#include "saltus/solve/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/quantities.hpp"

namespace saltus {
namespace {

void check(const OptimalControlProblem& problem, const SeveralSolutions::Start& start,
           std::size_t number) {
  const std::size_t phases = problem.phases().size();
  const auto fail = [&](const std::string& what) {
    throw DefinitionError(fmt::format("solve_from: start {}: {}", number, what));
  };
  const auto check_count = [&](std::size_t given, const char* what) {
    if (given != 0 && given != phases)
      fail(fmt::format("{} {} are given, but the problem has {} phases", given, what, phases));
  };
  check_count(start.durations.size(), "durations");
  check_count(start.states.size(), "guesses of states");
  check_count(start.inputs.size(), "guesses of inputs");
  for (std::size_t j = 0; j < start.durations.size(); ++j)
    if (const double T = start.durations[j];
        problem.phases()[j].has_free_duration() && !(T > 0.0 && std::isfinite(T)))
      fail(fmt::format("the duration of phase '{}' is {} s", problem.phases()[j].name, T));
  const auto check_guess = [&](const Guess& guess, int size, std::size_t j, const char* what) {
    if (!guess.is_given()) return;
    const VectorXd value = guess.at(0.0);
    if (value.size() != size || !value.allFinite())
      fail(fmt::format(
          "the {} of phase '{}' have {} entries, or are not finite; expected {} entries", what,
          problem.phases()[j].name, value.size(), size));
  };
  for (std::size_t j = 0; j < start.states.size(); ++j)
    check_guess(start.states[j], problem.phases()[j].sizes.nx, j, "states");
  for (std::size_t j = 0; j < start.inputs.size(); ++j)
    check_guess(start.inputs[j], problem.phases()[j].sizes.nu, j, "inputs");
}

NlpPoint point_of(const MultipleShooting& shooting, const SeveralSolutions::Start& start) {
  NlpPoint point =
      start.trajectory ? shooting.guess_from(*start.trajectory) : shooting.initial_guess();
  const Grid& grid = shooting.grid();
  const Layout& layout = shooting.layout();
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = shooting.problem().phases()[j];
    const double T = grid.reference_duration(j);
    if (!start.durations.empty() && layout.duration(j) >= 0)
      point.w[layout.duration(j)] =
          std::clamp(start.durations[j], phase.duration.lower, phase.duration.upper) /
          phase.nominal_duration;
    const auto fraction = [&](int node) { return T > 0.0 ? grid.node_offset(j, node) / T : 0.0; };
    if (!start.states.empty() && start.states[j].is_given())
      for (int k = 0; k <= grid.intervals(j); ++k)
        point.w.segment(layout.state(j, k), phase.sizes.nx) =
            start.states[j].at(fraction(k)).cwiseQuotient(phase.nominal_state);
    if (!start.inputs.empty() && start.inputs[j].is_given())
      for (int k = 0; k < grid.intervals(j); ++k) {
        const int nu = phase.sizes.nu;
        point.w.segment(layout.input(j, k), nu) =
            start.inputs[j].at(fraction(k)).cwiseQuotient(phase.nominal_input);
        if (phase.input_shape() == InputShape::linear)
          point.w.segment(layout.input(j, k) + nu, nu) =
              start.inputs[j].at(fraction(k + 1)).cwiseQuotient(phase.nominal_input);
      }
  }
  return point;
}

// Sizes in the units of the problem; sizes below this are replaced by 1.
constexpr double least_size = 1e-9;
double size_of(double magnitude) { return magnitude >= least_size ? magnitude : 1.0; }

// Without nominal magnitudes, the size of a variable is the largest value of its quantity in both.
bool is_same(const Solution& a, const Solution& b, const Quantities& undeclared,
             const SeveralSolutions::Options& options) {
  const double cost = size_of(std::max(std::abs(a.cost), std::abs(b.cost)));
  if (std::abs(a.cost - b.cost) > options.same_cost * cost) return false;
  VectorXd difference = (a.point.w - b.point.w).cwiseAbs();
  for (const std::vector<int>& variables : undeclared) {
    double largest = 0.0;
    for (const int v : variables)
      largest = std::max({largest, std::abs(a.point.w[v]), std::abs(b.point.w[v])});
    for (const int v : variables) difference[v] /= size_of(largest);
  }
  return difference.maxCoeff() <= options.same_point;
}

}  // namespace

SeveralSolutions solve_from(const OptimalControlProblem& problem,
                            const std::vector<SeveralSolutions::Start>& starts,
                            const SeveralSolutions::Options& options) {
  problem.check();
  if (starts.empty()) throw DefinitionError("solve_from: there is no start");
  for (std::size_t i = 0; i < starts.size(); ++i) check(problem, starts[i], i);
  const ShootingOptions grid{
      .intervals_per_phase = options.intervals_per_phase,
      .intervals = options.intervals,
      .integrator = options.integrator ? options.integrator : runge_kutta4({.steps = 2})};
  const MultipleShooting any(problem, grid);  // reports invalid options
  const Quantities undeclared = undeclared_quantities(any.program());

  // Programs own work memory: each start has its own program, and each thread takes the next start.
  const std::size_t count = starts.size();
  std::vector<Solution> all(count);
  std::vector<std::exception_ptr> thrown(count);
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) try {
        MultipleShooting shooting(problem, grid);
        const std::unique_ptr<Solver> solver =
            options.make_solver ? options.make_solver() : make_native_solver();
        all[i] = solve(shooting, *solver, point_of(shooting, starts[i]));
      } catch (...) {
        thrown[i] = std::current_exception();
      }
  };
  const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t threads =
      std::min<std::size_t>(count, options.threads > 0 ? options.threads : processors);
  {
    std::vector<std::jthread> others;
    try {
      for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work);
      // no further thread is available: the existing ones process all starts
    } catch (const std::system_error&) {
    }
    work();
  }
  for (const std::exception_ptr& e : thrown)
    if (e) std::rethrow_exception(e);

  SeveralSolutions result;
  result.optimum_of.assign(count, -1);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < count; ++i)
    if (all[i].ok()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return all[a].cost < all[b].cost; });
  std::vector<std::size_t> cheapest;  // start of each optimum; the first one among equal costs
  for (const std::size_t i : order) {
    std::size_t k = 0;
    while (k < cheapest.size() && !is_same(all[cheapest[k]], all[i], undeclared, options)) ++k;
    if (k == cheapest.size()) cheapest.push_back(i);
    result.optimum_of[i] = static_cast<int>(k);
  }
  for (const std::size_t i : cheapest) result.optima.push_back(all[i]);
  for (std::size_t i = 0; i < count; ++i)
    if (!all[i].ok()) result.failed.push_back(std::move(all[i]));
  return result;
}

}  // namespace saltus
