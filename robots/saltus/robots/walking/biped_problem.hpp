// Interface of a problem with a biped in a closed loop: start, planners, end of the run and
// verdict.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "saltus/robots/walking/biped_settings.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/robots/walking/unmet_explanations.hpp"
#include "saltus/robots/walking/verdict.hpp"

namespace saltus::walking {

/// Mass of iCub, kg. The defaults of the settings are for iCub (icub.yaml).
inline constexpr double mass_of_the_defaults = 33.0616727;

/// Size of a robot relative to iCub.
struct RobotScale {
  double mass = 1.0;    ///< ratio of the masses
  double length = 1.0;  ///< ratio of the heights of the CoM
};
/// Size of the robot in its first posture, rounded to two decimals.
RobotScale scale_of(const RobotDescription& robot);
/// Scales reach, forces and weights by dynamic similarity: lengths by `length`, forces by `mass`,
/// moments by both.
void scale(BipedSettings& settings, const RobotScale& scale);

/// Bounds on the steps of a planner that chooses times and places itself.
struct StepBounds {
  int most = 1;               ///< largest number of consecutive steps
  double shortest = 0.3;      ///< time of a swing, s
  std::vector<Point2> reach;  ///< corners of the region that a contact frame can reach, in the
                              ///< frame of the other foot: forward, and away from it, m
};

/// Task of a biped: settings, scene and verdict.
class BipedProblem {
 public:
  virtual ~BipedProblem() = default;

  /// Settings of the problem.
  virtual const BipedSettings& settings() const = 0;
  /// Settings of the problem, to be changed before a run.
  virtual BipedSettings& settings() = 0;
  /// Scales the settings to a robot of another size. A problem with its own weights scales them
  /// too.
  virtual void scale(const RobotScale& scale) { walking::scale(settings(), scale); }

  /// Posture at the start. Default: on the stance foot alone.
  virtual const StandingPosture& posture(const RobotDescription& robot) const;
  /// Pushes sorted by time. Default: those of the settings.
  virtual std::vector<Push> pushes() const;

  /// Creates the problem's own planner, for the robot as its controllers know it.
  virtual std::unique_ptr<Planner> make_planner(const RobotDescription& nominal,
                                                const Scene& scene) const = 0;
  /// Contact schedule known at the start. Default: contacts of the scene.
  virtual Schedule contacts(const Scene& scene) const;
  /// Creates the step planner. Default: none.
  virtual std::unique_ptr<StepPlanner> make_step_planner(const RobotDescription& nominal,
                                                         const Scene& scene) const;
  /// Bounds on steps. Default: none; the time of a step is then a setting.
  virtual std::optional<StepBounds> step_bounds(const RobotDescription& nominal) const;

  /// End of the run (s). The last push is over at `push_end` (0 without one). `landing` is infinite
  /// while none is due, `touchdown` (the last one) until a foot has landed.
  virtual double end_time(double push_end, double landing, double touchdown) const = 0;
  /// Reason, as a sentence, to stop the run early; empty to continue. Default: a fall.
  virtual std::string lost(double t, const Vec<double, 9>& gamma, const Scene& scene) const;
  /// Success of the run, with its quantities.
  virtual Verdict judge(const RunLog& log) const = 0;
  /// Explanations of unmet constraints. Default: by names of terms.
  virtual std::unique_ptr<UnmetExplanations> unmet_explanations(
      const RobotDescription& robot) const;
};

/// Scene of the problem's posture.
Scene initial_scene(const BipedProblem& problem, const RobotDescription& robot);

/// Robot of the settings. Throws InputError for missing or wrong entries of its files.
RobotDescription robot_of(const BipedSettings& settings);

}  // namespace saltus::walking
