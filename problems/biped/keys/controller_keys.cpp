#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {

void declare_solver(Settings& s, PlannerSettings& planner) {
  s.choice<SolverChoice>("solver", planner.solver, solver_choices(),
                         "solver of the optimal control problem: stage by stage, as one sparse "
                         "system, or as a general nonlinear program");
}

void declare_settings(Settings& s, PlannerSettings& planner) {
  s.number("mpc.step_s", planner.step, "s", "grid spacing and period of the controller",
           between(1e-4, 10.0));
  s.integer("mpc.intervals", planner.intervals, "", "number of grid intervals in the horizon",
            between(1.0, 1000.0));
  s.number("solver_tolerance", planner.tolerance, "", "tolerance of the scaled KKT error",
           strictly_between(0, 1));
  s.number("mpc.deadline_s", planner.deadline, "s", "time limit per tick (wall clock); 0: none",
           at_least(0.0));
}

void declare_settings(Settings& s, ContactSettings& c) {
  s.number("contact.friction", c.friction, "", "coefficient of friction", above(0.0));
  s.integer("contact.edges", c.edges, "",
            "number of edges of the friction pyramid: 3, 4, 6, 8 or 12", between(3.0, 12.0));
  s.rule({"contact.edges"}, [&c] {
    const int n = c.edges;
    const bool known = n == 3 || n == 4 || n == 6 || n == 8 || n == 12;
    return known ? "" : fmt::format("contact.edges is {}; use 3, 4, 6, 8 or 12", n);
  });
  s.number("contact.torsional_friction_m", c.torsional_friction, "m", "largest |tz| / fz",
           at_least(0.0));
  s.flag("contact.corners", c.corners,
         "also limit the torque about the normal to what friction at the foot's four corners can "
         "exert; a foot that stands on one corner then turns freely");
  s.number("contact.fz_min", c.normal_force_min, "N", "minimum normal force of a foot in contact",
           at_least(0.0));
  s.number("contact.fz_max", c.normal_force_max, "N", "maximum normal force of a foot", above(0.0));
  s.rule({"contact.fz_min", "contact.fz_max"}, [&c] {
    return c.normal_force_min <= c.normal_force_max
               ? ""
               : fmt::format("contact.fz_min ({}) exceeds contact.fz_max ({})", c.normal_force_min,
                             c.normal_force_max);
  });
}

}  // namespace saltus::robots::walking
