#include "problems/suite/integrator_names.hpp"

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"

namespace saltus {

const std::vector<std::pair<std::string, Scheme>>& schemes() {
  static const std::vector<std::pair<std::string, Scheme>> names{
      {"own", Scheme::own},       {"rk4", Scheme::runge_kutta4}, {"rk8", Scheme::runge_kutta8},
      {"cvodes", Scheme::cvodes}, {"arkode", Scheme::arkode},    {"zoh", Scheme::zero_order_hold}};
  return names;
}

IntegratorChoice make_scheme(Scheme scheme, double tolerance) {
  switch (scheme) {
    case Scheme::own:
      return nullptr;
    case Scheme::runge_kutta4:
      return runge_kutta4();
    case Scheme::runge_kutta8:
      return runge_kutta8();
    case Scheme::cvodes:
      return cvodes({.method = CvodesOptions::Method::Bdf, .tolerance = tolerance});
    case Scheme::arkode:
      return arkode({.tolerance = tolerance});
    case Scheme::zero_order_hold:
      return zero_order_hold();
  }
  return nullptr;
}

}  // namespace saltus
