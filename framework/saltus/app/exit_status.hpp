// What a program of the project tells its caller when it ends.
#pragma once

namespace saltus {

/// Exit statuses of the programs. A robot that falls is a result: `ok`.
enum class ExitStatus {
  ok = 0,              ///< the run finished, and its results say what happened
  internal_error = 1,  ///< something the program did not foresee; please report it
  bad_input = 2,       ///< a file, key, flag or value is unusable; nothing was written
  solver_failed = 3,   ///< a solver gave up; the results written so far say which and why
  not_applicable = 4,  ///< makes no sense for this problem, and a sentence says why
  differs = 5,         ///< what was compared is not the same, or a check found something
};

}  // namespace saltus
