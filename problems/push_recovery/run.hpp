// `saltus run push_recovery`: one closed-loop run from settings to results.
#pragma once

#include "saltus/app/problem_registry.hpp"

namespace saltus::push_recovery {

ProblemEntry entry();

}  // namespace saltus::push_recovery
