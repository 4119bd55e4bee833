// The verb `bench`: how fast are our solvers, alone (`latency`) and beside others?
#pragma once

#include "saltus/app/program.hpp"

namespace saltus::bench {

Verb bench_verb();

}  // namespace saltus::bench
