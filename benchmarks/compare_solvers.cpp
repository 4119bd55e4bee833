// Our own solvers against Ipopt on random programs in stages:
//
//     compare_solvers [FEASIBLE [CONTRADICTORY [FIRST_SEED]]]      (500, 100, 1)
//
// Prints one line per program on which they differ, and the totals.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "benchmarks/random_programs.hpp"
#include "saltus/solver/ipopt.hpp"

namespace {

using namespace saltus;  // NOLINT(google-build-using-namespace): a program of one file

constexpr std::array choices{SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati};
constexpr double same_cost = 1e-6;

Solution solve_with(const RandomProgram& program, SolverChoice choice) {
  MultipleShooting shooting(program.problem, program.options);
  const auto solver = make_solver(choice, {.time_limit = 20.0});
  return solve(shooting, *solver);
}

struct Sums {
  std::array<int, 3> solved{}, same{}, better{}, worse{}, named{}, said{}, iterations{};
  std::array<double, 3> seconds{};
};

void compare(unsigned seed, Sums& sums) {
  const RandomProgram program = random_program(seed);
  std::array<Solution, 3> s;
  for (int k = 0; k < 3; ++k) {
    s[k] = solve_with(program, choices[k]);
    sums.solved[k] += s[k].ok() ? 1 : 0;
    sums.seconds[k] += s[k].seconds;
    sums.iterations[k] += s[k].iterations;
  }
  for (int k = 1; k < 3; ++k) {
    if (s[0].ok() && s[k].ok()) {
      const double off = (s[k].cost - s[0].cost) / (1.0 + std::abs(s[0].cost));
      ++(std::abs(off) <= same_cost ? sums.same : off < 0.0 ? sums.better : sums.worse)[k];
      if (std::abs(off) > same_cost)
        fmt::print(
            "{:4} {:8} another optimum: {:.8g}, Ipopt {:.8g}; KKT residuals {:.1e}, {:.1e}\n", seed,
            name_of(choices[k]), s[k].cost, s[0].cost, s[k].kkt.scaled(), s[0].kkt.scaled());
    }
    if (s[k].ok() != s[0].ok())
      fmt::print("{:4} {:8} {} ({} iterations); Ipopt: {} ({})\n", seed, name_of(choices[k]),
                 s[k].message, s[k].iterations, s[0].message, s[0].iterations);
  }
}

void contradict(unsigned seed, Sums& sums) {
  const RandomProgram program = contradictory_program(seed);
  for (int k = 0; k < 3; ++k) {
    const Solution s = solve_with(program, choices[k]);
    const bool said = s.status == SolveStatus::infeasible;
    const bool named = said && s.message.find(program.contradiction) != std::string::npos;
    sums.said[k] += said ? 1 : 0;
    sums.named[k] += named ? 1 : 0;
    if (!named)
      fmt::print("{:4} {:8} contradiction not named: {}\n", seed, name_of(choices[k]), s.message);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const auto number = [&](int i, int otherwise) {
    return count > i ? std::atoi(arguments[i]) : otherwise;
  };
  const int feasible = number(1, 500), contradictory = number(2, 100), first = number(3, 1);
  Sums sums;
  for (int i = 0; i < feasible; ++i) compare(first + i, sums);
  for (int i = 0; i < contradictory; ++i) contradict(first + i, sums);
  for (int k = 0; k < 3; ++k)
    fmt::print(
        "{:8} solved {} of {} in {:.2f} s, {} iterations; of those solved by Ipopt too: {} the "
        "same cost, "
        "{} "
        "lower, {} higher; {} of {} called infeasible, {} with the term\n",
        name_of(choices[k]), sums.solved[k], feasible, sums.seconds[k], sums.iterations[k],
        sums.same[k], sums.better[k], sums.worse[k], sums.said[k], contradictory, sums.named[k]);
  return 0;
}
