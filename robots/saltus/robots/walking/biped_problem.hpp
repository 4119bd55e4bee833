// What a problem says of a biped in a closed loop: how it starts, what plans its wrenches and its
// steps, when the run is over and what is made of it. The loop knows no more.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "saltus/robots/walking/biped_settings.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/robots/walking/unmet_words.hpp"
#include "saltus/robots/walking/verdict.hpp"

namespace saltus::walking {

/// kg, of iCub, whose figures the defaults of the settings are (icub.yaml).
inline constexpr double mass_of_the_defaults = 33.0616727;

/// A robot's size against iCub's.
struct RobotScale {
  double mass = 1.0;    ///< ratio of the masses
  double length = 1.0;  ///< ratio of the heights of the CoM
};
/// Of the robot, standing in its first posture; to two decimals.
RobotScale scale_of(const RobotDescription& robot);
/// Fits reach, forces and weights by dynamic similarity: lengths by `length`, forces by `mass`,
/// moments by both.
void scale(BipedSettings& settings, const RobotScale& scale);

/// What bounds the steps of a planner that decides about their times and places itself.
struct StepBounds {
  int most = 1;               ///< steps, one after the other
  double shortest = 0.3;      ///< time of a swing, s
  std::vector<Point2> reach;  ///< corners of the places of a contact frame relative to that of the
                              ///< other foot: forward, and away from it, m
};

/// What a biped is to do: settings, scene, judgement.
class BipedProblem {
 public:
  virtual ~BipedProblem() = default;

  /// Its settings.
  virtual const BipedSettings& settings() const = 0;
  /// Its settings, to be changed before a run.
  virtual BipedSettings& settings() = 0;
  /// Fits the settings to a robot of another size. A problem with weights of its own fits them too.
  virtual void scale(const RobotScale& scale) { walking::scale(settings(), scale); }

  /// How it stands when the run begins; unless said otherwise on the stance foot alone.
  virtual const StandingPosture& posture(const RobotDescription& robot) const;
  /// Unless said otherwise those of the settings, in the order of time.
  virtual std::vector<Push> pushes() const;

  /// The problem's own planner, for the robot as its controllers know it.
  virtual std::unique_ptr<Planner> make_planner(const RobotDescription& nominal,
                                                const Scene& scene) const = 0;
  /// Which feet stand when, as far as it is known when the run begins: those of the scene.
  virtual Schedule contacts(const Scene& scene) const;
  /// Unless said otherwise none is made.
  virtual std::unique_ptr<StepPlanner> make_step_planner(const RobotDescription& nominal,
                                                         const Scene& scene) const;
  /// Nothing, unless said otherwise: the time of a step is a setting then.
  virtual std::optional<StepBounds> step_bounds(const RobotDescription& nominal) const;

  /// When enough has been seen (s). The last push is over at `push_end` (0 without one); `landing`
  /// is infinite while none is due, `touchdown`, the last, until a foot has landed.
  virtual double end_time(double push_end, double landing, double touchdown) const = 0;
  /// Why there is no use in going on, as a sentence, or nothing; a fall unless said otherwise.
  virtual std::string lost(double t, const Vec<double, 9>& gamma, const Scene& scene) const;
  /// Whether the run was a success, and figures of it.
  virtual Verdict judge(const RunLog& log) const = 0;
  /// How what a planner could not keep to is told; unless said otherwise by names of terms.
  virtual std::unique_ptr<UnmetWords> unmet_words(const RobotDescription& robot) const;
};

/// The scene of the problem's posture.
Scene initial_scene(const BipedProblem& problem, const RobotDescription& robot);

/// The robot of the settings. Throws InputError for what the files lack or say wrongly.
RobotDescription robot_of(const BipedSettings& settings);

}  // namespace saltus::walking
