// The component sundials: creates an integrator of CVODES.
#include <cstdio>
#include <saltus/integrators/sundials.hpp>

int main() {
  const saltus::IntegratorChoice choice = saltus::cvodes({});
  std::printf("%s\n", choice->name().c_str());
  return choice->name().empty() ? 1 : 0;
}
