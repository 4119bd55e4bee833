// Stance and swing of each leg: one schedule per leg, extended by a clock and edited by contacts.
#pragma once

#include <array>
#include <string>

#include "problems/quadruped/rigid_body.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus::quadruped {

using Touching = std::array<bool, legs>;

struct GaitSettings {
  std::array<double, legs> lifts_at{0.0, 0.5, 0.5, 0.0};  // fraction of the period: a trot
  double period = 0.45;                                   // s
  double duty = 0.55;                                     // fraction of it in which a leg stands
  double begin = 0.3;                                     // start of the first swing, s
  double shortest_stance =
      0.5;             // fraction of the planned stance that the gait waits after a late landing
  bool blind = false;  // ignores contacts: the clock decides
};

class Gait {
 public:
  /// `horizon`: length of the schedule, s; `tick`: control period, s.
  Gait(const GaitSettings& settings, double horizon, double tick);

  /// Processes the contacts at time `now`, once per tick. A foot with contact in the second half of
  /// its swing has landed now. The landing of a due foot without contact is postponed to the next
  /// tick, and meanwhile no other leg lifts off: the whole gait waits. In blind mode only the clock
  /// advances.
  void update(double now, const Touching& touching);

  /// Schedule from the last update to the end of the horizon.
  const Schedule& contacts() const { return contacts_.joined(); }
  const JointSchedule& legs_apart() const { return contacts_; }

  bool stands(int leg) const { return legs_[leg].stands; }
  double lifted_at(int leg) const { return legs_[leg].lifted; }  ///< last lift-off, s
  double due_at(int leg) const { return legs_[leg].due; }  ///< planned landing by the clock, s
  double next_lift(int leg) const;                         ///< s
  double next_landing(int leg) const;                      ///< s
  double period() const { return settings_.period; }
  double stance() const { return settings_.duty * settings_.period; }
  double waited() const { return waited_; }  ///< total waiting time, s
  int early() const { return early_; }       ///< early landings
  int late() const { return late_; }         ///< late landings

 private:
  struct Leg {
    bool stands = true;
    double lifted = 0.0, due = 0.0;
    bool is_overdue = false;
    long written = 0;  // number of swings
  };
  void land_early(double now, const Touching& touching);
  void put_off(double now, const Touching& touching);
  void wait(double seconds);
  void write_ahead(double until);

  GaitSettings settings_;
  double horizon_, tick_;
  std::array<Leg, legs> legs_;
  JointSchedule contacts_;
  double waited_ = 0.0;
  int early_ = 0, late_ = 0;
};

}  // namespace saltus::quadruped
