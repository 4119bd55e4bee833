// A receding-horizon controller of a plugin (saltus/c/register_controller.hpp) as the controller of
// a robot in another process.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "saltus/robots/control/link_controller.hpp"

namespace saltus::robots::control {

/// Runs a controller that a user's project has registered. By default its state contains all joint
/// positions, then all joint velocities, and its inputs are the joint torques. A plugin with
/// another state or input exports functions for the conversion, see saltus/c/saltus_robot.h.
class PluginController final : public LinkController {
 public:
  /// Loads the plugin. `name`: one of its controllers; empty: the only one. `period`:
  /// period of the readings, s. Throws InputError that names the plugin and the reason.
  PluginController(const std::filesystem::path& plugin, const std::string& name, int joints,
                   double period);
  ~PluginController() override;

  void start(const SensorMessage& readings) override;
  const Robot::Commands& update(double time, const SensorMessage& readings) override;
  /// First failure of the plugin, or empty.
  std::string fault() const override;
  void prepare() override;

  /// Period of the controller, s.
  double period() const;
  /// Computing times of its ticks, from the readings to the input, s.
  const LatencyHistogram& ticks() const;
  /// Ticks whose input came from an earlier plan, or from none.
  long without_plan() const;

 private:
  struct Plugin;
  std::unique_ptr<Plugin> plugin_;
};

}  // namespace saltus::robots::control
