// Searches over mode sequences whose end conditions read the state and the time. The reference is
// the best of all sequences.
//
// x' = b_m u + c_m, |u| <= 1, h_m seconds per mode, cost r_m / 2 u^2. For a given sequence, the end
// x(T) requires sum b h u = D. The least effort is u_k = clip(lambda b_k / r_k), with lambda found
// by bisection.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "saltus/sequences/search.hpp"
#include "tests/corpus/formulas.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

struct Mode {
  double gain, drift, seconds, weight;
};
struct Moved {
  Mode mode;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return Vec<S, 1>(mode.gain * u[0] + mode.drift);
  }
};
// x - place - speed t
struct Distance {
  double place, speed;
  template <class S, class X>
  S operator()(const S& t, const X& x) const {
    return x[0] - place - speed * t;
  }
};

struct Game {
  std::vector<Mode> modes;
  double start, place, speed, weight;  // weight: of the squared end error; 0: a constraint
  bool is_inequality;

  // Least cost of a sequence, or infinity if the end is unreachable.
  double cost(const std::vector<int>& path) const {
    double time = 0.0, drift = 0.0;
    for (const int m : path) time += modes[m].seconds, drift += modes[m].drift * modes[m].seconds;
    const double wanted = place + speed * time - start - drift;
    const auto reached = [&](double lambda) {
      double sum = 0.0;
      for (const int m : path)
        sum += modes[m].gain * modes[m].seconds *
               std::clamp(lambda * modes[m].gain / modes[m].weight, -1.0, 1.0);
      return sum;
    };
    const auto effort = [&](double lambda) {
      double sum = 0.0;
      for (const int m : path) {
        const double u = std::clamp(lambda * modes[m].gain / modes[m].weight, -1.0, 1.0);
        sum += 0.5 * modes[m].weight * modes[m].seconds * u * u;
      }
      return sum;
    };
    if (is_inequality && weight == 0.0 && wanted <= 0.0) return 0.0;
    double low = -1e6, high = 1e6;
    for (int k = 0; k < 200; ++k) {
      const double lambda = 0.5 * (low + high);
      const double excess =
          weight > 0.0 ? lambda - weight * (wanted - reached(lambda)) : reached(lambda) - wanted;
      (excess > 0.0 ? high : low) = lambda;
    }
    const double miss = wanted - reached(low);
    if (weight > 0.0) return effort(low) + 0.5 * weight * miss * miss;
    return std::abs(miss) > 1e-6 ? infinity : effort(low);
  }
  double best(int phases) const {
    std::vector<int> path(phases, 0);
    double least = infinity;
    for (;;) {
      least = std::min(least, cost(path));
      int k = 0;
      while (k < phases && ++path[k] == static_cast<int>(modes.size())) path[k++] = 0;
      if (k == phases) return least;
    }
  }
  // Distance between the required end and the nearest reachable one.
  bool is_clear_cut(int phases) const {
    for (const double change : {-1e-3, 1e-3}) {
      Game moved = *this;
      moved.place += change;
      if (std::isfinite(moved.best(phases)) != std::isfinite(best(phases))) return false;
    }
    return true;
  }
};

}  // namespace

Instance mode_searches(Random& random) {
  Game game;
  const int phases = random.integer(2, 5);
  const int count = random.integer(2, 3);
  const bool same_seconds = random.chance(0.5);
  const double seconds = random.uniform(0.2, 1.0);
  for (int m = 0; m < count; ++m) {
    game.modes.push_back({random.uniform(0.2, 2.0) * (random.chance(0.3) ? -1.0 : 1.0),
                          random.chance(0.5) ? 0.0 : random.uniform(-1.0, 1.0),
                          same_seconds ? seconds : random.uniform(0.2, 1.0),
                          random.log_uniform(0.1, 10.0)});
  }
  game.start = random.uniform(-1.0, 1.0);
  game.place = random.uniform(-2.0, 2.0);
  game.speed = random.chance(0.3) ? 0.0 : random.uniform(-2.0, 2.0);
  game.weight = random.chance(0.4) ? random.log_uniform(0.1, 100.0) : 0.0;
  game.is_inequality = game.weight == 0.0 && random.chance(0.3);
  Instance instance;
  instance.run = [=](SolverChoice) -> Verdict {
    ModeGraph graph("game");
    for (std::size_t m = 0; m < game.modes.size(); ++m) {
      const Mode& mode = game.modes[m];
      Phase<1, 1> phase("mode " + std::to_string(m + 1), Moved{mode}, exactly(mode.seconds));
      phase.bound_input(0, between(-1.0, 1.0))
          .track(
              "effort", [](const auto&, const auto&, const auto& u) { return u[0]; },
              VectorXd::Constant(1, mode.weight));
      graph.mode(phase);
    }
    graph.all_transitions().start_at(VectorXd::Constant(1, game.start));
    const Distance distance{game.place, game.speed};
    if (game.weight > 0.0) {
      const double weight = game.weight;
      graph.minimise_at_end<1>("distance", [=](const auto& t, const auto& x) {
        const auto d = distance(t, x);
        return std::decay_t<decltype(d)>(0.5 * weight * d * d);
      });
    } else {
      graph.reach_at_end<1>("meeting", distance, game.is_inequality ? at_least(0.0) : exactly(0.0));
    }
    const double best = game.best(phases);
    const SequenceResult result = search(graph, {.phases = phases});
    const double allowed = 1e-4 * (1.0 + std::abs(best));
    const bool clear = game.is_clear_cut(phases);
    if (result.guarantee == SequenceResult::Guarantee::infeasible) {
      if (std::isfinite(best) && clear)
        return {Outcome::wrong,
                fmt::format("certificate: no sequence, although one costs {:.6g}", best)};
      return {Outcome::reported, result.message};
    }
    if (!std::isfinite(best))
      return {result.found() && clear ? Outcome::wrong : Outcome::reported,
              fmt::format("a sequence, although none is feasible (end sensitivity {:.3g})",
                          game.speed)};
    const bool certifies = result.guarantee == SequenceResult::Guarantee::optimal ||
                           result.guarantee == SequenceResult::Guarantee::bounded;
    if (certifies && result.lower_bound > best + allowed)
      return {Outcome::wrong,
              fmt::format("certificate: bound {:.6g}, although a sequence costs {:.6g}",
                          result.lower_bound, best)};
    if (result.found() && result.cost < best - allowed)
      return {Outcome::wrong,
              fmt::format("cost {:.6g}, but the least cost is {:.6g} (end sensitivity {:.3g})",
                          result.cost, best, game.speed)};
    if (result.found() && std::abs(game.cost(result.modes) - result.cost) > allowed)
      return {Outcome::wrong, fmt::format("reported cost {:.6g}, but the sequence costs {:.6g}",
                                          result.cost, game.cost(result.modes))};
    if (result.guarantee == SequenceResult::Guarantee::optimal && result.cost > best + allowed)
      return {Outcome::wrong,
              fmt::format("certificate: optimal with cost {:.6g}, but the least cost is {:.6g}",
                          result.cost, best)};
    return {result.found() ? Outcome::right : Outcome::unsolved, result.message};
  };
  return instance;
}

}  // namespace saltus::corpus
