#include <fmt/format.h>

#include "saltus/integrators/cvodes.hpp"
#include "saltus/ocp/window.hpp"
#include "saltus/robots/centroidal/centroidal_plant.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/legged_plant.hpp"

namespace saltus::walking {
namespace {

// The plant is the truth: far tighter than anything that is compared with it.
constexpr double plant_tolerance = 1e-11;

class CentroidalLeggedPlant final : public LeggedPlant {
 public:
  explicit CentroidalLeggedPlant(const PlantStart& start)
      : period_(start.period),
        nominal_mass_(start.robot.mass * (1.0 + start.mass_error)),
        swing_side_(other(start.scene.side)),
        swing_sole_(start.scene.swing),
        pushes_(start.pushes),
        plant_(start.robot.mass, start_state(start.posture),
               cvodes({.method = CvodesMethod::Adams,
                       .tolerance = plant_tolerance,
                       .absolute_tolerance = plant_tolerance})) {
    plant_.foot(start.scene.side) = {start.scene.stance, true};
    plant_.foot(swing_side_) = {swing_sole_, start.scene.two_feet};
    applied_ = start.scene.standing_wrenches(start.robot.mass, plant_.state().head<3>());
  }

  double tick_time(long k) const override { return static_cast<double>(k) * period_; }
  double step_end(double, double limit) const override { return limit; }

  bool sense(double) override { return true; }
  Vec<double, 9> measured() const override { return plant_.state(); }
  double nominal_mass() const override { return nominal_mass_; }
  SoleFrame sole(Side foot) const override {
    return foot == swing_side_ && !plant_.foot(foot).in_contact ? swing_sole_
                                                                : plant_.foot(foot).sole;
  }
  Vec<double, 3> sole_velocity(Side) const override { return Vec<double, 3>::Zero(); }
  const Vec<double, 12>& applied() const override { return applied_; }
  Vec<double, 3> contact_force() const override { return plant_.contact_force(applied_); }
  bool lands_on_time() const override { return true; }

  void lift_off(double, Side foot) override {
    swing_side_ = foot;
    swing_sole_ = plant_.foot(foot).sole;
    plant_.foot(foot).in_contact = false;
    landing_ = infinity;
  }
  void swing(double, const SwingTarget& target) override {
    landing_ = target.landing;
    swing_sole_.position = target.place;
  }
  std::optional<Landing> find_landing(double t) override {
    if (plant_.foot(swing_side_).in_contact || t <= landing_ - same_instant) return std::nullopt;
    plant_.foot(swing_side_) = {swing_sole_, true};
    return Landing{swing_sole_.position, swing_sole_.position};
  }
  void command(double, const Vec<double, 12>& wrenches) override { applied_ = wrenches; }
  std::string step(double from, double to) override {
    plant_.push = total_push_force(pushes_, from, to);
    const IntegrationStatus status = plant_.advance(to - from, applied_);
    if (status != IntegrationStatus::success)
      return fmt::format("the plant could not be integrated at {:.3f} s: {}", from,
                         saltus::describe(status));
    now_ = to;
    return {};
  }

  double truth_time() const override { return now_; }
  Vec<double, 9> truth() const override { return plant_.state(); }
  Vec<double, 3> true_sole(Side foot) const override { return sole(foot).position; }
  void describe(RunLog&) const override {}

 private:
  static Vec<double, 9> start_state(const StandingPosture& posture) {
    Vec<double, 9> gamma = Vec<double, 9>::Zero();
    gamma.head<3>() = posture.com;
    return gamma;
  }

  double period_, nominal_mass_;
  Side swing_side_;
  SoleFrame swing_sole_;
  double landing_ = infinity;
  std::vector<Push> pushes_;
  CentroidalPlant plant_;
  Vec<double, 12> applied_ = Vec<double, 12>::Zero();
  double now_ = 0.0;
};

}  // namespace

std::unique_ptr<LeggedPlant> make_centroidal_legged_plant(const PlantStart& start) {
  return std::make_unique<CentroidalLeggedPlant>(start);
}

}  // namespace saltus::walking
