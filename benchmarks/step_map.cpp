// Largest push of a pendulum per direction, depending on the freedom of its step planner. Prints
// CSV: direction (deg), then the largest impulse (N s) that was recovered with time and place
// fixed, place free, time free, both free, several steps; and the bound of the pendulum for 0 to 3
// steps. `step_map [left|both] [directions]`
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "benchmarks/pendulum_walker.hpp"
#include "saltus/robots/model/capturability.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::push_recovery {
namespace {

constexpr double usual_time = 0.6, shortest_time = 0.3;  // s
const Vec<double, 2> usual_place(0.0, 0.15);             // distance of the centres, m
constexpr double reach_forward = 0.25, reach_near = 0.13, reach_far = 0.31;

struct Variant {
  const char* name;
  bool free_place, free_time;
  int steps;
};
constexpr Variant variants[] = {{"fixed", false, false, 1},
                                {"place", true, false, 1},
                                {"time", false, true, 1},
                                {"both", true, true, 1},
                                {"steps", true, true, 3}};

StepModel model_of(const Variant& v, const WalkerOptions& walker) {
  StepModel m;
  m.sole = m.standing_sole = walker.half_sole.array() - 0.002;
  m.lent = walker.lent;
  m.lent_rate = walker.lent_rate;
  constexpr double fixed = 1e-3;  // m, s: half of the remaining width
  const double x = v.free_place ? reach_forward : fixed,
               y0 = v.free_place ? reach_near : usual_place[1] - fixed,
               y1 = v.free_place ? reach_far : usual_place[1] + fixed;
  m.reach = robots::SupportPolygon::hull(robots::corners_of(between(-x, x), between(y0, y1)))
                .half_planes(reach_rows);
  const Bounds far = between(-0.5, 0.5);
  m.leg = robots::SupportPolygon::hull(robots::corners_of(far, far)).half_planes(reach_rows);
  m.swing_speed = 2.0;
  if (v.free_time)
    m.swing = between(shortest_time, 0.9);
  else
    m.swing = between(usual_time, usual_time + fixed);
  m.usual_swing = usual_time;
  return m;
}

// --- the bound: sets of capture points from which it can be stopped ------------------------------

// N s, from rest in the middle of the stance; positions are those of the centres of the soles.
double bound(int steps, double angle, const WalkerOptions& walker) {
  const double omega = pendulum_frequency(walker.height), duration = PendulumPush{}.duration;
  const double decay = (1.0 - std::exp(-omega * duration)) / (omega * duration);
  const robots::FootRectangle sole{between(-walker.half_sole[0], walker.half_sole[0]),
                                   between(-walker.half_sole[1], walker.half_sole[1])};
  const robots::SteppingLimits limits{sole,
                                      sole,
                                      {{-reach_forward, reach_near},
                                       {reach_forward, reach_near},
                                       {reach_forward, reach_far},
                                       {-reach_forward, reach_far}},
                                      shortest_time};
  const robots::Point2 right(0.0, -usual_place[1]);
  const bool both = walker.left_stands && walker.right_stands;
  const std::vector<robots::SupportPolygon> sets =
      both ? robots::capturable_on_two_feet(limits, right, steps, omega)
           : std::vector<robots::SupportPolygon>{
                 robots::capturable(limits, robots::Side::left, steps, omega)};
  const robots::Point2 middle = both ? robots::Point2(0.5 * right) : robots::Point2(0.0, 0.0);
  const robots::Point2 along(std::cos(angle), std::sin(angle));
  double distance = 0.0;
  for (const robots::SupportPolygon& set : sets)
    distance = std::max(distance, robots::distance_to_border(set, middle, along));
  return distance * walker.mass * omega / decay;
}

// --- the map ------------------------------------------------------------------------------------

// Bisection to half an N s; survival is assumed monotone in the size of the push.
double largest(StepChoice& planner, const WalkerOptions& walker, double angle) {
  constexpr double most = 32.0, resolution = 0.5;  // N s
  double survived = 0.0, fallen = most;
  while (fallen - survived > resolution) {
    const double impulse = 0.5 * (survived + fallen);
    planner.restart();
    const PendulumPush push{0.05, 0.1, impulse * Vec<double, 2>(std::cos(angle), std::sin(angle))};
    (walk(planner, walker, {&push, 1}).recovered ? survived : fallen) = impulse;
  }
  return survived;
}

void print_map(WalkerOptions walker, int directions) {
  const double turn = 2.0 * std::numbers::pi / directions;
  std::vector<std::unique_ptr<StepChoice>> planners;
  const SoleCentres& centres = walker.centres;
  for (const Variant& v : variants)
    planners.push_back(std::make_unique<StepChoice>(
        model_of(v, walker), StepChoiceSettings{.most_steps = v.steps}, centres, usual_place));
  fmt::print("direction");
  for (const Variant& v : variants) fmt::print(",{}", v.name);
  for (int k = 0; k <= 3; ++k) fmt::print(",bound_{}", k);
  fmt::print("\n");
  std::vector<std::vector<double>> rows;
  std::vector<double> area(std::size(variants) + 4, 0.0);
  std::vector<double> first(area.size()), last(area.size());
  for (int i = 0; i < directions; ++i) {
    fmt::print("{:.2f}", 360.0 * i / directions);
    std::vector<double> radius;
    // Forwards equals backwards: soles and reach are symmetric about their centres.
    const int image = (directions + directions / 2 - i) % directions;
    const bool is_image = directions % 2 == 0 && image < i;
    for (std::size_t j = 0; j < planners.size(); ++j)
      radius.push_back(is_image ? rows[static_cast<std::size_t>(image)][j]
                                : largest(*planners[j], walker, i * turn));
    for (int k = 0; k <= 3; ++k) radius.push_back(bound(k, i * turn, walker));
    rows.push_back(radius);
    for (std::size_t j = 0; j < radius.size(); ++j) {
      fmt::print(",{:.2f}", radius[j]);
      if (i == 0)
        first[j] = radius[j];
      else
        area[j] += 0.5 * std::sin(turn) * last[j] * radius[j];
      last[j] = radius[j];
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  fmt::print("area");
  for (std::size_t j = 0; j < area.size(); ++j)
    fmt::print(",{:.0f}", area[j] + 0.5 * std::sin(turn) * last[j] * first[j]);
  fmt::print("\n");
}

}  // namespace
}  // namespace saltus::push_recovery

int main(int argc, char** argv) {
  saltus::push_recovery::WalkerOptions walker;
  walker.right_stands = argc > 1 && std::string(argv[1]) == "both";
  walker.duration = 3.5;
  walker.lent = 1e-4;  // negligible: the bound has no flywheel
  walker.lent_rate = 0.05;
  saltus::push_recovery::print_map(walker, argc > 2 ? std::max(3, std::atoi(argv[2])) : 16);
}
