// A quadruped trots over uneven ground and is pushed: a second application in receding horizon,
// which uses only the framework.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus::quadruped {

/// Entry for `saltus run quadruped`.
ProblemEntry entry();

}  // namespace saltus::quadruped
