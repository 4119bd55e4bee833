// Finds the best sequence of modes with its times and its trajectory, in one call.
//
//     const SequenceResult best = search(thermostat, {.phases = 15});
//
// Branch and bound solves convex problems in sampled time (sequence_search.hpp) and bounds the cost
// of all sequences. Other problems are enumerated, shorter sequences first. Each sequence is an
// OptimalControlProblem that starts from results of shorter ones. The result then has only the
// guarantee Guarantee::enumerated.
#pragma once

#include "saltus/sequences/mode_graph.hpp"
#include "saltus/sequences/sequence_result.hpp"

namespace saltus {

/// Throws DefinitionError if the graph or the options are invalid (ModeGraph::check()). Set
/// SearchOptions::phases, or at_most for modes of free duration.
SequenceResult search(const ModeGraph& graph, const SearchOptions& options);

}  // namespace saltus
