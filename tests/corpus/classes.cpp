#include "tests/corpus/trial.hpp"

namespace saltus::corpus {

const std::vector<CorpusClass>& corpus_classes() {
  static const std::vector<CorpusClass> classes{
      {"tiny_start", "start moved by 0, 1e-12 to 1e-2", 400, 12, tiny_start},
      {"idle_bounds", "bounds of 1e3 to 1e30 that are never active", 500, 14, idle_bounds},
      {"penalty_weights", "L1 and L2 weights 1e-2 to 1e14", 600, 16, penalty_weights},
      {"pillars", "1 to 4 pillars, paths of 1 to 1000 m", 500, 12, pillars},
      {"thin_walls", "walls of 5 to 12 mm on paths of 1 to 10 m", 300, 8, thin_walls},
      {"unstable_horizons", "x' = a x + u, a T from 1 to 60", 400, 12, unstable_horizons},
      {"aliasing", "forcing of 0.3 to 16 periods, 1 to 300 turns", 400, 12, aliasing},
      {"higher_order", "maxima and saddles of order 2 to 8", 400, 12, higher_order},
      {"constant_rows", "rows on data or time only, satisfied or violated by 1e-3 to 1e3", 300, 10,
       constant_rows},
      {"mode_searches", "2 or 3 modes, 2 to 5 phases, time-dependent end conditions", 400, 12,
       mode_searches},
      {"scales", "units of 1e-6 to 1e6", 400, 10, scales},
      {"near_infeasible", "targets inside or outside the reachable set by 1e-9 to 0.1", 300, 8,
       near_infeasible},
      {"hybrid_events", "guards grazed, not reached, or crossed wrongly or too early", 300, 8,
       hybrid_events},
      {"split_phases", "1 to 5 phases, limits in adjacent phases", 300, 8, split_phases},
  };
  return classes;
}

}  // namespace saltus::corpus
