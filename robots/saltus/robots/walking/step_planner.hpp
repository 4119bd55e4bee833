// Step planners, which decide which foot steps, when and where: their interface, the measured
// situation in a tick, and the contacts that they plan.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {
class MultipleShooting;
}

namespace saltus::robots::walking {

/// Measured situation at the start of a tick, in world axes.
struct StepSituation {
  /// Measured state of a foot.
  struct Foot {
    SoleFrame sole;  ///< contact frame, levelled, with the heading of the foot, m
    Vec<double, 3> velocity = Vec<double, 3>::Zero();  ///< velocity of its origin, m/s
    bool stands = true;                                ///< true if on the ground
    double lifted_off = infinity;  ///< start of the swing, s; infinite: not swinging. A foot that
                                   ///< neither stands nor swings is in the air, as at the start on
                                   ///< one foot. It may land but need not.
    /// Supported part of the sole, in its frame, m. Empty: the whole sole.
    std::optional<FootRectangle> support = std::nullopt;
    /// True if the foot swings.
    bool swings() const { return lifted_off < infinity; }
  };

  double time = 0.0;                              ///< s
  double period = 0.01;                           ///< time until the next call, s
  double mass = 0.0;                              ///< mass of the controllers' model, kg
  double omega = 0.0;                             ///< sqrt(g / z) at the measured height z, 1/s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< measured CoM (m), its velocity (m/s), angular
                                                  ///< momentum about it (Nms)
  Foot left, right;

  /// State of the foot on the given side.
  const Foot& foot(Side side) const { return side == Side::left ? left : right; }
  /// State of the foot on the given side.
  Foot& foot(Side side) { return side == Side::left ? left : right; }
};

/// Planned steps, soonest first. Without steps the robot stays on its present feet. A step whose
/// lift-off is due before the next tick begins and is then fixed. Until its foot has landed, it
/// stays the first step of every plan. If a plan omits it, its time and place do not change. All
/// other steps may be withdrawn.
struct StepPlan {
  /// One step: a foot lifts off and lands again. Absolute times, s.
  struct Step {
    Side foot = Side::right;     ///< foot that steps
    double lift_off = infinity;  ///< for a foot that is in the air already: any time up to now
    double landing = infinity;   ///< s
    double earliest_landing = infinity;  ///< an earlier contact does not count as the landing
    Vec<double, 3> place = Vec<double, 3>::Zero();  ///< place of its contact frame, m
    /// Yaw of the foot at the landing, rad; empty: as at the lift-off.
    std::optional<double> heading = std::nullopt;
  };

  /// A candidate: first foot and number of steps.
  struct Alternative {
    int steps = 0;             ///< number of steps
    Side first = Side::right;  ///< foot of the first step; meaningless without steps
    double cost = infinity;    ///< infinite: not feasible
    Vec<double, 3> place = Vec<double, 3>::Zero();  ///< place of the first step, m
    double landing = infinity;                      ///< landing of the first step, absolute, s
  };

  /// Horizontal motion of the CoM in a plan. Without samples the planner gives none.
  struct Motion {
    static constexpr int most_samples = 16;                  ///< capacity
    static constexpr double step = 0.02;                     ///< sampling time, s
    double begin = 0.0;                                      ///< time of the first sample, s
    int samples = 0;                                         ///< number of samples
    std::array<Vec<double, 2>, most_samples> com;            ///< m
    std::array<Vec<double, 2>, most_samples> capture_point;  ///< after the momentum has returned to
                                                             ///< zero, m
  };

  static constexpr int most_steps = 3, most_alternatives = 8;  ///< capacities

  int count = 0;                       ///< number of steps
  std::array<Step, most_steps> steps;  ///< the first `count` of them

  Motion motion;  ///< motion of the CoM

  /// For the log: candidates that were compared.
  int alternatives = 0;
  std::array<Alternative, most_alternatives> alternative;  ///< the candidates
  int chosen = -1;  ///< index of the chosen candidate; -1: none
  /// False if no candidate meets all limits and this is the one with the smallest violation.
  bool is_feasible = true;
  double missed = 0.0;  ///< total violation, m; infinite: nothing was found

  /// True if the plan contains a step.
  bool is_stepping() const { return count > 0; }
};

struct Scene;

/// Interface of planners that decide on steps. Called once per tick of the controller. This base
/// class never steps.
class StepPlanner {
 public:
  virtual ~StepPlanner() = default;

  /// Steps planned in the current situation. The reference is valid until the next call.
  virtual const StepPlan& plan(const StepSituation& /*now*/) { return plan_; }
  /// Program of the last plan, with its data; null if none was solved.
  virtual const MultipleShooting* shooting() const { return nullptr; }

 protected:
  StepPlan plan_;  ///< last plan; sized once
};

/// Options of the step planner.
struct Step {
  /// Step planner: one step of the foot in the air by a formula, any number of steps with either
  /// foot by a reactive rule, or the problem's own planner by optimal control.
  enum class Planner { formula, reactive, ocp };

  /// Trigger of a step: the start of the push, or the capture point.
  enum class Trigger { push, icp };

  /// Step always, or only if standing cannot recover.
  enum class Decision { always, if_it_helps };

  /// Placement of the foot: by the capture point, or at a fixed place.
  enum class Placement { predicted, fixed };

  bool allowed = true;                 ///< true if the robot may step
  Planner planner = Planner::formula;  ///< type of planner
  double duration = 0.6;               ///< time from the trigger to the landing, s
  double shortest = 0.3;               ///< shortest swing of the reactive planner, s
  /// True if the planner `formula` uses the start time of the push. No planner uses its size,
  /// direction or duration, and the other planners have no knowledge of the push.
  bool known = true;
  Trigger trigger = Trigger::push;     ///< trigger of a step
  Decision decide = Decision::always;  ///< step always, or only if it helps
  /// Time from the trigger to the final placement, s; the push of the paper is then over.
  double decision_delay = 0.1;
  /// Alternative to `decision_delay`: time from the final placement to the landing, s.
  std::optional<double> decision_lead;
  Placement placement = Placement::predicted;  ///< by the capture point or fixed
  /// Place of the swing sole relative to the stance sole: forward, and to the side away from it, m.
  Vec<double, 2> fixed_place{0.0, 0.14};
  double lateral_min = 0.12;  ///< smallest distance to the side of the stance sole, m
  double lateral_max = 0.30;  ///< largest distance to the side of the stance sole, m
  double forward_max = 0.25;  ///< largest distance to the front or back, m
};
/// Deprecated name.
using StepTrigger [[deprecated("use Step::Trigger; removed in 0.4")]] = Step::Trigger;
/// Deprecated name.
using Placement [[deprecated("use Step::Placement; removed in 0.4")]] = Step::Placement;

/// Creates a planner that takes one step of the foot in the air, to the capture point that is
/// predicted for the landing. `push_start` (s) is required for the trigger `push`; throws
/// DefinitionError without it.
std::unique_ptr<StepPlanner> make_formula_steps(const Step& options,
                                                std::optional<double> push_start,
                                                const Scene& scene);

/// Creates a planner that takes any number of steps with either foot, without a prediction beyond
/// the next landing. It has no knowledge of pushes.
std::unique_ptr<StepPlanner> make_reactive_steps(const Step& options, const Scene& scene);

}  // namespace saltus::robots::walking
