// The component ipopt: a quadratic with a bound.
#include <cstdio>
#include <saltus/solver/ipopt.hpp>

int main() {
  const auto solver = saltus::make_ipopt();
  std::printf("%s\n", solver->name().c_str());
  return solver->name().empty() ? 1 : 0;
}
