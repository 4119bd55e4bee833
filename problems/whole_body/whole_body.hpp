// `saltus run whole_body`: plans of the whole body of iCub, tracked in simulation.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus::whole_body {

/// The entry of the program's list of problems.
ProblemEntry entry();

}  // namespace saltus::whole_body
