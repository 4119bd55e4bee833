// Soft ground: forces on the soles, the same for all engines.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots {

/// Adds the forces of soft ground (`options.ground.sink` > 0) to an engine that was made with the
/// same options. They act on the feet alone, as pushes, and are part of contact().
///
/// The ground is a bed of springs and dampers under a grid of points of each sole. At a point of
/// depth d, with velocity v_n along the normal and v_t along the surface, the forces per area are
///
///     p = max(0, k d - c v_n),    q = -(k s + c v_t) limited to |q| <= friction p,
///
/// where the stretch s integrates v_t while the point touches, and follows from q while it slips.
/// The stiffness k makes a whole sole sink by `sink` under the weight of the robot. The damping c
/// is critical for this mass, or as large as the time step permits for the mass of the foot.
///
/// Throws InputError if the stiffness is too large for the time step.
std::unique_ptr<Plant> make_soft_ground(std::unique_ptr<Plant> engine, const FloatingRobot& robot,
                                        const Plant::Options& options);

}  // namespace saltus::robots
