// Step planner by optimal control: chooses feet, number, times and places of steps. Every tick it
// solves the step problem for each candidate that can still be the best, and takes the cheapest.
#pragma once

#include <vector>

#include "problems/push_recovery/step_program.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus {
class Settings;
}

namespace saltus::push_recovery {

using robots::walking::StepPlan;
using robots::walking::StepSituation;

struct StepChoiceSettings {
  int most_steps = 2;
  double price = 2.0;        ///< cost of every step, in units of the total cost
  double hysteresis = 0.5;   ///< cost advantage that another candidate needs to be chosen
  double lead = 0.08;        ///< time before the landing at which its time and place are fixed, s
  int iterations = 3;        ///< quadratic programs per candidate and tick from the previous plan,
  int first_iterations = 8;  ///< and for a candidate without a previous plan
  /// Quadratic programs per tick after which no further candidate is solved. It replaces a clock,
  /// so that runs are equal on all machines.
  int budget = 24;
  /// Desired velocity: forward and to the left, m/s, and yaw rate, rad/s.
  Vec<double, 3> velocity = Vec<double, 3>::Zero();
  double walk_until = infinity;  ///< time after which the robot stands, s
  bool bring_back = false;       ///< once at rest, a foot away from its usual place steps there
};

/// Centres of the soles in their contact frames, m.
struct SoleCentres {
  Vec<double, 2> left, right;
  const Vec<double, 2>& of(robots::Side side) const {
    return side == robots::Side::left ? left : right;
  }
};

/// Does not allocate or throw after construction. If inputs are NaN, the plan stays the same.
class StepChoice final : public robots::walking::StepPlanner {
 public:
  /// `stride`: usual place of a foot relative to the other one, forward and away from it, m.
  StepChoice(const StepModel& model, const StepChoiceSettings& settings, const SoleCentres& centres,
             const Vec<double, 2>& stride);

  const StepPlan& plan(const StepSituation& now) override;
  const MultipleShooting* shooting() const override;

  /// Discards all plans, before another run.
  void restart();
  /// True if the last plan meets all constraints; otherwise it has the smallest violation.
  bool is_feasible() const { return plan_.is_feasible; }
  /// The first input of the last plan: centre of pressure in the world (m), rate of eta (m/s).
  const Vec<double, 2>& pressure() const { return pressure_; }
  const Vec<double, 2>& lent_rate() const { return lent_rate_; }
  double seconds() const { return seconds_; }     ///< wall clock of the last tick
  int iterations() const { return iterations_; }  ///< quadratic programs of the last tick

 private:
  enum class Footing { two_feet, one_foot, other };
  struct Candidate {
    StepProgram program;
    int steps;
    bool from_two_feet;
    robots::Side first = robots::Side::right;
    double solved_at = -infinity;
    const StepSolution* solution = nullptr;  // solution of this tick
    double cost = infinity;                  // including the cost of the steps
  };
  // The frame of the problem in the world.
  struct Frame {
    Vec<double, 3> origin = Vec<double, 3>::Zero();  // centre of the stance sole, m
    Vec<double, 2> forward{1.0, 0.0}, towards{0.0, 1.0};

    Vec<double, 2> into(const Vec<double, 3>& point) const;
    Vec<double, 2> turned(const Vec<double, 2>& vector) const;
    Vec<double, 3> out(const Vec<double, 2>& point) const;
  };

  /// True if steps follow a task and not a push.
  bool walks() const { return is_bringing_back_ || !velocity_.isZero(0.0); }
  bool is_off_its_place(const StepSituation& now) const;
  Frame frame_on(const StepSituation& now, robots::Side stance) const;
  Vec<double, 3> centre(const StepSituation& now, robots::Side side) const;
  Vec<double, 4> support(const StepSituation& now, robots::Side side, robots::Side stance) const;
  /// Place of the contact frame of a foot whose sole is at `place` and turned by `turn` (rad).
  Vec<double, 3> in_world(const Frame& frame, robots::Side foot, const Vec<double, 2>& place,
                          double turn) const;
  /// Yaw of a landing foot relative to the standing one, rad.
  double turn() const { return velocity_[2] * pace_; }
  Vec<double, 2 * most_planned_steps> drift(robots::Side stance) const;
  robots::Side stance_of(const Candidate& candidate, const StepSituation& now) const;
  void look_at(Candidate& candidate, const StepSituation& now);
  void carry_out(const Candidate& candidate, const StepSituation& now);
  void note(const Candidate& candidate, const StepSituation& now);
  bool is_fixed(const StepSituation& now) const;

  StepModel model_;
  StepChoiceSettings settings_;
  SoleCentres centres_;
  Vec<double, 2> stride_;
  std::vector<Candidate> candidates_;
  Vec<double, 3> velocity_ = Vec<double, 3>::Zero();  // desired velocity at present, m/s, rad/s
  int incumbent_ = -1;
  const Candidate* asked_ = nullptr;   // candidate of the last plan; null: nothing was solved
  int landed_last_ = -1;               // side of the foot that landed last, -1: none
  double landed_at_ = -infinity;       // s
  double pace_;                        // time between landings while walking, s
  double unloading_since_ = infinity;  // s
  double swinging_since_ = infinity;   // s, for a foot whose swing the situation does not report
  Vec<double, 3> lifted_from_ = Vec<double, 3>::Zero(), aim_ = Vec<double, 3>::Zero();  // m
  double at_rest_since_ = infinity;  // s, start of rest on two feet
  bool is_bringing_back_ = false;
  Vec<double, 2> pressure_ = Vec<double, 2>::Zero(), lent_rate_ = Vec<double, 2>::Zero();
  double seconds_ = 0.0;
  int iterations_ = 0;
};

}  // namespace saltus::push_recovery
