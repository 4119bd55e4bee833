// `saltus check P`: a problem of the library looked at before it is solved.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// check [PROBLEM] [--intervals N]: one page with a verdict per line; without a name of all of
/// them, and then only what is doubtful or unknown. `differs` if anything is doubtful.
Verb check_verb();

}  // namespace saltus
