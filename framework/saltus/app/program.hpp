// Main function of programs with verbs: runs the verb of the first argument, and converts errors to
// one sentence and an exit status.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "saltus/app/exit_status.hpp"
#include "saltus/app/problem_registry.hpp"

namespace saltus {

/// A verb besides `list`, `run` and `help`. It receives the arguments after its name.
struct Verb {
  std::string name;     ///< the word on the command line
  std::string summary;  ///< one line for `saltus help`
  /// Runs the verb.
  std::function<ExitStatus(std::span<const std::string> arguments)> run;
};

/// A verb implemented by another program in the same folder: the process is replaced by that
/// program, with the verb and its arguments. Throws InputError if the program is missing.
Verb verb_of_program(std::string name, std::string summary, std::string program);

/// `int main(int argc, char** argv) { return saltus_main(argc, argv, problems); }`
///
/// InputError and DefinitionError end with one sentence on the error stream and status 2.
/// Unexpected exceptions end with status 1.
int saltus_main(int argc, const char* const* argv, std::span<const ProblemEntry> problems,
                std::span<const Verb> more_verbs = {});

}  // namespace saltus
