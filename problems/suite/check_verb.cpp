#include "problems/suite/check_verb.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "problems/library/catalogue.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/solve/check.hpp"

namespace saltus {
namespace {

constexpr const char* summary =
    "derivatives, sparsity, scaling, ranks, bounds, start and grid of a problem, in one page";

bool is_called(const ReferenceCase& c, const std::string& name) {
  return c.id == name || c.name == name || fmt::format("{}_{}", c.id, c.name) == name;
}

std::string upper_case_id(std::string name) {
  if (!name.empty() && name.front() >= 'a' && name.front() <= 'z' && name.size() > 1 &&
      name[1] >= '0' && name[1] <= '9')
    name.front() = static_cast<char>(name.front() - 'a' + 'A');
  return name;
}

ProblemCheck check_case(const ReferenceCase& c, int intervals) {
  ShootingOptions options = c.options;
  if (intervals > 0) {
    options.intervals.clear();
    options.meshes.clear();
    options.intervals_per_phase = intervals;
  }
  ProblemCheck page = check(c.problem(), options);
  page.problem = fmt::format("{} {}", c.id, c.name);
  return page;
}

ExitStatus check_one(const std::string& name, int intervals) {
  std::vector<std::string> names;
  for (const ReferenceCase& c : reference_cases()) {
    names.insert(names.end(), {c.id, c.name});
    if (!is_called(c, upper_case_id(name))) continue;
    const ProblemCheck page = check_case(c, intervals);
    fmt::print("{}", page.text());
    return page.ok() ? ExitStatus::ok : ExitStatus::differs;
  }
  const std::string meant = nearest_name(name, names);
  throw InputError(fmt::format(
      "check: the library has no optimal control problem '{}'{}; 'saltus list' shows them",
      shortened(name), meant.empty() ? "" : fmt::format(" (did you mean '{}'?)", meant)));
}

ExitStatus check_all(int intervals) {
  int doubtful = 0;
  for (const ReferenceCase& c : reference_cases()) {
    ProblemCheck page = check_case(c, intervals);
    doubtful += page.ok() ? 0 : 1;
    std::erase_if(page.lines,
                  [](const CheckLine& line) { return line.verdict == CheckVerdict::good; });
    fmt::print("{}", page.text());
    std::fflush(stdout);
  }
  fmt::print("{} problems, {} doubtful\n", reference_cases().size(), doubtful);
  return doubtful == 0 ? ExitStatus::ok : ExitStatus::differs;
}

}  // namespace

Verb check_verb() {
  return {"check", summary, [](std::span<const std::string> arguments) {
            std::string name;
            std::vector<Assignment> assignments;
            OptionParser parser("check", summary);
            parser.word("problem", "its name; without, all of the library", name)
                .option("--intervals", "N", "per phase; the case's own grid without",
                        [&](const std::string& text) {
                          assignments.push_back(flag_assignment("intervals", text));
                        });
            parser.parse(arguments);
            if (parser.help_wanted()) {
              fmt::print("{}", parser.help());
              return ExitStatus::ok;
            }
            int intervals = 0;
            Settings settings;
            settings.integer("intervals", intervals, "", "per phase", between(0, 2000));
            settings.apply(assignments);
            return name.empty() ? check_all(intervals) : check_one(name, intervals);
          }};
}

}  // namespace saltus
