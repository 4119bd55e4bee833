// `saltus plot DIR`: all pictures of a folder of results again, from its tables.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// The Python package draws what the folder holds: a run, a legged robot's run with report and
/// replay, a survival map. `not_applicable` if it cannot, which is said.
Verb plot_verb();

}  // namespace saltus
