// The library problems for `saltus run` and `saltus list`.
#pragma once

#include <vector>

#include "saltus/app/program.hpp"

namespace saltus {

/// One entry per case, in the order of their ids: "a01_three_modes", also found as "A01" and
/// "three_modes". A run leaves trajectory.csv (of a case with several motions one per motion),
/// events.csv, summary.json, config.yaml and a picture in its folder. A value that misses its
/// reference is a result; a solve that does not converge gives status 3. With --loop a problem runs
/// in closed loop (library_loop.hpp), or gives the reason with status 4; the kind names the
/// problems with a closed loop.
std::vector<ProblemEntry> library_problems();

}  // namespace saltus
