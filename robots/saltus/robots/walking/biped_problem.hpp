// Interface of a problem with a biped in a closed loop: start, planners, end of the run, verdict
// and explanations of unmet constraints.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/robots/walking/biped_settings.hpp"
#include "saltus/robots/walking/run_log.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus::robots::walking {

class BalanceController;

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

/// A limit of the hardware that a run exceeds.
struct HardwareExcess {
  std::string what;    ///< quantity and part, such as "speed of l_knee"
  std::string unit;    ///< unit of `worst` and `limit`
  double time = 0.0;   ///< time at which the limit is first exceeded, s
  double first = 0.0;  ///< value at that time
  double worst = 0.0;  ///< value that exceeds the limit most
  double limit = 0.0;  ///< limit at the time of `first`
};

/// Success of a run, with its quantities.
struct Verdict {
  /// Results that only whole-body runs have.
  struct Body {
    /// True if the robot recovered without a step: no fall, both soles within `standing_move` of
    /// their start, and the base within `standing_tilt` of its start.
    bool standing = false;
    double feet_moved = 0.0;  ///< largest distance of a sole's origin from its start, m
    double tilt_max = 0.0;  ///< angle between the vertical in the base and that at the start, rad;
    double tilt_end = 0.0;  ///< rotation about the vertical does not count
    Vec<double, 2> slip = Vec<double, 2>::Zero();      ///< largest sole_slip, left and right, m
    Vec<double, 2> slips_from{infinity, infinity};     ///< time at which the slip exceeds
                                                       ///< `planted_slip`, s
    Vec<double, 2> friction = Vec<double, 2>::Zero();  ///< largest friction_used
    /// Impulse beyond Coulomb friction on both feet, N s: integral of the positive part of the
    /// tangential force minus `RunLog::ground_friction` times the vertical force. Engines implement
    /// the friction law differently.
    double beyond_friction = 0.0;
    Vec<double, 2> force_peak = Vec<double, 2>::Zero();  ///< vertical, mean over wrench_filter, N
    double limit_margin = infinity;      ///< smallest distance of a joint from its limit, rad; < 0:
                                         ///< beyond it
    std::string limit_joint;             ///< joint with the smallest distance
    double limit_time = 0.0;             ///< time of the smallest distance, s
    double torque_limit_fraction = 0.0;  ///< share of the time in which a torque is at its limit
    double speed_ratio = 0.0;            ///< largest ratio of a joint speed to its limit
    std::string speed_joint;             ///< joint with the largest ratio
    double speed_time = 0.0;             ///< time of the largest ratio, s
    double over_speed = 0.0;             ///< longest time that a joint exceeds its speed limit, s
    double clearance = infinity;         ///< smallest distance of two limbs, m; < 0: they overlap;
                                         ///< infinite: no collision shapes
    std::string clearance_pair;          ///< names of these limbs
    double clearance_time = 0.0;         ///< time of the smallest distance, s
    double landing_speed = 0.0;          ///< largest downward speed of a sole that lands, m/s
    double landing_force = 0.0;          ///< largest vertical force on a foot, unfiltered, N
    int lost_contacts = 0;               ///< landings that a foot lost before it carried load
    std::vector<HardwareExcess> excesses;  ///< limits of the hardware that are exceeded, by time

    /// True if no limit of the hardware is exceeded.
    bool is_hardware_safe() const { return excesses.empty(); }

    /// True if any joint reached its limit.
    bool touches_joint_limit() const;
  };

  bool recovered = false;                                 ///< all criteria are met
  std::string reason;                                     ///< if not recovered: the first reason
  double final_com_error = 0.0, icp_settling = infinity;  ///< m, s
  double settled_from = 0.0;  ///< time from which settling is measured, s
  double com_height_min = infinity, com_height_max = -infinity;  ///< m
  double angular_momentum_max = 0.0;                             ///< Nms
  bool fell_before_push = false;  ///< true if the run does not test the push
  std::optional<Body> body;       ///< whole body only

  /// Notes the first reason.
  void fail(std::string because) {
    if (reason.empty()) reason = std::move(because);
  }
};
/// Deprecated name.
using BodyVerdict [[deprecated("use Verdict::Body; removed in 0.4")]] = Verdict::Body;

// Bounds are often given for iCub, with this mass and CoM height on one foot. For other robots,
// lengths of the CoM scale with its height h, and angular momentum with m h sqrt(g h).
/// Mass (kg) and CoM height (m) of the robot for which the criteria were chosen. Criteria for other
/// robots are scaled.
inline constexpr double reference_mass = 33.0616727, reference_height = 0.5578762015;  // kg, m
/// Distance within which the capture point counts as settled, m.
inline constexpr double icp_settled_within = 0.01;  // m

/// Computes all quantities except `recovered`. The only failure reason that it sets is an early
/// stop. The capture point has settled when it stays near its final position; the time is measured
/// from `settled_from`, s.
Verdict figures_of(const RunLog& log, double settled_from, std::span<const Push> pushes);

/// True if the robot has fallen. It stands on a foot at `foot` with its CoM at the nominal height
/// `com_height`, m.
bool has_fallen(const Vec<double, 9>& gamma, const Vec<double, 3>& foot, double com_height);
/// Sentence for a fall; mentions a fall before all pushes.
std::string fall_sentence(std::span<const Push> pushes, double t);

/// Texts about constraints of a biped that cannot be met, for explain(). Default: names of terms
/// and numbers.
class UnmetExplanations {
 public:
  virtual ~UnmetExplanations() = default;

  /// The problem to explain, including bounds for criteria beyond its own constraints, such as
  /// limits of the verdict. Default: the problem of the tick.
  virtual OptimalControlProblem problem(const UnmetDecision& unmet) const { return unmet.problem; }
  /// Name of the added criteria, such as "the verdict's limits". Empty: none.
  virtual std::string limits(const UnmetDecision& /*unmet*/) const { return {}; }
  /// True if a number may be proposed for change. False for measured values.
  virtual bool may_change(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return true;
  }
  /// Description of what is missing, with directions. Empty: use the general sentence.
  virtual std::string of(const UnmetDecision& /*unmet*/,
                         const Explanation::Shortage& /*shortage*/) const {
    return {};
  }
  /// Description of a change that would help. Empty: use the general clause.
  virtual std::string of(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return {};
  }
};
/// Deprecated name.
using UnmetWords [[deprecated("use UnmetExplanations; removed in 0.4")]] = UnmetExplanations;

/// Task of a biped: settings, scene and verdict.
class BipedProblem {
 public:
  /// Bounds on the steps of a planner that chooses times and places itself.
  struct StepBounds {
    int most = 1;               ///< largest number of consecutive steps
    double shortest = 0.3;      ///< time of a swing, s
    std::vector<Point2> reach;  ///< corners of the region that a contact frame can reach, in the
                                ///< frame of the other foot: forward, and away from it, m
  };

  virtual ~BipedProblem() = default;

  /// Settings of the problem.
  virtual const BipedSettings& settings() const = 0;
  /// Settings of the problem, to be changed before a run.
  virtual BipedSettings& settings() = 0;
  /// Scales the settings to a robot of a different size. A problem with its own weights scales them
  /// too.
  virtual void scale(const RobotScale& scale) { walking::scale(settings(), scale); }

  /// Posture at the start. Default: on the stance foot alone.
  virtual const StandingPosture& posture(const RobotDescription& robot) const;
  /// Pushes sorted by time. Default: those of the settings.
  virtual std::vector<Push> pushes() const;

  /// Creates the problem's own planner. `nominal` is the controllers' model of the robot.
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

/// Creates the planner of the settings: the problem's own or the capture-point controller. Its
/// model of the robot has the mass error of the settings.
std::unique_ptr<Planner> make_planner(const BipedProblem& problem, const RobotDescription& robot,
                                      const Scene& scene);
/// Creates the step planner of the problem, with the same mass error.
std::unique_ptr<StepPlanner> make_step_planner(const BipedProblem& problem,
                                               const RobotDescription& robot, const Scene& scene);

/// Creates the controller of the settings for any Robot. `body` is the controllers' model of the
/// robot, `model` evaluates its dynamics, and `period` (s) is Robot::period(). Throws
/// DefinitionError if the control period is not a multiple of `period`.
BalanceController make_balance_controller(const BipedProblem& problem,
                                          const RobotDescription& robot, const FloatingRobot& body,
                                          std::unique_ptr<DynamicsModel> model, const Scene& scene,
                                          double period);

/// Robot of the settings. Throws InputError for missing or wrong entries of its files.
RobotDescription robot_of(const BipedSettings& settings);

}  // namespace saltus::robots::walking
