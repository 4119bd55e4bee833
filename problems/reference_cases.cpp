#include "problems/reference_cases.hpp"

#include <fmt/format.h>

#include "framework/core/error.hpp"
#include "framework/core/text.hpp"
#include "problems/bryson_denham/problem.hpp"
#include "problems/interior_point/problem.hpp"
#include "problems/pendulum_on_cart/problem.hpp"
#include "problems/phase_transition/problem.hpp"

namespace saltus {

const std::vector<ReferenceCase>& reference_cases() {
  static const std::vector<ReferenceCase> cases{
      bryson_denham::reference(),
      interior_point::reference(),
      phase_transition::reference(),
      pendulum_on_cart::reference(),
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
  const std::string near = nearest_name(id_or_name, known);
  throw InputError(fmt::format("there is no reference case '{}'{}", id_or_name,
                               near.empty() ? "" : "; did you mean '" + near + "'?"));
}

}  // namespace saltus
