#include "problems/library/catalogue.hpp"

#include <fmt/format.h>

#include "problems/library/cases.hpp"
#include "problems/library/simulations.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {

const std::vector<ReferenceCase>& reference_cases() {
  static const std::vector<ReferenceCase> cases{
      library::three_modes(),              // A01
      library::linear_quadratic_switch(),  // A02
      library::switched_autonomous(),      // A04
      library::fishing(),                  // A06
      library::fishing_relaxed(),          // A08
      library::f8_aircraft(),              // A09
      library::double_tank(),              // A11
      library::tank_on_ramp(),             // A12
      library::tank_sequence(),            // A12
      library::calcium_oscillation(),      // A13
      library::turbo_car(),                // A14
      library::switch_of_speed(),          // A17
      library::juggled_ball(),             // A20
      library::bryson_denham(),            // B01
      library::low_ceiling(),              // B02
      library::touched_ceiling(),          // B02
      library::low_ceiling_arcs(),         // B02
      library::brachistochrone(),          // B03
      library::bang_bang(),                // B05
      library::goddard_rocket(),           // B07
      library::delta_iii(),                // B09
      library::catalyst_mixing(),          // B10
      library::particle_steering(),        // B11
      library::hang_glider(),              // B12
      library::hanging_chain(),            // B14
      library::hanging_chain_fine(),       // B14
      library::maximum_range(),            // B15
      library::hyper_sensitive(),          // B16
      library::moon_lander(),              // B18
      library::alp_rider(),                // B20
      library::two_phase_tracking(),       // B21
      library::interior_point(),           // B22
      library::van_der_pol(),              // B25
      library::phase_transition(),         // C02
      library::pendulum_on_cart(),         // C03
      library::step_recovery_landing(),    // C09
      library::step_recovery_waiting(),    // C09
      library::dido(),                     // E01
      library::linked_phases(),            // E02
      library::tide(),                     // E03
      library::delayed_product(),          // E04
      library::thermostat_size(),          // E05
      library::soft_targets(),             // E06
      library::boundary_layers(),          // E07
  };
  return cases;
}

const std::vector<SimulationCase>& simulation_cases() {
  static const std::vector<SimulationCase> cases{
      library::switched_oscillator(),
      library::filippov_cases(),
      library::capture_point(),
      library::van_der_pol_stiff(),
      library::robertson_kinetics(),
      library::restricted_three_body(),
      library::bouncing_ball_simulation(),
      library::saltation_matrix(),
      library::spring_leg_stance(),
      library::matrix_exponential(),
  };
  return cases;
}

const ReferenceCase& reference_case(const std::string& id_or_name) {
  std::vector<std::string> known;
  for (const ReferenceCase& c : reference_cases()) {
    if (c.id == id_or_name || c.name == id_or_name) return c;
    known.push_back(c.id);
    known.push_back(c.name);
  }
  throw InputError(fmt::format("there is no reference case '{}'{}", id_or_name,
                               did_you_mean(id_or_name, known)));
}

}  // namespace saltus
