// What the feet of a whole body felt and how they slid, from the log of a run.
//
// Wrenches are (force N | torque Nm about the origin of the contact frame), left and right, in the
// axes of their soles.
#pragma once

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

/// Measured wrenches are also given as their mean over this last span, s.
inline constexpr double wrench_filter = 0.020;

/// Measured wrenches, one per sample.
std::vector<Vec<double, 12>> measured_wrenches(const RunLog& log);
/// The same as their mean over the filter.
std::vector<Vec<double, 12>> filtered_wrenches(const RunLog& log);

/// How far the soles have slid: the largest horizontal distance of one of the sole's corners from
/// where it stood first (swing: where it landed; zero before), so that a turn about the vertical is
/// told. Left and right, one per sample, m.
std::vector<Vec<double, 2>> sole_slip(const RunLog& log);

/// A foot that carries less than this tells no friction.
inline constexpr double friction_told_from = 1.0;  // N
/// The friction that the ground exerts on either foot, tangential over vertical force, one per
/// sample; zero where it carries less than `friction_told_from`.
std::vector<Vec<double, 2>> friction_used(const RunLog& log);

/// Largest vertical force of each foot, left and right, as the mean over `wrench_filter`, N.
Vec<double, 2> peak_forces(const RunLog& log);

}  // namespace saltus::walking
