// The program `saltus-bench`, which `saltus bench` executes: problems do not depend on benchmarks.
#include <vector>

#include "benchmarks/suite/bench_verb.hpp"
#include "saltus/app/program.hpp"

int main(int argc, char** argv) {
  const std::vector<saltus::Verb> verbs{saltus::bench::bench_verb()};
  return saltus::saltus_main(argc, argv, {}, verbs);
}
