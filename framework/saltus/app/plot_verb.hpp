// `saltus plot DIR`: draws all plots of a results folder again from its tables.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// Draws with the Python package: a run, a legged robot's run with report and replay, or a survival
/// map. Returns `not_applicable` with a message if that is not possible.
Verb plot_verb();

}  // namespace saltus
