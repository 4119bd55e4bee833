// Several independent schedules, for example one per leg, and the schedule of their joint modes.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/schedule.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus {

/// Each part is edited like a single schedule. A joint mode combines one mode per part and joins
/// their names: "FL - - RR". It changes when any part changes. There are at most 64 joint modes.
///
///     JointSchedule contacts({leg("left"), leg("right")}, 8);
///     phase.bound_input(0, exactly(0.0), contacts.during(0, "swing"));
///     contacts.part(0).retime("left lands", 0.31);
///     controller.set_schedule(contacts.join(now, now + horizon));
class JointSchedule {
 public:
  /// `capacity` is the maximum number of events of the joint schedule. Throws DefinitionError if
  /// there is no part or if there are too many joint modes.
  JointSchedule(std::vector<Schedule> parts, int capacity);

  /// Number of parts.
  int parts() const { return static_cast<int>(parts_.size()); }
  /// The schedule of part i, for editing. join() applies the edits.
  Schedule& part(int i) { return parts_[i]; }
  /// The schedule of part i.
  const Schedule& part(int i) const { return parts_[i]; }

  /// Window in which part i is in this mode, for any modes of the other parts. Throws
  /// DefinitionError with the nearest known mode.
  Window during(int i, const std::string& mode) const;

  /// The joint schedule of (from, to]. It excludes events before and after. Simultaneous events of
  /// several parts become one event with the name of the first. Does not allocate without an error.
  /// Throws DefinitionError if the events exceed the capacity, or if two events at different times
  /// have the same name.
  const Schedule& join(double from, double to);
  /// The result of the last join().
  const Schedule& joined() const { return joined_; }

 private:
  // Joint modes are numbers in a mixed radix whose digits are the modes of the parts.
  struct Digit {
    int stride = 1;    // change of the joint mode per step of the part's mode
    int position = 0;  // index of the part's active mode in its schedule
  };

  std::vector<Schedule> parts_;
  std::vector<Digit> digits_;
  Schedule joined_;
};

}  // namespace saltus
