// What the feet of a whole body felt and how they slid, from the log of a run.
//
// Wrenches are (force N | torque Nm about the origin of the contact frame), left and right, in the
// axes of their soles.
#pragma once

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

/// Measured wrenches are also given as their mean over this last span, s.
inline constexpr double wrench_filter = 0.020;

/// Measured wrenches, one per sample, and the same as their mean over the filter.
std::vector<Vec<double, 12>> measured_wrenches(const RunLog& log);
std::vector<Vec<double, 12>> filtered_wrenches(const RunLog& log);

/// Horizontal distance of the soles' origins from where they stood first (swing: where it landed;
/// zero before), left and right, one per sample, m.
std::vector<Vec<double, 2>> sole_slip(const RunLog& log);

/// Largest vertical force of each foot, left and right, as the mean over `wrench_filter`, N.
Vec<double, 2> peak_forces(const RunLog& log);

}  // namespace saltus::walking
