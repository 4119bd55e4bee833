#include "saltus/transcription/quantities.hpp"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace saltus {

Quantities undeclared_quantities(const ShootingProgram& program) {
  Quantities list;
  // Keyed by the number of states (or inputs) of a phase and the component.
  std::map<std::pair<int, int>, std::vector<int>> states, inputs;
  std::map<std::string, std::vector<int>> integrals;  // by name
  const Layout& layout = program.layout();
  for (int j = 0; j < program.grid().phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    const int nx = phase.sizes.nx, nu = phase.sizes.nu, intervals = program.grid().intervals(j);
    for (int i = 0; i < nx; ++i) {
      if (phase.has_nominal || is_declared(phase.nominal_state[i])) continue;
      for (int k = 0; k <= intervals; ++k) states[{nx, i}].push_back(layout.state(j, k) + i);
    }
    const int coefficients = program.integrators()[j]->arguments().nc;
    for (int c = 0; c < coefficients; ++c) {
      if (phase.has_nominal || is_declared(phase.nominal_input[c % nu])) continue;
      for (int k = 0; k < intervals; ++k) inputs[{nu, c % nu}].push_back(layout.input(j, k) + c);
    }
    for (int i = 0; i < program.data().parameters[j].size(); ++i)
      if (layout.parameter(j, i) >= 0 && !is_declared(phase.nominal_parameter(i)))
        list.push_back({layout.parameter(j, i)});
    if (layout.duration(j) >= 0 && !phase.has_nominal_duration &&
        !is_declared(phase.nominal_duration))
      list.push_back({layout.duration(j)});
    for (std::size_t i = 0; i < phase.integrals.size(); ++i) {
      if (is_declared(phase.integrals[i].magnitude)) continue;
      for (int k = 0; k <= intervals; ++k)
        integrals[phase.integrals[i].name].push_back(layout.integral(j, k) + static_cast<int>(i));
    }
  }
  if (layout.start_time() >= 0) list.push_back({layout.start_time()});
  for (auto& [name, variables] : integrals) list.push_back(std::move(variables));
  for (auto* components : {&states, &inputs})
    for (auto& [component, variables] : *components) list.push_back(std::move(variables));
  return list;
}

double datum_magnitude(double value, double nominal, double share) {
  constexpr double zero = 1e-9;  // relative to the nominal magnitude
  return std::abs(value) > zero * nominal ? std::abs(value) : share * nominal;
}

}  // namespace saltus
