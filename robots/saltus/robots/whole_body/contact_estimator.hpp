// Contact of a swing foot with the ground: whether it has landed, and whether it has lost a
// contact.
#pragma once

#include "saltus/core/bounds.hpp"

namespace saltus::robots {

/// Estimates the probability that the swing foot touches the ground, as the sum of log odds: the
/// vertical force speaks for a contact, a foot that is above the expected ground, early or fast
/// speaks against it. A foot has landed when the probability reaches one half, but not before an
/// earliest time. Earlier contacts belong to lift-off or scuffing. A landed foot has lost its
/// contact when the probability stays small.
class ContactEstimator {
 public:
  /// Options of the estimate.
  struct Options {
    bool is_estimated = false;  ///< False: the force alone decides, and no contact is ever lost.
    double force = 20.0;        ///< N, force with even odds if nothing speaks against a contact
    double force_unit = 0.25;   ///< part of `force` that changes the log odds by 1
    /// Height above the expected ground (m), time before the expected landing (s) and downward
    /// speed beyond the expected one (m/s) that lower the log odds by 1. Each lowers them by at
    /// most `most_doubt`, because the ground may be higher than expected.
    double height_unit = 0.01, time_unit = 0.05, speed_unit = 0.05, most_doubt = 3.0;
    double speed = 0.1;    ///< m/s, largest expected downward speed of a foot that touches
    double lost = 0.1;     ///< probability below which a contact may be lost
    double grace = 0.005;  ///< s; a contact is lost after this time with such a probability
  };

  /// Measurements of the foot at an instant.
  struct Evidence {
    double time = 0.0;    ///< s
    double force = 0.0;   ///< vertical force of the ground, N
    double height = 0.0;  ///< height of the sole, m
    double speed = 0.0;   ///< downward speed of the sole, m/s
  };

  /// An estimator that expects no landing.
  explicit ContactEstimator(const Options& options) : options_(options) {}

  /// Sets earliest and expected time (s) and expected height (m) of the next landing.
  void expect(double earliest, double landing, double height);
  /// Processes the newest evidence.
  void update(const Evidence& now);

  /// Probability that the foot touches the ground; zero before the earliest time.
  double probability() const;
  bool has_landed() const { return log_odds_ >= 0.0; }         ///< true if a contact is likely
  bool is_lost() const { return unlikely_ > options_.grace; }  ///< true if the contact is lost

 private:
  Options options_;
  double earliest_ = infinity, landing_ = infinity, height_ = 0.0;
  double time_ = 0.0, log_odds_ = -infinity;
  double unlikely_ = 0.0;  // s, time since which the contact is unlikely
};

}  // namespace saltus::robots
