// `saltus check P`: analyses a library problem before it is solved.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus {

/// check [PROBLEM] [--intervals N]: prints one page with a verdict per line. Without a name it
/// checks all problems and prints only doubtful and unknown verdicts. Returns `differs` if a
/// verdict is doubtful.
Verb check_verb();

}  // namespace saltus
