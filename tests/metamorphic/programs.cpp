// The problems of examples/, docs/first_problem.cpp and docs/tutorial/, as stated in their
// programs.
#include "docs/tutorial/hopper.hpp"
#include "saltus/integrators/sundials.hpp"
#include "tests/metamorphic/cases.hpp"

namespace saltus::metamorphic {
namespace {

struct Gear {              // x = (position m, speed m/s), u = (throttle, brake)
  double thrust, braking;  // m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 2>& u) const {
    return {x[1], thrust * u[0] - braking * u[1] - 0.01 * x[1] * x[1]};
  }
};

OptimalControlProblem car(bool with_clutch_window) {
  const auto clock = [](auto t, auto) { return t; };
  Phase<2, 2> first{"first gear", Gear{6.0, 8.0}, between(0.5, 10.0)};
  first.bound_input(0, between(0.0, 1.0))
      .bound_input(1, exactly(0.0))
      .keep("rev limit", speed, at_most(12.0));
  Phase<2, 2> second{"second gear", Gear{3.0, 8.0}, between(0.5, 20.0)};
  second.bound_input(0, between(0.0, 1.0)).bound_input(1, between(0.0, 1.0));
  if (with_clutch_window)
    second.keep("clutch settles", speed, at_most(14.0), Window{.from = 0.0, .to = 0.3});
  second.reach("finish line", height, exactly(100.0))
      .reach("at rest", speed, exactly(0.0))
      .minimise_at_end("time", clock);
  OptimalControlProblem problem("car");
  problem.start_at({0, 0}).then(first).then(second, jump<2>("clutch", [](auto, auto x) {
                                              return decltype(x){x[0], 0.97 * x[1]};
                                            }));
  return problem;
}

struct Ball {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 0>&, const Vec<S, 3>& p) const {
    const S resistance = p[0] * sqrt(x[2] * x[2] + x[3] * x[3] + 1e-6);
    return {x[2], x[3], -resistance * x[2], -9.81 - resistance * x[3]};
  }
};

OptimalControlProblem throw_of_a_ball() {
  const auto ground = [](auto, auto x) { return x[1]; };
  const auto bounce = [](auto, auto x, auto, auto p) {
    return decltype(x){x[0], x[1], p[2] * x[2], -p[1] * x[3]};
  };
  const auto place = [](auto, auto x) { return x.template head<2>().eval(); };
  const auto rates = [](auto, auto x) { return x.template tail<2>().eval(); };
  Phase<4, 0, 3> flight{"flight", Ball{}, between(0.5, 3.0)};
  flight.on("impact", ground, Crossing::falling, bounce)
      .reach("basket", place, {exactly(4.0), exactly(0.5)})
      .track_at_end("softly", rates, VectorXd::Ones(2))
      .data("ball", VectorXd{{0.02, 0.75, 0.9}})
      .guess_duration(1.7)
      .guess_state(Guess::simulate());
  OptimalControlProblem problem("throw");
  problem
      .start_within({exactly(0.0), exactly(1.5), between(0.5, 8.0), between(-8.0, 8.0)},
                    VectorXd{{0.0, 1.5, 2.5, 1.0}})
      .then(flight);
  return problem;
}

struct Crane {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 1>& u) const {
    const S s = sin(x[1]), c = cos(x[1]);
    const S all = 1.0 + 2.0 * s * s, spin = 3.0 * x[3] * x[3] * s;
    return {x[2], x[3], (spin + u[0] + 2.0 * 9.81 * c * s) / all,
            -(spin * c + u[0] * c + 3.0 * 9.81 * s) / (1.5 * all)};
  }
};

OptimalControlProblem crane() {
  const auto state = [](auto, auto x) { return x; };
  Phase<4, 1> move{"move", Crane{}, exactly(3.0)};
  move.bound_input(0, between(-10.0, 10.0))
      .bound_state(1, between(-0.25, 0.25))
      .reach("there, at rest", state, {exactly(2.0), exactly(0.0), exactly(0.0), exactly(0.0)})
      .track("effort", force, VectorXd::Ones(1));
  OptimalControlProblem problem("crane");
  problem.start_at({0, 0, 0, 0}).then(move);
  return problem;
}

struct Warmth {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 3>& p) const {
    const S flow = p[1] * (x[0] - x[1]);
    return {2.0 * u[0] - flow - p[0] * (x[0] - p[2]), 0.15 * flow};
  }
};

OptimalControlProblem office() {
  Phase<2, 1, 3> phase{"office", Warmth{}, exactly(12.0)};
  phase.bound_input(0, between(0.0, 4.0))
      .keep("comfort", height, between(20.0, 23.0), during("open"), soft("comfort", 50.0))
      .minimise(
          "energy by day", [](auto, auto, auto u) { return 3.0 * u[0]; }, during("open"))
      .minimise("energy by night", force, during("closed"))
      .track("calm", force, VectorXd::Constant(1, 0.05))
      .data("house", VectorXd{{0.12, 0.6, 2.0}});
  OptimalControlProblem problem("office");
  problem.start_at({16, 16})
      .schedule(Schedule({"closed", "open", "closed", "open", "closed"},
                         {{"open 1", 8}, {"close 1", 18}, {"open 2", 32}, {"close 2", 42}}))
      .then(phase);
  return problem;
}

Phase<2, 1> push_off(bool high_enough) {
  Phase<2, 1> push = stance("push off", between(0.05, 1.0));
  push.ends_when("lift-off", off_the_ground, Crossing::rising).guess_duration(0.3);
  if (high_enough) push.reach("fast enough", apex, at_least(0.75));
  return push;
}

OptimalControlProblem tutorial(int step) {
  OptimalControlProblem problem("tutorial");
  problem.start_at({0.3, 0.0});
  if (step == 1) {
    Phase<2, 1> rise = stance("rise", exactly(0.5));
    rise.reach("straight", height, exactly(leg)).reach("at rest", speed, exactly(0.0));
    problem.then(rise);
  } else if (step == 2) {
    problem.then(push_off(true));
  } else if (step == 3) {
    Phase<2, 0> fly{"rise in the air", Flight{}, between(0.05, 2.0)};
    fly.ends_when("apex", speed, Crossing::falling)
        .reach("high enough", height, at_least(0.75))
        .guess_duration(0.2);
    problem.then(push_off(false)).then(fly);
  } else if (step == 4) {
    Phase<2, 1> land = stance("land", between(0.05, 1.0));
    land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0));
    problem.then(push_off(true)).then(flight("fly")).then(land, jump<2>("landing", landing));
  } else if (step == 5) {
    Phase<2, 1> bounce = stance("bounce", between(0.1, 1.0));
    bounce.ends_when("lift-off", off_the_ground, Crossing::rising)
        .reach("fast enough", apex, at_least(0.75))
        .guess_duration(0.4)
        .guess_state(Guess::interpolate(VectorXd{{leg, -2.0}}, VectorXd{{leg, 2.0}}));
    Phase<2, 0> fly = flight("fly");
    fly.guess_state(Guess::interpolate(VectorXd{{leg, 2.0}}, VectorXd{{leg, -2.0}}));
    problem.start_within({exactly(leg), between(-4.0, -0.5)}, VectorXd{{leg, -2.0}});
    problem.then(bounce).then(fly).close(jump<2>("landing", landing));
  } else {
    problem.start_at({leg, -2.1});
    for (int hop = 1; hop <= 4; ++hop) {
      const std::string number = std::to_string(hop);
      Phase<2, 1> bounce = stance("bounce " + number, between(0.05, 1.0));
      bounce.ends_when("lift-off", off_the_ground, Crossing::rising)
          .reach("fast enough", apex, exactly(0.75))
          .guess_duration(0.4)
          .guess_state(Guess::interpolate(VectorXd{{leg, -2.1}}, VectorXd{{leg, 2.2}}));
      Phase<2, 0> fly = flight("fly " + number);
      fly.guess_state(Guess::interpolate(VectorXd{{leg, 2.2}}, VectorXd{{leg, -2.2}}));
      if (hop == 1)
        problem.then(bounce);
      else
        problem.then(bounce, jump<2>("landing", landing));
      problem.then(fly);
    }
    Phase<2, 1> land = stance("land", between(0.05, 1.0));
    land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0));
    land.guess_state(Guess::interpolate(VectorXd{{leg, -2.1}}, VectorXd{{0.3, 0.0}}));
    problem.then(land, jump<2>("landing", landing));
  }
  return problem;
}

ShootingOptions grid(int intervals, IntegratorChoice integrator = runge_kutta4({.steps = 2})) {
  return {.intervals_per_phase = intervals, .integrator = std::move(integrator)};
}

}  // namespace

std::vector<Case> program_cases() {
  std::vector<Case> all{
      {"first_problem",
       [] {
         return Stated{car(true), grid(30)};
       },
       500, true},
      {"example_car",
       [] {
         return Stated{car(false), grid(30)};
       },
       500, true},
      {"example_ball",
       [] {
         return Stated{throw_of_a_ball(), grid(17, cvodes({.tolerance = 1e-9}))};
       }},
      {"example_crane",
       [] {
         return Stated{crane(), grid(60)};
       }},
      {"example_heating",
       [] {
         return Stated{office(), grid(48, zero_order_hold())};
       },
       500, true},
  };
  for (int step = 1; step <= 6; ++step)
    all.push_back({"tutorial_" + std::to_string(step),
                   [step] {
                     return Stated{tutorial(step), grid(step == 6 ? 15 : 30)};
                   },
                   500, step < 6});
  return all;
}

}  // namespace saltus::metamorphic
