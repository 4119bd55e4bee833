// `saltus logs DIR`: converts the tables of a results folder for other tools.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// Writes run.mat and run.mcap for any folder with trajectory.csv, including those of other
/// projects. Returns `not_applicable` with a message if a Python package is missing.
Verb logs_verb();

}  // namespace saltus
