// When each leg stands and swings: a schedule per leg, written ahead by a clock and edited by what
// the feet feel.
#pragma once

#include <array>
#include <string>

#include "problems/quadruped/rigid_body.hpp"
#include "saltus/ocp/joint_schedule.hpp"

namespace saltus::quadruped {

using Touching = std::array<bool, legs>;

struct GaitSettings {
  std::array<double, legs> lifts_at{0.0, 0.5, 0.5, 0.0};  // fraction of the period: a trot
  double period = 0.45;                                   // s
  double duty = 0.55;                                     // fraction of it in which a leg stands
  double begin = 0.3;                                     // of the first swing, s
  double shortest_stance = 0.5;  // of the planned one: after a late landing the gait waits so long
  bool blind = false;            // to landings: the clock decides
};

class Gait {
 public:
  /// `horizon`, s: how far ahead the schedule is written; `tick`, s: the period of the controller.
  Gait(const GaitSettings& settings, double horizon, double tick);

  /// What the feet say at time `now`, once per tick:
  ///   a foot that touches the ground in the second half of its swing has landed now;
  ///   one that is due and does not has not, and its landing is put off until the next tick;
  ///   while one is overdue no other leg lifts: the whole gait waits.
  /// Blind, only the clock moves.
  void update(double now, const Touching& touching);

  /// From `now` of the last update to the horizon's end.
  const Schedule& contacts() const { return contacts_.joined(); }
  const JointSchedule& legs_apart() const { return contacts_; }

  bool stands(int leg) const { return legs_[leg].stands; }
  double lifted_at(int leg) const { return legs_[leg].lifted; }  ///< the last time, s
  double due_at(int leg) const { return legs_[leg].due; }  ///< by the clock, to land from that, s
  double next_lift(int leg) const;                         ///< s
  double next_landing(int leg) const;                      ///< s
  double period() const { return settings_.period; }
  double stance() const { return settings_.duty * settings_.period; }
  double waited() const { return waited_; }  ///< in all, s
  int early() const { return early_; }       ///< landings before their time
  int late() const { return late_; }         ///< landings after it

 private:
  struct Leg {
    bool stands = true;
    double lifted = 0.0, due = 0.0;
    bool is_overdue = false;
    long written = 0;  // swings
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
