// A throw over two bounces into a basket at 4 m. The unknown is the initial velocity with which the
// ball arrives softly. CVODES locates the impacts and differentiates through them.
#include <cstdio>
#include <fstream>
#include <saltus/integrators/sundials.hpp>
#include <saltus/saltus.hpp>
#include <saltus/solver/ipopt.hpp>

using namespace saltus;

template <class S>
struct Ball {
  S drag = 0.02;         // 1/m
  S restitution = 0.75;  // factor on the speed normal to the ground
  S grip = 0.9;          // factor on the speed along the ground

  using Entries = ParameterEntries<&Ball::drag, &Ball::restitution, &Ball::grip>;
};

struct Flight {  // x = (distance, height, their rates) in m and m/s
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 0>&,
                       const Vec<S, size_of<Ball>>& p) const {
    const S resistance = view_as<Ball>(p).drag * sqrt(x[2] * x[2] + x[3] * x[3] + 1e-6);
    return {x[2], x[3], -resistance * x[2], -9.81 - resistance * x[3]};
  }
};

int main() {
  const auto height = [](auto, auto x) { return x[1]; };
  const auto bounce = [](auto, auto x, auto, auto p) {
    const auto ball = view_as<Ball>(p);
    return decltype(x){x[0], x[1], ball.grip * x[2], -ball.restitution * x[3]};
  };
  const auto place = [](auto, auto x) { return x.template head<2>().eval(); };
  const auto speed = [](auto, auto x) { return x.template tail<2>().eval(); };

  Phase<4, 0, size_of<Ball>> flight{"flight", Flight{}, between(0.5, 3.0)};
  flight.on("impact", height, Crossing::falling, bounce)
      .reach("basket", place, {exactly(4.0), exactly(0.5)})
      .track_at_end("softly", speed, VectorXd::Ones(2))
      .data("ball", Ball<double>{})
      .guess_duration(1.7)
      .guess_state(Guess::simulate());
  OptimalControlProblem game("throw");
  game.start_within({exactly(0.0), exactly(1.5), between(0.5, 8.0), between(-8.0, 8.0)},
                    VectorXd{{0.0, 1.5, 2.5, 1.0}})
      .then(flight);

  const Solution plan = solve(game, {.intervals_per_phase = 17,
                                     .integrator = cvodes({.tolerance = 1e-9}),
                                     .solver = make_ipopt({.tolerance = 1e-7})});
  const VectorXd start = plan.trajectory.state(0.0);
  std::printf("%s: thrown with (%.3f, %.3f) m/s, %.3f s in the air\n", plan.message.c_str(),
              start[2], start[3], plan.durations[0]);

  Recording recording = record(game, plan.trajectory, 12);
  recording.state_names = {"distance [m]", "height [m]", "v_x [m/s]", "v_y [m/s]"};
  std::ofstream("ball.csv") << recording.trajectory_csv();
  for (const HybridEvent& event : recording.events)
    std::printf("%s at %.6f s\n", event.name.c_str(), event.time);
  return plan.ok() && recording.events.size() == 2 ? 0 : 1;
}
