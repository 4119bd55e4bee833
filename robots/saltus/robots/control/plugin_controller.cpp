#include "saltus/robots/control/plugin_controller.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "saltus/c/saltus_c.h"
#include "saltus/c/saltus_robot.h"
#include "saltus/core/error.hpp"

namespace saltus::robots::control {

struct PluginController::Plugin {
  std::string file;
  void* library = nullptr;
  saltus_controller* controller = nullptr;
  saltus_sizes sizes{};

  decltype(&::saltus_interface_version) interface_version = nullptr;
  decltype(&::saltus_controllers) controllers = nullptr;
  decltype(&::saltus_controller_name) controller_name = nullptr;
  decltype(&::saltus_create) create = nullptr;
  decltype(&::saltus_destroy) destroy = nullptr;
  decltype(&::saltus_error) error = nullptr;
  decltype(&::saltus_read_sizes) read_sizes = nullptr;
  decltype(&::saltus_prepare) prepare = nullptr;
  decltype(&::saltus_feedback) feedback = nullptr;
  decltype(&::saltus_read_piece) read_piece = nullptr;
  // Optional.
  decltype(&::saltus_state_of_sensors) state_of = nullptr;
  decltype(&::saltus_torques_of_input) torques_of = nullptr;

  int joints = 0;
  double link_period = 0.0;
  long tick = -1;  // number of the last tick
  bool is_prepared = false;
  std::vector<double> state, input;
  saltus_sensors readings{};
  saltus_tick last{};
  LatencyHistogram times;
  long without_plan = 0;
  Robot::Commands commands;
  std::string failure;  // sentence about the first one

  ~Plugin() {
    if (destroy != nullptr) destroy(controller);
    if (library != nullptr) ::dlclose(library);
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(fmt::format("--plugin {}: {}", file, why));
  }
  template <class Function>
  void find(Function& function, const char* name, bool is_optional = false) {
    function = reinterpret_cast<Function>(::dlsym(library, name));
    if (function == nullptr && !is_optional)
      refuse(fmt::format("it has no function {}; build it with saltus_plugin()", name));
  }
  void expect(saltus_status status) const {
    if (status != SALTUS_OK) refuse(controller != nullptr ? error(controller) : "no memory");
  }
  void note(saltus_status status) {
    if (status == SALTUS_OK || !failure.empty()) return;
    failure = fmt::format("the controller of the plugin has failed: {}", error(controller));
  }
  double time_of(long number) const { return static_cast<double>(number) * sizes.period; }
  void convert(const SensorMessage& r);
  void read_input(double time);
};

PluginController::PluginController(const std::filesystem::path& plugin, const std::string& name,
                                   int joints, double period)
    : plugin_(std::make_unique<Plugin>()) {
  Plugin& p = *plugin_;
  p.file = plugin.string();
  p.library = ::dlopen(std::filesystem::absolute(plugin).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (p.library == nullptr) p.refuse(::dlerror());
  p.find(p.interface_version, "saltus_interface_version");
  if (p.interface_version() != SALTUS_INTERFACE_VERSION)
    p.refuse(fmt::format("it has version {} of the interface, this program {}; build it again",
                         p.interface_version(), SALTUS_INTERFACE_VERSION));
  p.find(p.controllers, "saltus_controllers");
  p.find(p.controller_name, "saltus_controller_name");
  p.find(p.create, "saltus_create");
  p.find(p.destroy, "saltus_destroy");
  p.find(p.error, "saltus_error");
  p.find(p.read_sizes, "saltus_read_sizes");
  p.find(p.prepare, "saltus_prepare");
  p.find(p.feedback, "saltus_feedback");
  p.find(p.read_piece, "saltus_read_piece");
  p.find(p.state_of, "saltus_state_of_sensors", true);
  p.find(p.torques_of, "saltus_torques_of_input", true);
  std::string all;
  for (int i = 0; i < p.controllers(); ++i)
    all += fmt::format("{}{}", i > 0 ? ", " : "", p.controller_name(i));
  if (name.empty() && p.controllers() != 1)
    p.refuse(fmt::format("name one of its controllers with --controller: {}", all));
  const std::string chosen = name.empty() ? p.controller_name(0) : name;
  if (const saltus_status status = p.create(chosen.c_str(), &p.controller);
      status == SALTUS_UNKNOWN_NAME)
    p.refuse(fmt::format("it has no controller {}; it has {}", chosen, all));
  else
    p.expect(status);
  p.expect(p.read_sizes(p.controller, &p.sizes));
  p.joints = joints;
  p.link_period = period;
  if (p.state_of == nullptr && p.sizes.states != 2 * joints)
    p.refuse(
        fmt::format("{} has {} states, expected the positions and velocities of {} joints; "
                    "or export saltus_state_of_sensors()",
                    chosen, p.sizes.states, joints));
  if (p.torques_of == nullptr && p.sizes.inputs != joints)
    p.refuse(
        fmt::format("{} has {} inputs, expected the torques of {} joints; or export "
                    "saltus_torques_of_input()",
                    chosen, p.sizes.inputs, joints));
  const double ratio = p.sizes.period / period;
  if (std::round(ratio) < 1.0 || std::abs(ratio - std::round(ratio)) > 1e-6 * ratio)
    p.refuse(fmt::format("the period of {}, {} s, is not a multiple of that of the readings, {} s",
                         chosen, p.sizes.period, period));
  p.state.resize(static_cast<std::size_t>(p.sizes.states));
  p.input.resize(static_cast<std::size_t>(std::max(p.sizes.inputs, p.sizes.plan_inputs)));
  p.commands.torques = VectorXd::Zero(joints);
}

PluginController::~PluginController() = default;

double PluginController::period() const { return plugin_->sizes.period; }
const LatencyHistogram& PluginController::ticks() const { return plugin_->times; }
std::string PluginController::fault() const { return plugin_->failure; }
long PluginController::without_plan() const { return plugin_->without_plan; }

void PluginController::Plugin::convert(const SensorMessage& r) {
  if (state_of == nullptr) {
    std::copy_n(r.q.data(), joints, state.begin());
    std::copy_n(r.dq.data(), joints, state.begin() + joints);
    return;
  }
  readings.sequence = r.sequence;
  readings.time = std::llround(1e9 * r.time);
  readings.pace = r.pace;
  std::copy_n(r.angular_velocity.data(), 3, readings.angular_velocity);
  std::copy_n(r.specific_force.data(), 3, readings.specific_force);
  std::copy_n(r.orientation.data(), 4, readings.orientation);
  std::copy_n(r.left.data(), 6, readings.left);
  std::copy_n(r.right.data(), 6, readings.right);
  std::copy_n(r.q.data(), joints, readings.q);
  std::copy_n(r.dq.data(), joints, readings.dq);
  state_of(&readings, joints, state.data(), sizes.states);
}

// The piece of the input that acts at `time`.
void PluginController::Plugin::read_input(double time) {
  for (int i = 0; i < last.pieces; ++i) {
    double begin = 0.0, length = 0.0;
    int count = 0;
    note(read_piece(controller, i, &begin, &length, input.data(), static_cast<int>(input.size()),
                    &count));
    if (time < begin + length - 0.5 * link_period) break;
  }
}

void PluginController::start(const SensorMessage&) {
  plugin_->tick = -1;
  prepare();
}

// Prepares the next tick without a measurement.
void PluginController::prepare() {
  Plugin& p = *plugin_;
  if (p.is_prepared) return;
  p.note(p.prepare(p.controller, p.time_of(p.tick + 1)));
  p.is_prepared = true;
}

const Robot::Commands& PluginController::update(double time, const SensorMessage& r) {
  Plugin& p = *plugin_;
  if (time + 0.5 * p.link_period > p.time_of(p.tick + 1)) {
    prepare();
    p.convert(r);
    p.note(p.feedback(p.controller, p.state.data(), p.sizes.states, &p.last));
    ++p.tick;
    p.is_prepared = false;
    p.times.add(p.last.feedback);
    if (p.last.provenance == SALTUS_SHIFTED || p.last.provenance == SALTUS_FALLBACK)
      ++p.without_plan;
  }
  p.read_input(time);
  if (p.torques_of == nullptr)
    std::copy_n(p.input.begin(), p.joints, p.commands.torques.data());
  else
    p.torques_of(&p.readings, p.input.data(), p.sizes.inputs, p.commands.torques.data(), p.joints);
  return p.commands;
}

}  // namespace saltus::robots::control
