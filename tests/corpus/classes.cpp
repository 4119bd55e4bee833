#include "tests/corpus/trial.hpp"

namespace saltus::corpus {

const std::vector<CorpusClass>& corpus_classes() {
  static const std::vector<CorpusClass> classes{
      {"tiny_start", "start moved by 0, 1e-12 to 1e-2", 400, 12, tiny_start},
      {"idle_bounds", "bounds of 1e3 to 1e30 that never act", 500, 14, idle_bounds},
      {"penalty_weights", "L1 and L2 weights 1e-2 to 1e14", 600, 16, penalty_weights},
      {"pillars", "1 to 4 pillars, ways of 1 to 1000 m", 500, 12, pillars},
      {"thin_walls", "walls of 5 to 12 mm on ways of 1 to 10 m", 300, 8, thin_walls},
      {"unstable_horizons", "x' = a x + u, a T of 1 to 60", 400, 12, unstable_horizons},
      {"aliasing", "forcing of 0.3 to 16 periods, 1 to 300 turns", 400, 12, aliasing},
      {"higher_order", "maxima and saddles of order 2 to 8", 400, 12, higher_order},
      {"constant_rows", "rows of data or time alone, met or missed by 1e-3 to 1e3", 300, 10,
       constant_rows},
      {"mode_searches", "2 or 3 modes, 2 to 5 phases, ends that read t", 400, 12, mode_searches},
      {"scales", "units of 1e-6 to 1e6", 400, 10, scales},
      {"near_infeasible", "1e-9 to 0.1 of the way within or beyond reach", 300, 8, near_infeasible},
      {"hybrid_events", "guards that graze, are missed, passed the wrong way or before", 300, 8,
       hybrid_events},
      {"split_phases", "1 to 5 phases, limits kept in neighbouring ones", 300, 8, split_phases},
  };
  return classes;
}

}  // namespace saltus::corpus
