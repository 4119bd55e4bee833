// The plan of one tick; problem.cpp has the mathematics.
#pragma once

#include "problems/quadruped/rigid_body.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus::quadruped {

/// Data of a tick: desired motion of the body and positions of the feet.
template <class S>
struct Tick {
  S begin = 0.0;                                  // start of the horizon, s
  Vec<S, 3> position = Vec<S, 3>::Zero();         // desired position at `begin`, m
  Vec<S, 3> velocity = Vec<S, 3>::Zero();         // desired velocity, m/s
  S yaw = 0.0, yaw_rate = 0.0;                    // desired at `begin`, rad; throughout, rad/s
  PerLeg<S> feet = PerLeg<S>::Zero();             // present positions, or next landings, m
  PerLeg<S> next_feet = PerLeg<S>::Zero();        // positions after the next swing, m
  Vec<S, legs> next_from = Vec<S, legs>::Zero();  // middle of that swing, s
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
  double friction = 0.5;   // friction coefficient of the plan
  double strongest = 160;  // upward force of a foot, N
  double step = 0.03;      // interval of the grid, s
  int intervals = 15;
  double horizon() const { return step * intervals; }
};

/// Names of the modes of a leg for contacts.during().
inline std::string on_ground(int leg) { return leg_names[leg]; }
inline constexpr const char* in_air = "-";

/// Has the data "tick" of type Tick. Part i of `contacts` is the schedule of leg i.
OptimalControlProblem problem(const Model& model, const Weights& weights,
                              const JointSchedule& contacts);

}  // namespace saltus::quadruped
