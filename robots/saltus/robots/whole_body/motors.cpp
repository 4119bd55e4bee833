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
    // Of a torque that is asked for all through a step the lag's exact solution: at its end, and
    // the mean, which is what the engine's step is given.
    if (options.bandwidth > 0.0) {
      const double lags = 2.0 * std::numbers::pi * options.bandwidth * step;
      followed_ = -std::expm1(-lags);
      mean_followed_ = 1.0 - followed_ / lags;
    }
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
    for (int i = 0; i < torques_.size(); ++i) {
      const double missing = wanted_[i] - torques_[i], change = followed_ * missing;
      const bool is_limited = std::abs(change) > largest_change_;
      const double moved = is_limited ? std::copysign(largest_change_, change) : change;
      exerted_[i] = torques_[i] + (is_limited ? 0.5 * moved : mean_followed_ * missing);
      torques_[i] += moved;
    }
    plant_->set_torques(exerted_);
    plant_->step();
  }

 private:
  void rest() {
    wanted_ = torques_ = exerted_ = VectorXd::Zero(plant_->state().q.size());
    rests_ = true;
  }

  // Per step: of what is missing, at its end and on average; Nm.
  double followed_ = 1.0, mean_followed_ = 1.0, largest_change_ = infinity;
  VectorXd wanted_, torques_, exerted_;  // torques_: at the end of the last step
  bool rests_ = true;                    // nothing has been asked for since the reset
};

}  // namespace

std::unique_ptr<Plant> with_motors(std::unique_ptr<Plant> plant, const MotorOptions& options,
                                   double step) {
  return std::make_unique<DrivenPlant>(std::move(plant), options, step);
}

}  // namespace saltus
