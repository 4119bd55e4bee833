// Problems whose sequence of modes is to be found.
#pragma once

#include "saltus/sequences/mode_graph.hpp"

namespace saltus::library {

/// A pole on a cart between two soft walls that it may lean on, sampled every 0.1 s; the state is
/// (cart, pole angle, velocities) in m and rad.
ModeGraph cart_between_walls(const VectorXd& start);
/// Three rooms, each heated or not, at most two at a time, sampled every 10 min; deg C.
ModeGraph thermostats(const VectorXd& start);
/// Two tanks, a pump into the first and one from it to the second, each on or off, every 30 s; m.
ModeGraph two_tanks(const VectorXd& start);
/// When to fish, all or nothing, over twelve units of time with any number of trips.
ModeGraph fishing_modes();

}  // namespace saltus::library
