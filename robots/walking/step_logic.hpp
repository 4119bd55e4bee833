// When does the robot step, and where does the foot land?
#pragma once

#include "problems/push_recovery/config.hpp"
#include "saltus/core/bounds.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::push_recovery {

/// Decides once per tick from the capture point. The foot is placed at the capture point predicted
/// for the landing with the centre of pressure at the edge of the stance sole that is nearest to
/// it, clipped to the reach; the place is fixed at the decision.
class StepLogic {
 public:
  /// The stance foot, on that side of the robot, stands at `stance`. Places are forward and to the
  /// side, away from the stance foot: of a left one towards -y.
  StepLogic(const Step& options, bool stepping, double push_start, Side side, SoleFrame stance,
            FootRectangle stance_foot);

  /// `t` s, capture point in the world (m), omega 1/s.
  void update(double t, const Vec<double, 2>& capture_point, double omega);

  bool is_stepping() const { return landing_ < infinity; }
  bool is_decided() const { return decided_; }
  /// Absolute time of the landing, infinite while no step is due, s.
  double landing_time() const { return landing_; }
  /// Where the contact frame of the swing foot lands, in the world, m.
  const Vec<double, 3>& place() const { return place_; }

 private:
  Vec<double, 3> in_world(const Vec<double, 2>& place) const;
  Vec<double, 2> predicted_place(double t, const Vec<double, 2>& capture_point, double omega) const;

  Step options_;
  bool stepping_;
  double push_start_;
  double away_;  // from the stance foot, along its y
  SoleFrame stance_;
  FootRectangle stance_foot_;
  double trigger_ = infinity;
  double landing_ = infinity;
  bool decided_ = false;
  Vec<double, 3> place_;
};

}  // namespace saltus::push_recovery
