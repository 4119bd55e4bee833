// Shell completion: verbs, problems, settings and their values.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/app/program.hpp"

namespace saltus {

/// Hidden verb of the shell scripts. Its arguments are the words up to and including the one being
/// typed.
inline constexpr const char* completion_verb = "__complete";

/// Completions of the last of `words`, which may be empty or partial. Empty if a file is expected.
std::vector<std::string> completions(std::span<const std::string> words,
                                     std::span<const std::string> verbs,
                                     std::span<const ProblemEntry> problems);

/// `saltus completion bash|zsh|fish` prints the script.
ExitStatus print_completion(std::span<const std::string> arguments);

}  // namespace saltus
