// The hopper of the tutorial: a body on a light leg.
#pragma once

#include <cmath>
#include <cstdio>
#include <saltus/saltus.hpp>
#include <string>

using namespace saltus;

inline constexpr double gravity = 9.81;     // m/s^2
inline constexpr double mass = 10.0;        // kg
inline constexpr double leg = 0.5;          // m, length of the straight leg
inline constexpr double deepest = 0.25;     // m, lowest height of the body
inline constexpr double strongest = 400.0;  // N, largest force of the leg

struct Stance {  // x = (height m, speed upwards m/s), u = force of the leg, N
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] / mass - gravity};
  }
};

struct Flight {  // no force
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {x[1], S(-gravity)};
  }
};

inline constexpr auto height = [](auto, auto x) { return x[0]; };
inline constexpr auto speed = [](auto, auto x) { return x[1]; };
inline constexpr auto force = [](auto, auto, auto u) { return u[0]; };
// Zero if the leg is straight.
inline constexpr auto off_the_ground = [](auto, auto x) { return x[0] - leg; };
// Predicted apex of the flight, m.
inline constexpr auto apex = [](auto, auto x) { return x[0] + x[1] * x[1] / (2.0 * gravity); };
// The foot has a twentieth of the mass and stops at landing.
inline constexpr auto landing = [](auto, auto x) { return decltype(x){x[0], 0.95 * x[1]}; };

// Stance with a bounded force.
inline Phase<2, 1> stance(const std::string& name, Bounds duration) {
  Phase<2, 1> phase{name, Stance{}, duration};
  phase.bound_input(0, between(0.0, strongest))
      .bound_state(0, between(deepest, leg))
      .track("effort", force, VectorXd::Constant(1, 1e-4))
      .nominal(VectorXd{{0.5, 2.0}}, VectorXd::Constant(1, 100.0));
  return phase;
}

// Flight until the straight leg touches the ground.
inline Phase<2, 0> flight(const std::string& name) {
  Phase<2, 0> phase{name, Flight{}, between(0.05, 2.0)};
  phase.ends_when("touch-down", off_the_ground, Crossing::falling).guess_duration(0.4);
  return phase;
}

inline const std::vector<std::string> state_names{"height [m]", "speed [m/s]"};
inline const std::vector<std::string> input_names{"force [N]"};
