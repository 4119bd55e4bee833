#include "saltus/app/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

template <class Named>
const Named* find_by_name(std::span<const Named> entries, const std::string& name) {
  const auto it = std::find_if(entries.begin(), entries.end(),
                               [&](const Named& entry) { return entry.name == name; });
  return it == entries.end() ? nullptr : &*it;
}

template <class Named>
std::vector<std::string> names_of(std::span<const Named> entries) {
  std::vector<std::string> names;
  for (const Named& entry : entries) names.push_back(entry.name);
  return names;
}

[[noreturn]] void reject_unknown(std::string_view kind, const std::string& given,
                                 const std::vector<std::string>& known, std::string_view remedy) {
  const std::string meant = nearest_name(given, known);
  throw InputError(meant.empty()
                       ? fmt::format("unknown {} '{}'; {}", kind, given, remedy)
                       : fmt::format("unknown {} '{}'; did you mean '{}'?", kind, given, meant));
}

template <class Named>
void print_table(std::span<const Named> entries) {
  std::size_t width = 0;
  for (const Named& entry : entries) width = std::max(width, entry.name.size());
  for (const Named& entry : entries) {
    fmt::print("  {:<{}}  {}\n", entry.name, width, entry.summary);
  }
}

ExitStatus print_help(std::span<const Verb> more_verbs) {
  std::vector<Verb> verbs{
      {"list", "the problems this program knows", {}},
      {"run", "run PROBLEM [--config FILE] [--set KEY=VALUE]... [--out DIR] [--KEY VALUE]...", {}},
  };
  verbs.insert(verbs.end(), more_verbs.begin(), more_verbs.end());
  verbs.push_back({"help", "this text; 'run PROBLEM --help' lists the settings of a problem", {}});
  fmt::print("saltus VERB ...\n\n");
  print_table(std::span<const Verb>(verbs));
  return ExitStatus::ok;
}

ExitStatus run_problem(std::span<const std::string> arguments,
                       std::span<const ProblemEntry> problems, std::span<const Verb> more_verbs) {
  const RunRequest request = parse_run_request(arguments);
  if (request.problem.empty()) return print_help(more_verbs);  // run --help
  const ProblemEntry* problem = find_by_name(problems, request.problem);
  if (problem == nullptr) {
    reject_unknown("problem", request.problem, names_of(problems), "'saltus list' shows them");
  }
  return problem->run(request);
}

ExitStatus dispatch(std::span<const std::string> arguments, std::span<const ProblemEntry> problems,
                    std::span<const Verb> more_verbs) {
  if (arguments.empty()) {
    print_help(more_verbs);
    throw InputError("a verb is missing");
  }
  const std::string& verb = arguments.front();
  const std::span<const std::string> rest = arguments.subspan(1);
  if (verb == "run") return run_problem(rest, problems, more_verbs);
  if (verb == "help" || verb == "--help" || verb == "-h") return print_help(more_verbs);
  if (verb == "list") {
    if (!rest.empty())
      throw InputError(fmt::format("list takes no arguments, but '{}' follows", rest[0]));
    print_table(problems);
    return ExitStatus::ok;
  }
  if (const Verb* more = find_by_name(more_verbs, verb)) return more->run(rest);
  std::vector<std::string> known = names_of(more_verbs);
  known.insert(known.end(), {"list", "run", "help"});
  reject_unknown("verb", verb, known, "'saltus help' shows them");
}

}  // namespace

int saltus_main(int argc, const char* const* argv, std::span<const ProblemEntry> problems,
                std::span<const Verb> more_verbs) {
  const auto end_with = [](ExitStatus status, std::string_view sentence) {
    std::fflush(stdout);
    fmt::print(stderr, "saltus: {}\n", sentence);
    return static_cast<int>(status);
  };
  // Some builds of Ipopt's linear solver start MPI, which aborts the process without a home folder.
  ::setenv("HOME", "/tmp", /*overwrite=*/0);
  try {
    const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
    return static_cast<int>(dispatch(arguments, problems, more_verbs));
  } catch (const InputError& error) {
    return end_with(ExitStatus::bad_input, error.what());
  } catch (const DefinitionError& error) {
    return end_with(ExitStatus::bad_input, error.what());
  } catch (const std::exception& error) {
    return end_with(ExitStatus::internal_error, fmt::format("internal error: {}", error.what()));
  }
}

}  // namespace saltus
