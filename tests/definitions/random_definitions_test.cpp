// Solves random problems, some of them wrong. The outcome must be a DefinitionError with names or a
// solve that ends with a status. Other exceptions, NaN in a solution, and two solvers with
// contradictory definite answers are failures. SALTUS_RANDOM_DEFINITIONS=10000 sets the number of
// seeds, =2001:3000 a range of seeds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/definitions/random_definition.hpp"

namespace saltus::test {
namespace {

constexpr double longest_solve = 600.0;  // s, beyond which a solve counts as hanging, even on a
                                         // loaded machine; the longest takes 1 s

struct Seeds {
  int first = 1, last = 60;
  bool is_campaign = false;  // prints its counts
};

Seeds seeds() {
  const char* given = std::getenv("SALTUS_RANDOM_DEFINITIONS");
  if (given == nullptr) return {};
  const std::string text = given;
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return {1, std::stoi(text), true};
  return {std::stoi(text), std::stoi(text.substr(colon + 1)), true};
}

struct Outcome {
  std::optional<Solution> solution;  // empty if the problem was refused
  bool is_of_formula = false;
  std::string refusal, failure;
};

// `failure` describes a violation, or is empty.
Outcome solve_drawn(std::uint32_t seed, SolverChoice choice) {
  Outcome outcome;
  try {
    RandomDefinition drawn = draw_definition(seed);
    MultipleShooting shooting(std::move(drawn.problem),
                              {.intervals_per_phase = 6, .integrator = runge_kutta4({.steps = 2})});
    const auto solver = make_solver(choice, {.tolerance = 1e-9, .time_limit = longest_solve});
    outcome.solution = solve(shooting, *solver);
  } catch (const DefinitionError& error) {
    outcome.refusal = error.what();
  } catch (const FormulaIsOutOfOrder&) {
    outcome.is_of_formula = true;  // exceptions of formulas at set-up are passed on unchanged
  } catch (const std::exception& error) {
    outcome.failure = fmt::format("throws {}", error.what());
  }
  if (!outcome.solution) return outcome;
  const Solution& s = *outcome.solution;
  if (s.message.empty()) outcome.failure = "has no message";
  bool is_finite = std::isfinite(s.cost) && !s.trajectory.empty();
  for (const Trajectory::Piece& piece : s.trajectory.pieces())
    is_finite = is_finite && piece.end_state.allFinite() && piece.state.allFinite();
  if (s.ok() && !is_finite) outcome.failure = "returns NaN as a solution";
  if (s.ok() && !(s.kkt_in_scale.scaled() < 1e-5))
    outcome.failure = "reports a point as an optimum that is not one";
  return outcome;
}

bool is_sure_of_none(const Outcome& o) {
  return o.solution && o.solution->status == SolveStatus::infeasible;
}
bool is_proved_to_have_none(const Outcome& o) {
  return o.solution && o.solution->message.find("the constraints cannot all be satisfied") == 0;
}
// True for an optimum of the program. Path constraints may be violated between its nodes, which the
// status reports.
bool is_sure_of_one(const Outcome& o) {
  return o.solution && (o.solution->status == SolveStatus::optimal ||
                        o.solution->status == SolveStatus::coarse_grid);
}

// Solves the problem of a seed with all solvers and checks the outcomes.
void check_seed(int seed, std::map<std::string, int>& counts) {
  SCOPED_TRACE(fmt::format("seed {}", seed));
  std::map<std::string, Outcome> outcomes;
  for (const auto& [name, choice] : solver_choices()) {
    const Outcome& o = outcomes[name] = solve_drawn(static_cast<std::uint32_t>(seed), choice);
    EXPECT_EQ(o.failure, "") << name;
    ++counts[name + ": " + (o.solution ? describe(o.solution->status) : "refused")];
    if (!o.solution && !o.is_of_formula && o.failure.empty()) {
      EXPECT_NE(o.refusal.find('\''), std::string::npos)
          << "the message names nothing: " << o.refusal;
    }
  }
  RandomDefinition drawn;
  try {
    drawn = draw_definition(static_cast<std::uint32_t>(seed));
  } catch (const std::exception&) {
    return;
  }
  for (const auto& [one, a] : outcomes)
    for (const auto& [other, b] : outcomes) {
      if (is_sure_of_one(a) && is_proved_to_have_none(b))
        ADD_FAILURE() << one << " finds a feasible point, but " << other
                      << " proves that there is none: " << b.solution->message;
    }
  if (!drawn.is_convex) return;
  for (const auto& [name, o] : outcomes)
    if (o.solution && o.solution->status != SolveStatus::evaluation_failed) {
      EXPECT_TRUE(is_sure_of_one(o) || is_sure_of_none(o)) << name << ": " << o.solution->message;
    }
  for (const auto& [one, a] : outcomes)
    for (const auto& [other, b] : outcomes) {
      if (is_sure_of_one(a) && is_sure_of_none(b))
        ADD_FAILURE() << one << " reports an optimum, but " << other << " reports infeasibility";
      // Two scaled residuals of 1e-9 and costs of order 1.
      if (one < other && is_sure_of_one(a) && is_sure_of_one(b)) {
        EXPECT_NEAR(a.solution->cost, b.solution->cost, 1e-6 * (1.0 + std::abs(a.solution->cost)))
            << one << ", " << other;
      }
    }
}

TEST(RandomDefinitions, GiveAMessageOrAStatusAndSolversAgree) {
  std::map<std::string, int> counts;
  const auto [first, last, is_campaign] = seeds();
  for (int seed = first; seed <= last; ++seed) check_seed(seed, counts);
  if (is_campaign)
    for (const auto& [what, count] : counts) fmt::print("{:6} {}\n", count, what);
}

// Convex problems from campaigns in which one solver ended without an optimum. riccati failed at
// soft sides that are just reached (the first eight). Ipopt failed where the tolerance was met only
// in the units of the program (the next three), or where the optimal cost is 4e-7.
TEST(RandomDefinitions, SolversAgreeOnProblemsThatCampaignsFound) {
  std::map<std::string, int> counts;
  for (const int seed : {201, 809, 1446, 1862, 1945, 2694, 3871, 4301, 2947, 3417, 3434, 442})
    check_seed(seed, counts);
}

}  // namespace
}  // namespace saltus::test
