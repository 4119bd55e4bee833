// Receding horizon control: solve from the measured state, hand over the input until the next tick.
#pragma once

#include "framework/mpc/held_input.hpp"
#include "framework/transcription/multiple_shooting.hpp"

namespace saltus {

/// Where the input of a tick comes from.
enum class Provenance {
  optimal,  ///< of the plan made in this tick; solution.status says how good
  shifted,  ///< the solve failed: the plan of an earlier tick goes on
  none      ///< the first solve failed: there is no plan yet
};
const char* describe(Provenance provenance);

struct ControlTick {
  Provenance provenance = Provenance::none;
  HeldInput input;    ///< empty for Provenance::none
  Solution solution;  ///< of this tick's solve, whatever came of it
};

/// Repeats: start at the measurement, guess from the last plan, solve, hold. Data, event times and
/// the previous input are set on shooting() before the tick; the object keeps the plan.
class RecedingHorizonController {
 public:
  /// `period` between ticks, s.
  RecedingHorizonController(MultipleShooting shooting, std::unique_ptr<Solver> solver,
                            double period);

  MultipleShooting& shooting() { return shooting_; }
  double period() const { return period_; }

  /// One tick at absolute time t with the measured state. A failed solve is reported, not thrown.
  ControlTick tick(double t, const VectorRef& state);

 private:
  MultipleShooting shooting_;
  std::unique_ptr<Solver> solver_;
  double period_;
  Trajectory plan_;  // the last good one
};

}  // namespace saltus
