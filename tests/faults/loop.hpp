// A controller in closed loop with a plant, with fault injection.
//
// The plant is a mass on a spring that stiffens. The force is at most 1 N in mode "slow" and 3 N in
// mode "fast". Data give the target position. The plan covers one second in 14 intervals.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>

#include "saltus/mpc/receding_horizon.hpp"

namespace saltus::test {

/// Kind of fault.
enum class Fault {
  none,
  measurement_nan,
  measurement_infinite,
  measurement_frozen,
  measurement_late,
  measurements_out_of_order,
  measurement_outliers,
  clock_ahead,
  clock_back,
  clock_stands,
  clock_nan,
  deadline_missed,
  dynamics_nan,
  dynamics_throw,
  cost_throws,
  solver_gives_up,
  solver_gives_nan,
  data_nan,
  previous_input_infinite,
  event_at_nan,
  schedule_impossible,
  sender_throws,
  fallback_throws,
  count
};
/// Name of the fault in docs/faults.md.
const char* describe(Fault fault);

class FaultyLoop {
 public:
  FaultyLoop();
  ~FaultyLoop();
  FaultyLoop(const FaultyLoop&) = delete;
  FaultyLoop& operator=(const FaultyLoop&) = delete;

  /// Runs one tick and moves the plant until the next tick.
  const ControlTick& tick(Fault fault);
  /// Inserts a mode change at a random time within the horizon. Removes modes that have ended.
  void edit_schedule();
  /// Sets the target position, m.
  void aim(double position);
  /// Changes the speed of the plant, m/s, but not that of the model.
  void strike(double speed);

  /// True if the last input was finite, within the bounds of its modes, and covered the tick.
  bool input_is_sound() const { return input_is_sound_; }
  /// Number of edits that the schedule correctly refused as impossible.
  long refused() const { return refused_; }
  /// Time of the plant, s.
  double time() const { return time_; }
  const RecedingHorizonController& controller() const { return controller_; }
  /// The controller's report. Call it only without an active fault.
  Solution report() { return controller_.report(); }

  static constexpr double period = 0.1;  // s

 private:
  struct Switches;  // injected behaviour of formulas, solver and user functions

  Vec<double, 2> measured(Fault fault);
  double clock(Fault fault);
  void check_input(const ControlTick& tick);
  void move_plant(const ControlTick& tick);

  std::shared_ptr<Switches> switches_;
  Schedule schedule_;
  RecedingHorizonController controller_;
  std::mt19937 random_{1};
  Vec<double, 2> state_{0.5, 0.0};
  std::array<Vec<double, 2>, 8> past_{};  // measurements, newest first
  Vec<double, 2> frozen_{0.5, 0.0};
  Vec<double, 1> last_input_{0.0};
  double time_ = 0.0;
  long ticks_ = 0, refused_ = 0;
  std::uint32_t events_ = 0;
  bool input_is_sound_ = true;
};

}  // namespace saltus::test
