// The plan of one tick; its mathematics is in problem.cpp.
#pragma once

#include "problems/quadruped/rigid_body.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/joint_schedule.hpp"
#include "saltus/ocp/problem.hpp"

namespace saltus::quadruped {

/// Where the body should be and the feet will stand: data of a tick.
template <class S>
struct Tick {
  S begin = 0.0;                                  // of the horizon, s
  Vec<S, 3> position = Vec<S, 3>::Zero();         // wanted at `begin`, m
  Vec<S, 3> velocity = Vec<S, 3>::Zero();         // wanted throughout, m/s
  S yaw = 0.0, yaw_rate = 0.0;                    // wanted at `begin`, rad; throughout, rad/s
  PerLeg<S> feet = PerLeg<S>::Zero();             // where they stand, or will land, m
  PerLeg<S> next_feet = PerLeg<S>::Zero();        // after the next swing, m
  Vec<S, legs> next_from = Vec<S, legs>::Zero();  // in the middle of that swing, s
  using Entries =
      ParameterEntries<&Tick::begin, &Tick::position, &Tick::velocity, &Tick::yaw, &Tick::yaw_rate,
                       &Tick::feet, &Tick::next_feet, &Tick::next_from>;
};

struct Weights {
  State<double> state{{5.0, 20.0, 400.0, 10.0, 20.0, 10.0, 60.0, 60.0, 20.0, 0.5, 0.5, 0.5}};
  double force = 4e-5;
};

struct Model {
  Body body;
  double friction = 0.5;   // what the plan counts on
  double strongest = 160;  // upward force of a foot, N
  double step = 0.03;      // of the grid, s
  int intervals = 15;
  double horizon() const { return step * intervals; }
};

/// Modes of a leg, as contacts.during() takes them.
inline std::string on_ground(int leg) { return leg_names[leg]; }
inline constexpr const char* in_air = "-";

/// Data "tick": Tick. Part i of `contacts` is the schedule of leg i.
OptimalControlProblem problem(const Model& model, const Weights& weights,
                              const JointSchedule& contacts);

}  // namespace saltus::quadruped
