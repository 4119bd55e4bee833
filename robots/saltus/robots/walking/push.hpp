// Forces of the pushes of the settings.
#pragma once

#include <span>
#include <vector>

#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::walking {

/// The first push, those of the list and the random ones, sorted by time. With random pushes, the
/// first push is only their pattern and is left out. Throws InputError for a list that cannot be
/// read, for pushes that overlap, and for random pushes that do not fit into the time.
std::vector<Push> all_pushes(const Push& first, const MorePushes& more);

/// Name in the settings.
const char* describe(PushShape shape);

/// Fraction of the impulse applied up to `t` (s), 0 to 1.
double impulse_fraction(const Push& push, double t);
/// Mean force over an interval, world axes, N. Applied as a constant it gives exactly the impulse
/// of the interval, wherever the interval begins and ends.
Vec<double, 3> mean_push_force(const Push& push, double from, double to);
/// Sum of the mean forces of all pushes, world axes, N.
Vec<double, 3> total_push_force(std::span<const Push> pushes, double from, double to);

}  // namespace saltus::walking
