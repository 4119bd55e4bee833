#include "problems/suite/check_verb.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "problems/library/catalogue.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/app/option_parser.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/solve/check.hpp"

namespace saltus {
namespace {

constexpr const char* summary =
    "checks derivatives, sparsity, scaling, ranks, bounds, start and grid of a problem, on one "
    "page";

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

using Json = nlohmann::ordered_json;

constexpr const char* page_schema = R"({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "title": "saltus check --json: a page for one problem, a list for all",
  "$defs": {
    "page": {
      "type": "object",
      "required": ["problem", "ok", "lines"],
      "additionalProperties": false,
      "properties": {
        "problem": {"type": "string", "description": "id and name"},
        "ok": {"type": "boolean", "description": "true if no verdict is doubtful"},
        "lines": {
          "type": "array",
          "items": {
            "type": "object",
            "required": ["aspect", "verdict", "text"],
            "additionalProperties": false,
            "properties": {
              "aspect": {"enum": ["definition", "start", "derivatives", "sparsity", "jumps", "bounds",
                                  "scaling", "ranks", "integration", "reach"]},
              "verdict": {"enum": ["good", "doubtful", "unknown"]},
              "text": {"type": "string", "description": "a sentence, with phase, term and time"}
            }
          }
        }
      }
    }
  },
  "anyOf": [
    {"$ref": "#/$defs/page"},
    {
      "type": "object",
      "required": ["problems", "doubtful", "interrupted"],
      "additionalProperties": false,
      "properties": {
        "problems": {"type": "array", "items": {"$ref": "#/$defs/page"}},
        "doubtful": {"type": "integer", "description": "number of doubtful problems"},
        "interrupted": {"type": "boolean", "description": "true if the other problems were not checked"}
      }
    }
  ]
}
)";

const char* word_for(ProblemCheck::Verdict verdict) {
  switch (verdict) {
    case ProblemCheck::Verdict::good:
      return "good";
    case ProblemCheck::Verdict::doubtful:
      return "doubtful";
    case ProblemCheck::Verdict::unknown:
      break;
  }
  return "unknown";
}

// The columns are those of page_schema.
Json page_json(const ProblemCheck& page) {
  Json lines = Json::array();
  for (const ProblemCheck::Line& line : page.lines)
    lines.push_back(
        {{"aspect", line.aspect}, {"verdict", word_for(line.verdict)}, {"text", line.text}});
  return {{"problem", page.problem}, {"ok", page.ok()}, {"lines", lines}};
}

struct CheckRequest {
  std::string problem;  // empty: all
  int intervals = 0;    // per phase; 0: the case's own grid
  bool json = false, quiet = false, print_schema = false;
};

ExitStatus check_one(const CheckRequest& request) {
  const std::string& name = request.problem;
  std::vector<std::string> names;
  for (const ReferenceCase& c : reference_cases()) {
    names.insert(names.end(), {c.id, c.name});
    if (!is_called(c, upper_case_id(name))) continue;
    const ProblemCheck page = check_case(c, request.intervals);
    if (request.json)
      fmt::print("{}\n", page_json(page).dump(2));
    else if (!request.quiet)
      fmt::print("{}", page.text());
    return page.ok() ? ExitStatus::ok : ExitStatus::differs;
  }
  const std::string meant = nearest_name(name, names);
  throw InputError(fmt::format(
      "check: the library has no optimal control problem '{}'{}; 'saltus list' shows them",
      shortened(name), meant.empty() ? "" : fmt::format(" (did you mean '{}'?)", meant)));
}

ExitStatus check_all(const CheckRequest& request) {
  int doubtful = 0, checked = 0, signal = 0;
  Json pages = Json::array();
  {
    const DeferSignals note;
    for (const ReferenceCase& c : reference_cases()) {
      signal = DeferSignals::received();
      if (signal != 0) break;
      ProblemCheck page = check_case(c, request.intervals);
      ++checked;
      doubtful += page.ok() ? 0 : 1;
      if (request.json) pages.push_back(page_json(page));
      if (request.json || request.quiet) continue;
      std::erase_if(page.lines, [](const ProblemCheck::Line& line) {
        return line.verdict == ProblemCheck::Verdict::good;
      });
      fmt::print("{}", page.text());
      std::fflush(stdout);
    }
  }
  if (request.json)
    fmt::print(
        "{}\n",
        Json{{"problems", pages}, {"doubtful", doubtful}, {"interrupted", signal != 0}}.dump(2));
  else if (!request.quiet)
    fmt::print("{} problems, {} doubtful\n", checked, doubtful);
  if (signal != 0) {
    if (!request.json) fmt::print("interrupted: the other problems were not checked\n");
    std::fflush(nullptr);
    std::raise(signal);
  }
  return doubtful == 0 ? ExitStatus::ok : ExitStatus::differs;
}

}  // namespace

Verb check_verb() {
  return {
      "check", summary, [](std::span<const std::string> arguments) {
        CheckRequest request;
        std::vector<Assignment> assignments;
        OptionParser parser("check", summary);
        parser.word("problem", "name of the problem; default: all of the library", request.problem)
            .option("--intervals", "N", "intervals per phase; default: the case's own grid",
                    [&](const std::string& text) {
                      assignments.push_back(flag_assignment("intervals", text));
                    })
            .flag("--json", "print every verdict as JSON instead of text", request.json)
            .flag("--quiet", "print nothing; the exit status is the result", request.quiet)
            .flag("--print-schema",
                  "print a JSON Schema of the output of --json, and check nothing",
                  request.print_schema);
        if (parser.prints_help(arguments)) return ExitStatus::ok;
        if (request.print_schema) {
          fmt::print("{}", page_schema);
          return ExitStatus::ok;
        }
        Settings settings;
        settings.integer("intervals", request.intervals, "", "per phase", between(0, 2000));
        settings.apply(assignments);
        if (!assignments.empty() && request.intervals < 1)
          throw InputError("check: --intervals must be at least 1");
        return request.problem.empty() ? check_all(request) : check_one(request);
      }};
}

}  // namespace saltus
