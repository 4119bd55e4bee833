// The timed batches of step recovery programs: horizon, landing and push of each.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/step_recovery_qp.hpp"

namespace saltus::bench {

struct Batch {
  std::string name;
  StepRecovery options;
  Bounds push = between(0.2, 0.3);  // m/s
  int fewer = 1;                    // divisor of the number of solves
  bool with_run_time_sizes = false;
};

inline std::vector<Batch> step_recovery_batches() {
  const int beyond = 1 << 20;
  return {{.name = "recipe/kI=7", .options = {15, 7}, .with_run_time_sizes = true},
          {.name = "recipe/no-impact", .options = {15, beyond}},
          {.name = "recipe/kI=0", .options = {15, 0}},
          {.name = "recipe/N=30", .options = {30, 7}},
          {.name = "recipe/N=60", .options = {60, 7}},
          {.name = "recipe/N=150", .options = {150, 7}},
          {.name = "recipe/N=1500", .options = {1500, 7}, .fewer = 50},
          {.name = "recipe/kI=0,N=1500", .options = {1500, 0}, .fewer = 50},
          {.name = "recipe/binding", .options = {15, 7}, .push = binding_push}};
}

}  // namespace saltus::bench
