// Consecutive problems of a robot that recovers, recorded once (record_sequence.cpp) and stored.
#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/step_recovery_qp.hpp"

namespace saltus::bench {

struct SequenceProblem {
  int landing = 0;
  CentroidalState start;
};
struct RecordedSequence {
  int intervals = 0;
  std::vector<SequenceProblem> problems;

  StageQp program(int tick) const {
    return step_recovery_qp({intervals, problems[tick].landing}, problems[tick].start);
  }
};

/// Throws InputError naming the file and what is wrong with it.
RecordedSequence read_sequence(const std::filesystem::path& file);

/// Landing in 22 ticks seen from tick 0, then both feet.
inline int landing_at(int tick) { return tick < 22 ? 22 - tick : 0; }

}  // namespace saltus::bench
