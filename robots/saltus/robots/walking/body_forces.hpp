// Forces on the feet of a whole body and their slip, from the log of a run.
//
// Wrenches are (force N | torque Nm about the origin of the contact frame), left and right, in the
// axes of their soles.
#pragma once

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::robots::walking {

/// Time span over which measured wrenches are averaged, s.
inline constexpr double wrench_filter = 0.020;

/// Measured wrenches, one per sample.
std::vector<Vec<double, 12>> measured_wrenches(const RunLog& log);
/// Measured wrenches averaged over `wrench_filter`.
std::vector<Vec<double, 12>> filtered_wrenches(const RunLog& log);

/// Slip of the soles, left and right, one per sample, m: the largest horizontal distance of a
/// corner from its first contact (swing foot: from its landing; zero until then). Corners also
/// detect rotation about the vertical.
std::vector<Vec<double, 2>> sole_slip(const RunLog& log);

/// Smallest vertical force for which friction is evaluated.
inline constexpr double friction_min_force = 1.0;  // N
/// Ratio of tangential to vertical force of each foot, one per sample; zero below
/// `friction_min_force`.
std::vector<Vec<double, 2>> friction_used(const RunLog& log);

/// Largest vertical force of each foot, left and right, averaged over `wrench_filter`, N.
Vec<double, 2> peak_forces(const RunLog& log);

}  // namespace saltus::robots::walking
