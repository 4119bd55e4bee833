// The fishing problem (a06_fishing.cpp) with a free sequence: the boat is out or in, and the number
// of trips is unknown.
//
//   min int_0^12 (x1 - 1)^2 + (x2 - 1)^2      x(0) = (0.5, 0.7)
//   x1' = x1 - x1 x2 - 0.4 x1 w, x2' = -x2 + x1 x2 - 0.2 x2 w     w in {0, 1}
//
// With a continuous effort the optimum is 1.34408 (a08_fishing_relaxed.cpp), a lower bound for
// every sequence: S. Sager, mintOC.de.
#include "problems/library/fishing.hpp"
#include "problems/library/mode_graphs.hpp"

namespace saltus::library {

ModeGraph fishing_modes() {
  ModeGraph graph("fishing");
  for (const bool out : {false, true}) {
    Phase<2, 0> phase{out ? "fish" : "wait", Populations{out ? 1.0 : 0.0}, between(0.0, 12.0)};
    phase.minimise("deviation", Deviation{}).guess_state(Guess::simulate()).guess_duration(1.0);
    graph.mode(phase);
  }
  graph.transition("wait", "fish")
      .transition("fish", "wait")
      .start_at({0.5, 0.7})
      .total_time(exactly(12.0));
  return graph;
}

}  // namespace saltus::library
