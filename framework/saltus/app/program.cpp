#include "saltus/app/program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <new>
#include <system_error>
#include <utility>

#include "saltus/app/completion.hpp"
#include "saltus/app/process_limits.hpp"
#include "saltus/app/rerun.hpp"
#include "saltus/app/silent_output.hpp"
#include "saltus/app/version.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

// Finds a problem by name or alias, ignoring case.
const ProblemEntry* find_problem(std::span<const ProblemEntry> problems, const std::string& given) {
  const std::string wanted = lower_case(given);
  for (const ProblemEntry& problem : problems) {
    if (lower_case(problem.name) == wanted) return &problem;
    for (const std::string& alias : problem.aliases)
      if (lower_case(alias) == wanted) return &problem;
  }
  return nullptr;
}

std::vector<std::string> names_of(std::span<const ProblemEntry> problems) {
  std::vector<std::string> names;
  for (const ProblemEntry& problem : problems) {
    names.push_back(problem.name);
    names.insert(names.end(), problem.aliases.begin(), problem.aliases.end());
  }
  return names;
}

[[noreturn]] void reject_unknown(std::string_view kind, const std::string& given,
                                 const std::vector<std::string>& known, std::string_view remedy) {
  const std::string meant = nearest_name(given, known);
  throw InputError(meant.empty()
                       ? fmt::format("unknown {} '{}'; {}", kind, shortened(given), remedy)
                       : fmt::format("unknown {} '{}'; did you mean '{}'?", kind, given, meant));
}

void print_list(std::span<const ProblemEntry> problems) {
  std::size_t width = 0;
  for (const ProblemEntry& problem : problems) width = std::max(width, problem.name.size());
  for (const ProblemEntry& problem : problems)
    fmt::print("  {:<{}}  {}{}\n", problem.name, width, problem.summary,
               problem.kind.empty() ? "" : fmt::format(" ({})", problem.kind));
}

// The program's own verbs and those of its caller, as subcommands.
class Verbs {
 public:
  explicit Verbs(std::span<const Verb> more) {
    app_.name("saltus");
    app_.set_help_flag();
    app_.allow_extras();
    add("list", "lists the problems of this program");
    add("run", "run PROBLEM [--config FILE] [--set KEY=VALUE]... [--out DIR] [--KEY VALUE]...");
    add("rerun", "rerun DIR: repeats a run and compares the results bit by bit");
    add("completion", "completion bash|zsh|fish: prints the completion script of a shell");
    for (const Verb& verb : more) add(verb.name, verb.summary);
    add("help", "prints this help; 'run PROBLEM --help' lists the settings of a problem");
    help_ = app_.help();  // help of all verbs; after parsing it would be the help of one verb
  }

  /// Name of the verb that the first word selects. The words after it belong to the verb: CLI11
  /// would look for further verbs among them ("run list").
  std::string parse(const std::string& word) {
    try {
      app_.parse(std::vector<std::string>{word});
    } catch (const CLI::ParseError& error) {
      throw InputError(error.what());
    }
    for (const CLI::App* sub : app_.get_subcommands()) return sub->get_name();
    if (word == "--help" || word == "-h") return "help";
    reject_unknown("verb", word, names_, "'saltus help' shows them");
  }

  const std::vector<std::string>& names() const { return names_; }

  ExitStatus print_help() const {
    fmt::print("{}", help_);
    return ExitStatus::ok;
  }

 private:
  void add(const std::string& name, const std::string& summary) {
    app_.add_subcommand(name, summary)->set_help_flag();
    names_.push_back(name);
  }

  CLI::App app_{"Hybrid model predictive control: problems to run, by name."};
  std::vector<std::string> names_;
  std::string help_;
};

ExitStatus run_problem(std::span<const std::string> arguments,
                       std::span<const ProblemEntry> problems) {
  const RunRequest request = parse_run_request(arguments);
  if (request.problem.empty()) {  // run --help
    fmt::print("{}", request.usage);
    return ExitStatus::ok;
  }
  const ProblemEntry* problem = find_problem(problems, request.problem);
  if (problem == nullptr) {
    reject_unknown("problem", request.problem, names_of(problems), "'saltus list' shows them");
  }
  const bool only_asks = request.help || request.print_config || request.print_schema;
  if (only_asks || (!request.quiet && !request.json)) return problem->run(request);
  const auto begin = std::filesystem::file_time_type::clock::now();
  const ExitStatus status = [&] {
    const SilentOutput silence;
    return problem->run(request);
  }();
  if (request.json) {
    const std::filesystem::path file = request.out / "summary.json";
    std::error_code missing;
    if (std::filesystem::last_write_time(file, missing) >= begin && !missing)
      std::cout << std::ifstream(file).rdbuf() << std::flush;
  }
  return status;
}

ExitStatus dispatch(const std::vector<std::string>& arguments,
                    std::span<const ProblemEntry> problems, std::span<const Verb> more_verbs) {
  Verbs verbs(more_verbs);
  // Called by shell completion, not by users.
  if (!arguments.empty() && arguments.front() == completion_verb) {
    for (const std::string& word :
         completions(std::span(arguments).subspan(1), verbs.names(), problems))
      fmt::print("{}\n", word);
    return ExitStatus::ok;
  }
  if (arguments == std::vector<std::string>{"--version"}) {
    fmt::print("saltus {} ({})\n", version(), commit());
    return ExitStatus::ok;
  }
  if (arguments.empty()) {
    verbs.print_help();
    throw InputError("a verb is missing");
  }
  const std::string verb = verbs.parse(arguments.front());
  const std::span<const std::string> rest = std::span(arguments).subspan(1);
  if (verb == "run") return run_problem(rest, problems);
  if (verb == "rerun") return rerun(rest, problems);
  if (verb == "completion") return print_completion(rest);
  if (verb == "help") return verbs.print_help();
  if (verb == "list") {
    if (!rest.empty())
      throw InputError(fmt::format("list takes no arguments, but '{}' follows", rest[0]));
    print_list(problems);
    return ExitStatus::ok;
  }
  return std::find_if(more_verbs.begin(), more_verbs.end(),
                      [&](const Verb& more) { return more.name == verb; })
      ->run(rest);
}

}  // namespace

Verb verb_of_program(std::string name, std::string summary, std::string program) {
  const auto become = [name, program](std::span<const std::string> arguments) -> ExitStatus {
    const std::filesystem::path file = program_folder() / program;
    std::vector<std::string> words{"saltus", name};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    std::fflush(stdout);
    ::execv(file.c_str(), argv.data());
    throw InputError(fmt::format("{} needs the program {}, which cannot be started: {}", name,
                                 file.string(), std::strerror(errno)));
  };
  return {std::move(name), std::move(summary), become};
}

namespace {

// Opens closed standard streams. Otherwise the next opened file would replace a stream and receive
// the printed output.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) < 0) return;
}

// Sets HOME if it is missing. Some builds of Ipopt's linear solver start MPI, which aborts without
// a home folder, and fetched files are stored below it. It is the user's folder or "/", never a
// folder such as /tmp where others can place files.
void ensure_home_folder() {
  const char* given = std::getenv("HOME");
  if (given != nullptr && *given != '\0') return;
  const passwd* user = ::getpwuid(::geteuid());
  const bool is_known = user != nullptr && user->pw_dir != nullptr && *user->pw_dir == '/';
  ::setenv("HOME", is_known ? user->pw_dir : "/", /*overwrite=*/1);
}

}  // namespace

int saltus_main(int argc, const char* const* argv, std::span<const ProblemEntry> problems,
                std::span<const Verb> more_verbs) {
  const auto end_with = [](ExitStatus status, std::string_view sentence) {
    std::fflush(stdout);
    // fmt::print would throw if writing fails.
    std::fputs(fmt::format("saltus: {}\n", printable(sentence)).c_str(), stderr);
    return static_cast<int>(status);
  };
  prepare_process();
  open_standard_streams();
  ensure_home_folder();
  try {
    const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
    const ExitStatus status = dispatch(arguments, problems, more_verbs);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {  // buffered output too
      throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(),
                              "the standard output cannot be written");
    }
    return static_cast<int>(status);
  } catch (const InputError& error) {
    return end_with(ExitStatus::bad_input, error.what());
  } catch (const DefinitionError& error) {
    return end_with(ExitStatus::bad_input, error.what());
  } catch (const std::system_error& error) {
    return end_with(ExitStatus::bad_input,
                    fmt::format("the system reports an error: {}", error.what()));
  } catch (const std::bad_alloc&) {
    // fmt::format would allocate.
    std::fflush(stdout);
    std::fputs("saltus: not enough memory; a smaller problem needs less\n", stderr);
    return static_cast<int>(ExitStatus::bad_input);
  } catch (const std::exception& error) {
    return end_with(ExitStatus::internal_error, fmt::format("internal error: {}", error.what()));
  }
}

}  // namespace saltus
