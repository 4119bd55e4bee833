// Words that a shell can complete: verbs, problems, settings and their values.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "saltus/app/problem_registry.hpp"

namespace saltus {

/// What the scripts for shells ask the program, followed by the words up to and with the one that
/// is being written.
inline constexpr const char* completion_question = "__complete";

/// What the last of `words` (which may be empty, or begun) can be. Nothing where a file is due.
std::vector<std::string> completions(std::span<const std::string> words,
                                     std::span<const std::string> verbs,
                                     std::span<const ProblemEntry> problems);

/// `saltus completion bash|zsh|fish`: the script.
ExitStatus print_completion(std::span<const std::string> arguments);

}  // namespace saltus
