// `saltus bench latency --against hpipm`: alternates the structured solver and HPIPM on the same
// instances in one process, with the same judge.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "benchmarks/cases.hpp"

namespace saltus::bench {

/// One case. The time of an instance is the minimum of several alternating solves.
struct Duel {
  CaseResult ours, theirs;
  double ratio = 0.0;  ///< median over the instances of our time over theirs
};

/// The given file, otherwise that of the package comma-deps-acados in the environment of the peers.
/// Throws InputError if it does not exist.
std::filesystem::path hpipm_library(const std::optional<std::filesystem::path>& given);

/// Runs the selected cases and calls `observe` after each one. Throws InputError if there is no
/// such case, or if the library is invalid.
std::vector<Duel> measure_against_hpipm(const std::filesystem::path& library,
                                        const Selection& selection,
                                        const std::function<void(const Duel&)>& observe = {});

std::string duel_head();
std::string duel_line(const Duel& duel);

}  // namespace saltus::bench
