// Pushes: impulses on a link, spread over a time.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus::walking {

/// Shape of the force over time.
enum class PushShape { rectangle, half_sine, triangle };

/// A force on the robot for a limited time.
struct Push {
  double impulse = 7.0;                      ///< N s
  Vec<double, 3> direction{0.0, -1.0, 0.0};  ///< world axes, any length
  double duration = 0.1;                     ///< s
  double start = 2.4;                        ///< s
  PushShape shape = PushShape::rectangle;  ///< shape of the force over time; it does not change the
                                           ///< impulse
  /// For the whole body: pushed link of the URDF, and the point in its frame, m. The centroidal
  /// model is pushed at its CoM.
  std::string link = "chest";
  Vec<double, 3> point{0.0, 0.0, 0.0};  ///< in the frame of the pushed link, m

  double end() const { return start + duration; }  ///< s
};

/// Further pushes, with the shape and point of the first one.
struct MorePushes {
  /// "TIME IMPULSE ANGLE [DURATION]; ...": s, N s, degrees (0 forward, 90 to the left), s.
  std::string list;
  /// Mean rate of random pushes in random horizontal directions; 0: none.
  double rate = 0.0;                 ///< Hz
  double until = 60.0;               ///< time at which the last of them is over, s
  Vec<double, 2> impulse{3.0, 8.0};  ///< range, N s
  double apart = 4.0;                ///< smallest time between two starts, s
  int seed = 1;                      ///< seed of the random pushes
};

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
