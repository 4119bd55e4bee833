#include "saltus/model/switching_system.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

void check_function(const std::string& what, const Function& function, const Arguments& sizes,
                    int outputs) {
  if (!function) throw DefinitionError(what + " is missing.");
  if (function.inputs() != sizes.size())
    throw DefinitionError(fmt::format("{} must take (t, x, u, p) of {} entries, but takes {}.",
                                      what, sizes.size(), function.inputs()));
  if (function.outputs() != outputs)
    throw DefinitionError(fmt::format("{} must return {} entries, but returns {}.", what, outputs,
                                      function.outputs()));
}

}  // namespace

SwitchingSystem::SwitchingSystem() = default;
SwitchingSystem::SwitchingSystem(const SwitchingSystem& other) = default;
SwitchingSystem::SwitchingSystem(SwitchingSystem&& other) noexcept = default;
SwitchingSystem& SwitchingSystem::operator=(const SwitchingSystem& other) = default;
SwitchingSystem& SwitchingSystem::operator=(SwitchingSystem&& other) noexcept = default;
SwitchingSystem::~SwitchingSystem() = default;

int SwitchingSystem::mode_index(const std::string& name) const {
  for (std::size_t m = 0; m < modes.size(); ++m)
    if (modes[m].name == name) return static_cast<int>(m);
  return -1;
}

void SwitchingSystem::add_transition(const std::string& name, const std::string& from_mode,
                                     const std::string& to_mode, Function guard, Crossing direction,
                                     Function reset) {
  const auto find = [&](const std::string& mode) {
    const int index = mode_index(mode);
    if (index < 0)
      throw DefinitionError("event '" + name + "': there is no mode '" + mode + "' yet.");
    return index;
  };
  transitions.push_back(
      {name, find(from_mode), find(to_mode), std::move(guard), direction, std::move(reset)});
}

void SwitchingSystem::check(const Arguments& sizes, int nq) const {
  if (empty()) return;
  const int count = static_cast<int>(modes.size());
  std::set<std::string> names;
  for (const Mode& mode : modes) {
    if (!names.insert(mode.name).second)
      throw DefinitionError("two modes are called '" + mode.name + "'.");
    check_function("mode '" + mode.name + "': the dynamics", mode.dynamics, sizes, sizes.nx);
    if (mode.running_cost)
      check_function("mode '" + mode.name + "': the running cost", mode.running_cost, sizes, nq);
  }
  if (memory >= sizes.nx)
    throw DefinitionError(
        fmt::format("the mode is stored in state {}, but there are {} states.", memory, sizes.nx));
  const VectorXd anywhere = VectorXd::Zero(sizes.size());  // a rate that reads nothing is constant
  for (const Mode& mode : modes)
    if (memory >= 0 && (mode.dynamics.jacobian_pattern().row_begin(memory) <
                            mode.dynamics.jacobian_pattern().row_end(memory) ||
                        mode.dynamics(anywhere)[memory] != 0.0))
      throw DefinitionError(
          fmt::format("mode '{}': state {} stores the mode, so its rate must be the constant 0.",
                      mode.name, memory));
  for (const Transition& transition : transitions) {
    const std::string event = "event '" + transition.name + "': ";
    for (const int mode : {transition.from, transition.to})
      if (mode < 0 || mode >= count)
        throw DefinitionError(fmt::format("{}there is no mode {}; there are {}, counted from 0.",
                                          event, mode, count));
    const std::string between =
        "event '" + transition.name + "' of mode '" + modes[transition.from].name + "': ";
    if (transition.from == transition.to && !transition.reset)
      throw DefinitionError(
          between +
          "it changes neither mode nor state; add a reset or choose another target mode.");
    check_function(between + "the guard", transition.guard, sizes, 1);
    if (transition.reset) check_function(between + "the reset", transition.reset, sizes, sizes.nx);
    if (!depends_on(transition.guard, sizes.t()) &&
        !depends_on_any(transition.guard, sizes.x(), sizes.nx) &&
        !depends_on_any(transition.guard, sizes.u(), sizes.nu))
      throw DefinitionError(
          between +
          "the guard depends on neither state, time nor input, so it never crosses zero.");
  }
}

}  // namespace saltus
