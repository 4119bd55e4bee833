// `saltus bench latency --against hpipm`: the structured solver and HPIPM in turns on the same
// instances in one process, judged alike.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "benchmarks/cases.hpp"

namespace saltus::bench {

/// One case. The times of an instance are the least of some solves in turns.
struct Duel {
  CaseResult ours, theirs;
  double ratio = 0.0;  ///< median over the instances of our time over theirs
};

/// The file given, else that of the package comma-deps-acados in the environment of the peers.
/// Throws InputError if there is none.
std::filesystem::path hpipm_library(const std::optional<std::filesystem::path>& given);

/// Runs what is wanted; `observe` hears of every case as it ends. Throws InputError if there is no
/// such case, or the library is none.
std::vector<Duel> measure_against_hpipm(const std::filesystem::path& library,
                                        const Selection& selection,
                                        const std::function<void(const Duel&)>& observe = {});

std::string duel_head();
std::string duel_line(const Duel& duel);

}  // namespace saltus::bench
