#include "framework/mpc/held_input.hpp"

#include <algorithm>

#include "framework/ocp/window.hpp"

namespace saltus {

HeldInput hold(const Trajectory& plan, double t, double period) {
  HeldInput held;
  double at = t;
  for (const TrajectoryPiece& piece : plan.pieces()) {
    const double end = std::min(piece.end(), t + period);
    if (end - at <= same_instant) continue;  // over, or nothing left of the tick
    held.push_back({at, end - at, plan.input(0.5 * (std::max(at, piece.start) + end))});
    at = end;
  }
  const double left = t + period - at;
  if (left > same_instant || held.empty())
    held.push_back({at, left, plan.input(plan.end_time())});
  else
    held.back().length = t + period - held.back().start;
  return held;
}

}  // namespace saltus
