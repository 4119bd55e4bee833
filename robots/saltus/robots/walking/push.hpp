// A disturbance: an impulse on a link, spread over a time.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/core/types.hpp"

namespace saltus::walking {

/// Of the force over its duration.
enum class PushShape { rectangle, half_sine, triangle };

/// A force that acts for a while.
struct Push {
  double impulse = 7.0;                      ///< N s
  Vec<double, 3> direction{0.0, -1.0, 0.0};  ///< world axes, any length
  double duration = 0.1;                     ///< s
  double start = 2.4;                        ///< s
  PushShape shape = PushShape::rectangle;    ///< of the force over time; the impulse is the same
  /// Whole body: the link of the URDF that is pushed, and where, in its frame, m. The centroidal
  /// model is pushed on its CoM.
  std::string link = "chest";
  Vec<double, 3> point{0.0, 0.0, 0.0};  ///< in the frame of the link that is pushed, m

  double end() const { return start + duration; }  ///< s
};

/// Further pushes, of the same shape at the same point as the first.
struct MorePushes {
  /// "TIME IMPULSE ANGLE [DURATION]; ...": s, N s, degrees (0 forward, 90 to the left), s.
  std::string list;
  /// Drawn for long runs: so many per second on average up to `until`, in random directions on the
  /// ground; 0: none.
  double rate = 0.0;                 ///< Hz
  double until = 60.0;               ///< the last of them is over by then, s
  Vec<double, 2> impulse{3.0, 8.0};  ///< from, to, N s
  double apart = 4.0;                ///< at least, from begin to begin, s
  int seed = 1;                      ///< of what is drawn at random
};

/// The first push, those of the list and the random ones, in the order of time. With random ones
/// the first push is left out: it is their pattern. Throws InputError for a list that cannot be
/// read, pushes that overlap, and random ones that have no room.
std::vector<Push> all_pushes(const Push& first, const MorePushes& more);

/// As settings have it.
const char* describe(PushShape shape);

/// The fraction of the impulse that was given up to `t` (s), 0 to 1.
double impulse_fraction(const Push& push, double t);
/// Mean of the force over an interval, s: applied as a constant it gives the impulse of the
/// interval exactly, wherever its ends lie. World axes, N.
Vec<double, 3> mean_push_force(const Push& push, double from, double to);
/// The same of all together.
Vec<double, 3> total_push_force(std::span<const Push> pushes, double from, double to);

}  // namespace saltus::walking
