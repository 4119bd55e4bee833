// A state constraint in two adjacent phases has two equal rows at their common node. Twelve
// problems of this kind from a fixed generator are solved from a flat guess: the start at every
// node.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

constexpr auto effort = [](auto, auto, auto u) { return u.dot(u); };
constexpr auto whole_state = [](auto, auto x) { return x; };
constexpr auto clock = [](auto t, auto) { return t; };

struct Case {
  std::string name;
  OptimalControlProblem problem;
};

// Two phases with the same dynamics. `keep(phase, window)` limits the state, and `close(phase)`
// sets the end of the second phase. Without `twice` the limit in the second phase begins after its
// first node.
template <int nx, int nu, class Dynamics, class Keep, class Close>
Case two_phases(const std::string& name, bool twice, const Vec<double, nx>& start,
                Dynamics dynamics, Bounds first_duration, Bounds second_duration, Keep keep,
                Close close) {
  Case result{name, OptimalControlProblem(name)};
  result.problem.costs(CostRule::integrated).start_at(start);
  Phase<nx, nu> first{"first", dynamics, first_duration},
      second{"second", dynamics, second_duration};
  for (auto* phase : {&first, &second}) {
    const bool is_behind = phase == &second && !twice;
    keep(*phase, is_behind ? Window{.from = 1e-3} : Window{});
    phase->minimise("effort", effort).guess_state(Guess::constant(start));
    phase->guess_duration(1.0);
  }
  close(second);
  result.problem.then(first).then(second);
  return result;
}

std::vector<Case> cases(std::uint64_t seed, bool twice) {
  Random random(seed);
  const auto between_of = [&](double low, double high) { return random.uniform(low, high); };
  std::vector<Case> all;
  const Bounds second = exactly(1.0), free = between(0.3, 3.0);
  const auto pendulum = [](auto, auto x, auto u) { return decltype(x){x[1], u[0] - sin(x[0])}; };
  const auto cart = [](auto, auto x, auto u) { return decltype(x){x[1], u[0]}; };
  const auto plane = [](auto, auto x, auto u) { return decltype(x){x[2], x[3], u[0], u[1]}; };
  {
    const double limit = between_of(0.36, 0.5), far = between_of(0.5, 0.65);
    all.push_back(two_phases<2, 1>(
        "square of a speed", twice, {0.0, 0.0}, pendulum, second, second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[1] * x[1]; }, at_most(limit * limit), w);
        },
        [=](auto& p) {
          p.reach("there", whole_state, {exactly(far), exactly(0.0)});
        }));
  }
  {
    const double ceiling = between_of(0.15, 0.22);
    all.push_back(two_phases<2, 1>(
        "ceiling", twice, {0.0, 0.5}, cart, second, second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[0]; }, at_most(ceiling), w);
        },
        [](auto& p) {
          p.reach("there", whole_state, {exactly(0.0), exactly(-0.5)});
        }));
  }
  {
    const double radius = between_of(0.4, 0.6), offset = between_of(0.25, 0.35);
    all.push_back(two_phases<4, 2>(
        "pillar", twice, {-1.0, offset, 0.0, 0.0}, plane, second, second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[0] * x[0] + x[1] * x[1]; },
              at_least(radius * radius), w);
        },
        [=](auto& p) {
          p.reach("there", whole_state,
                  {exactly(1.0), exactly(offset), exactly(0.0), exactly(0.0)});
        }));
  }
  {
    const double drag = between_of(0.1, 0.4), limit = between_of(0.6, 1.0);
    all.push_back(two_phases<2, 1>(
        "fastest way with a speed limit", twice, {0.0, 0.0},
        [=](auto, auto x, auto u) {
          return decltype(x){x[1], u[0] - drag * x[1] * x[1]};
        },
        free, free,
        [=](auto& p, Window w) {
          p.bound_input(0, between(-1.0, 1.0));
          p.keep(
              "limit", [](auto, auto x) { return x[1] * (1.0 + 0.1 * x[0]); }, at_most(limit), w);
        },
        [](auto& p) {
          p.reach("there", whole_state, {exactly(2.0), exactly(0.0)})
              .minimise_at_end("time", clock);
        }));
  }
  {
    const double level = between_of(0.7, 0.9), target = between_of(0.4, 0.6);
    all.push_back(two_phases<2, 1>(
        "tanks", twice, {0.2, 0.2},
        [](auto, auto x, auto u) {
          const auto flow = 0.5 * sqrt(x[0] + 0.05);
          return decltype(x){u[0] - flow, flow - 0.4 * sqrt(x[1] + 0.05)};
        },
        exactly(1.5), exactly(1.5),
        [=](auto& p, Window w) {
          p.bound_input(0, between(0.0, 1.0));
          p.keep(
              "limit", [](auto, auto x) { return x[0]; }, at_most(level), w);
        },
        [=](auto& p) {
          p.reach(
              "there", [](auto, auto x) { return x[1]; }, exactly(target));
        }));
  }
  {
    const double angle = between_of(1.0, 2.0);
    all.push_back(two_phases<2, 2>(
        "on a circle", twice, {1.0, 0.0}, [](auto, auto, auto u) { return decltype(u){u}; }, second,
        second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[0] * x[0] + x[1] * x[1]; }, exactly(1.0), w);
        },
        [=](auto& p) {
          p.reach(
              "there",
              [=](auto, auto x) { return x[0] * std::sin(angle) - x[1] * std::cos(angle); },
              exactly(0.0));
        }));
  }
  {
    const double floor = between_of(-0.6, -0.3);
    all.push_back(two_phases<2, 1>(
        "van der Pol", twice, {0.0, 1.0},
        [](auto, auto x, auto u) {
          return decltype(x){x[1], (1.0 - x[0] * x[0]) * x[1] - x[0] + u[0]};
        },
        exactly(2.5), exactly(2.5),
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[1]; }, at_least(floor), w);
          p.minimise("state", [](auto, auto x) { return x.dot(x); });
        },
        [](auto&) {}));
  }
  {
    const double energy = between_of(0.25, 0.4);
    all.push_back(two_phases<2, 1>(
        "energy", twice, {0.0, 0.0}, pendulum, free, free,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return 0.5 * x[1] * x[1] + 1.0 - cos(x[0]); },
              at_most(energy), w);
        },
        [](auto& p) {
          p.reach("there", whole_state, {exactly(-0.6), exactly(0.0)})
              .minimise_at_end("time", [](auto t, auto) { return 0.1 * t; });
        }));
  }
  {
    const double width = between_of(0.25, 0.4);
    all.push_back(two_phases<4, 2>(
        "two rows", twice, {0.0, 0.0, 0.0, 0.0}, plane, exactly(1.5), second,
        [=](auto& p, Window w) {
          p.keep(
              "limit",
              [](auto, auto x) {
                using S = std::decay_t<decltype(x[0])>;
                return Vec<S, 2>{x[1] - x[0] * x[0], x[2] * x[2] + x[3] * x[3]};
              },
              {between(-width, width), at_most(1.0)}, w);
        },
        [](auto& p) {
          p.reach("there",
                  [](auto, auto x) {
                    return Vec<std::decay_t<decltype(x[0])>, 2>{x[0], x[1]};
                  },
                  {exactly(1.2), exactly(1.2)});
        }));
  }
  {
    const double rise = between_of(0.1, 0.3);
    all.push_back(two_phases<2, 1>(
        "ceiling that rises", twice, {0.0, 1.0}, cart, second, second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [=](auto t, auto x) { return x[0] - rise * t; }, at_most(0.25), w);
        },
        [](auto& p) {
          p.reach("there", whole_state, {exactly(0.1), exactly(-0.5)});
        }));
  }
  {
    const double wall = between_of(0.35, 0.5);
    all.push_back(two_phases<3, 2>(
        "car beside a wall", twice, {0.0, 0.0, 0.0},
        [](auto, auto x, auto u) {
          return decltype(x){u[0] * cos(x[2]), u[0] * sin(x[2]), u[1]};
        },
        second, second,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [=](auto, auto x) { return x[1] - wall * sin(x[0]); }, at_most(0.0), w);
        },
        [=](auto& p) {
          p.reach("there",
                  [](auto, auto x) {
                    return Vec<std::decay_t<decltype(x[0])>, 2>{x[0], x[1]};
                  },
                  {exactly(2.0), exactly(0.8 * wall)});
        }));
  }
  {
    const double size = between_of(1e3, 1e4);  // m
    all.push_back(two_phases<2, 1>(
        "large units", twice, {0.0, 0.0}, cart, exactly(50.0), free,
        [=](auto& p, Window w) {
          p.keep(
              "limit", [](auto, auto x) { return x[1]; }, at_most(size / 40.0), w);
          p.guess_duration(1.0);
        },
        [=](auto& p) {
          p.reach("there", whole_state, {exactly(size), exactly(0.0)});
        }));
  }
  return all;
}

Solution solved(const OptimalControlProblem& problem, SolverChoice choice) {
  MultipleShooting shooting(problem,
                            {.intervals_per_phase = 10,
                             .integrator = runge_kutta4(),
                             .accuracy = {.verify = false}});  // this test compares rows at nodes
  return solve(shooting, *make_solver(choice));
}

TEST(AdjacentPhases, SharedLimitDoesNotBlockProgress) {
  const std::vector<Case> kept_in_both = cases(1, true), once = cases(1, false);
  ASSERT_EQ(kept_in_both.size(), 12u);
  for (std::size_t i = 0; i < kept_in_both.size(); ++i)
    for (const SolverChoice choice :
         {SolverChoice::sparse, SolverChoice::riccati, SolverChoice::ipopt}) {
      SCOPED_TRACE(fmt::format("{}, {}", kept_in_both[i].name, name_of(choice)));
      const Solution both = solved(kept_in_both[i].problem, choice);
      EXPECT_TRUE(both.ok()) << both.message;
      // Without the second row the second phase has one more node, 1 ms after its first. The phase
      // change of a fastest path is free, so grids have several optima.
      EXPECT_NEAR(both.cost, solved(once[i].problem, choice).cost, 1e-3 * both.cost);
    }
}

}  // namespace
}  // namespace saltus
