// `saltus logs DIR`: the tables of a folder of results for other people's tools.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// Writes run.mat and run.mcap beside the tables of any folder with trajectory.csv, a project's own
/// too. `not_applicable` if a Python package is missing, which is said.
Verb logs_verb();

}  // namespace saltus
