// The best sequence of modes, its times and its trajectory, in one call.
//
//     const SequenceResult best = search(thermostat, {.phases = 15});
//
// Convex problems in sampled time go to branch and bound (sequence_search.hpp), which bounds the
// cost of all sequences. The others are enumerated, shorter sequences first: each is solved as an
// OptimalControlProblem from what was found for shorter ones, and the result says that its
// guarantee is no more than that (Guarantee::enumerated).
#pragma once

#include "saltus/sequences/mode_graph.hpp"
#include "saltus/sequences/sequence_result.hpp"

namespace saltus {

/// Throws DefinitionError when graph or options are wrong (ModeGraph::check()). Give
/// SearchOptions::phases, or at_most for modes of free duration.
SequenceResult search(const ModeGraph& graph, const SearchOptions& options);

}  // namespace saltus
