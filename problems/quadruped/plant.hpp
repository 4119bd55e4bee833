// The robot on uneven ground: a hybrid automaton with a mode for every set of feet in contact.
//
// A foot in the air moves as commanded until it touches the ground: the event "lands". In contact
// it sticks, and its leg pushes the body with the commanded force, limited by friction and the
// length of the leg. A leg that is commanded to swing in contact drags: it is a servo of finite
// gain. It leaves the ground when it is commanded to move away from it: the event "lifts".
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "problems/quadruped/gait.hpp"
#include "problems/quadruped/ground.hpp"
#include "problems/quadruped/rigid_body.hpp"
#include "saltus/simulation/plants.hpp"

namespace saltus::quadruped {

/// Command of a leg, valid until the next one.
struct LegCommand {
  bool swings = false;                     // false: it pushes with the planned force
  Vec<double, 3> velocity{0.0, 0.0, 0.0};  // velocity of a foot without contact, m/s
};

struct PlantSettings {
  Body body;
  double friction = 0.6;     // friction coefficient of the ground
  double leg_length = 0.42;  // a longer leg cannot push, m
  double servo_gain = 60.0;  // gain of a dragging leg, N s/m
};

class RobotOnGround final : public LoopPlant {
 public:
  /// The robot starts level, with its CoM `height` (m) above the mean of its feet below the hips.
  RobotOnGround(const PlantSettings& settings, const Ground& ground, double height);

  double time() const override { return inner_->time(); }
  VectorXd state() const override { return inner_->state().head(states); }
  int inputs() const override { return 3 * legs; }
  bool advance(const VectorRef& forces, double length) override;
  std::string failure() const override { return inner_->failure(); }
  std::string mode() const override { return inner_->mode(); }
  /// Returns the state of the body.
  std::vector<HybridEvent> take_events() override;
  void disturb(const VectorRef& change) override;
  /// Forces on the CoM, N.
  bool take_pulses(std::span<const Pulse> pulses) override {
    pulses_.assign(pulses.begin(), pulses.end());
    return true;
  }
  std::string name() const override { return "rigid body on uneven ground"; }

  PerLeg<double> feet() const { return inner_->state().tail<3 * legs>().reshaped(3, legs); }
  Touching touching() const;
  /// Ground forces during the last call of advance(), for feet in contact, N.
  const PerLeg<double>& forces() const { return forces_; }
  void command(const std::array<LegCommand, legs>& commands) { commands_ = commands; }
  /// Tilt of the body, rad, and height of its CoM above the ground, m.
  double tilt() const;
  double height() const;

 private:
  Vec<double, 3> force_of_leg(int leg, const State<double>& x, const Vec<double, 3>& foot,
                              const Vec<double, 3>& planned) const;

  PlantSettings settings_;
  Ground ground_;
  std::vector<Pulse> pulses_;
  std::array<LegCommand, legs> commands_;
  PerLeg<double> forces_ = PerLeg<double>::Zero();
  std::unique_ptr<IntegratorPlant> inner_;
};

}  // namespace saltus::quadruped
