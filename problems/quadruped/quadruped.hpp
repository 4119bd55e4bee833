// A quadruped trots over uneven ground under control, and is pushed: a second application in
// receding horizon, on the framework alone.
#pragma once

#include "saltus/app/problem_registry.hpp"

namespace saltus::quadruped {

/// `saltus run quadruped`.
ProblemEntry entry();

}  // namespace saltus::quadruped
