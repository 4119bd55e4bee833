// Detects the landing of the swing foot from the force on it.
#pragma once

#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// A foot has landed once the ground carries a threshold of force, but not before an earliest time:
/// earlier touches are those of lifting off and of scuffing.
class ContactEstimator {
 public:
  /// `force`: vertical, N.
  explicit ContactEstimator(double force) : force_(force) {}

  /// Earliest time of the landing to come, s.
  void expect(double earliest) { earliest_ = earliest; }
  /// True if the swing foot, with this contact at `t` (s), has landed.
  bool has_landed(double t, const FootContact& contact) const {
    return !(t < earliest_ || contact.wrench[2] < force_);
  }

 private:
  double force_, earliest_ = infinity;
};

}  // namespace saltus
