// Exit statuses of the programs of the project.
#pragma once

namespace saltus {

/// Exit status of a program. A robot that falls is a valid result: `ok`.
enum class ExitStatus {
  ok = 0,              ///< the run finished; its results contain the outcome
  internal_error = 1,  ///< unexpected error; please report it
  bad_input = 2,       ///< a file, key, flag or value is invalid; nothing was written
  solver_failed = 3,   ///< a solver failed; the results written so far name it and the reason
  not_applicable = 4,  ///< not applicable to this problem; a sentence explains why
  differs = 5,         ///< a comparison found a difference, or a check found a defect
};

}  // namespace saltus
