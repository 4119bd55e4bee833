// A disturbance: an impulse on a link, spread over a time.
#pragma once

#include <span>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus {
class Settings;
}

namespace saltus::walking {

enum class PushShape { rectangle, half_sine, triangle };

struct Push {
  double impulse = 7.0;                      ///< N s
  Vec<double, 3> direction{0.0, -1.0, 0.0};  ///< world axes, any length
  double duration = 0.1;                     ///< s
  double start = 2.4;                        ///< s
  PushShape shape = PushShape::rectangle;    ///< of the force over time; the impulse is the same
  /// Whole body: the link of the URDF that is pushed, and where, in its frame, m. The centroidal
  /// model is pushed on its CoM.
  std::string link = "chest";
  Vec<double, 3> point{0.0, 0.0, 0.0};

  double end() const { return start + duration; }  ///< s
};

const char* describe(PushShape shape);

/// The fraction of the impulse that was given up to `t` (s), 0 to 1.
double impulse_fraction(const Push& push, double t);
/// Mean of the force over an interval, s: applied as a constant it gives the impulse of the
/// interval exactly, wherever its ends lie. World axes, N.
Vec<double, 3> mean_push_force(const Push& push, double from, double to);
/// The same of all together.
Vec<double, 3> total_push_force(std::span<const Push> pushes, double from, double to);

/// push.impulse, direction, duration, start, shape.
void declare_settings(Settings& settings, Push& push);
/// push.link and push.point, which a model without links has no use for.
void declare_point_of_push(Settings& settings, Push& push);

}  // namespace saltus::walking
