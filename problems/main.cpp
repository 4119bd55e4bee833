// The program `saltus`: its problems by name.
#include <vector>

#include "framework/app/program.hpp"
#include "problems/push_recovery/run.hpp"

int main(int argc, char** argv) {
  const std::vector<saltus::ProblemEntry> problems{saltus::push_recovery::entry()};
  return saltus::saltus_main(argc, argv, problems);
}
