// Actions of `saltus robot` with a link: check a live robot, serve a simulated one, replay a log.
#pragma once

#include <span>
#include <string>

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"

namespace saltus::robots::walking {

/// `saltus robot check --link`: moves each joint slightly and reports faults.
ExitStatus check_live_robot(std::span<const std::string> arguments,
                            const ConfigurableBiped& defaults);
/// `saltus robot serve`: simulates a robot for a controller in another process.
ExitStatus serve_simulated_robot(std::span<const std::string> arguments,
                                 const ConfigurableBiped& defaults);
/// `saltus robot play`: replays the readings of a log for a controller in another process.
ExitStatus play_log(std::span<const std::string> arguments);

}  // namespace saltus::robots::walking
