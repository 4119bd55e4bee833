#include "saltus/robots/whole_body/motors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

class DrivenPlant final : public PlantAround {
 public:
  DrivenPlant(std::unique_ptr<Plant> plant, const MotorOptions& options, double step)
      : PlantAround(std::move(plant)) {
    const auto expect = [](bool good, const char* what, double value) {
      if (!good || !std::isfinite(value))
        throw DefinitionError(fmt::format("motors: {} cannot be {}", what, value));
    };
    expect(options.bandwidth >= 0.0, "the bandwidth", options.bandwidth);
    expect(options.torque_rate >= 0.0, "the largest rate of torque", options.torque_rate);
    expect(step > 0.0, "the step", step);
    // Of a torque that is asked for all through a step: the lag's exact solution.
    if (options.bandwidth > 0.0)
      followed_ = -std::expm1(-2.0 * std::numbers::pi * options.bandwidth * step);
    if (options.torque_rate > 0.0) largest_change_ = options.torque_rate * step;
    rest();
  }

  void reset(const WholeBodyState& state) override {
    plant_->reset(state);
    rest();
  }
  void set_torques(const VectorXd& torques) override {
    wanted_ = torques;
    if (rests_) torques_ = torques;
    rests_ = false;
  }
  void step() override {
    torques_ +=
        (followed_ * (wanted_ - torques_)).cwiseMax(-largest_change_).cwiseMin(largest_change_);
    plant_->set_torques(torques_);
    plant_->step();
  }

 private:
  void rest() {
    wanted_ = torques_ = VectorXd::Zero(plant_->state().q.size());
    rests_ = true;
  }

  double followed_ = 1.0, largest_change_ = infinity;  // per step: relative; Nm
  VectorXd wanted_, torques_;
  bool rests_ = true;  // nothing has been asked for since the reset
};

}  // namespace

std::unique_ptr<Plant> with_motors(std::unique_ptr<Plant> plant, const MotorOptions& options,
                                   double step) {
  return std::make_unique<DrivenPlant>(std::move(plant), options, step);
}

}  // namespace saltus
