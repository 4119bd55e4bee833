#include "saltus/app/completion.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/app/new_project.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/template_file.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

using Words = std::vector<std::string>;

const ProblemEntry* problem_among(std::span<const std::string> words,
                                  std::span<const ProblemEntry> problems) {
  for (const std::string& word : words)
    for (const ProblemEntry& problem : problems)
      if (problem.name == word || std::ranges::find(problem.aliases, word) != problem.aliases.end())
        return &problem;
  return nullptr;
}

Words completions_of_run(std::span<const std::string> words, const std::string& last,
                         std::span<const ProblemEntry> problems) {
  const ProblemEntry* problem = problem_among(words, problems);
  const std::string before = words.empty() ? "" : words.back();
  if (before == "--config" || before == "--out") return {};  // the shell completes file names
  Words found;
  if (problem != nullptr && problem->with_settings) {
    problem->with_settings([&](const Settings& settings) {
      if (before.starts_with("--") && before.find('=') == std::string::npos && before != "--set")
        found = settings.values_of(before.substr(2));
      if (before == "--set")
        for (const std::string& key : settings.keys()) found.push_back(key + "=");
      else if (found.empty() && last.starts_with("-"))
        for (const std::string& flag : settings.flags()) found.push_back("--" + flag);
    });
  }
  if (!found.empty() && !last.starts_with("-")) return found;
  if (last.starts_with("-"))
    found.insert(found.end(), {"--config", "--set", "--out", "--quiet", "--json", "--print-config",
                               "--print-schema", "--help"});
  else if (problem == nullptr)
    for (const ProblemEntry& known : problems) found.push_back(known.name);
  return found;
}

}  // namespace

std::vector<std::string> completions(std::span<const std::string> words,
                                     std::span<const std::string> verbs,
                                     std::span<const ProblemEntry> problems) {
  const std::string last = words.empty() ? "" : words.back();
  Words found;
  if (words.size() <= 1) {
    found.assign(verbs.begin(), verbs.end());
    found.push_back("--version");
  } else if (words.front() == "run") {
    found = completions_of_run(words.subspan(1, words.size() - 2), last, problems);
  } else if (words.front() == "new" && words[words.size() - 2] == "--kind") {
    for (const ProjectKind& kind : project_kinds()) found.push_back(kind.name);
  } else if (words.front() == "completion") {
    found = {"bash", "zsh", "fish"};
  }
  std::erase_if(found, [&](const std::string& word) { return !word.starts_with(last); });
  return found;
}

ExitStatus print_completion(std::span<const std::string> arguments) {
  std::string shell;
  OptionParser parser("completion", "Prints the completion script of a shell.");
  parser.word("shell", "bash, zsh or fish", shell);
  if (parser.prints_help(arguments)) return ExitStatus::ok;
  if (shell != "bash" && shell != "zsh" && shell != "fish")
    throw InputError(fmt::format("completion needs bash, zsh or fish, not '{}'", shortened(shell)));
  const std::string program = (program_folder() / "saltus").string();
  fmt::print("{}", fill_template(data_file("framework/templates/completion/" + shell),
                                 {{"@PROGRAM@", program}, {"@QUESTION@", completion_verb}}));
  return ExitStatus::ok;
}

}  // namespace saltus
