// The input that a controller hands over until its next tick.
#pragma once

#include <vector>

#include "framework/core/types.hpp"
#include "framework/transcription/trajectory.hpp"

namespace saltus {

/// A constant input during [start, start + length), absolute time in s.
struct InputPiece {
  double start = 0.0;
  double length = 0.0;
  VectorXd input;
};

/// Pieces that cover one tick without gap, in order: one, or more when an event falls inside.
using HeldInput = std::vector<InputPiece>;

/// Cuts [t, t + period) out of a planned trajectory: a piece for every shooting interval that the
/// tick touches (linear inputs are sampled at the middle of their part). Where the plan ends
/// before the tick does, its last input goes on.
HeldInput hold(const Trajectory& plan, double t, double period);

}  // namespace saltus
