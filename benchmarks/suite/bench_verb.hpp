// The verb `bench`: measures our solvers alone (`latency`) and compares them with others.
#pragma once

#include "saltus/app/program.hpp"

namespace saltus::bench {

Verb bench_verb();

}  // namespace saltus::bench
