// `saltus plot DIR` and `saltus view DIR`: pictures and an interactive page of a results folder.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// Draws with the Python package: a run, a legged robot's run with report and view, or a survival
/// map. Returns `not_applicable` with a message if that is not possible.
Verb plot_verb();
/// Writes view.html: all tables of a run over time with a scene that moves.
Verb view_verb();

}  // namespace saltus
