// The files of a run of a library problem, and its terminal output.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "problems/library/case_outcome.hpp"
#include "problems/library/reference_case.hpp"
#include "problems/library/simulation_case.hpp"
#include "problems/suite/library_loop.hpp"
#include "saltus/app/program.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus {

/// Writes trajectory_NAME.csv and events_NAME.csv; without a name trajectory.csv and events.csv.
void write_recording(const OutputFolder& output, const Recording& recording,
                     const std::string& name = {});

/// The common part of all summaries: id, name, content, and the versions that made it.
nlohmann::ordered_json summary_head(const CaseOutcome& outcome, const std::string& summary);
/// Every checked value with its reference.
nlohmann::ordered_json checked_json(const CaseOutcome& outcome);
nlohmann::ordered_json solution_json(const Solution& solution, const Recording& recording);

/// The first checked value with its reference, and the reason if it is not met.
std::string verdict_text(const CaseOutcome& outcome);

/// A closed loop compared with its initial plan.
nlohmann::ordered_json loop_json(const ReferenceCase& c, const Solution& plan,
                                 const LibraryLoop& loop, const PlanRunOut& planned);
std::string loop_text(const ReferenceCase& c, const LibraryLoop& loop, const PlanRunOut& planned);

}  // namespace saltus
