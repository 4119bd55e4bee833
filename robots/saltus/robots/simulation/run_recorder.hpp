// Records the closed loop of a biped and decides when it is over, for any simulator.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/robots/walking/balance_controller.hpp"
#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/progress.hpp"
#include "saltus/robots/walking/unmet_decision.hpp"
#include "saltus/simulation/closed_loop.hpp"

namespace saltus::robots::walking {

/// Simulated state, without measurement noise.
struct TrueState {
  double time = 0.0;                              ///< s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< CoM m, velocity m/s, angular momentum Nms
  std::array<Vec<double, 3>, 2> soles;            ///< origins of the contact frames, left, right, m

  /// Origin of one contact frame, m.
  Vec<double, 3>& sole(Side side) { return soles[side == Side::left ? 0 : 1]; }
  /// Origin of one contact frame, m.
  const Vec<double, 3>& sole(Side side) const { return soles[side == Side::left ? 0 : 1]; }
};

/// Call order: note_tick() if the planners have run, note_landing() if a foot has landed between
/// ticks, note_sample() before and note_step() after the plant advances, is_over().
class RunRecorder {
 public:
  RunRecorder(const BipedProblem& problem, const RobotDescription& robot, BalancePlanner& planner,
              const Observer& observer);

  /// True if the run is over at t: end time, a fall, or a stop requested by the user.
  bool is_over(double t);
  /// Records that the planners have run. `step_seconds`: time of the step planner.
  void note_tick(double t, const BalancePlanner::StepChange& change, bool has_landed,
                 double step_seconds, const TrueState& truth);
  /// Records the landing of the swing foot.
  void note_landing(double t, const TrueState& truth);
  /// Records that the foot that landed last has lost its contact.
  void note_loss(double t);
  /// Records the wrenches that act from t on, and the mean push until the next sample.
  void note_sample(double t, const Vec<double, 12>& applied, const Vec<double, 3>& push,
                   const TrueState& truth);
  /// Ends the run with an error, described in one sentence.
  void note_failure(const std::string& failure);
  /// Records a step of the plant. `failure` is not empty if the plant could not advance.
  void note_step(const std::string& failure, const TrueState& truth);

  /// True after a fall or an error.
  bool has_stopped() const { return log_.stopped_early; }
  /// All pushes, in chronological order.
  std::vector<Pulse> pushes() const;
  /// Returns and removes the record of the last tick of the wrench planner.
  std::optional<LoopLog::Tick> take_tick() { return std::exchange(tick_, {}); }
  /// The log, to which the plant adds its own values.
  RunLog& log() { return log_; }
  /// Returns the complete log. `applied` and `truth` are those at the end.
  RunLog finish(const Vec<double, 12>& applied, const TrueState& truth);

 private:
  Vec<double, 3>& stood_at(Side side) { return stood_at_[side == Side::left ? 0 : 1]; }
  bool on_two_feet() const { return planner_.stands(Side::left) && planner_.stands(Side::right); }
  Scene scene_of_soles() const;
  void note_ground(double t);
  void keep_unmet(double t);
  Vec<double, 2> capture_point_of(const Vec<double, 9>& gamma) const;
  LoopState state(double t, const TrueState& truth) const;
  void stop(std::string reason);

  const BipedProblem& problem_;
  BalancePlanner& planner_;
  const Observer& observer_;
  std::vector<Push> pushes_;
  double push_end_ = 0.0;                   // end of the last push, s
  std::array<Vec<double, 3>, 2> stood_at_;  // true places of the last contacts, m
  double interrupted_at_ = infinity;        // end of the tick at which the user ended the run, s
  Vec<double, 3> push_ = Vec<double, 3>::Zero();  // mean push of the last sample
  std::optional<LoopLog::Tick> tick_;
  UnmetDecisions unmet_;
  RunLog log_;
};

/// Runs the closed loop, with the pushes, until the recorder reports its end.
void run_until_over(LoopController& controller, LoopPlant& plant, RunRecorder& recorder);

/// Sum of the mean forces of all pushes over an interval, N.
Vec<double, 3> mean_force(std::span<const Pulse> pushes, double from, double to);

/// Runs the problem on the exact centroidal dynamics.
RunLog simulate_centroidal(const BipedProblem& problem, const RobotDescription& robot,
                           const Observer& observer);
/// Runs the whole body in DART or MuJoCo. Throws InputError for robot files that are incomplete or
/// inconsistent.
RunLog simulate_whole_body(const BipedProblem& problem, const RobotDescription& robot,
                           const Observer& observer);

}  // namespace saltus::robots::walking
