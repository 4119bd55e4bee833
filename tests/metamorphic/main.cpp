// Metamorphic tests: every case under every law, with three solvers and, if applicable, in closed
// loop. Cost, plan and status must equal those of the original case after conversion.
//
//     saltus_metamorphic [--seed N]           the full set, numbers drawn by the seed
//     saltus_metamorphic --gate               the fixed sample of the gate
//     saltus_metamorphic --case B01 --law other_units --solver riccati --seed 3
//
// Exits with status 1 if an answer changes although it must not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "problems/library/catalogue.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/metamorphic/cases.hpp"

namespace saltus::metamorphic {

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> list = program_cases();
    const auto quick = {"A01", "A02", "A17", "B01", "B02", "B05",
                        "B22", "C02", "E02", "E03", "E06"};
    for (const ReferenceCase& c : reference_cases()) {
      list.push_back({c.name,
                      [&c] {
                        return Stated{c.problem(), c.options};
                      },
                      c.max_iterations,
                      std::find(quick.begin(), quick.end(), c.id) != quick.end()});
    }
    return list;
  }();
  return all;
}

namespace {

// Allowed differences. Solvers end at 1e-8 in their own scales.
constexpr double cost_tolerance = 1e-5;   // relative to 1 + |cost|, in the units of the case
constexpr double plan_tolerance = 1e-3;   // relative to the size of each state
constexpr double input_tolerance = 1e-3;  // for the first input of the controller
constexpr double solver_tolerance = 1e-8;
constexpr double time_limit = 60.0;  // s

struct Request {
  std::string only_case, only_law, only_solver;
  std::uint64_t seed = 1;
  bool gate = false, verbose = false;
};

[[noreturn]] void usage(const std::string& why) {
  fmt::print(stderr,
             "{}\nsaltus_metamorphic [--gate] [--case NAME] [--law NAME] "
             "[--solver ipopt|sparse|riccati|controller] [--seed N] [--verbose]\n",
             why);
  std::exit(2);
}

Request read(int argc, char** argv) {
  Request request;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) usage(name + " needs a value");
      return argv[++i];
    };
    if (name == "--gate")
      request.gate = true;
    else if (name == "--verbose")
      request.verbose = true;
    else if (name == "--case")
      request.only_case = value();
    else if (name == "--law")
      request.only_law = value();
    else if (name == "--solver")
      request.only_solver = value();
    else if (name == "--seed")
      request.seed = std::strtoull(value().c_str(), nullptr, 10);
    else
      usage("there is no option '" + name + "'");
  }
  return request;
}

Solution solved(const Stated& stated, SolverChoice choice, int max_iterations) {
  MultipleShooting shooting(stated.problem, stated.options);
  const auto solver = make_solver(
      choice,
      {.tolerance = solver_tolerance, .max_iterations = max_iterations, .time_limit = time_limit});
  return solve(shooting, *solver);
}

// The first tick from the start of the problem: its input and the source of that input.
struct FirstTick {
  Provenance provenance = Provenance::fallback;
  VectorXd input;
};
FirstTick first_tick(const Stated& stated) {
  RecedingHorizonController controller(MultipleShooting(stated.problem, stated.options),
                                       {.period = 0.01});
  FirstTick result;
  // A real-time iteration takes one step per tick. With constant measurements it converges to its
  // optimum.
  for (int k = 0; k < 30; ++k) {
    const ControlTick& tick =
        controller.tick(stated.problem.start_time(), stated.problem.start_guess());
    result.provenance = tick.provenance;
    result.input = tick.input[0].input();
    if (tick.provenance == Provenance::optimal) break;
  }
  return result;
}

// Difference of the plans, or empty if it is within the tolerance.
std::string difference(const Transformed& t, const Solution& base, const Solution& other) {
  double change = 0.0, left_out = 0.0;
  if (t.moved_state >= 0) {
    const double before = base.start_multipliers[t.moved_state];
    const double after = other.start_multipliers.size() == base.start_multipliers.size()
                             ? other.start_multipliers[t.moved_state]
                             : before;
    change = 0.5 * t.moved_by * (before + after);
    // The error is of third order, or of first order where a bound becomes active.
    left_out = 0.1 * std::abs(t.moved_by) * std::max(std::abs(before), std::abs(after));
  }
  const double cost = (base.cost + change) * t.cost_factor;
  const double allowed = (cost_tolerance * (1.0 + std::abs(base.cost)) + left_out) * t.cost_factor;
  if (!(std::abs(other.cost - cost) <= allowed))
    return fmt::format("cost {:.9g} instead of {:.9g}", other.cost / t.cost_factor,
                       cost / t.cost_factor);
  if (!t.is_same_plan) return {};
  const Trajectory &a = base.trajectory, &b = other.trajectory;
  const double length = a.end_time() - a.start_time();
  if (!(std::abs((b.end_time() - b.start_time()) / t.units.time - length) <=
        plan_tolerance * length))
    return fmt::format("duration {:.6g} instead of {:.6g}",
                       (b.end_time() - b.start_time()) / t.units.time, length);
  VectorXd size = VectorXd::Constant(64, 1e-3), worst = VectorXd::Zero(64);
  const auto& pieces = a.pieces();
  for (const Trajectory::Piece& piece : pieces)
    size.head(piece.state.size()) = size.head(piece.state.size()).cwiseMax(piece.state.cwiseAbs());
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (pieces.size() != b.pieces().size()) return "another number of intervals";
    const VectorXd x = pieces[k].state;
    VectorXd y = b.pieces()[k].state;
    if (x.size() != y.size()) return "another number of states";
    if (!t.units.state.empty()) y = y.cwiseQuotient(t.units.state[pieces[k].phase]);
    worst.head(x.size()) = worst.head(x.size()).cwiseMax((x - y).cwiseAbs());
  }
  int i = 0;
  const double largest = worst.cwiseQuotient(size).maxCoeff(&i);
  if (!(largest <= plan_tolerance))
    return fmt::format("state {} differs by {:.2g} of its size, cost {:.9g} instead of {:.9g}", i,
                       largest, other.cost / t.cost_factor, cost / t.cost_factor);
  return {};
}

// Known exceptions to invariance, with reasons. An empty field matches every case, law or solver.
struct KnownChange {
  const char *name, *law, *way, *why;
  const char* change = "";  // beginning of the description of the change
};
constexpr KnownChange known_changes[] = {
    {"bryson_denham", "", "",
     "on its published grid, cheaper plans violate the ceiling between the nodes"},
    {"low_ceiling_arcs", "", "",
     "plans of equal cost violate the ceiling differently between the nodes"},
    {"thermostat", "", "", "events inside a phase make the problem discontinuous"},
    {"example_ball", "", "", "events inside a phase make the problem discontinuous"},
    {"alp_rider", "other_units", "", "not convex: converges from some scales only", "ok ->"},
    {"f8_aircraft", "other_units", "ipopt", "Ipopt converges from one scale only"},
    {"calcium_oscillation", "other_units", "ipopt", "Ipopt converges from one scale only"},
    {"hanging_chain", "other_units", "ipopt", "Ipopt converges from one scale only"},
    {"", "other_units", "controller", "a single step depends on the scale"},
    {"turbo_car", "constant_rows", "controller", "inactive rows on free times: another step"},
};

const KnownChange* known_change(const std::string& name, const std::string& law,
                                const std::string& way, const std::string& change) {
  const auto fits = [](const char* entry, const std::string& value) {
    return *entry == '\0' || value == entry;
  };
  for (const KnownChange& k : known_changes) {
    if (fits(k.name, name) && fits(k.law, law) && fits(k.way, way) && change.starts_with(k.change))
      return &k;
  }
  return nullptr;
}

enum class Found { same, other_plan, other_optimum, changed, known, not_applicable };
struct Comparison {
  Found found = Found::same;
  std::string reason;
};

// True if the plan of the transformed case is a local optimum of the case: no plan whose durations
// are within 1 % of it costs less.
bool is_optimum_of_the_case(const Stated& stated, const Transformed& t, const Solution& other,
                            SolverChoice choice, int max_iterations) {
  const std::size_t phases = stated.problem.phases().size();
  if (other.durations.size() != phases) return false;
  Stated near = guessed_from(stated, other.trajectory, other.durations, t.units);
  for (std::size_t j = 0; j < phases; ++j) {
    PhaseDefinition& phase = near.problem.editable_phase(static_cast<int>(j));
    const double length = phase.duration_guess;
    phase.duration = between(std::max(phase.duration.lower, 0.99 * length),
                             std::min(phase.duration.upper, 1.01 * length));
  }
  const Solution again = solved(near, choice, max_iterations);
  const double cost = other.cost / t.cost_factor;
  return again.ok() && std::abs(again.cost - cost) <= cost_tolerance * (1.0 + std::abs(cost));
}

Comparison compare(const Transformed& t, const Solution& base, const Solution& other) {
  // Another start may need a finer grid.
  if (t.moved_state >= 0 && base.ok() && other.status == SolveStatus::coarse_grid)
    return {Found::not_applicable, "the grid is too coarse for the moved start"};
  if (base.ok() != other.ok()) {
    return {Found::changed, fmt::format("{} -> {}", base.ok() ? "ok" : describe(base.status),
                                        other.ok() ? "ok" : other.message)};
  }
  if (!base.ok()) return {};
  const std::string reason = difference(t, base, other);
  if (reason.empty()) return {};
  // If several plans have the same cost, each is a right answer.
  return {reason.starts_with("state") ? Found::other_plan : Found::changed, reason};
}

struct Counts {
  int same = 0, other_plan = 0, other_optimum = 0, changed = 0, known = 0, not_applicable = 0;
  double seconds = 0.0;
};

void count(Counts& c, Found found) {
  int* const counts[] = {&c.same,    &c.other_plan, &c.other_optimum,
                         &c.changed, &c.known,      &c.not_applicable};
  ++*counts[static_cast<int>(found)];
}

std::uint64_t mixed(std::uint64_t seed, const std::string& a, const std::string& b) {
  std::uint64_t hash = 1469598103934665603ULL ^ seed;
  for (const std::string& text : {a, b})
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

Comparison under_control(const Case& c, const Law& law, std::uint64_t seed, std::string& what) {
  Stated stated = c.stated();
  for (const Bounds& b : stated.problem.start_bounds())
    if (!b.is_equality()) return {Found::not_applicable, "the start is free"};
  const FirstTick base = first_tick(stated);
  Random random(seed);
  std::string why;
  // Laws that need a solution receive an empty one.
  const std::optional<Transformed> t = law.apply(stated, Solution{}, random, why);
  if (!t || !t->is_same_plan) return {Found::not_applicable, why};
  what = t->what;
  if (t->units.time != 1.0) return {Found::not_applicable, "the period is in seconds"};
  const FirstTick other = first_tick(t->stated);
  if (base.provenance != other.provenance)
    return {Found::changed,
            fmt::format("{} -> {}", describe(base.provenance), describe(other.provenance))};
  if (base.provenance != Provenance::optimal) return {};
  VectorXd input = other.input;
  if (!t->units.input.empty()) input = input.cwiseQuotient(t->units.input[0]);
  const double off =
      (input - base.input).size() > 0 ? (input - base.input).cwiseAbs().maxCoeff() : 0.0;
  const double size = 1.0 + (base.input.size() > 0 ? base.input.cwiseAbs().maxCoeff() : 0.0);
  if (off > input_tolerance * size)
    return {Found::other_plan, fmt::format("the input is off by {:.2g}", off)};
  return {};
}

int run(const Request& request) {
  std::map<std::pair<std::string, std::string>, Counts> table;
  std::string listed;
  Counts all;
  const std::vector<std::string> ways{"sparse", "riccati", "ipopt", "controller"};
  for (const Case& c : cases()) {
    if (!request.only_case.empty() && request.only_case != c.name) continue;
    if (request.gate && !c.is_quick) continue;
    for (const std::string& way : ways) {
      if (!request.only_solver.empty() && request.only_solver != way) continue;
      std::optional<SolverChoice> choice;
      for (const auto& [word, known] : solver_choices())
        if (word == way) choice = known;
      std::optional<Solution> base;
      const Stated stated = c.stated();
      for (const Law& law : laws()) {
        if (!request.only_law.empty() && request.only_law != law.name) continue;
        Counts& counts = table[{law.name, way}];
        const auto start = WallClock::now();
        const std::uint64_t seed = mixed(request.seed, c.name, law.name);
        Comparison comparison;
        std::string what;
        try {
          if (!choice) {
            comparison = under_control(c, law, seed, what);
          } else {
            if (!base) base = solved(stated, *choice, c.max_iterations);
            Random random(seed);
            std::string why;
            const std::optional<Transformed> t = law.apply(stated, *base, random, why);
            if (t) {
              what = t->what;
              const Solution other = solved(t->stated, *choice, c.max_iterations);
              comparison = compare(*t, *base, other);
              if (comparison.found == Found::changed && base->ok() && other.ok() &&
                  t->moved_state < 0 &&
                  is_optimum_of_the_case(stated, *t, other, *choice, c.max_iterations))
                comparison.found = Found::other_optimum;
            } else {
              comparison = {Found::not_applicable, why};
            }
          }
        } catch (const DefinitionError& error) {
          // A law is not applicable if the solver or the controller rejects even the unchanged
          // case.
          comparison = {base || !choice ? Found::changed : Found::not_applicable, error.what()};
          if (!choice) comparison.found = Found::not_applicable;
        }
        if (const KnownChange* known = known_change(c.name, law.name, way, comparison.reason);
            known != nullptr && comparison.found == Found::changed)
          comparison = {Found::known, fmt::format("({}) {}", known->why, comparison.reason)};
        counts.seconds += seconds_since(start);
        count(counts, comparison.found);
        count(all, comparison.found);
        const bool notable = comparison.found == Found::changed ||
                             comparison.found == Found::known ||
                             comparison.found == Found::other_plan ||
                             comparison.found == Found::other_optimum || request.verbose;
        if (notable) {
          const char* words[] = {"same", "other plan", "other optimum", "CHANGED", "known", "n/a"};
          listed += fmt::format("{:<13} --case {} --law {} --solver {} --seed {}: {} [{}]\n",
                                words[static_cast<int>(comparison.found)], c.name, law.name, way,
                                request.seed, comparison.reason, what);
        }
      }
    }
  }
  fmt::print("{:<20}{:<12}{:>7}{:>12}{:>15}{:>9}{:>7}{:>6}{:>9}\n", "law", "by", "same",
             "other plan", "other optimum", "CHANGED", "known", "n/a", "s");
  for (const Law& law : laws())
    for (const std::string& way : ways)
      if (const auto it = table.find({law.name, way}); it != table.end())
        fmt::print("{:<20}{:<12}{:>7}{:>12}{:>15}{:>9}{:>7}{:>6}{:>9.1f}\n", law.name, way,
                   it->second.same, it->second.other_plan, it->second.other_optimum,
                   it->second.changed, it->second.known, it->second.not_applicable,
                   it->second.seconds);
  if (!listed.empty()) fmt::print("\n{}", listed);
  fmt::print(
      "\nchanged answers: {} of {}, and {} for a known reason; other plans of the same cost: {}; "
      "other local optima of the case: {}\n",
      all.changed, all.same + all.other_plan + all.other_optimum + all.changed + all.known,
      all.known, all.other_plan, all.other_optimum);
  return all.changed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace saltus::metamorphic

int main(int argc, char** argv) {
  return saltus::metamorphic::run(saltus::metamorphic::read(argc, argv));
}
