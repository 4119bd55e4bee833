// `saltus suite`: compares the framework with published results.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "problems/library/run_case.hpp"
#include "saltus/app/program.hpp"

namespace saltus {

/// A case of any kind, for the suite.
struct SuiteCase {
  std::string id, name;
  std::function<CaseOutcome(SolverChoice)> run;
};
/// Every case of the library: optimisation problems, quadratic programs and simulations, by id.
std::vector<SuiteCase> suite_cases();

struct SuiteRequest {
  std::string only;  ///< part of an id or name, case-insensitive; empty: all
  SolverChoice solver = SolverChoice::ipopt;
  std::optional<std::filesystem::path> json = {};
  std::function<bool()> should_stop = {};  ///< evaluated before every case
  bool quiet = false;                      ///< print nothing but errors
  std::string help = {};                   ///< not empty: help was requested instead of a run
};
/// Parses the arguments after `suite`. Throws InputError.
SuiteRequest parse_suite_request(std::span<const std::string> arguments);

struct SuiteReport {
  SolverChoice solver = SolverChoice::ipopt;
  std::vector<CaseOutcome> outcomes;
  bool was_interrupted = false;  ///< the outcomes are incomplete

  int count(Verdict verdict) const;
  /// solver_failed if a case missed its tolerance or did not converge.
  ExitStatus exit_status() const;
};

/// Runs the selected cases and calls `observe` after each one. A case that throws counts as failed.
/// Throws InputError with the nearest name if no case is selected.
SuiteReport run_suite(std::span<const SuiteCase> cases, const SuiteRequest& request,
                      const std::function<void(const CaseOutcome&)>& observe = {});

/// The verb `suite`.
Verb suite_verb(std::function<std::vector<SuiteCase>()> cases = suite_cases);

}  // namespace saltus
