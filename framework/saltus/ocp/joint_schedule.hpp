// Several schedules side by side, as of legs that step each in its own time, and the one schedule
// of their joint modes.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/schedule.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus {

/// Each part is a schedule of its own and edited as one. A joint mode is a mode of every part at a
/// time and is called by all of them, "FL - - RR"; it changes wherever a part's does. There may be
/// at most 64 joint modes.
///
///     JointSchedule contacts({leg("left"), leg("right")}, 8);
///     phase.bound_input(0, exactly(0.0), contacts.during(0, "swing"));   // whatever the other
///     does contacts.part(0).retime("left lands", 0.31); controller.set_schedule(contacts.join(now,
///     now + horizon));
class JointSchedule {
 public:
  /// `capacity`: events of the joint schedule at a time. Throws DefinitionError when there is no
  /// part, or too many joint modes.
  JointSchedule(std::vector<Schedule> parts, int capacity);

  /// How many schedules stand side by side.
  int parts() const { return static_cast<int>(parts_.size()); }
  /// The schedule of part i, to be edited; join() takes it up.
  Schedule& part(int i) { return parts_[i]; }
  /// The schedule of part i.
  const Schedule& part(int i) const { return parts_[i]; }

  /// While part i is in this mode, whatever the others are in. Throws DefinitionError naming the
  /// nearest known mode.
  Window during(int i, const std::string& mode) const;

  /// The joint schedule of (from, to]: what happens earlier is over, what happens later is left
  /// out. Events of several parts at one instant are one event, called like the first. Allocates
  /// nothing as long as nothing is wrong; throws DefinitionError when events exceed the capacity,
  /// or two that are not at one instant have the same name.
  const Schedule& join(double from, double to);
  /// As joined last.
  const Schedule& joined() const { return joined_; }

 private:
  // Joint modes count like numbers whose digits are the modes of the parts.
  struct Digit {
    int stride = 1;    // how far a joint mode's number moves with the part's
    int position = 0;  // the part's mode in force, along its schedule
  };

  std::vector<Schedule> parts_;
  std::vector<Digit> digits_;
  Schedule joined_;
};

}  // namespace saltus
