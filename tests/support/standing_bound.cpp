#include "tests/support/standing_bound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::robots {
namespace {

void check_positive(double value, const char* name, const char* unit) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw DefinitionError(
        fmt::format("standing bound: the {} must be positive, not {} {}", name, value, unit));
}

void check(const StandingPush& push) {
  check_positive(push.mass, "mass", "kg");
  check_positive(push.height, "height of the centre of mass", "m");
  check_positive(push.duration, "duration of the push", "s");
  if (!(push.distance_to_edge >= 0.0) || !std::isfinite(push.distance_to_edge))
    throw DefinitionError(
        fmt::format("standing bound: the distance to the edge must not be negative, but is {} m: "
                    "the centre of mass must start above the foot",
                    push.distance_to_edge));
  if (!(push.torque > 0.0))
    throw DefinitionError(
        fmt::format("standing bound: the torque must be positive, not {} Nm", push.torque));
  if (!(push.settle_time >= push.duration) || !std::isfinite(push.settle_time))
    throw DefinitionError(
        fmt::format("standing bound: the settle time of {} s ends before the push of {} s",
                    push.settle_time, push.duration));
}

// integral_0^ramp t e^(-omega t) dt, by its series where the closed form suffers from cancellation.
double ramp_integral(double ramp, double omega) {
  const double a = omega * ramp;
  if (a < 1e-4) return ramp * ramp * (0.5 - a / 3.0);  // next term a^2 / 8: relative error < 1e-8
  return (-std::expm1(-a) - a * std::exp(-a)) / (omega * omega);
}

// Right side of the condition in the header, in m: the distance by which the best H(t) with this
// peak moves the capture point back.
double gain(double peak, const StandingPush& push, double omega) {
  const double ramp = std::min(peak / push.torque, 0.5 * push.settle_time);
  const double slope = ramp > 0.0 ? std::min(push.torque, peak / ramp) : 0.0;
  const double reached = std::isfinite(push.torque) ? push.torque * ramp : peak;
  const double down = push.settle_time - ramp;  // time at which H starts to fall
  const double flat = (std::exp(-omega * ramp) - std::exp(-omega * down)) / omega;
  // The falling part, with time measured from its start: H = reached - slope s.
  const double fall = std::exp(-omega * down) * (reached * -std::expm1(-omega * ramp) / omega -
                                                 slope * ramp_integral(ramp, omega));
  return (slope * ramp_integral(ramp, omega) + reached * flat + fall) / (push.mass * push.height);
}

// Shift of the capture point per unit of impulse, referred to t = 0, m / (N s).
double shift_per_impulse(const StandingPush& push, double omega) {
  return -std::expm1(-omega * push.duration) / (push.mass * omega * omega * push.duration);
}

}  // namespace

double largest_impulse_standing(double peak_angular_momentum, const StandingPush& push) {
  check(push);
  if (!(peak_angular_momentum >= 0.0) || !std::isfinite(peak_angular_momentum))
    throw DefinitionError(
        fmt::format("standing bound: the peak angular momentum must not be negative, but is {} Nms",
                    peak_angular_momentum));
  const double omega = pendulum_frequency(push.height);
  return (push.distance_to_edge + gain(peak_angular_momentum, push, omega)) /
         shift_per_impulse(push, omega);
}

double least_peak_angular_momentum(double impulse, const StandingPush& push) {
  check(push);
  if (!(impulse >= 0.0) || !std::isfinite(impulse))
    throw DefinitionError(
        fmt::format("standing bound: the impulse must not be negative, but is {} N s", impulse));
  const double omega = pendulum_frequency(push.height);
  const double needed = impulse * shift_per_impulse(push, omega) - push.distance_to_edge;
  if (needed <= 0.0) return 0.0;
  // Without a torque limit the gain is proportional to the peak. Otherwise it grows with the peak
  // until H is a triangle, and the peak is found by bisection down to adjacent numbers.
  if (!std::isfinite(push.torque)) return needed / gain(1.0, push, omega);
  double low = 0.0;
  double high = 0.5 * push.torque * push.settle_time;
  if (gain(high, push, omega) < needed) return infinity;
  for (double middle = 0.5 * high; middle > low && middle < high; middle = 0.5 * (low + high))
    (gain(middle, push, omega) < needed ? low : high) = middle;
  return high;
}

double largest_impulse_with_step(double reach, double landing, const StandingPush& push) {
  check(push);
  if (!std::isfinite(reach))
    throw DefinitionError("standing bound: the reach of the step must be finite");
  if (!(landing >= push.duration) || !std::isfinite(landing))
    throw DefinitionError(
        fmt::format("standing bound: the foot lands after {} s, before the push of {} s ends",
                    landing, push.duration));
  const double omega = pendulum_frequency(push.height);
  const double from_start = push.distance_to_edge + reach * std::exp(-omega * landing);
  return from_start / shift_per_impulse(push, omega);
}

}  // namespace saltus::robots
