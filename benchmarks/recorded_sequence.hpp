// Consecutive problems of a recovering robot, recorded once by record_sequence.cpp.
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

  qp::StageQp program(int tick) const {
    return step_recovery_qp({intervals, problems[tick].landing}, problems[tick].start);
  }
};

/// Throws InputError with the name of the file and the mistake.
RecordedSequence read_sequence(const std::filesystem::path& file);

/// At tick 0 the landing is 22 ticks ahead; after it both feet stand.
inline int landing_at(int tick) { return tick < 22 ? 22 - tick : 0; }

}  // namespace saltus::bench
