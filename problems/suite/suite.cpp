#include "problems/suite/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "problems/library/c01_mpc_qps.hpp"
#include "problems/library/catalogue.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {
namespace {

bool is_wanted(const SuiteCase& c, const std::string& pattern) {
  return lower_case(c.id + " " + c.name).find(lower_case(pattern)) != std::string::npos;
}

[[noreturn]] void reject_pattern(std::span<const SuiteCase> cases, const std::string& pattern) {
  std::vector<std::string> known;
  for (const SuiteCase& c : cases) {
    known.push_back(lower_case(c.id));
    known.push_back(lower_case(c.name));
    std::istringstream words(lower_case(c.name));  // "bryson" of "bryson_denham"
    for (std::string word; std::getline(words, word, '_');) known.push_back(word);
  }
  const std::string near = nearest_name(lower_case(pattern), known);
  throw InputError(fmt::format(
      "no case has '{}' in its id or name{}", pattern,
      near.empty() ? "; 'saltus suite' runs all of them" : "; did you mean '" + near + "'?"));
}

CaseOutcome run_safely(const SuiteCase& c, SolverChoice solver) {
  CaseOutcome outcome;
  try {
    outcome = c.run(solver);
  } catch (const std::exception& error) {
    outcome.verdict = Verdict::failed;
    outcome.status = error.what();
  }
  outcome.id = c.id;
  outcome.name = c.name;
  return outcome;
}

}  // namespace

std::vector<SuiteCase> suite_cases() {
  std::vector<SuiteCase> cases;
  for (const ReferenceCase& c : reference_cases())
    cases.push_back({c.id, c.name, [&c](SolverChoice solver) { return run_case(c, solver); }});
  cases.push_back({library::mpc_qps_id, library::mpc_qps_name, library::run_mpc_qps});
  for (const SimulationCase& c : simulation_cases())
    cases.push_back({c.id, c.name, [&c](SolverChoice) { return run_case(c); }});
  std::stable_sort(cases.begin(), cases.end(),
                   [](const SuiteCase& a, const SuiteCase& b) { return a.id < b.id; });
  return cases;
}

int SuiteReport::count(Verdict verdict) const {
  return static_cast<int>(
      std::count_if(outcomes.begin(), outcomes.end(),
                    [verdict](const CaseOutcome& o) { return o.verdict == verdict; }));
}

ExitStatus SuiteReport::exit_status() const {
  const bool wrong = std::any_of(outcomes.begin(), outcomes.end(),
                                 [](const CaseOutcome& o) { return o.is_wrong(); });
  return wrong ? ExitStatus::solver_failed : ExitStatus::ok;
}

SuiteReport run_suite(std::span<const SuiteCase> cases, const SuiteRequest& request,
                      const std::function<void(const CaseOutcome&)>& observe) {
  SuiteReport report{.solver = request.solver, .outcomes = {}};
  for (const SuiteCase& c : cases) {
    if (!is_wanted(c, request.only)) continue;
    if (request.should_stop && request.should_stop()) {
      report.was_interrupted = true;
      return report;
    }
    report.outcomes.push_back(run_safely(c, request.solver));
    if (observe) observe(report.outcomes.back());
  }
  if (report.outcomes.empty()) reject_pattern(cases, request.only);
  return report;
}

}  // namespace saltus
