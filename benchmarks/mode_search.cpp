// Search over sequences of modes: starts, optima, nodes and time, warm and cold, as CSV.
//
//   mode_search PROBLEM PHASES STARTS [cold] > results.csv      one line per start
//   mode_search PROBLEM PHASES STARTS speed                     200 nodes against warm solves
//   mode_search PROBLEM PHASES TICKS loop                       receding horizon, one line per tick
//   mode_search PROBLEM PHASES STARTS plan                      one trajectory that switches modes
//   mode_search fishing PHASES [plan]                           the nonlinear problem, at most
//                                                               PHASES
//
// PROBLEM is walls, thermostats or tanks. compare_mode_search.py solves the same starts with SCIP.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "problems/library/mode_graphs.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/sequences/sequence_search.hpp"

namespace {

using namespace saltus;

struct Family {
  const char* name;
  ModeGraph (*graph)(const VectorXd& start);
  VectorXd low, high;  // range of the starts
  double sample;       // s or h; sample time of the loop
};

std::vector<Family> families() {
  return {
      {"walls", library::cart_between_walls, -Vec<double, 4>(0.4, 0.15, 0.5, 0.5),
       Vec<double, 4>(0.4, 0.15, 0.5, 0.5), 0.1},
      {"thermostats", library::thermostats, Vec<double, 3>(17.5, 17.5, 17.5),
       Vec<double, 3>(23.0, 23.0, 23.0), 1.0 / 6.0},
      {"tanks", library::two_tanks, Vec<double, 2>(0.06, 0.06), Vec<double, 2>(0.55, 0.55), 30.0}};
}

constexpr int seed = 13;

VectorXd draw(const Family& family, Random& random) {
  VectorXd x(family.low.size());
  for (int i = 0; i < x.size(); ++i) x[i] = random.uniform(family.low[i], family.high[i]);
  return x;
}

std::string joined(const VectorXd& x) {
  std::string text;
  for (int i = 0; i < x.size(); ++i) text += fmt::format("{}{:.17g}", i > 0 ? " " : "", x[i]);
  return text;
}

void print_line(const Family& family, int phases, int start, const VectorXd& x,
                const SequenceResult& r) {
  std::string modes;
  for (const int mode : r.modes) modes += fmt::format("{}{}", modes.empty() ? "" : " ", mode);
  fmt::print("{},{},{},{},{:.12g},{:.12g},{},{},{},{},{},{:.6f},{},{},{:.12g}\n", family.name,
             phases, start, joined(x), r.cost, r.lower_bound, static_cast<int>(r.guarantee),
             r.nodes, r.infeasible, r.unresolved, r.iterations, r.cpu_seconds, r.reused, modes,
             r.solution.cost);
  std::fflush(stdout);
}

constexpr const char* header =
    "problem,phases,start,state,cost,bound,guarantee,nodes,infeasible,unresolved,iterations,"
    "seconds,reused,modes,confirmed\n";

void each_start(const Family& family, int phases, int starts, bool warm) {
  Random random(seed);
  SequenceSearch search(family.graph(family.low), {.phases = phases, .gap = 1e-7, .warm = warm});
  fmt::print("{}", header);
  for (int i = 0; i < starts; ++i) {
    const VectorXd x = draw(family, random);
    print_line(family, phases, i, x, search.solve(x));
  }
}

// CPU time of a search with 200 nodes, compared with that of the programs that it solved.
void speed(const Family& family, int phases, int starts) {
  Random random(seed);
  SequenceSearch search(family.graph(family.low),
                        {.phases = phases, .gap = 0.0, .max_nodes = 200, .confirm = false});
  double all = 0.0, solving = 0.0;
  long nodes = 0, iterations = 0;
  for (int i = 0; i < starts; ++i) {
    const SequenceResult r = search.solve(draw(family, random));
    all += r.cpu_seconds, solving += r.solver_seconds;
    nodes += r.nodes, iterations += r.iterations;
  }
  fmt::print(
      "{} nodes, {:.1f} iterations each: {:.1f} ms per 200 nodes, the time of {:.0f} warm "
      "solves of {:.0f} us\n",
      nodes, static_cast<double>(iterations) / nodes, 2e5 * all / nodes, 200.0 * all / solving,
      1e6 * solving / nodes);
}

void loop(const Family& family, int phases, int ticks) {
  Random random(seed);
  SequenceSearch warm(family.graph(family.low), {.phases = phases, .confirm = false});
  SequenceSearch cold(family.graph(family.low), {.phases = phases, .confirm = false});
  VectorXd x = draw(family, random);
  while (!cold.solve(x).found()) x = draw(family, random);
  fmt::print("{}", header);
  long warm_nodes = 0, cold_nodes = 0;
  double warm_time = 0.0, cold_time = 0.0;
  for (int tick = 0; tick < ticks; ++tick) {
    const SequenceResult next = tick == 0 ? warm.solve(x) : warm.solve_next(x);
    print_line(family, phases, tick, x, next);
    const SequenceResult alone = cold.solve(x, tick == 0 ? ModeGraph::History{} : warm.before());
    if (tick > 0) {
      warm_nodes += next.nodes, cold_nodes += alone.nodes;
      warm_time += next.cpu_seconds, cold_time += alone.cpu_seconds;
    }
    if (!next.found() || std::abs(next.cost - alone.cost) > 2e-6 * std::abs(alone.cost))
      fmt::print(stderr, "tick {}: {} warm, {} cold\n", tick, next.cost, alone.cost);
    if (!next.found()) return;
    // The plant is the model with a disturbance of the velocity (the last state).
    x = next.states[1];
    x[x.size() - 1] += 1e-2 * random.uniform(-1.0, 1.0) * (family.high - family.low)[x.size() - 1];
  }
  fmt::print(stderr, "{} ticks: {} nodes and {:.3f} s of CPU warm, {} and {:.3f} s cold\n", ticks,
             warm_nodes, warm_time, cold_nodes, cold_time);
}

void plan(const Family& family, int phases, int starts) {
  Random random(seed);
  SequenceSearch search(family.graph(family.low), {.phases = phases});
  for (int i = 0; i < starts; ++i) {
    const SequenceResult r = search.solve(draw(family, random));
    if (std::adjacent_find(r.modes.begin(), r.modes.end(), std::not_equal_to{}) != r.modes.end())
      return r.solution.trajectory.write_csv(std::cout);
  }
}

void fishing(int phases, bool as_table) {
  const SequenceResult found =
      search(library::fishing_modes(),
             {.at_most = phases, .intervals_per_phase = 6, .integrator = runge_kutta8()});
  if (as_table) return found.solution.trajectory.write_csv(std::cout, 4);
  fmt::print(
      "{:.10g} after {} programs and {:.1f} s; 1.344081198 is the optimum with continuous "
      "effort\n{}\n",
      found.cost, found.nodes, found.seconds, found.message);
  double t = 0.0;
  for (std::size_t i = 0; i < found.sequence.size(); ++i)
    fmt::print("{} from {:.6f}\n", found.sequence[i],
               std::exchange(t, t + found.solution.durations[i]));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string how = words.size() > 3 ? words[3] : "warm";
  const int phases = words.size() > 2 ? std::atoi(words[1].c_str()) : 0;
  const int count = words.size() > 2 ? std::atoi(words[2].c_str()) : 0;
  const bool fishing_plan = words.size() == 3 && words[2] == "plan";
  if ((words.size() == 2 || fishing_plan) && words[0] == "fishing" &&
      std::atoi(words[1].c_str()) > 0) {
    fishing(std::atoi(words[1].c_str()), fishing_plan);
    return 0;
  }
  for (const Family& family : families()) {
    if (words.empty() || words[0] != family.name || phases < 1 || count < 1) continue;
    if (how == "loop")
      loop(family, phases, count);
    else if (how == "speed")
      speed(family, phases, count);
    else if (how == "plan")
      plan(family, phases, count);
    else if (how == "warm" || how == "cold")
      each_start(family, phases, count, how == "warm");
    else
      break;
    return 0;
  }
  fmt::print(stderr,
             "usage: mode_search walls|thermostats|tanks PHASES COUNT [warm|cold|speed|loop|plan]\n"
             "       mode_search fishing PHASES [plan]\n");
  return 2;
}
