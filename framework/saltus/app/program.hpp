// The body of a program with verbs: finds what the first argument names, runs it, and turns errors
// into one sentence and an exit status.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "saltus/app/exit_status.hpp"
#include "saltus/app/problem_registry.hpp"

namespace saltus {

/// A verb besides `list`, `run` and `help`; it is given the arguments after its name.
struct Verb {
  std::string name;     ///< the word on the command line
  std::string summary;  ///< one line for `saltus help`
  /// Carries it out.
  std::function<ExitStatus(std::span<const std::string> arguments)> run;
};

/// A verb that another program in the folder of the running one carries out: the process becomes
/// that program, given the verb and its arguments. InputError if the program is not there.
Verb verb_of_program(std::string name, std::string summary, std::string program);

/// `int main(int argc, char** argv) { return saltus_main(argc, argv, problems); }`
///
/// InputError and DefinitionError end with one sentence on the error stream and status 2, whatever
/// was not foreseen with status 1.
int saltus_main(int argc, const char* const* argv, std::span<const ProblemEntry> problems,
                std::span<const Verb> more_verbs = {});

}  // namespace saltus
