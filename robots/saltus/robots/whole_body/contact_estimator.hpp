// Detects the landing of the swing foot from the force on it.
#pragma once

#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// A foot has landed once the vertical force reaches a threshold, but not before an earliest time.
/// Earlier contacts belong to lift-off or scuffing.
class ContactEstimator {
 public:
  /// `force`: threshold of the vertical force, N.
  explicit ContactEstimator(double force) : force_(force) {}

  /// Sets the earliest time of the next landing, s.
  void expect(double earliest) { earliest_ = earliest; }
  /// True if the swing foot, with this contact at `t` (s), has landed.
  bool has_landed(double t, const FootContact& contact) const {
    return !(t < earliest_ || contact.wrench[2] < force_);
  }

 private:
  double force_, earliest_ = infinity;
};

}  // namespace saltus
