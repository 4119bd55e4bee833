// Problems whose sequence of modes is searched.
#pragma once

#include "saltus/sequences/mode_graph.hpp"

namespace saltus::library {

/// A pole on a cart between two soft walls that it may lean on, sampled every 0.1 s; the state is
/// (cart, pole angle, velocities) in m and rad.
ModeGraph cart_between_walls(const VectorXd& start);
/// Three rooms with a heater each, at most two on, sampled every 10 min; deg C.
ModeGraph thermostats(const VectorXd& start);
/// Two tanks, a pump into the first and a pump to the second, on or off, sampled every 30 s; m.
ModeGraph two_tanks(const VectorXd& start);
/// Fishing on or off over twelve time units with any number of trips.
ModeGraph fishing_modes();

}  // namespace saltus::library
